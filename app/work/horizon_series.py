"""The vertical over a session's frames: from many requests, or an orbit and its cameras."""

import json
import math
from collections.abc import Iterator, Sequence
from datetime import datetime
from typing import Annotated

from app.answers.members import ProvenanceOut, to_json
from app.requests.json_reader import JsonReader
from app.work.horizon import ATTITUDE_SIGMA_DEG, attitudes_at, surroundings
from estimator.camera import HorizonCamera
from estimator.check import Verdict
from estimator.found import Direction, ReasonWord, SeriesReport, VerticalEstimate
from estimator.images import Pixels
from estimator.pipeline import estimate_vertical
from estimator.request import (
    Body,
    HorizonRequest,
    Position,
    PredictedAttitude,
    require_cameras,
)
from estimator.series import summarise_series
from planner.base.answer_members import Angle, AngleSize, answer
from planner.base.errors import InvalidInput
from planner.base.spec import Within, spec
from planner.world.attitude import Attitude
from planner.world.attitude.lvlh import LvlhAttitude
from planner.world.frames.time_scales import Utc, shifted_utc
from planner.world.orbits import Orbit

FRAMES_MAX = 10_000


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


@answer
class FrameNadir:
    """One frame; along and across as in an estimate's `check`, null where it has none."""

    at_utc: Utc
    verdict: Verdict
    reason: ReasonWord | None
    nadir_body: Direction | None
    sigma_rad: AngleSize | None
    along_rad: Angle | None
    across_rad: Angle | None


@answer
class SeriesResponse(SeriesReport):
    """The nadir over a session."""

    frames: tuple[FrameNadir, ...]
    provenance: ProvenanceOut


_SESSION = JsonReader(HorizonSession)
_FRAMES = JsonReader(HorizonFrames)


def read_series(body: bytes) -> HorizonSession | HorizonFrames | None:
    """A session, a list of frames, or None where the text is the request for one estimate."""
    try:
        document = json.loads(body)
    except (ValueError, RecursionError):
        return None
    if isinstance(document, list):
        return _FRAMES.read(b'{"frames": ' + body + b"}")
    if isinstance(document, dict) and "frames" in document:
        return _FRAMES.read(body)
    if isinstance(document, dict) and "orbit" in document:
        return _SESSION.read(body)
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
    frames: Iterator[Sequence[Pixels]],
    provenance: ProvenanceOut,
) -> bytes:
    """One estimate per frame, and what they tell; frames: a picture each, in the cameras' order."""
    estimates = tuple(
        estimate_vertical(images, request) for request, images in zip(requests, frames, strict=True)
    )
    sigma_deg = max((r.predicted.sigma_deg for r in requests if r.predicted), default=0.0)
    return to_json(
        SeriesResponse(
            **vars(summarise_series(estimates, math.radians(sigma_deg))),
            frames=tuple(map(_frame, requests, estimates)),
            provenance=provenance,
        )
    )


def _frame(request: HorizonRequest, estimate: VerticalEstimate) -> FrameNadir:
    check = estimate.check
    return FrameNadir(
        at_utc=request.epoch,
        verdict=estimate.verdict,
        reason=estimate.reason,
        nadir_body=estimate.nadir_body,
        sigma_rad=estimate.sigma_rad,
        along_rad=check.along_rad if check else None,
        across_rad=check.across_rad if check else None,
    )
