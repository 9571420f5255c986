"""A child's work on images of the horizon, and predicted views of horizon cameras.

Bytes in, bytes out: what comes from outside is decoded nowhere else.
"""

import base64
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from datetime import datetime
from typing import TYPE_CHECKING

import numpy as np

from app.answers.horizon import PictureOut, PredictionResponse, estimate_out
from app.answers.members import ProvenanceOut, to_json
from app.requests.horizon import ATTITUDE_SIGMA_DEG, PictureRequest, PredictionRequest
from estimator.camera import HorizonCamera
from estimator.errors import InvalidCamera
from estimator.found import HorizonCheck, HorizonView
from estimator.request import Body, HorizonRequest, Position
from estimator.surroundings import Surroundings
from planner.base.arrays import Array
from planner.base.errors import InvalidInput
from planner.base.rotation import Rotation
from planner.world.frames.time_scales import Instants, elapsed_s, shifted_utc, tai_us, utc_text
from planner.world.orbits import Orbit, OrbitStates
from planner.world.plan import FlightPlan

if TYPE_CHECKING:
    from estimator.images import Pixels
    from estimator.pipeline import VerticalEstimate

# Decoded and measured within a second and 500 MB.
PIXELS_MAX = 25_000_000
SEEN_AT = (0.0, 0.5, 1.0)  # shares of a session


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
) -> tuple["VerticalEstimate", tuple[bytes, ...]]:
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
    estimate, overlays = measure(request, images, draw=request.overlay)
    return to_json(estimate_out(estimate, request.epoch, overlays, provenance))


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
    request: HorizonRequest, images: Sequence["Pixels"], estimate: "VerticalEstimate"
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
