"""Bounds of angle and rate where they turn within a span of constant jerk.

A span of a single row can't be cut, and the hull of its Bernstein coefficients would keep a slew
away from a limit that it touches there.  The greatest angle or rate within such a span
is a convex function of the span's numbers: its value and slope are those at the instant of the
turn, found anew at each iteration of `planner.slew.interior_point`, and its curvature is exact.
All in normalised time: the motion lasts 1.
Source: envelope theorem, Danskin 1967, The Theory of Max-Min.
"""

import math

import numpy as np

from planner.arrays import Array, Mask
from planner.compiled import compiled

ROWS = 11  # bounded in a span: of a flat one 6 and 8 at the turns of angle and rate
FOLLOWED = 0.1  # of a slack: a turn's bound with less room than that is still broken
STRAIGHT = 1e-9  # of half a bound's range: what a quantity may bend within a span and not turn


@compiled
def bound_turns(
    rows: Array,
    turns: Array,
    curving: Array,
    widths: Array,
    flat: Mask,
    limits: Array,
    states: Array,
    jerks: Array,
) -> None:
    """Sets rows 6 and 8 of flat spans to angle and rate where they turn, or else at an end.

    As a function of the span's numbers an extremum's slope is that of the value at its instant,
    and it curves by the square of the slope's change in time over the second derivative:
    turns (n, 2) are the instants, as shares of the span, curving (n, 2) the second
    derivative's inverse, 0 at an end.
    """
    n = len(widths)
    for k in range(n):
        if not flat[k]:
            continue
        h, jerk = widths[k], (jerks[k, 0] + jerks[k, 1]) / 2.0
        _, rate, acceleration = states[k]
        x, y = _turn_of_angle(rate, acceleration, jerk, h), -acceleration / jerk
        for order, at in ((0, x), (1, y)):
            row, scale = 6 + 2 * order, 2.0 / (limits[order, 1] - limits[order, 0])
            inside = 0.0 < at < h
            if not inside:
                at = h if k == 0 else 0.0
            bend = jerk if order == 1 else acceleration + at * jerk
            turns[k, order] = at / h
            is_turn = inside and scale * abs(bend) * h * h > STRAIGHT
            curving[k, order] = scale / bend if is_turn else 0.0
            rows[k, row] = 0.0
            if k == 0 and k == n - 1:
                continue
            rows[k, row, order], rows[k, row, order + 1] = scale, scale * at
            if order == 0:
                rows[k, row, 2] = scale * at * at / 2.0
            last = scale * at**3 / 6.0 if order == 0 else scale * at * at / 2.0
            rows[k, row, 3] = rows[k, row, 4] = last / 2.0
            rows[k, row, 5] = -(limits[order, 1] + limits[order, 0]) * scale / 2.0


@compiled
def follow_turns(slack: Array, room: Array, flat: Mask) -> None:
    """Sets the slack of turns' bounds to what there is: a turn that comes or goes changes it."""
    n = len(flat)
    for i in range(len(slack)):
        k, row = (i // ROWS) % n, i % ROWS
        if flat[k] and row in (6, 8) and room[i] > FOLLOWED * slack[i]:
            slack[i] = room[i]


@compiled
def _turn_of_angle(rate: float, acceleration: float, jerk: float, h: float) -> float:
    """When the rate passes zero, at first if twice in h, else anywhere outside it."""
    root = math.sqrt(max(acceleration * acceleration - 2.0 * jerk * rate, 0.0))
    q = -acceleration - math.copysign(root, acceleration)
    first, second = q / jerk, 2.0 * rate / q
    if 0.0 < first < h and not 0.0 < second < first:
        return first
    return second


@compiled
def add_curving(hessian: Array, turns: Array, curving: Array, widths: Array, push: Array) -> None:
    """What the bounds of turns add to the upper triangle of the programme's second derivative."""
    half, change = push.size // 2, np.empty(5)
    pushes = (push[half:] - push[:half]).reshape(len(widths), ROWS)
    for k in range(len(widths)):
        for order in range(2):
            weight = -pushes[k, 6 + 2 * order] * curving[k, order]
            if weight <= 0.0:
                continue
            at = turns[k, order] * widths[k]
            change[:] = 0.0
            change[order + 1] = 1.0
            if order == 0:
                change[2] = at
            change[3] = change[4] = (at if order == 1 else at * at / 2.0) / 2.0
            for i in range(5):
                for j in range(i, 5):
                    hessian[k, i, j] += weight * change[i] * change[j]
