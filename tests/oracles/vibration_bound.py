"""The least residual vibration of a structural mode after any motion within the limits.

A linear programme over all motions whose jerk is constant between rows, as a table flies them;
the limits are kept on rows only and the circle of phases is a polygon inside it, so that no
motion does better.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import linprog

from planner.motion.slew import AxisState
from planner.world.platforms import AxisLimits, StructuralMode

ROW_S = 0.2
PHASES = 24


@dataclass(frozen=True)
class Wanted:
    """A mode, and the deflection it may be left with."""

    mode: StructuralMode
    left_rad: float


def least_share(
    start: AxisState,
    end: AxisState,
    limits: AxisLimits,
    duration_s: float,
    wanted: tuple[Wanted, ...],
) -> float:
    """The least, over all motions, of the greatest share left / wanted; infinite: none exists."""
    n = round(duration_s / ROW_S)
    t_s = np.arange(n + 1) * ROW_S
    free = [
        start.angle_rad + start.rate_rad_s * t_s + start.acceleration_rad_s2 * t_s**2 / 2.0,
        start.rate_rad_s + start.acceleration_rad_s2 * t_s,
        np.full(n + 1, start.acceleration_rad_s2),
    ]
    since_s = np.clip(t_s[:, None] - t_s[None, :-1], 0.0, None)
    in_cell = np.minimum(since_s, ROW_S)
    after = since_s - in_cell
    by_jerk = [
        in_cell**3 / 6.0 + after * in_cell**2 / 2.0 + in_cell * after**2 / 2.0,
        in_cell**2 / 2.0 + in_cell * after,
        in_cell,
    ]
    at_most, most = [], []
    for matrix, motion, (low, high) in zip(by_jerk, free, limits.bounds[:3], strict=True):
        at_most += [matrix, -matrix]
        most += [high - motion, motion - low]
    ends = (end.angle_rad, end.rate_rad_s, end.acceleration_rad_s2)
    rows = np.vstack(at_most)
    left = np.vstack([_left(one, duration_s, n) for one in wanted])
    jerk_max = limits.jerk_max_rad_s3
    found = linprog(
        np.append(np.zeros(n), 1.0),
        A_ub=np.block([[rows, np.zeros((len(rows), 1))], [left, -np.ones((len(left), 1))]]),
        b_ub=np.concatenate([*most, np.zeros(len(left))]),
        A_eq=np.column_stack([np.vstack([matrix[-1] for matrix in by_jerk]), np.zeros(3)]),
        b_eq=[goal - motion[-1] for goal, motion in zip(ends, free, strict=True)],
        bounds=[(-jerk_max, jerk_max)] * n + [(0.0, None)],
        method="highs",
    )
    return float(found.fun) if found.status == 0 else np.inf


def _left(wanted: Wanted, duration_s: float, n: int) -> np.ndarray:
    """Rows (PHASES, n): a deflection by unit jerk in each cell, over what is wanted.

    x'' + 2 z w x' + w^2 x = -a with the eigenvalue lambda: jerk leaves its integral with
    exp(lambda (T - t)), over |lambda| and the damped frequency.
    """
    mode = wanted.mode
    rate = mode.eigenvalue_rad_s
    to_go_s = duration_s - np.arange(1, n + 1) * ROW_S
    cells = np.exp(rate * to_go_s) * np.expm1(rate * ROW_S) / rate
    cells /= abs(rate) * rate.imag
    turns = np.exp(-2j * np.pi * np.arange(PHASES) / PHASES)
    return np.real(turns[:, None] * cells) / wanted.left_rad
