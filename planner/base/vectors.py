"""Vectors and polynomials in compiled code, each compiled into its callers."""

import math

import numpy as np

from planner.base.arrays import Array
from planner.base.compiled import inlined

Vector = tuple[float, float, float]
Powers = Array
"""(cells, 6, k): of the share of each cell, as `UniformTable` has them."""

TURN_RAD = 2.0 * math.pi


@inlined
def vector_of(rows: Array, n: int, m: int) -> Vector:
    """Three columns from the m-th on of a row."""
    return rows[n, m], rows[n, m + 1], rows[n, m + 2]


@inlined
def dot(a: Vector, b: Vector) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@inlined
def cross(a: Vector, b: Vector) -> Vector:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@inlined
def plus(a: Vector, k: float, b: Vector) -> Vector:
    """a + k b."""
    return a[0] + k * b[0], a[1] + k * b[1], a[2] + k * b[2]


@inlined
def scaled(k: float, a: Vector) -> Vector:
    return k * a[0], k * a[1], k * a[2]


@inlined
def norm(a: Vector) -> float:
    return math.sqrt(dot(a, a))


@inlined
def unit(a: Vector) -> Vector:
    return scaled(1.0 / norm(a), a)


@inlined
def angle_between(a: Vector, b: Vector) -> float:
    """Accurate near 0 and pi too, of vectors of any length."""
    return math.atan2(norm(cross(a, b)), dot(a, b))


@inlined
def arcsin(sine: float) -> float:
    """Straight overhead a sine may round to more than 1."""
    return math.asin(min(max(sine, -1.0), 1.0))


@inlined
def wrapped(angle_rad: float) -> float:
    """In [-pi, pi]."""
    return float(angle_rad - TURN_RAD * np.rint(angle_rad / TURN_RAD))


@inlined
def cell_of(powers: Powers, step_s: float, t_s: float) -> tuple[int, float]:
    """The cell, and the share of it that has passed; outside the table of its first or last."""
    cell = min(max(int(t_s / step_s), 0), len(powers) - 1)
    return cell, t_s / step_s - cell


@inlined
def vector_at(powers: Powers, step_s: float, t_s: float, m: int) -> Vector:
    """Three columns from the m-th on."""
    c, u = cell_of(powers, step_s, t_s)
    x, y, z = powers[c, 5, m], powers[c, 5, m + 1], powers[c, 5, m + 2]
    for k in range(4, -1, -1):
        x, y = x * u + powers[c, k, m], y * u + powers[c, k, m + 1]
        z = z * u + powers[c, k, m + 2]
    return x, y, z


@inlined
def column_at(powers: Powers, step_s: float, t_s: float, column: int) -> float:
    c, u = cell_of(powers, step_s, t_s)
    value = float(powers[c, 5, column])
    for k in range(4, -1, -1):
        value = value * u + float(powers[c, k, column])
    return value


@inlined
def motion_at(powers: Powers, step_s: float, t_s: float) -> tuple[Vector, Vector]:
    """The first three columns and their rates."""
    c, u = cell_of(powers, step_s, t_s)
    x, y, z = powers[c, 5, 0], powers[c, 5, 1], powers[c, 5, 2]
    vx, vy, vz = 0.0, 0.0, 0.0
    for k in range(4, -1, -1):
        vx, vy, vz = vx * u + x, vy * u + y, vz * u + z
        x, y, z = x * u + powers[c, k, 0], y * u + powers[c, k, 1], z * u + powers[c, k, 2]
    return (x, y, z), (vx / step_s, vy / step_s, vz / step_s)
