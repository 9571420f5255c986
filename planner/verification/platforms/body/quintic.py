"""The attitude between two rows: the quintic in modified Rodrigues parameters.

Derived from the quaternion's own derivatives; shares nothing with the planner's.
"""

from typing import NamedTuple

import numpy as np

from planner.base.arrays import Array, Indices, cross
from planner.base.commands import COMMAND_STEP_S


class FlownMotion(NamedTuple):
    """At n instants: `q_eci_from_body_xyzw` (n, 4), and rates against GCRF in body axes (n, 3)."""

    q_eci_from_body_xyzw: Array
    omega_body_rad_s: Array
    alpha_body_rad_s2: Array


def motion_between(
    q_eci_from_body_xyzw: Array,
    omega_body_rad_s: Array,
    alpha_body_rad_s2: Array,
    cell: Indices,
    u_s: Array,
) -> FlownMotion:
    """u_s after the rows that n cells begin with, of rows (m, 4), (m, 3) and (m, 3).

    The parameters p = e tan(angle / 4) of the turn since the row obey
    4 p' = (1 - p.p) w + 2 p x w + 2 p (p.w).  Of the curve of fifth degree that meets them and
    their first two derivatives at both rows the unit quaternion (2 p, 1 - p.p) / (1 + p.p) and its
    derivatives give the rates: w = 2 q* q', w' = 2 q* q''.
    Source: Schaub, Junkins, Analytical Mechanics of Space Systems, 3.6; Shuster 1993.
    """
    first, last = q_eci_from_body_xyzw[cell], q_eci_from_body_xyzw[cell + 1]
    turn = _product(_conjugate(first), last)
    turn = np.where(turn[:, 3:] < 0.0, -turn, turn)
    p = turn[:, :3] / (1.0 + turn[:, 3:])
    p1, p2 = _derivatives(p, omega_body_rad_s[cell + 1], alpha_body_rad_s2[cell + 1])
    h, u = COMMAND_STEP_S, u_s[:, None]
    c1, c2 = omega_body_rad_s[cell] / 4.0, alpha_body_rad_s2[cell] / 8.0
    # What the quadratic of the first row lacks at the second row: value, slope, curvature.
    value, slope, curvature = p - h * (c1 + h * c2), p1 - c1 - 2.0 * h * c2, p2 - 2.0 * c2
    c3 = (10.0 * value - 4.0 * h * slope + 0.5 * h**2 * curvature) / h**3
    c4 = (-15.0 * value + 7.0 * h * slope - h**2 * curvature) / h**4
    c5 = (6.0 * value - 3.0 * h * slope + 0.5 * h**2 * curvature) / h**5
    sigma = u * (c1 + u * (c2 + u * (c3 + u * (c4 + u * c5))))
    sigma1 = c1 + u * (2.0 * c2 + u * (3.0 * c3 + u * (4.0 * c4 + u * 5.0 * c5)))
    sigma2 = 2.0 * c2 + u * (6.0 * c3 + u * (12.0 * c4 + u * 20.0 * c5))

    square, square1 = _dot(sigma, sigma), 2.0 * _dot(sigma, sigma1)
    square2 = 2.0 * (_dot(sigma1, sigma1) + _dot(sigma, sigma2))
    size = 1.0 + square
    q = np.concatenate([2.0 * sigma, 1.0 - square], axis=1) / size
    q1 = (np.concatenate([2.0 * sigma1, -square1], axis=1) - square1 * q) / size
    q2 = np.concatenate([2.0 * sigma2, -square2], axis=1)
    q2 = (q2 - 2.0 * square1 * q1 - square2 * q) / size
    back = _conjugate(q)
    return FlownMotion(
        _product(first, q), 2.0 * _product(back, q1)[:, :3], 2.0 * _product(back, q2)[:, :3]
    )


def turned(q_eci_from_body_xyzw: Array, vector_body: Array) -> Array:
    """Vectors, (3,) or (n, 3), turned by n unit quaternions: v + 2 w (u x v) + 2 u x (u x v)."""
    part, scalar = q_eci_from_body_xyzw[:, :3], q_eci_from_body_xyzw[:, 3:]
    across = 2.0 * cross(part, np.broadcast_to(vector_body, part.shape))
    return np.asarray(vector_body + scalar * across + cross(part, across))


def _derivatives(p: Array, omega_rad_s: Array, alpha_rad_s2: Array) -> tuple[Array, Array]:
    """First and second of the parameters, per s and per s2."""
    omega, alpha = omega_rad_s, alpha_rad_s2
    along = _dot(p, omega)
    p1 = ((1.0 - _dot(p, p)) * omega + 2.0 * cross(p, omega) + 2.0 * along * p) / 4.0
    p2 = (
        (1.0 - _dot(p, p)) * alpha
        + 2.0 * cross(p, alpha)
        + 2.0 * _dot(p, alpha) * p
        - 2.0 * _dot(p, p1) * omega
        + 2.0 * cross(p1, omega)
        + 2.0 * _dot(p1, omega) * p
        + 2.0 * along * p1
    ) / 4.0
    return p1, p2


def _dot(a: Array, b: Array) -> Array:
    return np.asarray(np.sum(a * b, axis=1, keepdims=True))


def _conjugate(q: Array) -> Array:
    return np.asarray(q * [-1.0, -1.0, -1.0, 1.0])


def _product(p: Array, q: Array) -> Array:
    """Hamilton's, (n, 4): scalar last: the turn q, then p."""
    a, a_w, b, b_w = p[:, :3], p[:, 3:], q[:, :3], q[:, 3:]
    part = a_w * b + b_w * a + cross(a, b)
    return np.concatenate([part, a_w * b_w - _dot(a, b)], axis=1)
