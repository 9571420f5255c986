"""What all requests of a session share: orbit, clock, spacecraft, and where a point is seen."""

from dataclasses import dataclass
from datetime import datetime, timedelta

import numpy as np

from planner.arrays import Array
from planner.errors import InvalidInput
from planner.frames.earth_orientation import c_itrf_from_eci, itrf_from_eci_state
from planner.frames.geodesy import WGS84_A_M
from planner.frames.local_orbital import q_lvlh_from_eci
from planner.frames.time_scales import Instants, elapsed_s
from planner.orbits import Ephemeris
from planner.spacecraft.imaging.ground_arc import ChebyshevProfile, GroundArc, fitted_profile
from planner.spacecraft.requests import ImagingPlanRequest
from planner.spacecraft.table import TICK_S
from planner.spacecraft.turns.turn_time import TurnTime, turn_time
from planner.spacecraft.vehicle.definition import AgileSpacecraft

HEIGHT_MAX_M = 2000e3  # a low orbit: from higher the camera's angles and the turns mean little
_ORBIT_MARGIN = timedelta(seconds=200)  # scans are continued backwards, turns forwards


@dataclass(frozen=True, kw_only=True)
class ImagingSession:
    """Times are seconds since the session's start; duration_s: a whole number of ticks."""

    request: ImagingPlanRequest
    ephemeris: Ephemeris
    duration_s: float
    spacecraft: AgileSpacecraft
    turn_time: TurnTime

    @property
    def epoch_utc(self) -> datetime:
        return self.request.start

    @property
    def last_row(self) -> int:
        return round(self.duration_s / TICK_S)

    def instants(self, t_s: Array) -> Instants:
        return Instants(self.epoch_utc, t_s)

    def profile(self, arc: GroundArc | None, start_s: float, stop_s: float) -> ChebyshevProfile:
        """The attitude that scans an arc (None: orbital orientation), from start_s to stop_s."""
        return fitted_profile(arc, self.ephemeris, self.epoch_utc, (start_s, stop_s))

    def look_angles(self, r_target_itrf_m: Array, t_s: Array) -> tuple[Array, Array]:
        """Angles of the direction to a point (3,) along and across the track, rad, (n,) each.

        along: positive ahead; across: positive to the right of flight, both from geocentric
        nadir in LVLH (atan2 of the component and the downward one); behind the horizon: pi.
        """
        instants = self.instants(t_s)
        states = self.ephemeris.states(instants)
        c_itrf = c_itrf_from_eci(instants)
        target_itrf_m = np.broadcast_to(r_target_itrf_m, (len(t_s), 3))
        r_target_eci_m = np.einsum("nji,nj->ni", c_itrf, target_itrf_m)
        q_lvlh = q_lvlh_from_eci(states.r_sat_eci_m, states.v_sat_eci_m_s)
        x, y, z = q_lvlh.apply(r_target_eci_m - states.r_sat_eci_m).T
        r_sat_itrf_m = np.einsum("nij,nj->ni", c_itrf, states.r_sat_eci_m)
        hidden = np.sum((r_sat_itrf_m - r_target_itrf_m) * r_target_itrf_m, axis=1) < 0.0
        return np.where(hidden, np.pi, np.arctan2(x, z)), np.where(hidden, np.pi, np.arctan2(y, z))

    def velocity_passing(self, r_itrf_m: Array, step_s: float) -> Array:
        """The satellite's velocity in ITRF, m/s, (3,), where it is nearest to a point.

        step_s: of the instants looked at.
        """
        instants = self.instants(np.arange(0.0, self.duration_s + 1.0, step_s))
        states = self.ephemeris.states(instants)
        r, v = itrf_from_eci_state(states.r_sat_eci_m, states.v_sat_eci_m_s, instants)
        return np.asarray(v[np.argmin(np.linalg.norm(r - r_itrf_m, axis=1))])


def make_session(request: ImagingPlanRequest) -> ImagingSession:
    """The orbit and the spacecraft of a request, made ready.  Raises InvalidInput."""
    spacecraft = request.definition()
    ephemeris = request.orbit.ephemeris(request.start - _ORBIT_MARGIN, request.stop + _ORBIT_MARGIN)
    states = ephemeris.states(Instants(request.start, np.zeros(1)))
    height_m = float(np.linalg.norm(states.r_sat_eci_m[0])) - WGS84_A_M
    if height_m > HEIGHT_MAX_M:
        raise InvalidInput(
            f"the orbit is {height_m / 1e3:.0f} km high at the session's start; this spacecraft "
            f"images from low orbits, up to {HEIGHT_MAX_M / 1e3:.0f} km: give the orbit of such a "
            "one",
            field="orbit",
        )
    return ImagingSession(
        request=request,
        ephemeris=ephemeris,
        duration_s=int(elapsed_s(request.stop, request.start) / TICK_S + 1e-6) * TICK_S,
        spacecraft=spacecraft,
        turn_time=turn_time(spacecraft),
    )
