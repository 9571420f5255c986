"""Bounds that no slew can beat: least time and least squared jerk, from the angle to turn.

An attitude moves by the integral of |omega| at most.  Along the direction that omega has at one
instant it is a scalar motion within the same limits, from |omega_0| at most and to |omega_1| at
most: |omega(t)| stays below what such a motion reaches at t.  Limits by axis are as wide as
the ball around their box.  Between ends at rest under limits of magnitudes the eigenaxis slew
meets this bound: none is quicker.

Of the squared jerk the part between ends at rest costs 720 (integral of |v|)^2 / T^5 at least,
because the influence function of a clamped beam is positive; the cubic through the ends' rates is
orthogonal to it.
"""

import math
from dataclasses import dataclass

import numpy as np

from planner.base import effort
from planner.base.arrays import Array
from planner.base.commands import ROWS_PER_S
from planner.motion.attitude.problem import BodySlewProblem


@dataclass(frozen=True, kw_only=True)
class BoundOptions:
    """The quadrature of the largest rate by time, and its rounding."""

    instants: int = 200
    narrowed: int = 40  # times by a third: 1e-7 of the accelerations there are
    margin: float = 2e-4  # of the angle: what the quadrature may be short by
    passed_share: float = 0.5  # of the rows that a slew short of its angle needs at full rate
    row: float = 60.0  # of `effort`: to look at one arrival


OPTIONS = BoundOptions()


def _reachable_rate(
    t: Array, w0: float, a0: float, a: Array, rate_rad_s: float, jerk_rad_s3: float
) -> Array:
    """The greatest rate after t with acceleration a then, from w0 and at most a0."""
    begin = np.minimum(a0, a + jerk_rad_s3 * t)
    peak = np.minimum(rate_rad_s, (jerk_rad_s3 * t + begin + a) / 2.0)
    hold = t - (2.0 * peak - begin - a) / jerk_rad_s3
    reached = w0 + (2.0 * peak**2 - begin**2 - a**2) / (2.0 * jerk_rad_s3) + peak * hold
    return np.where(hold < -1e-9 * np.max(t, initial=1e-9), -np.inf, reached)


def furthest_rad(problem: BodySlewProblem, row: int) -> float:
    """More than any slew turns that arrives at this row."""
    effort.charge(OPTIONS.row)
    rate, acceleration, jerk = problem.limits.lengths
    goal = problem.arriving_at(row).goal
    start = problem.start
    w0, a0, w1, a1 = (
        float(np.linalg.norm(x))
        for x in (
            start.rate_rad_s,
            start.acceleration_rad_s2,
            goal.rate_rad_s,
            goal.acceleration_rad_s2,
        )
    )
    span_s = row / ROWS_PER_S
    # Midpoints: of a rate that rises and falls a sum at these is too large rather than too small.
    t = (np.arange(OPTIONS.instants) + 0.5) / OPTIONS.instants * span_s

    def most(alpha_rad_s2: Array) -> Array:
        a = alpha_rad_s2
        over = np.maximum(a**2 - max(a0, a1) ** 2, 0.0)
        here = np.minimum(
            _reachable_rate(t, w0, a0, a, acceleration, jerk),
            _reachable_rate(span_s - t, w1, a1, -a, acceleration, jerk),
        )
        return np.minimum(here, rate - over / (2.0 * jerk))

    low = -np.minimum(acceleration, jerk * (span_s - t) + a1)
    high = np.minimum(acceleration, jerk * t + a0)
    for _ in range(OPTIONS.narrowed):
        x, y = low + (high - low) / 3.0, high - (high - low) / 3.0
        is_rising = most(x) < most(y)
        low, high = np.where(is_rising, x, low), np.where(is_rising, high, y)
    return float(np.sum(most((low + high) / 2.0)) / OPTIONS.instants * span_s)


def least_row(problem: BodySlewProblem) -> int | None:
    """The first row of the goal at which a slew may arrive, None: a proof that it is none."""
    rows, angles_rad = problem.arrival_rows, problem.angles_rad
    rate, acceleration, _ = problem.limits.lengths
    goal, start = problem.goal, problem.start
    t_s = rows / ROWS_PER_S
    # Cheap and weaker: as far as jerk without limit would bring it.
    w0, w1 = float(np.linalg.norm(start.rate_rad_s)), np.linalg.norm(goal.rate_rad_s, axis=1)
    peak = np.minimum(rate, (acceleration * t_s + w0 + w1) / 2.0)
    coast_s = t_s - (2.0 * peak - w0 - w1) / acceleration
    most_rad = (2.0 * peak**2 - w0**2 - w1**2) / (2.0 * acceleration) + peak * coast_s
    hopeful = np.flatnonzero(most_rad >= angles_rad * (1.0 - OPTIONS.margin))
    fastest_rad_s = rate + float(np.max(w1))
    k = int(hopeful[0]) if len(hopeful) else len(rows)
    while k < len(rows):
        short_rad = angles_rad[k] * (1.0 - OPTIONS.margin) - furthest_rad(problem, int(rows[k]))
        if short_rad <= 0.0:
            return int(rows[k])
        # Neither the slew nor its goal turns faster: rows in which they can't meet are passed.
        k += 1 + int(OPTIONS.passed_share * short_rad / fastest_rad_s * ROWS_PER_S)
    return None


def least_s(problem: BodySlewProblem) -> float:
    """No slew arrives at any row of the goal in less; infinite where at none of them."""
    row = least_row(problem)
    return math.inf if row is None else row / ROWS_PER_S


def may(problem: BodySlewProblem) -> bool:
    """False is a proof that no slew arrives at any row of the goal."""
    return least_row(problem) is not None


def least_cost_rad2_s5(problem: BodySlewProblem, row: int) -> float:
    """No slew that arrives at this row has a smaller integral of squared jerk."""
    there = problem.arriving_at(row)
    span_s = row / ROWS_PER_S
    w0, a0 = problem.start.rate_rad_s[0], problem.start.acceleration_rad_s2[0]
    w1, a1 = there.goal.rate_rad_s[0], there.goal.acceleration_rad_s2[0]
    u = ((np.arange(OPTIONS.instants) + 0.5) / OPTIONS.instants)[:, None]
    gap = w1 - w0 - a0 * span_s
    bend = (a1 - a0) * span_s
    c2, c3 = 3.0 * gap - bend, bend - 2.0 * gap
    j0, j1 = 2.0 * c2 / span_s**2, (2.0 * c2 + 6.0 * c3) / span_s**2
    ends = span_s / 3.0 * float(j0 @ j0 + j0 @ j1 + j1 @ j1)
    cubic = w0 + a0 * span_s * u + c2 * u**2 + c3 * u**3
    turned_rad = float(np.mean(np.linalg.norm(cubic, axis=1))) * span_s
    left_rad = max(float(there.angles_rad[0]) - turned_rad * (1.0 + OPTIONS.margin), 0.0)
    return ends + 720.0 * left_rad**2 / span_s**5
