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

from planner.arrays import Array
from planner.orbits.gravity import GM_M3_S2, RADIUS_M

Vectors = Array

SEGMENT_S = 900.0
NODES = 49  # a wave of degree 36 takes 150 s: eight nodes each
_J2 = 1.0826359e-3  # of the same field; only speeds convergence, no influence on the result
_INNER_TOLERANCE_M = 1e-7
_OUTER_TOLERANCE_M = 1e-5
_MAX_SWEEPS = 60
_DIVERGED_M = 1e9


@dataclass(frozen=True, eq=False)
class CollocationSegment:
    """Motion from start_s to stop_s (start_s > stop_s when propagated backward).

    position, velocity: Chebyshev coefficients over [-1, 1], shape (NODES + 2, 3), m and m/s.
    """

    start_s: float
    stop_s: float
    position: Vectors
    velocity: Vectors

    def at(self, t_s: Array) -> tuple[Vectors, Vectors]:
        """Position and velocity, shape (n, 3), at t_s, shape (n,)."""
        tau = 2.0 * (t_s - self.start_s) / (self.stop_s - self.start_s) - 1.0
        basis = chebyshev.chebvander(tau, len(self.position) - 1)
        return basis @ self.position, basis[:, : len(self.velocity)] @ self.velocity


@dataclass(frozen=True, eq=False)
class _Scheme:
    """Nodes on [-1, 1] and the maps from accelerations at them.

    once, twice: to Chebyshev coefficients of the first and second integral from -1.
    once_at, twice_at: to those integrals at the nodes.
    """

    nodes: Array
    once: Array
    twice: Array
    once_at: Array
    twice_at: Array


@cache
def _scheme() -> _Scheme:
    nodes = -np.cos(np.pi * np.arange(NODES) / (NODES - 1))
    nodes[0], nodes[-1] = -1.0, 1.0
    fit: Vectors = np.linalg.inv(chebyshev.chebvander(nodes, NODES - 1)).astype(np.float64)
    once: Vectors = chebyshev.chebint(fit, lbnd=-1.0).astype(np.float64)
    twice: Vectors = chebyshev.chebint(once, lbnd=-1.0).astype(np.float64)
    return _Scheme(
        nodes=nodes,
        once=once,
        twice=twice,
        once_at=chebyshev.chebvander(nodes, NODES) @ once,
        twice_at=chebyshev.chebvander(nodes, NODES + 1) @ twice,
    )


def node_times_s(start_s: float, stop_s: float) -> Array:
    """Where `propagate_segment` asks for accelerations."""
    return start_s + 0.5 * (stop_s - start_s) * (_scheme().nodes + 1.0)


def propagate_segment(
    r_m: Array,
    v_m_s: Array,
    start_s: float,
    stop_s: float,
    acceleration: Callable[[Vectors, Vectors], Vectors],
) -> CollocationSegment | None:
    """Motion from the state r_m, v_m_s, shape (3,), at start_s.

    acceleration: positions and velocities at the nodes, shape (NODES, 3), to accelerations in
    inertial axes.  All but the central and J2 terms are held while those two are iterated,
    then taken anew: three calls suffice.  Good to 1e-5 m for up to 1000 s in low orbit.
    Source: Bai & Junkins 2011 (modified Chebyshev-Picard iteration).
    """
    scheme = _scheme()
    half_s = 0.5 * (stop_s - start_s)
    since_s = (half_s * (scheme.nodes + 1.0))[:, None]
    # Circular motion as a first guess.
    rate = np.sqrt(GM_M3_S2 / np.linalg.norm(r_m) ** 3)
    r = r_m * np.cos(rate * since_s) + v_m_s / rate * np.sin(rate * since_s)
    held = np.zeros_like(r)
    for _ in range(_MAX_SWEEPS):
        total = _central_j2(r) + held
        improved = r_m + v_m_s * since_s + half_s**2 * (scheme.twice_at @ total)
        change_m = float(np.max(np.abs(improved - r)))
        r = improved
        if not change_m < _DIVERGED_M:
            return None
        if change_m < _INNER_TOLERANCE_M:
            v = v_m_s + half_s * (scheme.once_at @ total)
            full = acceleration(r, v)
            renewed = full - _central_j2(r)
            step_m = half_s**2 * float(np.max(np.abs(scheme.twice_at @ (renewed - held))))
            held = renewed
            if step_m < _OUTER_TOLERANCE_M:
                return _segment(r_m, v_m_s, start_s, stop_s, full)
    return None


def _segment(
    r_m: Array, v_m_s: Array, start_s: float, stop_s: float, acceleration_m_s2: Vectors
) -> CollocationSegment:
    scheme = _scheme()
    half_s = 0.5 * (stop_s - start_s)
    velocity = half_s * (scheme.once @ acceleration_m_s2)
    velocity[0] += v_m_s
    position = half_s**2 * (scheme.twice @ acceleration_m_s2)
    # v (t - start) = v half (1 + tau)
    position[0] += r_m + half_s * v_m_s
    position[1] += half_s * v_m_s
    return CollocationSegment(start_s, stop_s, position, velocity)


def _central_j2(r_m: Vectors) -> Vectors:
    """Point mass and oblateness about the z axis, shape (n, 3)."""
    r2 = np.einsum("ni,ni->n", r_m, r_m)[:, None]
    u = r_m[:, 2:] ** 2 / r2
    factor = 1.5 * _J2 * RADIUS_M**2 / r2
    bracket = 1.0 - factor * (5.0 * u - 1.0) + factor * np.array([0.0, 0.0, 2.0])
    pull: Vectors = -GM_M3_S2 / r2**1.5 * r_m * bracket
    return pull
