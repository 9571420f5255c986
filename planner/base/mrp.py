"""Modified Rodrigues parameters of an attitude and the body rates that go with them.

sigma = e tan(theta/4) turns reference axes onto body axes; smooth and free of constraints
below a full turn, so curves of sigma serve as attitude profiles.  It is the vector of SciPy's
`q_reference_from_body.as_mrp()`.
Source: Schaub, Junkins, Analytical Mechanics of Space Systems, 3.6 (eq. 3.157-3.162).
"""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from planner.base.arrays import Array
from planner.base.interpolation import quintic_coefficients


class BodyMotion(NamedTuple):
    """Rates of a body in its own axes, each (..., 3)."""

    omega_body_rad_s: Array
    alpha_body_rad_s2: Array
    jerk_body_rad_s3: Array


class MrpState(NamedTuple):
    """sigma and its first two derivatives in time, each (..., 3)."""

    mrp: Array
    rate_per_s: Array
    acceleration_per_s2: Array


class MrpMotion(NamedTuple):
    """sigma and its first three derivatives in time, each (..., 3)."""

    mrp: Array
    rate_per_s: Array
    acceleration_per_s2: Array
    jerk_per_s3: Array


MrpCurve = Callable[[Array], MrpMotion]  # by instants t_s (n,)


def _row_dot(a: Array, b: Array) -> Array:
    return np.asarray(np.sum(a * b, axis=-1, keepdims=True))


def body_motion(
    motion: Sequence[Any],
    dot: Callable[..., Any] = _row_dot,
    cross: Callable[..., Any] = np.cross,
) -> BodyMotion:
    """Body rates of an `MrpMotion`; dot, cross: of what it is made of instead of arrays."""
    sigma, d1, d2, d3 = motion
    s, s1 = dot(sigma, sigma), dot(sigma, d1)
    s2 = dot(d1, d1) + dot(sigma, d2)
    s3 = 3.0 * dot(d1, d2) + dot(sigma, d3)
    inverse = 1.0 / (1.0 + s)
    f = 4.0 * inverse**2
    f1 = -4.0 * f * inverse * s1
    f2 = f * inverse * (24.0 * inverse * s1**2 - 4.0 * s2)
    a = (1.0 - s) * d1 - 2.0 * cross(sigma, d1) + 2.0 * sigma * s1
    a1 = (1.0 - s) * d2 - 2.0 * cross(sigma, d2) + 2.0 * sigma * s2
    a2 = (1.0 - s) * d3 - 2.0 * s1 * d2 - 2.0 * cross(d1, d2) - 2.0 * cross(sigma, d3)
    a2 = a2 + 2.0 * (d1 * s2 + sigma * s3)
    return BodyMotion(f * a, f1 * a + f * a1, f2 * a + 2.0 * f1 * a1 + f * a2)


def mrp_state(mrp: Array, omega_body_rad_s: Array, alpha_body_rad_s2: Array) -> MrpState:
    """The derivatives of sigma that give these body rates, each (..., 3)."""
    sigma, omega, alpha = mrp, omega_body_rad_s, alpha_body_rad_s2
    s = _row_dot(sigma, sigma)

    def _inverse_derivative(x: Array) -> Array:
        return (1.0 - s) * x + 2.0 * np.cross(sigma, x) + 2.0 * sigma * _row_dot(sigma, x)

    d1 = _inverse_derivative(omega) / 4.0
    s1 = _row_dot(sigma, d1)
    a = omega * (1.0 + s) ** 2 / 4.0
    a1 = (alpha + 16.0 * s1 / (1.0 + s) ** 3 * a) * (1.0 + s) ** 2 / 4.0
    rest = a1 - 2.0 * sigma * _row_dot(d1, d1)
    return MrpState(sigma, d1, _inverse_derivative(rest) / (1.0 + s) ** 2)


def quintic(start: MrpState, end: MrpState, span_s: float, shares: Array) -> MrpMotion:
    """The quintic Hermite at shares (n,) of the span between two states, (n, 3) or (3,)."""
    c0, c1, c2, c3, c4, c5 = quintic_coefficients(span_s, start, end)
    h, x = span_s, shares[:, None]
    return MrpMotion(
        c0 + x * (c1 + x * (c2 + x * (c3 + x * (c4 + x * c5)))),
        (c1 + x * (2 * c2 + x * (3 * c3 + x * (4 * c4 + x * 5 * c5)))) / h,
        (2 * c2 + x * (6 * c3 + x * (12 * c4 + x * 20 * c5))) / h**2,
        (6 * c3 + x * (24 * c4 + x * 60 * c5)) / h**3,
    )
