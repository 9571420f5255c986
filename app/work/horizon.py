"""Images of the horizon, one or a series, and predicted views: requests, measurement, answers."""

import base64
import json
import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from datetime import datetime
from itertools import zip_longest
from typing import TYPE_CHECKING, Annotated

import numpy as np
from pydantic import FailFast, Field

from app.answers.members import BUILT_ON_FIRST_USE, ProvenanceOut, to_json
from app.requests.json_reader import JsonReader
from estimator.camera import HorizonCamera
from estimator.errors import InvalidCamera
from estimator.found import (
    FrameNadir,
    HorizonCheck,
    HorizonView,
    PictureOut,
    SeriesReport,
    VerticalEstimate,
)
from estimator.rendering.scene import Scene
from estimator.rendering.sensor import Sensor
from estimator.request import (
    Body,
    HorizonRequest,
    Position,
    PredictedAttitude,
    require_cameras,
)
from estimator.surroundings import Surroundings
from planner.base.answer_members import answer
from planner.base.arrays import Array
from planner.base.errors import InvalidInput
from planner.base.rotation import Rotation
from planner.base.spec import Within, spec
from planner.world.attitude import Attitude
from planner.world.attitude.lvlh import LvlhAttitude
from planner.world.frames.time_scales import (
    DAY_S,
    Instants,
    elapsed_s,
    shifted_utc,
    tai_us,
    utc_text,
)
from planner.world.orbits import Orbit, OrbitStates
from planner.world.plan import FlightPlan

if TYPE_CHECKING:
    from estimator.images import Pixels

VIEWS_MAX = 2000
SPAN_MAX_DAYS = 3.0
ATTITUDE_SIGMA_DEG = 0.5
PICTURE_PIXELS_MAX = 4_200_000
# Decoded and measured within a second and 500 MB.
PIXELS_MAX = 25_000_000
FRAMES_MAX = 10_000
SEEN_AT = (0.0, 0.5, 1.0)  # shares of a session


@spec
class PredictionRequest:
    """A carrier, its attitude, its horizon cameras, and the instants one wants to look ahead to.

    attitude_sigma_deg: 1-sigma error of the attitude about each axis.
    cameras: the carrier's.
    instants: times of each camera's views; UTC.
    """

    orbit: Orbit
    attitude: Attitude = LvlhAttitude()
    attitude_sigma_deg: Annotated[float, Within(0.0, 180.0)] = ATTITUDE_SIGMA_DEG
    cameras: tuple[HorizonCamera, ...]
    body: Body = Body()
    instants: Annotated[tuple[datetime, ...], Field(max_length=VIEWS_MAX), FailFast()]

    def __post_init__(self) -> None:
        require_cameras("cameras", self.cameras)
        if not 1 <= len(self.instants) * len(self.cameras) <= VIEWS_MAX:
            raise ValueError(
                f"instants times cameras must come to 1 to {VIEWS_MAX}, not "
                f"{len(self.instants)} x {len(self.cameras)}"
            )
        first, last = min(self.instants), max(self.instants)
        if elapsed_s(last, first) > SPAN_MAX_DAYS * DAY_S:
            raise ValueError(
                f"instants must lie within {SPAN_MAX_DAYS:.0f} days, not from "
                f"{utc_text(first)} to {utc_text(last)}"
            )


@spec
class PictureRequest:
    """One camera's picture of the horizon, to be rendered.

    at: time of the exposure; UTC.
    seed: of clouds and noise; the same gives the same picture.
    """

    orbit: Orbit
    attitude: Attitude = LvlhAttitude()
    camera: HorizonCamera
    at: datetime
    scene: Scene = Scene()
    sensor: Sensor = Sensor()
    seed: Annotated[int, Within(0, 2**32 - 1)] = 0

    def __post_init__(self) -> None:
        pixels = self.camera.width_px * self.camera.height_px
        if pixels > PICTURE_PIXELS_MAX:
            raise ValueError(
                f"camera: pictures up to {PICTURE_PIXELS_MAX} pixels are rendered, not {pixels}"
            )


@spec
class HorizonSession:
    """Frames taken every step_s from `start` by the cameras of one carrier.

    attitude: the planned one, to be checked; attitude_sigma_deg: its 1-sigma error about each
    axis.
    """

    orbit: Orbit
    attitude: Attitude = LvlhAttitude()
    attitude_sigma_deg: Annotated[float, Within(0.0, 180.0)] = ATTITUDE_SIGMA_DEG
    cameras: tuple[HorizonCamera, ...]
    body: Body = Body()
    start: datetime
    step_s: Annotated[float, Within(1e-3, 86400.0)]

    def __post_init__(self) -> None:
        require_cameras("cameras", self.cameras)

    def requests(self, count: int) -> tuple[HorizonRequest, ...]:
        """The requests for the first `count` frames; raises OutsideCoverage."""
        moments = [shifted_utc(self.start, k * self.step_s) for k in range(count)]
        r_sat_eci_m, q_body_from_eci, _ = attitudes_at(
            self.orbit, self.attitude.q_body_from_eci, moments
        )
        requests = []
        for moment, r_m, q in zip(moments, r_sat_eci_m, q_body_from_eci.as_quat(), strict=True):
            around = surroundings(moment, r_m, self.cameras, self.body)
            x, y, z = (around.limb.r_itrf_m / 1e3).tolist()
            requests.append(
                HorizonRequest(
                    epoch=moment,
                    position=Position(frame="ITRF", position_km=(x, y, z)),
                    cameras=self.cameras,
                    body=self.body,
                    predicted=PredictedAttitude(
                        q_body_from_eci_xyzw=tuple(q.tolist()), sigma_deg=self.attitude_sigma_deg
                    ),
                )
            )
        return tuple(requests)


@spec
class HorizonFrames:
    """Frames one by one, each as for an estimate."""

    frames: tuple[HorizonRequest, ...]

    def __post_init__(self) -> None:
        if not 1 <= len(self.frames) <= FRAMES_MAX:
            raise ValueError(f"frames must hold 1 to {FRAMES_MAX} of them, not {len(self.frames)}")


ESTIMATE_READER = JsonReader(HorizonRequest)
PREDICTION_READER = JsonReader(PredictionRequest)
PICTURE_READER = JsonReader(PictureRequest)
SESSION_READER = JsonReader(HorizonSession)
FRAMES_READER = JsonReader(HorizonFrames)


@answer
class EstimateResponse(VerticalEstimate):
    """The local vertical in body axes."""

    __pydantic_config__ = BUILT_ON_FIRST_USE

    provenance: ProvenanceOut


@answer
class SeriesResponse(SeriesReport):
    """The nadir over a session."""

    frames: tuple[FrameNadir, ...]
    provenance: ProvenanceOut


@dataclass(frozen=True, kw_only=True)
class PredictionResponse:
    """One view per instant and camera.

    views: instants in the order asked for, cameras within each.
    warnings: cautions to read before relying on it. E.g.
    `["the elements' epoch 2015-02-27T11:40:53Z is 9.0 days from the farthest instant asked for"]`.
    """

    views: list[HorizonView]
    warnings: list[str]
    provenance: ProvenanceOut


def attitudes_at(
    orbit: Orbit,
    q_body_from_eci: Callable[[Instants, OrbitStates], Rotation],
    moments: Sequence[datetime],
) -> tuple[Array, Rotation, tuple[str, ...]]:
    """r_sat_eci_m (n, 3) and q_body_from_eci (n) at any n moments, and the orbit's warnings.

    Raises OutsideCoverage.
    """
    first = min(moments, key=tai_us)
    t_s, place = np.unique([elapsed_s(moment, first) for moment in moments], return_inverse=True)
    instants = Instants(first, t_s)
    ephemeris = orbit.ephemeris(first, max(moments, key=tai_us))
    states = ephemeris.states(instants)
    turned = q_body_from_eci(instants, states)
    return states.r_sat_eci_m[place], turned[place], ephemeris.warnings


def surroundings(
    moment: datetime, r_sat_eci_m: Array, cameras: tuple[HorizonCamera, ...], body: Body
) -> Surroundings:
    """The limb and the Sun as seen from there; raises InvalidInput inside the body."""
    x, y, z = (r_sat_eci_m / 1e3).tolist()
    position = Position(frame="GCRF", position_km=(x, y, z))
    try:
        HorizonRequest(epoch=moment, position=position, cameras=cameras, body=body)
    except ValueError as error:
        raise InvalidInput(f"at {utc_text(moment)} {error}", field="body", at_utc=moment) from None
    return Surroundings(moment, position, body)


def _views(
    r_sat_eci_m: Array,
    q_body_from_eci: Rotation,
    cameras: tuple[HorizonCamera, ...],
    moments: Sequence[datetime],
    body: Body,
    attitude_sigma_deg: float,
) -> list[HorizonView]:
    """Moment by moment every camera's, from (n, 3) positions with n attitudes."""
    from estimator.prediction import predict_horizon

    found = []
    for moment, r_m, q in zip(moments, r_sat_eci_m, q_body_from_eci, strict=True):
        around = surroundings(moment, r_m, cameras, body)
        found += [predict_horizon(camera, around, q, attitude_sigma_deg) for camera in cameras]
    return found


def prediction_json(request: PredictionRequest, provenance: ProvenanceOut) -> bytes:
    law, moments = request.attitude, request.instants
    r_m, q, warnings = attitudes_at(request.orbit, law.q_body_from_eci, moments)
    found = _views(r_m, q, request.cameras, moments, request.body, request.attitude_sigma_deg)
    since_s = np.array([elapsed_s(moment, moments[0]) for moment in moments])
    warnings = (*warnings, *law.warnings_at(Instants(moments[0], since_s)))
    told = list(dict.fromkeys(warnings))
    return to_json(PredictionResponse(views=found, warnings=told, provenance=provenance))


def horizon_checks(plan: FlightPlan, cameras: tuple[HorizonCamera, ...]) -> list[HorizonCheck]:
    """Session by session every camera's part; none without cameras."""
    if not cameras:
        return []
    scenario = plan.scenario
    moments = [
        shifted_utc(session.start, share * elapsed_s(session.stop, session.start))
        for session in scenario.sessions
        for share in SEEN_AT
    ]
    r_m, q, _ = attitudes_at(scenario.orbit, plan.q_body_from_eci, moments)
    seen = _views(r_m, q, cameras, moments, Body(), ATTITUDE_SIGMA_DEG)
    count = len(cameras)
    per_session = len(SEEN_AT) * count
    return [
        _check(number, seen[number * per_session + k : (number + 1) * per_session : count])
        for number in range(len(scenario.sessions))
        for k in range(count)
    ]


def _check(session: int, seen: list[HorizonView]) -> HorizonCheck:
    worst = next((view for view in seen if not view.usable), seen[0])
    return HorizonCheck(
        session=session,
        camera=worst.camera,
        usable=worst.usable,
        reason=worst.reason,
        explanation=worst.explanation,
        views=tuple(seen),
    )


@contextmanager
def _report_out_of_memory() -> Iterator[None]:
    """OpenCV has an error of its own for a lack of memory."""
    import cv2

    try:
        yield
    except cv2.error as error:
        if error.code == cv2.Error.StsNoMem:
            raise MemoryError(error.err) from None
        raise


@_report_out_of_memory()
def measure(
    request: HorizonRequest, images: Sequence[bytes], *, draw: bool
) -> tuple[VerticalEstimate, tuple[bytes, ...]]:
    """The estimate and, if wanted, the annotated frames as PNG files.

    Raises InvalidImage, InvalidCamera.
    """
    from estimator.images import decode_image
    from estimator.pipeline import estimate_vertical

    if len(images) != len(request.cameras):
        raise InvalidCamera(
            f"{len(images)} images for {len(request.cameras)} cameras; send one per camera, in "
            "the cameras' order",
            field="images",
        )
    total = sum(camera.width_px * camera.height_px for camera in request.cameras)
    if total > PIXELS_MAX:
        raise InvalidCamera(
            f"the frames come to {total} pixels together; {PIXELS_MAX} are read at a time: send "
            "fewer, or bin them",
            field="cameras",
        )
    pixels = [
        decode_image(content, f"images.{k}", camera)
        for k, (content, camera) in enumerate(zip(images, request.cameras, strict=True))
    ]
    estimate = estimate_vertical(pixels, request)
    return estimate, _overlays(request, pixels, estimate) if draw else ()


def estimate_json(
    request: HorizonRequest, images: Sequence[bytes], provenance: ProvenanceOut
) -> bytes:
    """Raises InvalidImage, InvalidCamera."""
    estimate, overlays = measure(request, images, draw=request.overlay)
    pictures: list[str | None] = [base64.b64encode(png).decode("ascii") for png in overlays]
    cameras = tuple(
        replace(report, overlay_png=overlay_png)
        for report, overlay_png in zip_longest(estimate.cameras, pictures)
    )
    told = vars(estimate) | {"cameras": cameras}
    return to_json(EstimateResponse(**told, provenance=provenance))


@_report_out_of_memory()
def picture(request: PictureRequest) -> bytes:
    from estimator.overlay import encode_png
    from estimator.rendering.scene import HorizonRenderer

    around, c_body_from_itrf = _surroundings(request)
    horizon = HorizonRenderer(
        around.limb.r_itrf_m, c_body_from_itrf, around.sun_itrf, request.scene, request.seed
    )
    return encode_png(horizon.picture(request.camera, request.sensor))


def picture_json(request: PictureRequest) -> bytes:
    """The rendered picture and what an estimate should find in it, as UTF-8 JSON."""
    around, c_body_from_itrf = _surroundings(request)
    q = Rotation.from_matrix(c_body_from_itrf @ around.c_itrf_from_eci)
    answer = PictureOut(
        image_png=base64.b64encode(picture(request)).decode("ascii"),
        at_utc=request.at,
        position_itrf_m=around.limb.r_itrf_m,
        q_body_from_eci_xyzw=q.as_quat(),
        nadir_body=c_body_from_itrf @ around.limb.nadir_itrf,
        nadir_geodetic_body=c_body_from_itrf @ around.limb.nadir_geodetic_itrf,
    )
    return to_json(answer)


def _surroundings(request: PictureRequest) -> tuple[Surroundings, np.ndarray]:
    [r_m], [q], _ = attitudes_at(request.orbit, request.attitude.q_body_from_eci, [request.at])
    around = surroundings(request.at, r_m, (request.camera,), Body())
    return around, q.as_matrix() @ around.c_itrf_from_eci.T


def _overlays(
    request: HorizonRequest, images: Sequence["Pixels"], estimate: VerticalEstimate
) -> tuple[bytes, ...]:
    from estimator.overlay import draw_overlay, encode_png

    frames = zip(images, request.cameras, estimate.cameras, strict=True)
    return tuple(
        encode_png(draw_overlay(pixels, camera, report, estimate, _expected_px(request, camera)))
        for pixels, camera, report in frames
    )


def _expected_px(request: HorizonRequest, camera: HorizonCamera) -> np.ndarray | None:
    if request.predicted is None:
        return None
    from estimator.prediction import predict_horizon

    around = Surroundings(request.epoch, request.position, request.body)
    q_body_from_eci = Rotation.from_quat(request.predicted.q_body_from_eci_xyzw)
    return predict_horizon(camera, around, q_body_from_eci).limb_px


def read_series(body: bytes) -> HorizonSession | HorizonFrames | None:
    """A session, a list of frames, or None where the text is the request for one estimate."""
    try:
        document = json.loads(body)
    except (ValueError, RecursionError):
        return None
    if isinstance(document, list):
        return FRAMES_READER.read(b'{"frames": ' + body + b"}")
    if isinstance(document, dict) and "frames" in document:
        return FRAMES_READER.read(body)
    if isinstance(document, dict) and "orbit" in document:
        return SESSION_READER.read(body)
    return None


def frame_requests(
    source: HorizonSession | HorizonFrames, images: int
) -> tuple[HorizonRequest, ...]:
    """One request per frame for so many images; raises InvalidInput when they don't come out."""
    if isinstance(source, HorizonFrames):
        needed = sum(len(request.cameras) for request in source.frames)
        if needed != images:
            raise InvalidInput(
                f"{images} images for frames that need {needed}; send each frame's in the "
                "cameras' order, frame after frame",
                field="frames",
            )
        return source.frames
    count, rest = divmod(images, len(source.cameras))
    if rest or not 1 <= count <= FRAMES_MAX:
        raise InvalidInput(
            f"{images} images don't come out for {len(source.cameras)} cameras; send each frame's "
            f"in the cameras' order, up to {FRAMES_MAX} frames",
            field="cameras",
        )
    return source.requests(count)


def series_json(
    requests: Sequence[HorizonRequest],
    frames: Iterator[Sequence["Pixels"]],
    provenance: ProvenanceOut,
) -> bytes:
    """One estimate per frame, and what they tell; frames: a picture each, in the cameras' order."""
    from estimator.pipeline import estimate_vertical
    from estimator.series import frame_nadir, summarise_series

    estimates = tuple(
        estimate_vertical(images, request) for request, images in zip(requests, frames, strict=True)
    )
    sigma_deg = max((r.predicted.sigma_deg for r in requests if r.predicted), default=0.0)
    return to_json(
        SeriesResponse(
            **vars(summarise_series(estimates, math.radians(sigma_deg))),
            frames=tuple(map(frame_nadir, requests, estimates)),
            provenance=provenance,
        )
    )
