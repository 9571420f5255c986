"""The session that all requests share: orbit, clock, spacecraft, and where a point is seen."""

import math
from dataclasses import dataclass
from datetime import datetime, timedelta
from functools import cached_property

import numpy as np

from planner.base.arrays import Array
from planner.base.errors import InvalidInput
from planner.base.rotation import Rotation
from planner.spacecraft.imaging.ground_arc import (
    GroundArc,
    orbital_q_body_from_eci,
    scan_q_body_from_eci,
)
from planner.spacecraft.imaging.slews import Slews
from planner.spacecraft.requests import ImagingPlanRequest
from planner.spacecraft.table import TICK_S
from planner.spacecraft.vehicle import AgileSpacecraft
from planner.world.frames.geodesy import WGS84_A_M
from planner.world.frames.time_scales import Instants, elapsed_s, shifted_utc, utc_text
from planner.world.orbits import Ephemeris
from planner.world.platforms import BodyPlatform
from planner.world.targets.passing import Passing

HEIGHT_MAX_M = 2000e3  # a low orbit: from higher the camera's angles and the slews mean little
HEIGHT_STEP_S = 30.0
_ORBIT_MARGIN = timedelta(seconds=200)  # scans are continued beyond the session


@dataclass(frozen=True, kw_only=True)
class ImagingSession:
    """Times are seconds since the session's start; duration_s: a whole number of ticks.

    slews: of the spacecraft as the pipeline of a body turns it.
    """

    request: ImagingPlanRequest
    ephemeris: Ephemeris
    duration_s: float
    spacecraft: AgileSpacecraft
    slews: Slews

    @property
    def epoch_utc(self) -> datetime:
        return self.request.start

    @property
    def priorities(self) -> list[float]:
        """Of its requests."""
        return [one.priority for one in self.request.requests]

    @property
    def last_row(self) -> int:
        return round(self.duration_s / TICK_S)

    def instants(self, t_s: Array) -> Instants:
        return Instants(self.epoch_utc, t_s)

    @property
    def platform(self) -> BodyPlatform:
        return self.slews.platform

    def q_body_from_eci(self, arc: GroundArc | None, begins_s: Array, t_s: Array) -> Rotation:
        """n attitudes on an arc whose scans begin then, or in orbital orientation."""
        if arc is None:
            return orbital_q_body_from_eci(self.ephemeris, self.instants(t_s))
        share = (t_s - begins_s) / arc.duration_s
        return scan_q_body_from_eci(arc, share, self.ephemeris, self.instants(t_s))

    def ends(self, arc: GroundArc | None, begins_s: Array, after_s: float) -> Array:
        """States as of `Slews`, so long after the scans of an arc begin, (n, 11); None: in orbital
        orientation."""
        t_s = begins_s + after_s
        return self.slews.states(
            lambda more_s: self.q_body_from_eci(arc, begins_s, t_s + more_s).inv()
        )

    def entries(self, arc: GroundArc, begins_s: Array) -> Array:
        """In which lines are joined whose scans begin then."""
        return self.ends(arc, begins_s, -self.slews.settle_s)

    @cached_property
    def passing(self) -> Passing:
        """Where points on the ground are seen."""
        return Passing(
            ephemeris=self.ephemeris, start_utc=self.epoch_utc, duration_s=self.duration_s
        )


def make_session(request: ImagingPlanRequest) -> ImagingSession:
    """The orbit and the spacecraft of a request, made ready.

    Raises InvalidInput, and InfeasibleSlew where the gyros are too full to turn.
    """
    ephemeris = request.orbit.ephemeris(request.start - _ORBIT_MARGIN, request.stop + _ORBIT_MARGIN)
    _refuse_height(request, ephemeris)
    spacecraft = request.definition()
    return ImagingSession(
        request=request,
        ephemeris=ephemeris,
        duration_s=int(elapsed_s(request.stop, request.start) / TICK_S + 1e-6) * TICK_S,
        spacecraft=spacecraft,
        slews=Slews(platform=spacecraft.platform(request.settings.momentum_n_m_s)),
    )


def _refuse_height(request: ImagingPlanRequest, ephemeris: Ephemeris) -> None:
    """Looked at where the session begins and ends, and so closely between that no apogee is
    missed by 1 km (an acceleration of 9 m/s^2)."""
    seconds = elapsed_s(request.stop, request.start)
    t_s = np.linspace(0.0, seconds, math.ceil(seconds / HEIGHT_STEP_S) + 1)
    states = ephemeris.states(Instants(request.start, t_s))
    heights_m = np.linalg.norm(states.r_sat_eci_m, axis=1) - WGS84_A_M
    highest = int(np.argmax(heights_m))
    if heights_m[highest] > HEIGHT_MAX_M:
        at_utc = shifted_utc(request.start, float(t_s[highest]))
        raise InvalidInput(
            f"the orbit is {heights_m[highest] / 1e3:.0f} km high at {utc_text(at_utc)}, in the "
            f"session; this spacecraft images from low orbits, up to {HEIGHT_MAX_M / 1e3:.0f} km: "
            "give the orbit of such a one, or a session while it is low",
            field="orbit",
        )
