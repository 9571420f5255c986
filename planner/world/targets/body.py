"""The Sun, the Moon or a planet as a target."""

import math
from typing import Literal

import numpy as np

from planner.base.arrays import Array
from planner.base.spec import spec
from planner.world.frames.solar_system import BODIES, r_body_bary_m
from planner.world.frames.time_scales import Instants
from planner.world.targets.apparent import SPEED_OF_LIGHT_M_S
from planner.world.targets.refraction import Refraction
from planner.world.targets.sky import GRAZING_ALTITUDE_KM, GrazingAltitudeKm, SkyTarget

HIDDEN_RAD = math.radians(1.5)  # below the limb: refraction lifts by 1.1 deg, half a disk is 0.3
LIGHT_TIME_PASSES = 4  # each shrinks the error by v/c = 1e-4, Mercury's 1.6e-4 being the worst


@spec
class BodyTarget(SkyTarget):
    """The centre of the Sun, the Moon or a planet, from JPL's DE421.

    name: Sun, Moon or a planet, in either case.  Of the giant planets it is the centre of mass with
    their moons; the centre of the lit part of a disk is elsewhere.
    """

    mode: Literal["body"] = "body"
    name: str
    grazing_altitude_km: GrazingAltitudeKm = GRAZING_ALTITUDE_KM
    refraction: Refraction = "none"

    def __post_init__(self) -> None:
        if self.body_seen() not in BODIES:
            raise ValueError(f"name must be one of {', '.join(BODIES)}, not {self.name[:40]!r}")
        super().__post_init__()

    @property
    def label(self) -> str:
        """Its name."""
        return self.name

    def body_seen(self) -> str:
        """The ephemeris's name."""
        return self.name.lower()

    def seen_from(self, instants: Instants, r_observer_bary_m: Array) -> tuple[Array, Array]:
        """Directions from where it was when the light left; see `SkyTarget`."""
        light_time_s = np.zeros(len(instants.t_s))
        for _ in range(LIGHT_TIME_PASSES):
            emitted = Instants(instants.epoch_utc, instants.t_s - light_time_s)
            los_m = r_body_bary_m(self.body_seen(), emitted) - r_observer_bary_m
            range_m = np.linalg.norm(los_m, axis=1)
            light_time_s = range_m / SPEED_OF_LIGHT_M_S
        return los_m / range_m[:, None], range_m
