"""How do modified Rodrigues parameters and body rates correspond?

sigma = e tan(theta/4) turns reference axes onto body axes; smooth and free of constraints
below a full turn, so curves of sigma serve as attitude profiles.
Source: Schaub, Junkins, Analytical Mechanics of Space Systems, 3.6 (eq. 3.157-3.162).
"""

from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from planner.arrays import Array


class BodyMotion(NamedTuple):
    """Rates of a body in its own axes, each (..., 3): rad/s, rad/s^2, rad/s^3."""

    omega_body_rad_s: Array
    alpha_body_rad_s2: Array
    jerk_body_rad_s3: Array


def _dot(a: Array, b: Array) -> Array:
    return np.asarray(np.sum(a * b, axis=-1, keepdims=True))


def body_motion(sigma: Array, d1: Array, d2: Array, d3: Array) -> BodyMotion:
    """Body rates of the curve sigma with time derivatives d1, d2, d3, each (..., 3)."""
    s, s1 = _dot(sigma, sigma), _dot(sigma, d1)
    s2 = _dot(d1, d1) + _dot(sigma, d2)
    s3 = 3.0 * _dot(d1, d2) + _dot(sigma, d3)
    f = 4.0 / (1.0 + s) ** 2
    f1 = -16.0 * s1 / (1.0 + s) ** 3
    f2 = -16.0 * s2 / (1.0 + s) ** 3 + 96.0 * s1**2 / (1.0 + s) ** 4
    a = (1.0 - s) * d1 - 2.0 * np.cross(sigma, d1) + 2.0 * sigma * s1
    a1 = (1.0 - s) * d2 - 2.0 * np.cross(sigma, d2) + 2.0 * sigma * s2
    a2 = (
        (1.0 - s) * d3
        - 2.0 * s1 * d2
        - 2.0 * np.cross(d1, d2)
        - 2.0 * np.cross(sigma, d3)
        + 2.0 * d1 * s2
        + 2.0 * sigma * s3
    )
    return BodyMotion(f * a, f1 * a + f * a1, f2 * a + 2.0 * f1 * a1 + f * a2)


def mrp_rates(sigma: Array, omega: Array, alpha: Array) -> tuple[Array, Array]:
    """First and second time derivatives of sigma that give these body rates, each (..., 3)."""
    s = _dot(sigma, sigma)

    def undone(v: Array) -> Array:
        return (1.0 - s) * v + 2.0 * np.cross(sigma, v) + 2.0 * sigma * _dot(sigma, v)

    d1 = undone(omega) / 4.0
    s1 = _dot(sigma, d1)
    a = omega * (1.0 + s) ** 2 / 4.0
    a1 = (alpha + 16.0 * s1 / (1.0 + s) ** 3 * a) * (1.0 + s) ** 2 / 4.0
    rest = a1 - 2.0 * sigma * _dot(d1, d1)
    return d1, undone(rest) / (1.0 + s) ** 2


def quintic(ends: tuple[Array, ...], span_s: float, u: Array) -> tuple[Array, ...]:
    """Value and three derivatives of the quintic Hermite at shares u (n,) of the span.

    ends: value, first, second derivative at both ends (six arrays, (n, 3) or (3,)).
    """
    p0, v0, a0, p1, v1, a1 = ends
    h = span_s
    c0, c1, c2 = p0, v0 * h, 0.5 * a0 * h**2
    dp, dv, da = p1 - c0 - c1 - c2, v1 * h - c1 - 2 * c2, a1 * h**2 - 2 * c2
    c3 = 10 * dp - 4 * dv + 0.5 * da
    c4 = -15 * dp + 7 * dv - da
    c5 = 6 * dp - 3 * dv + 0.5 * da
    x = u[:, None]
    return (
        c0 + x * (c1 + x * (c2 + x * (c3 + x * (c4 + x * c5)))),
        (c1 + x * (2 * c2 + x * (3 * c3 + x * (4 * c4 + x * 5 * c5)))) / h,
        (2 * c2 + x * (6 * c3 + x * (12 * c4 + x * 20 * c5))) / h**2,
        (6 * c3 + x * (24 * c4 + x * 60 * c5)) / h**3,
    )


def relative_mrp(eci_from_start: Rotation, eci_from_end: Rotation) -> Array:
    """sigma of the rotation start axes -> end axes, (..., 3)."""
    return np.asarray((eci_from_start.inv() * eci_from_end).as_mrp())
