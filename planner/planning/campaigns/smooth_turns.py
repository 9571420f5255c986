"""The turn of a body from one attitude and rate to another with little jerk; compiled.

About each axis of the body the rate is a polynomial of time: of third order, as the rates and
accelerations at both ends ask for, and a bulge of fourth order, as the attitude at the end does.
Where the axis of the turn stands still no motion has a smaller integral of squared jerk.
"""

import math
from typing import NamedTuple

import numpy as np

from planner.base.arrays import Array
from planner.base.compiled import compiled, nested
from planner.base.vectors import Vector, cross, dot, norm, plus, scaled, vector_of

_Quaternion = tuple[Vector, float]


class TurnOptions(NamedTuple):
    """How closely a turn meets its end."""

    steps: int = 64  # of a turn, of constant rate each
    parts: int = 16  # of a turn, whose beginnings are told: a peak is missed by 1 % at most
    tries: int = 12  # by Newton's method, which squares what is missed each time
    missed_rad: float = 1e-5
    least_rad: float = 1e-12  # no axis is told from less


OPTIONS = TurnOptions()


@nested
def _product(p: _Quaternion, q: _Quaternion) -> _Quaternion:
    side = plus(plus(cross(p[0], q[0]), p[1], q[0]), q[1], p[0])
    return side, p[1] * q[1] - dot(p[0], q[0])


@nested
def _turn(rotation: Vector) -> _Quaternion:
    angle = norm(rotation)
    share = 0.5 if angle < OPTIONS.least_rad else math.sin(0.5 * angle) / angle
    return scaled(share, rotation), math.cos(0.5 * angle)


@nested
def _rotation(q: _Quaternion) -> Vector:
    """The shorter way."""
    sine, side = norm(q[0]), 1.0 if q[1] >= 0.0 else -1.0
    if sine < OPTIONS.least_rad:
        return scaled(2.0 * side, q[0])
    return scaled(side * 2.0 * math.atan2(sine, side * q[1]) / sine, q[0])


@nested
def _turned(q: _Quaternion, v: Vector) -> Vector:
    """From the body's axes to those that stand still."""
    across = scaled(2.0, cross(q[0], v))
    return plus(plus(v, q[1], across), 1.0, cross(q[0], across))


@nested
def _rate(
    start_states: Array, stop_states: Array, n: int, long_s: float, bulge: Vector, p: float
) -> Vector:
    rate = scaled(1.0 - p**2 * (3.0 - 2.0 * p), vector_of(start_states, n, 4))
    rate = plus(rate, long_s * p * (1.0 - p) ** 2, vector_of(start_states, n, 7))
    rate = plus(rate, p**2 * (3.0 - 2.0 * p), vector_of(stop_states, n, 4))
    rate = plus(rate, -long_s * p**2 * (1.0 - p), vector_of(stop_states, n, 7))
    return plus(rate, 30.0 * p**2 * (1.0 - p) ** 2, bulge)


@nested
def _missed(
    start_states: Array, stop_states: Array, n: int, long_s: float, bulge: Vector, gained_s: Array
) -> Vector:
    """What is missed of the attitude at the end, in the axes that stand still.

    gained_s: (3, 3), what a change of the bulge brings there.
    """
    q, step_s = (vector_of(start_states, n, 0), start_states[n, 3]), long_s / OPTIONS.steps
    gained_s[:] = 0.0
    for k in range(OPTIONS.steps):
        p = (k + 0.5) / OPTIONS.steps
        half = _turn(scaled(0.5 * step_s, _rate(start_states, stop_states, n, long_s, bulge, p)))
        q = _product(q, half)
        weight = 30.0 * p**2 * (1.0 - p) ** 2 * step_s
        for axis in range(3):
            one = (1.0 * (axis == 0), 1.0 * (axis == 1), 1.0 * (axis == 2))
            along = _turned(q, one)
            for row in range(3):
                gained_s[row, axis] += weight * along[row]
        q = _product(q, half)
    back = scaled(-1.0, q[0]), q[1]
    left = _rotation(_product(back, (vector_of(stop_states, n, 0), stop_states[n, 3])))
    return _turned(q, left)


@nested
def _found(start_states: Array, stop_states: Array, n: int, long_s: float, bulge: Vector) -> Vector:
    gained_s = np.empty((3, 3))
    for _ in range(OPTIONS.tries + 1):
        missed = _missed(start_states, stop_states, n, long_s, bulge, gained_s)
        if norm(missed) < OPTIONS.missed_rad:
            return bulge
        # By Cramer's rule: it is near a turn, whose determinant is 1, times the time.
        columns = (
            vector_of(gained_s.T, 0, 0),
            vector_of(gained_s.T, 1, 0),
            vector_of(gained_s.T, 2, 0),
        )
        whole = dot(columns[0], cross(columns[1], columns[2]))
        if abs(whole) < 1e-6 * long_s**3:
            break
        bulge = (
            bulge[0] + dot(missed, cross(columns[1], columns[2])) / whole,
            bulge[1] + dot(missed, cross(columns[2], columns[0])) / whole,
            bulge[2] + dot(missed, cross(columns[0], columns[1])) / whole,
        )
    return math.nan, math.nan, math.nan


@compiled
def smooth_turns(start_states: Array, stop_states: Array, long_s: Array) -> Array:
    """Attitudes, scalar last and from the body's axes, and rates of n turns at the beginnings of
    `OPTIONS.parts` equal parts of each, (n, OPTIONS.parts, 7).

    start_states, stop_states: attitude, rate and acceleration, (n, 10).  The shorter bulge of two
    is taken, one sought from none, the other from the Euler axis; else the latter's, as begun.
    """
    told = np.empty((len(start_states), OPTIONS.parts, 7))
    for n in range(len(start_states)):
        q = (vector_of(start_states, n, 0), start_states[n, 3])
        back = scaled(-1.0, q[0]), q[1]
        whole = _rotation(_product(back, (vector_of(stop_states, n, 0), stop_states[n, 3])))
        ends = plus(vector_of(start_states, n, 4), 1.0, vector_of(stop_states, n, 4))
        bent = plus(vector_of(start_states, n, 7), -1.0, vector_of(stop_states, n, 7))
        straight = plus(scaled(1.0 / long_s[n], whole), -0.5, ends)
        straight = plus(straight, -long_s[n] / 12.0, bent)
        bulge = _found(start_states, stop_states, n, long_s[n], straight)
        other = _found(start_states, stop_states, n, long_s[n], (0.0, 0.0, 0.0))
        if not norm(bulge) <= norm(other) and not math.isnan(norm(other)):
            bulge = other
        if math.isnan(norm(bulge)):
            bulge = straight
        step_s, many = long_s[n] / OPTIONS.steps, OPTIONS.steps // OPTIONS.parts
        for k in range(OPTIONS.steps):
            rate = _rate(start_states, stop_states, n, long_s[n], bulge, (k + 0.5) / OPTIONS.steps)
            if k % many == 0:
                part = k // many
                here = _rate(start_states, stop_states, n, long_s[n], bulge, k / OPTIONS.steps)
                for axis in range(3):
                    told[n, part, axis], told[n, part, 4 + axis] = q[0][axis], here[axis]
                told[n, part, 3] = q[1]
            q = _product(q, _turn(scaled(step_s, rate)))
    return told
