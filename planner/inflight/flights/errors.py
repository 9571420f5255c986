"""Errors of a plan's sessions: the causes of its pointing budget and their sizes."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Array, cross
from planner.inflight.flights.draws import Draw
from planner.planning.sessions.uncertainty import ut1_sigma_s
from planner.world.attitude import AttitudeLaw
from planner.world.frames.time_scales import Instants
from planner.world.orbits import Ephemeris, OrbitStates

ATTITUDE_INSTANTS = (3, 11)  # of a session: as the budget, fewer where there are many sessions
_INSTANTS = 330  # of all of them: the attitude's joint covariance takes their number cubed


@dataclass(frozen=True, kw_only=True, eq=False)
class SessionErrors:
    """1-sigma errors over one session, at n instants.

    orbit_m: (n, 3), radial, along and across the track.  attitude_body_rad: (m, n, 3), independent
    turns.  swing_body_rad: (3,), rms; its phase grows by swing_phase_rad (n,), from the plan's
    first session on.  ut1_s: of the Earth's turning.
    """

    orbit_m: Array
    is_along_laplace: bool
    attitude_body_rad: Array
    swing_body_rad: Array
    swing_phase_rad: Array
    ut1_s: float

    def moved(self, states: OrbitStates, draw: Draw) -> OrbitStates:
        """The orbit as flown: raised, turned ahead about its normal, and shifted across."""
        along = draw.along_laplace_score if self.is_along_laplace else draw.orbit_scores[1]
        radial_m, along_m, cross_m = (
            self.orbit_m * [draw.orbit_scores[0], along, draw.orbit_scores[2]]
        ).T
        r, v = states.r_sat_eci_m, states.v_sat_eci_m_s
        radius = np.linalg.norm(r, axis=1)
        normal = cross(r, v)
        normal /= np.linalg.norm(normal, axis=1, keepdims=True)
        turn = along_m / radius
        c, s = np.cos(turn)[:, None], np.sin(turn)[:, None]
        # Both square to the normal, so that the turn needs no third term.
        r_ahead, v_ahead = c * r + s * cross(normal, r), c * v + s * cross(normal, v)
        raised = (1.0 + radial_m / radius)[:, None]
        return OrbitStates(r_ahead * raised + cross_m[:, None] * normal, v_ahead)

    def turned_body_rad(self, draw: Draw) -> Array:
        """Rotation vectors from the planned body to the flown one, (n, 3)."""
        steady = np.einsum("m,mna->na", draw.attitude_scores, self.attitude_body_rad)
        swing = np.cos(self.swing_phase_rad[:, None] - draw.phase_rad)
        return np.asarray(steady + np.sqrt(2.0) * draw.swing_share * self.swing_body_rad * swing)


def session_errors(
    ephemerides: Sequence[Ephemeris],
    attitude: AttitudeLaw,
    instants: Sequence[Instants],
    states: Sequence[OrbitStates],
) -> list[SessionErrors]:
    """Of a plan's sessions together: a run's attitude is off in one as it is in the others.

    instants, states: of each session, on one epoch.
    """
    count = int(np.clip(_INSTANTS // len(instants), *ATTITUDE_INSTANTS))
    few_s = [np.linspace(at.t_s[0], at.t_s[-1], count) for at in instants]
    told = attitude.errors(Instants(instants[0].epoch_utc, np.concatenate(few_s)))
    modes = told.modes_body_rad
    if not len(modes):
        sigma = np.broadcast_to(told.sigma_body_rad, (len(few_s) * count, 3))
        modes = sigma * np.eye(3)[:, None, :]
    begin_s = float(instants[0].t_s[0])
    found = []
    for number, (ephemeris, at, flown) in enumerate(
        zip(ephemerides, instants, states, strict=True)
    ):
        mine = slice(number * count, (number + 1) * count)
        sigma_m = ephemeris.sigma(at)
        r_m, v_m_s = flown.r_sat_eci_m, flown.v_sat_eci_m_s
        rate_rad_s = np.linalg.norm(cross(r_m, v_m_s), axis=1) / np.sum(r_m**2, axis=1)
        found.append(
            SessionErrors(
                orbit_m=np.stack([sigma_m.radial_m, sigma_m.along_m, sigma_m.cross_m], axis=1),
                is_along_laplace=sigma_m.is_along_laplace,
                attitude_body_rad=_between(at.t_s, few_s[number], modes[:, mine]),
                swing_body_rad=told.swing_rms_body_rad,
                swing_phase_rad=rate_rad_s * (at.t_s - begin_s),
                ut1_s=ut1_sigma_s(at),
            )
        )
    return found


def _between(t_s: Array, few_s: Array, modes_rad: Array) -> Array:
    """Linear between a few instants: (m, k, 3) to (m, n, 3)."""
    by_mode = [
        np.stack([np.interp(t_s, few_s, mode_rad[:, axis]) for axis in range(3)], axis=1)
        for mode_rad in modes_rad
    ]
    return np.array(by_mode).reshape(-1, len(t_s), 3)
