"""Random slews of the HRC whose straight path enters a moving cone, for tests and benchmark."""

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation
from scipy_boresight import scipy_boresight

from planner.base.errors import InfeasibleSlew
from planner.motion.pointing.keep_out import KeepOutView, MovingCone
from planner.motion.slew import AxisState, SlewProblem, SlewSolution, next_duration_s, optimal_slew
from planner.world.platforms import ISS_HRC

LIMITS = ISS_HRC.outer_limits
CARRIER_RATE_RAD_S = math.radians(4.0 / 60.0)  # the ISS in its orbit
FINE_S = 0.01


@dataclass(frozen=True)
class Case:
    """straight: flown as if there were no cone.  axis_at(t_s): the cone's axis, unit vectors."""

    straight: SlewSolution
    half_angle_rad: float
    middle_axis: np.ndarray
    turn_axis: np.ndarray

    @property
    def problem(self):
        return self.straight.problem

    def axis_at(self, t_s):
        return turning(self.middle_axis, self.turn_axis, t_s - self.straight.duration_s / 2.0)


def turning(middle_axis, turn_axis, t_s):
    return Rotation.from_rotvec(np.outer(t_s, turn_axis * CARRIER_RATE_RAD_S)).apply(middle_axis)


def away_rad(case, t_s, angle_rad):
    cosine = np.sum(case.axis_at(t_s) * scipy_boresight(angle_rad), axis=1)
    return np.arccos(np.clip(cosine, -1.0, 1.0))


def hermite(solution, fine_s=FINE_S):
    """t_s and angles every fine_s of the cubic Hermite through the slew's rows, and its rows."""
    rows = np.arange(round(solution.duration_s / 0.2) + 1) / 5.0
    angle, rate, _, _ = solution.motion(rows)
    s = np.arange(round(0.2 / fine_s))[:, None] * (fine_s / 0.2)
    parts = (
        np.kron(angle[:-1], 1.0 + s * s * (2.0 * s - 3.0))
        + np.kron(angle[1:], s * s * (3.0 - 2.0 * s))
        + np.kron(rate[:-1], 0.2 * s * (1.0 - s) ** 2)
        + np.kron(rate[1:], 0.2 * s * s * (s - 1.0))
    )
    t_s = np.append((rows[:-1, None] + 0.2 * s.T).ravel(), rows[-1])
    return t_s, np.vstack([parts, angle[-1:]]), angle, rate


def row_accelerations(rows, rates):
    """Of the Hermite through rows, at both ends of each cell, (2, n - 1, 2)."""
    mean = np.diff(rows, axis=0) / 0.2
    first, last = rates[:-1], rates[1:]
    return (
        np.array([6.0 * mean - 4.0 * first - 2.0 * last, 2.0 * first + 4.0 * last - 6.0 * mean])
        / 0.2
    )


def draw_cases(seed, count, starting=None):
    """starting: (rate, acceleration) of the outer axis at the start, in place of a random rate."""
    rng = np.random.default_rng(seed)
    drawn = 0
    while drawn < count:
        case = _drawn(rng, starting)
        if case is not None:
            drawn += 1
            yield case


def draw_straight(rng, starting=None):
    """A slew between states at random, as flown where nothing is in the way; None if it can't be.

    starting: rate and acceleration of the outer axis at the start, rad/s, rad/s2.
    """

    def state():
        return AxisState(
            angle_rad=math.radians(rng.uniform(-170.0, 170.0)),
            rate_rad_s=math.radians(rng.uniform(-1.0, 1.0)),
        )

    start, end = (state(), state()), (state(), state())
    if starting is not None:
        rate, acceleration = starting
        outer = replace(start[0], rate_rad_s=rate, acceleration_rad_s2=acceleration)
        start = (outer, start[1])
    least_s = [next_duration_s(a, b, LIMITS, 0.0) for a, b in zip(start, end, strict=True)]
    if None in least_s:
        return None
    duration_s = math.ceil(max(least_s) * rng.uniform(1.2, 3.0) * 5.0) / 5.0
    problem = SlewProblem(
        axis_names=ISS_HRC.axis_names,
        limits=ISS_HRC.axis_limits,
        start=start,
        end=end,
        duration_s=duration_s,
    )
    try:
        return optimal_slew(problem, on_rows=True)
    except InfeasibleSlew:
        return None


def _drawn(rng, starting):
    straight = draw_straight(rng, starting)
    if straight is None:
        return None
    duration_s = straight.problem.duration_s
    angle_rad = straight.motion(np.array([duration_s * rng.uniform(0.25, 0.75)]))[0]
    on_path = scipy_boresight(angle_rad)[0]
    aside, turn_axis = np.cross(on_path, rng.normal(size=3)), rng.normal(size=3)
    half_angle_rad = math.radians(rng.uniform(10.0, 45.0))
    off_rad = half_angle_rad * rng.uniform(0.0, 0.95)
    aside /= np.linalg.norm(aside)
    turn_axis /= np.linalg.norm(turn_axis)
    middle_axis = math.cos(off_rad) * on_path + math.sin(off_rad) * aside
    nodes_s = np.linspace(0.0, duration_s, max(4, math.ceil(duration_s / 10.0) + 1))
    cone = MovingCone(
        about="a direction",
        half_angle_rad=half_angle_rad,
        t_s=nodes_s,
        axis_platform=turning(middle_axis, turn_axis, nodes_s - duration_s / 2.0),
        counts_rad=np.ones(len(nodes_s)),
    )
    view = KeepOutView(platform=ISS_HRC, cones=(cone,))
    problem = replace(straight.problem, keep_out=view)
    case = Case(replace(straight, problem=problem), half_angle_rad, middle_axis, turn_axis)
    t_s, angle, _, _ = hermite(straight)
    away = away_rad(case, t_s, angle)
    if min(away[0], away[-1]) < half_angle_rad or away.min() > half_angle_rad:
        return None  # an end inside can't be cured by any detour; a path outside needs none
    return case
