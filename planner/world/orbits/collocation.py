"""A satellite's motion under all forces: Picard iteration on Chebyshev nodes.

A segment's acceleration is one polynomial through its nodes; velocity and position are its
integrals, so that the velocity is the exact derivative of the position.  The force model
sees all nodes of a segment at once.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.polynomial import chebyshev

from planner.base.arrays import Array
from planner.world.orbits.gravity import GM_M3_S2, RADIUS_M


@dataclass(frozen=True, kw_only=True)
class CollocationOptions:
    """How an orbit is propagated."""

    segment_s: float = 900.0  # a sixth of a revolution, so that sweeps converge
    nodes: int = 49  # a wave of degree 36 takes 150 s: eight nodes each
    inner_tolerance_m: float = 1e-7  # of a sweep in the simple field, which costs nothing
    # of a sweep in the full one: far below what the forces are known to
    outer_tolerance_m: float = 1e-5
    max_sweeps: int = 60  # bounds what a field without an orbit takes
    diverged_m: float = 1e9  # farther than any satellite: it fell


OPTIONS = CollocationOptions()

_J2 = 1.0826359e-3  # of the same field; only speeds convergence, no influence on the result


@dataclass(frozen=True, eq=False)
class CollocationSegment:
    """Motion from start_s to stop_s (start_s > stop_s when propagated backward).

    r_coefficients_m, v_coefficients_m_s: of Chebyshev polynomials over [-1, 1], inertial axes,
    shape (NODES + 2, 3) and (NODES + 1, 3).
    """

    start_s: float
    stop_s: float
    r_coefficients_m: Array
    v_coefficients_m_s: Array

    def at(self, t_s: Array) -> tuple[Array, Array]:
        """Position and velocity, shape (n, 3), at t_s, shape (n,)."""
        tau = 2.0 * (t_s - self.start_s) / (self.stop_s - self.start_s) - 1.0
        basis = chebyshev.chebvander(tau, len(self.r_coefficients_m) - 1)
        v_basis = basis[:, : len(self.v_coefficients_m_s)]
        return basis @ self.r_coefficients_m, v_basis @ self.v_coefficients_m_s


@dataclass(frozen=True, eq=False)
class _Scheme:
    """Nodes on [-1, 1], `cosines`, and the maps from accelerations at them.

    integral_coefficients, double_integral_coefficients: to the Chebyshev coefficients of the first
    and second integral from -1.  integral_matrix, double_integral_matrix: to their values at the
    nodes.
    """

    cosines: Array
    integral_coefficients: Array
    double_integral_coefficients: Array
    integral_matrix: Array
    double_integral_matrix: Array


@cache
def _collocation_scheme() -> _Scheme:
    cosines = -np.cos(np.pi * np.arange(OPTIONS.nodes) / (OPTIONS.nodes - 1))
    cosines[0], cosines[-1] = -1.0, 1.0
    fit: Array = np.linalg.inv(chebyshev.chebvander(cosines, OPTIONS.nodes - 1)).astype(np.float64)
    once: Array = chebyshev.chebint(fit, lbnd=-1.0).astype(np.float64)
    twice: Array = chebyshev.chebint(once, lbnd=-1.0).astype(np.float64)
    return _Scheme(
        cosines=cosines,
        integral_coefficients=once,
        double_integral_coefficients=twice,
        integral_matrix=chebyshev.chebvander(cosines, OPTIONS.nodes) @ once,
        double_integral_matrix=chebyshev.chebvander(cosines, OPTIONS.nodes + 1) @ twice,
    )


def node_times_s(start_s: float, stop_s: float) -> Array:
    """Where `propagate_segment` asks for accelerations."""
    return start_s + 0.5 * (stop_s - start_s) * (_collocation_scheme().cosines + 1.0)


def propagate_segment(
    r_m: Array,
    v_m_s: Array,
    start_s: float,
    stop_s: float,
    acceleration_m_s2: Callable[[Array, Array], Array],
) -> CollocationSegment | None:
    """Motion from the state r_m, v_m_s, shape (3,), at start_s.

    acceleration_m_s2: positions and velocities at the nodes, shape (NODES, 3), to accelerations in
    inertial axes.  All but the central and J2 terms are held while those two are iterated,
    then taken anew: three calls suffice.  Good to 1e-5 m for up to 1000 s in low orbit.
    Source: Bai & Junkins 2011 (modified Chebyshev-Picard iteration).
    """
    scheme = _collocation_scheme()
    half_s = 0.5 * (stop_s - start_s)
    since_s = (half_s * (scheme.cosines + 1.0))[:, None]
    # Circular motion as a first guess.
    rate = np.sqrt(GM_M3_S2 / np.linalg.norm(r_m) ** 3)
    r = r_m * np.cos(rate * since_s) + v_m_s / rate * np.sin(rate * since_s)
    other = np.zeros_like(r)
    for _ in range(OPTIONS.max_sweeps):
        total = _central_j2_m_s2(r) + other
        next_r = r_m + v_m_s * since_s + half_s**2 * (scheme.double_integral_matrix @ total)
        change_m = float(np.max(np.abs(next_r - r)))
        r = next_r
        if not change_m < OPTIONS.diverged_m:
            return None
        if change_m < OPTIONS.inner_tolerance_m:
            v = v_m_s + half_s * (scheme.integral_matrix @ total)
            full = acceleration_m_s2(r, v)
            next_other = full - _central_j2_m_s2(r)
            step_m = half_s**2 * float(
                np.max(np.abs(scheme.double_integral_matrix @ (next_other - other)))
            )
            other = next_other
            if step_m < OPTIONS.outer_tolerance_m:
                break
    else:
        return None
    v_coefficients_m_s = half_s * (scheme.integral_coefficients @ full)
    v_coefficients_m_s[0] += v_m_s
    r_coefficients_m = half_s**2 * (scheme.double_integral_coefficients @ full)
    # v (t - start) = v half (1 + tau)
    r_coefficients_m[0] += r_m + half_s * v_m_s
    r_coefficients_m[1] += half_s * v_m_s
    return CollocationSegment(start_s, stop_s, r_coefficients_m, v_coefficients_m_s)


def _central_j2_m_s2(r_m: Array) -> Array:
    """Point mass and oblateness about the z axis, shape (n, 3)."""
    r2 = np.einsum("ni,ni->n", r_m, r_m)[:, None]
    u = r_m[:, 2:] ** 2 / r2
    factor = 1.5 * _J2 * RADIUS_M**2 / r2
    bracket = 1.0 - factor * (5.0 * u - 1.0) + factor * np.array([0.0, 0.0, 2.0])
    pull: Array = -GM_M3_S2 / r2**1.5 * r_m * bracket
    return pull
