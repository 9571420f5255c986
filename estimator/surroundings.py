"""The Earth, its limb and its daylight around a craft at one instant."""

from datetime import datetime

import numpy as np
from numpy.typing import NDArray

from estimator.camera import HorizonCamera
from estimator.errors import Reason
from estimator.limb.geometry import Limb
from estimator.limb.low_sun import AIR_SCALE_M
from estimator.request import Body, Position, PredictedAttitude
from planner.base.arrays import Array
from planner.base.rotation import Rotation
from planner.world.frames.earth_orientation import C_GCRF_FROM_EME2000, c_itrf_from_eci
from planner.world.frames.solar_system import r_sun_eci_m
from planner.world.frames.time_scales import Instants

_NIGHT_LIMB_KM = 60.0
_SUN_LOW_RAD = np.deg2rad(5.0)
_SUN_LEAST_SINE = np.sin(np.deg2rad(3.0))
_SUN_NEAR_RAD = np.deg2rad(30.0)
# Under a low Sun little of the limb is lit and its height leans: what is left may be too vague.
_SUN_VAGUE_SINE = np.sin(np.deg2rad(20.0))


class Surroundings:
    """The limb and the Sun (a unit vector) at a request's epoch, in ITRF axes."""

    def __init__(self, epoch: datetime, position: Position, body: Body) -> None:
        instants = Instants(epoch, np.zeros(1))
        self.c_itrf_from_eci: Array = c_itrf_from_eci(instants)[0]
        r_m = np.array(position.position_km) * 1e3
        if position.frame == "EME2000":
            r_m = C_GCRF_FROM_EME2000 @ r_m
        if position.frame != "ITRF":
            r_m = self.c_itrf_from_eci @ r_m
        self.epoch, self.body = epoch, body
        self.limb = Limb(r_m, body.a_km * 1e3, body.b_km * 1e3)
        sun_m = self.c_itrf_from_eci @ r_sun_eci_m(instants)[0]
        self.sun_itrf: Array = sun_m / np.linalg.norm(sun_m)

    @property
    def daylight(self) -> bool:
        """Whether the limb looked for is the sunlit Earth's."""
        return self.body.limb_height_km is None

    @property
    def air_scale_m(self) -> float:
        """Scale height of the limb's profile; 0 where it is no exponential atmosphere."""
        height_km = self.body.limb_height_km
        airy = height_km is None or 5.0 < height_km < _NIGHT_LIMB_KM
        return AIR_SCALE_M if airy else 0.0

    @property
    def sun_sine(self) -> float:
        """Sine of the Sun's elevation at the craft."""
        return float(-self.limb.nadir_itrf @ self.sun_itrf)

    @property
    def is_sun_vague(self) -> bool:
        """Whether the Sun is so low that much of the craft's limb is not in full daylight."""
        return bool(self.sun_sine < _SUN_VAGUE_SINE)

    def c_body_from_itrf(self, predicted: PredictedAttitude) -> Array:
        """The predicted attitude (3, 3) against ITRF axes."""
        q = Rotation.from_quat(predicted.q_body_from_eci_xyzw)
        return np.asarray(q.as_matrix() @ self.c_itrf_from_eci.T)

    def darkness(self) -> Reason | None:
        """Why the Sun allows no daylight limb, or None."""
        if self.sun_sine > _SUN_LEAST_SINE:
            return None
        # At the far limb the Sun stands higher by the angle that the limb is away.
        lit_as_far_as_rad = float(np.arccos(self.limb.mean_radius_m / self.limb.range_m))
        twilight = np.arcsin(self.sun_sine) > -lit_as_far_as_rad
        return Reason.LOW_SUN if twilight else Reason.NIGHT_SIDE

    def well_lit(self, azimuth_rad: Array, height_m: float) -> NDArray[np.bool_]:
        """Where along the limb, at azimuths (n,), the daylight limb's height is known.

        Under a lower Sun the limb is that of twilight; near the Sun it is that of dust.
        """
        direction_itrf = self.limb.directions_itrf(azimuth_rad, height_m)
        elevation_rad = self.limb.sun_elevation_rad(direction_itrf, height_m, self.sun_itrf)
        from_sun_rad = np.arccos(np.clip(direction_itrf @ self.sun_itrf, -1.0, 1.0))
        return np.asarray((elevation_rad > _SUN_LOW_RAD) & (from_sun_rad > _SUN_NEAR_RAD))

    def is_sun_in_frame(self, camera: HorizonCamera, c_body_from_itrf: Array) -> bool:
        """Whether the Sun's middle shines into the frame, not hidden by the Earth."""
        limb_cosine = np.sqrt(1.0 - (self.limb.mean_radius_m / self.limb.range_m) ** 2)
        hidden = self.sun_itrf @ self.limb.nadir_itrf > limb_cosine
        xy_px = camera.pixels((c_body_from_itrf @ self.sun_itrf)[None])
        return bool(camera.sees(xy_px)[0]) and not hidden
