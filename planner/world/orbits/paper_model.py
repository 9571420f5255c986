"""The paper's prediction of the orbit: J2 and J4 only, Runge-Kutta steps of 1 s."""

import math
from dataclasses import dataclass
from datetime import datetime
from functools import lru_cache

import numpy as np

from planner.base.arrays import Array
from planner.base.interpolation import hermite
from planner.world.frames.earth_orientation import (
    OMEGA_EARTH_RAD_S,
    eci_from_itrf_state,
    itrf_from_eci_state,
)
from planner.world.frames.time_scales import Instants, elapsed_s
from planner.world.orbits.accuracy import OrbitSigma, state_sigma
from planner.world.orbits.ephemeris import Ephemeris, OrbitStates

State = tuple[float, float, float, float, float, float]

STEP_S = 1.0
CACHE_STEPS, CACHE_SIZE = 900, 600  # three days either way, 26 MB
_MU = 398600.4418e9  # m^3/s^2: Sumarokov 2016, eq. 6
_P1 = -66063.46e6  # m^2, -1.5 J2 Re^2: Sumarokov 2016, eq. 6
_P2 = 1.6752e21  # m^4, -(5/8) J4 Re^4; the paper prints 2.5023e9 km^4, 49 % too large


@dataclass(frozen=True, eq=False, kw_only=True)
class PaperEphemeris(Ephemeris):
    """The paper's prediction, a state a second.

    t_s: shape (k,), increasing, from epoch_utc.  r_eci_m, v_eci_m_s: shape (k, 3).
    """

    t_s: Array
    r_eci_m: Array
    v_eci_m_s: Array

    def interpolate(self, instants: Instants) -> OrbitStates:
        """Velocity is the exact derivative of position."""
        t_s = instants.since_s(self.epoch_utc)
        return OrbitStates(*hermite(self.t_s, self.r_eci_m, self.v_eci_m_s, t_s, nodes=2))

    def sigma(self, instants: Instants) -> OrbitSigma:
        """Errors of the state at its epoch, grown, and of the paper's force model."""
        return state_sigma(self.age_s(instants), paper_model=True)


def paper_ephemeris(
    epoch_utc: datetime,
    r_eci_m: Array,
    v_eci_m_s: Array,
    start_utc: datetime,
    stop_utc: datetime,
    warnings: tuple[str, ...],
) -> PaperEphemeris:
    """Prediction from a state, each part of shape (3,), at epoch_utc, forward and backward.

    The paper integrates in axes that stand where ITRF's were at the epoch and turns the result
    back by the Earth's angle since then.
    """
    at_epoch = Instants(epoch_utc, np.zeros(1))
    r_m, v_itrf_m_s = itrf_from_eci_state(r_eci_m[None], v_eci_m_s[None], at_epoch)
    v_m_s = v_itrf_m_s + np.cross([0.0, 0.0, OMEGA_EARTH_RAD_S], r_m)
    x, y, z = r_m[0].tolist()
    vx, vy, vz = v_m_s[0].tolist()
    start = (x, y, z, vx, vy, vz)
    before_s, before = predict(start, min(elapsed_s(start_utc, epoch_utc), 0.0))
    after_s, after = predict(start, max(elapsed_s(stop_utc, epoch_utc), STEP_S))
    t_s = np.concatenate([before_s[:0:-1], after_s])
    states = np.concatenate([before[:0:-1], after])
    # Only what the span's own cells rest on.
    low = int(np.searchsorted(t_s, elapsed_s(start_utc, epoch_utc))) - 2
    high = int(np.searchsorted(t_s, elapsed_s(stop_utc, epoch_utc))) + 2
    near = slice(max(low, 0), max(high, 2))
    t_s, states = t_s[near], states[near]
    c, s = np.cos(OMEGA_EARTH_RAD_S * t_s), np.sin(OMEGA_EARTH_RAD_S * t_s)
    r_itrf_m, v_m_s = _turn_about_z(states[:, :3], c, s), _turn_about_z(states[:, 3:], c, s)
    v_itrf_m_s = v_m_s - np.cross([0.0, 0.0, OMEGA_EARTH_RAD_S], r_itrf_m)
    r_eci_m, v_eci_m_s = eci_from_itrf_state(r_itrf_m, v_itrf_m_s, Instants(epoch_utc, t_s))
    return PaperEphemeris(
        epoch_utc=epoch_utc,
        start_utc=start_utc,
        stop_utc=stop_utc,
        warnings=warnings,
        t_s=t_s,
        r_eci_m=r_eci_m,
        v_eci_m_s=v_eci_m_s,
    )


def predict(start: State, span_s: float) -> tuple[Array, Array]:
    """Times (k,) from 0 to span_s (either sign) and states (k, 6) in m and m/s at them.

    start: in axes that don't rotate and whose z is the Earth's axis.  The last step is the
    remainder of the span.  56 m off after 900 s, 550 m after 5400 s: the Earth's other
    harmonics are left out.  Source: Sumarokov 2016, eq. 3-7 (5 as meant, with its X_n +).
    """
    whole = math.floor(abs(span_s) / STEP_S)
    t_s: Array = np.arange(whole + 1, dtype=np.float64) * STEP_S
    if abs(span_s) > t_s[-1]:
        t_s = np.append(t_s, abs(span_s))
    t_s *= math.copysign(1.0, span_s)
    parts = [np.array([start])]
    step_s = np.diff(t_s)
    for first in range(0, len(step_s), CACHE_STEPS):
        before: State = tuple(parts[-1][-1].tolist())
        steps = step_s[first : first + CACHE_STEPS].tolist()
        whole_steps = all(abs(step) == STEP_S for step in steps) and len(steps) == CACHE_STEPS
        parts.append(_cached_steps(before, steps[0]) if whole_steps else _steps(before, steps))
    return t_s, np.concatenate(parts)


@lru_cache(maxsize=CACHE_SIZE)
def _cached_steps(start: State, step_s: float) -> Array:
    """Kept, since one plan asks for several spans: three days of steps take seconds."""
    return _steps(start, [step_s] * CACHE_STEPS)


def _steps(start: State, steps_s: list[float]) -> Array:
    """The states after each of the steps, shape (k, 6)."""
    states = [start]
    for step_s in steps_s:
        states.append(_runge_kutta(states[-1], step_s))
    return np.array(states[1:], dtype=np.float64)


def _runge_kutta(state: State, h: float) -> State:
    k1 = _derivative(state)
    k2 = _derivative(_step_along(state, k1, 0.5 * h))
    k3 = _derivative(_step_along(state, k2, 0.5 * h))
    k4 = _derivative(_step_along(state, k3, h))
    a, b = h / 6.0, h / 3.0
    return (
        state[0] + a * k1[0] + b * k2[0] + b * k3[0] + a * k4[0],
        state[1] + a * k1[1] + b * k2[1] + b * k3[1] + a * k4[1],
        state[2] + a * k1[2] + b * k2[2] + b * k3[2] + a * k4[2],
        state[3] + a * k1[3] + b * k2[3] + b * k3[3] + a * k4[3],
        state[4] + a * k1[4] + b * k2[4] + b * k3[4] + a * k4[4],
        state[5] + a * k1[5] + b * k2[5] + b * k3[5] + a * k4[5],
    )


def _step_along(s: State, k: State, h: float) -> State:
    return (
        s[0] + h * k[0],
        s[1] + h * k[1],
        s[2] + h * k[2],
        s[3] + h * k[3],
        s[4] + h * k[4],
        s[5] + h * k[5],
    )


def _derivative(s: State) -> State:
    x, y, z = s[0], s[1], s[2]
    r2 = x * x + y * y + z * z
    u = z * z / r2
    pull = -_MU / (r2 * math.sqrt(r2))
    j2, j4 = _P1 / r2, _P2 / (r2 * r2)
    across = pull * (1.0 + j2 * (5.0 * u - 1.0) + j4 * ((63.0 * u - 42.0) * u + 3.0))
    along = pull * (1.0 + j2 * (5.0 * u - 3.0) + j4 * ((63.0 * u - 70.0) * u + 15.0))
    return s[3], s[4], s[5], across * x, across * y, along * z


def _turn_about_z(v: Array, c: Array, s: Array) -> Array:
    """Components of v, (n, 3), in axes turned about z by the angles of cosine c and sine s."""
    x, y, z = v.T
    return np.stack([c * x + s * y, c * y - s * x, z], axis=1)
