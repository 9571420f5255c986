"""The session that all requests share: orbit, clock, spacecraft, and where a point is seen."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from datetime import datetime, timedelta
from functools import cached_property

import numpy as np

from planner.base.arrays import Array
from planner.base.errors import InvalidInput
from planner.base.mrp import BodyMotion
from planner.base.rotation import Rotation
from planner.spacecraft.imaging.ground_arc import ChebyshevProfile, GroundArc, fitted_profile
from planner.spacecraft.requests import ImagingPlanRequest
from planner.spacecraft.slews.slew_time import SlewTime, slew_time
from planner.spacecraft.table import TICK_S
from planner.spacecraft.vehicle.definition import AgileSpacecraft
from planner.world.frames.geodesy import WGS84_A_M
from planner.world.frames.time_scales import Instants, elapsed_s, shifted_utc, utc_text
from planner.world.orbits import Ephemeris
from planner.world.targets.passing import Passing

HEIGHT_MAX_M = 2000e3  # a low orbit: from higher the camera's angles and the slews mean little
HEIGHT_STEP_S = 30.0
START_SPAN_S = (-1.0, 30.0)  # of the profile that the rate at row 0 is taken from
_ORBIT_MARGIN = timedelta(seconds=200)  # scans are continued backwards, slews forwards

# q_body_from_eci and body rates at instants (m,): what a stretch of a timeline follows.
AttitudeAt = Callable[[Array], tuple[Rotation, BodyMotion]]


@dataclass(frozen=True, kw_only=True)
class ImagingSession:
    """Times are seconds since the session's start; duration_s: a whole number of ticks.

    momentum_eci_n_m_s: of body and gyros at the start, (3,).
    """

    request: ImagingPlanRequest
    ephemeris: Ephemeris
    duration_s: float
    spacecraft: AgileSpacecraft
    momentum_eci_n_m_s: Array
    slew_time: SlewTime

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

    @cached_property
    def passing(self) -> Passing:
        """Where points on the ground are seen."""
        return Passing(
            ephemeris=self.ephemeris, start_utc=self.epoch_utc, duration_s=self.duration_s
        )


def make_session(request: ImagingPlanRequest) -> ImagingSession:
    """The orbit and the spacecraft of a request, made ready.  Raises InvalidInput."""
    spacecraft = request.definition()
    ephemeris = request.orbit.ephemeris(request.start - _ORBIT_MARGIN, request.stop + _ORBIT_MARGIN)
    _refuse_height(request, ephemeris)
    q_body_from_eci, motion = initial_profile(request, ephemeris)(np.zeros(1))
    gyros_body_n_m_s = np.array(request.settings.momentum_n_m_s)
    momentum_eci_n_m_s = (
        q_body_from_eci[0]
        .inv()
        .apply(np.array(spacecraft.inertia_kg_m2) * motion.omega_body_rad_s[0] + gyros_body_n_m_s)
    )
    return ImagingSession(
        request=request,
        ephemeris=ephemeris,
        duration_s=int(elapsed_s(request.stop, request.start) / TICK_S + 1e-6) * TICK_S,
        spacecraft=spacecraft,
        momentum_eci_n_m_s=momentum_eci_n_m_s,
        slew_time=slew_time(spacecraft, momentum_eci_n_m_s),
    )


def initial_profile(request: ImagingPlanRequest, ephemeris: Ephemeris) -> AttitudeAt:
    """What the spacecraft follows at row 0: orbital orientation, or rest in another attitude."""
    q_body_from_eci_xyzw = request.initial_q_body_from_eci_xyzw
    if q_body_from_eci_xyzw is None:
        return fitted_profile(None, ephemeris, request.start, START_SPAN_S).attitude_at

    def at_rest(t_s: Array) -> tuple[Rotation, BodyMotion]:
        still = BodyMotion(*np.zeros((3, len(t_s), 3)))
        return Rotation.from_quat([q_body_from_eci_xyzw] * len(t_s)), still

    return at_rest


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
