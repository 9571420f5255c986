"""Requests about the horizon, besides those for an estimate."""

from datetime import datetime
from typing import Annotated

from pydantic import FailFast, Field

from app.requests.json_reader import JsonReader
from estimator.camera import HorizonCamera
from estimator.rendering.scene import Scene
from estimator.rendering.sensor import Sensor
from estimator.request import Body, HorizonRequest, require_cameras
from planner.base.spec import Within, spec
from planner.world.attitude import Attitude
from planner.world.attitude.lvlh import LvlhAttitude
from planner.world.frames.time_scales import DAY_S, elapsed_s, utc_text
from planner.world.orbits import Orbit

VIEWS_MAX = 2000
SPAN_MAX_DAYS = 3.0
ATTITUDE_SIGMA_DEG = 0.5
PICTURE_PIXELS_MAX = 4_200_000


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


ESTIMATE_READER = JsonReader(HorizonRequest)
PREDICTION_READER = JsonReader(PredictionRequest)
PICTURE_READER = JsonReader(PictureRequest)

read_estimate_request = ESTIMATE_READER.read
read_prediction_request = PREDICTION_READER.read
read_picture_request = PICTURE_READER.read
