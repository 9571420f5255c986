"""A request to the horizon estimator: the fields of `POST /v1/horizon/estimates`."""

from datetime import datetime
from typing import Annotated, Literal

import numpy as np

from estimator.camera import HorizonCamera, require_unit_quaternion
from planner.base.spec import UnitPart, Within, spec
from planner.world.frames.geodesy import WGS84_A_M, WGS84_B_M

MAX_CAMERAS = 16
_MAX_RANGE_KM = 500_000.0
_RateDegS = Annotated[float, Within(-20.0, 20.0)]
_PartKm = Annotated[float, Within(-_MAX_RANGE_KM, _MAX_RANGE_KM)]


@spec
class Position:
    """Position of the craft at the request's epoch.

    frame: of the position.
    position_km: x, y, z from the Earth's centre.
    """

    frame: Literal["ITRF", "EME2000", "GCRF"]
    position_km: tuple[_PartKm, _PartKm, _PartKm]


@spec
class Body:
    """The body whose limb is seen; by default the Earth with its limb in daylight.

    a_km: equatorial radius of its ellipsoid.
    b_km: polar radius of its ellipsoid.
    limb_height_km: height of the limb's steepest brightness above the ellipsoid, however bright
    that is. Left out, it is the daylight limb's, low Sun included, and frames whose limb lies in
    the dark are refused. Heights above 60 km mean the airglow layer at night. E.g. `16.0`.
    limb_height_sigma_km: 1-sigma scatter of that height. E.g. `0.5`.
    """

    a_km: Annotated[float, Within(100.0, 1e5)] = WGS84_A_M / 1e3
    b_km: Annotated[float, Within(50.0, 1e5)] = WGS84_B_M / 1e3
    limb_height_km: Annotated[float, Within(-20.0, 1000.0)] | None = None
    limb_height_sigma_km: Annotated[float, Within(0.0, 100.0)] | None = None

    def __post_init__(self) -> None:
        if not 0.5 * self.a_km <= self.b_km <= self.a_km:
            raise ValueError(
                f"b_km must lie between half of a_km and a_km ({self.a_km}), not {self.b_km}"
            )
        if (self.limb_height_km is None) != (self.limb_height_sigma_km is None):
            raise ValueError("give limb_height_km and limb_height_sigma_km together, or neither")

    @property
    def highest_limb_km(self) -> float:
        """Above any limb the estimator will try."""
        if self.limb_height_km is None or self.limb_height_sigma_km is None:
            return 60.0
        return max(self.limb_height_km, 0.0) + 10.0 * self.limb_height_sigma_km


@spec
class PredictedAttitude:
    """The attitude to be checked.

    q_body_from_eci_xyzw: scalar last, `Rotation.from_quat(q).apply(v_eci)` gives `v_body`.
    sigma_deg: 1-sigma error about each axis.
    """

    q_body_from_eci_xyzw: tuple[UnitPart, UnitPart, UnitPart, UnitPart]
    sigma_deg: Annotated[float, Within(0.0, 180.0)]

    def __post_init__(self) -> None:
        require_unit_quaternion("q_body_from_eci_xyzw", self.q_body_from_eci_xyzw)


@spec
class HorizonRequest:
    """Images of one instant, one per camera in the cameras' order, and what is known.

    epoch: time of the images; UTC.
    position: position of the craft.
    cameras: those that took the images, in the images' order.
    predicted: the attitude to be checked; none is measured against nothing.
    rate_body_deg_s: the body's rate against the stars, on its axes. It matters for cameras with
    `readout_s`, whose rows then see the limb from different attitudes.
    rate_sigma_deg_s: its 1-sigma on each axis. Left out, the rate is as good as unknown.
    overlay: true to get the frames annotated, as PNG.
    """

    epoch: datetime
    position: Position
    cameras: tuple[HorizonCamera, ...]
    body: Body = Body()
    predicted: PredictedAttitude | None = None
    rate_body_deg_s: tuple[_RateDegS, _RateDegS, _RateDegS] = (0.0, 0.0, 0.0)
    rate_sigma_deg_s: Annotated[float, Within(0.0, 20.0)] = 3.0
    overlay: bool = False

    def __post_init__(self) -> None:
        require_cameras("cameras", self.cameras)
        range_km = float(np.linalg.norm(self.position.position_km))
        least_km = self.body.a_km * 1.015 + self.body.highest_limb_km
        if not least_km < range_km < _MAX_RANGE_KM:
            raise ValueError(
                f"position_km is {range_km:.1f} km from the body's centre; it must be above "
                f"{least_km:.0f} and below {_MAX_RANGE_KM:.0f} km"
            )


def require_cameras(field: str, cameras: tuple[HorizonCamera, ...]) -> None:
    """Raise ValueError unless there are one to sixteen, each with a name of its own."""
    if not 1 <= len(cameras) <= MAX_CAMERAS:
        raise ValueError(f"{field} must hold 1 to {MAX_CAMERAS} of them, not {len(cameras)}")
    names = [camera.name for camera in cameras]
    if len(set(names)) < len(names):
        raise ValueError(f"{field} need names of their own, not {names}")
