"""Points on the ground as a satellite passes them."""

from dataclasses import dataclass
from datetime import datetime
from functools import cached_property

import numpy as np

from planner.base.arrays import Array
from planner.world.frames.earth_orientation import c_itrf_from_eci, itrf_from_eci_state
from planner.world.frames.local_orbital import q_lvlh_from_eci
from planner.world.frames.time_scales import Instants
from planner.world.orbits import Ephemeris


@dataclass(frozen=True, kw_only=True)
class PassingOptions:
    """How closely a pass is looked at."""

    track_step_s: float = 5.0  # its velocity turns by 0.3 deg


OPTIONS = PassingOptions()


@dataclass(frozen=True, kw_only=True)
class Passing:
    """An orbit over a time; times are seconds since its start."""

    ephemeris: Ephemeris
    start_utc: datetime
    duration_s: float

    def look_angles(self, r_target_itrf_m: Array, t_s: Array) -> tuple[Array, Array]:
        """Angles of the direction to a point (3,) along and across the track, rad, (n,) each.

        along: positive ahead; across: positive to the right of flight, both from geocentric
        nadir in LVLH (atan2 of the component and the downward one); behind the horizon: pi.
        """
        instants = Instants(self.start_utc, t_s)
        states = self.ephemeris.states(instants)
        c_itrf = c_itrf_from_eci(instants)
        target_itrf_m = np.broadcast_to(r_target_itrf_m, (len(t_s), 3))
        r_target_eci_m = np.einsum("nji,nj->ni", c_itrf, target_itrf_m)
        q_lvlh = q_lvlh_from_eci(states.r_sat_eci_m, states.v_sat_eci_m_s)
        x, y, z = q_lvlh.apply(r_target_eci_m - states.r_sat_eci_m).T
        r_sat_itrf_m = np.einsum("nij,nj->ni", c_itrf, states.r_sat_eci_m)
        hidden = np.sum((r_sat_itrf_m - r_target_itrf_m) * r_target_itrf_m, axis=1) < 0.0
        return np.where(hidden, np.pi, np.arctan2(x, z)), np.where(hidden, np.pi, np.arctan2(y, z))

    @cached_property
    def _track_itrf(self) -> tuple[Array, Array]:
        """The satellite's position, m, and velocity, m/s, (n, 3) each."""
        instants = Instants(
            self.start_utc, np.arange(0.0, self.duration_s + 1.0, OPTIONS.track_step_s)
        )
        states = self.ephemeris.states(instants)
        return itrf_from_eci_state(states.r_sat_eci_m, states.v_sat_eci_m_s, instants)

    def velocity_passing(self, r_itrf_m: Array) -> Array:
        """The satellite's velocity in ITRF, m/s, (3,), where it is nearest to a point."""
        r_track_itrf_m, v_track_itrf_m_s = self._track_itrf
        nearest = np.argmin(np.linalg.norm(r_track_itrf_m - r_itrf_m, axis=1))
        return np.asarray(v_track_itrf_m_s[nearest])

    def range_passing_m(self, r_itrf_m: Array) -> float | None:
        """The satellite's least distance from a point that sees it; None where it never does."""
        to_sat_m = self._track_itrf[0] - r_itrf_m
        seen = to_sat_m[to_sat_m @ r_itrf_m > 0.0]
        return float(np.linalg.norm(seen, axis=1).min()) if len(seen) else None
