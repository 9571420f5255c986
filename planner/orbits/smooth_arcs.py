"""Between which nodes of an ephemeris does no engine burn?

A burn makes a kink in the acceleration that a polynomial must not cross.  It shows as a change
of velocity between two nodes that gravity and air don't explain.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from planner.frames.time_scales import Instants
from planner.orbits.forces import Drag, forces_at

# The unexplained mean acceleration above which a cell holds a burn.  In NASA's ISS ephemerides
# coasting cells reach 3e-6 (drag, their other field), reboosts 1.8e-3.
THRUST_MIN_M_S2 = 5e-5
_NO_DRAG = Drag(mass_kg=1.0, area_m2=0.0, coefficient=0.0)
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(5)


@dataclass(frozen=True)
class SmoothArc:
    """Nodes first..last inclusive; thrust_m_s2: 0 while coasting, else the mean thrust."""

    first: int
    last: int
    thrust_m_s2: float


def smooth_arcs(
    nodes: Instants, r_eci_m: NDArray[np.float64], v_eci_m_s: NDArray[np.float64]
) -> list[SmoothArc]:
    """Runs of coasting and of burning cells, in order; neighbours share a node.

    r_eci_m, v_eci_m_s: shape (n, 3), n >= 2.
    """
    thrust_m_s2 = _unexplained_m_s2(nodes, r_eci_m, v_eci_m_s)
    burning = thrust_m_s2 > THRUST_MIN_M_S2
    changes = np.flatnonzero(np.diff(burning)) + 1
    edges = [0, *changes.tolist(), len(burning)]
    return [
        SmoothArc(a, b, float(np.max(thrust_m_s2[a:b])) if burning[a] else 0.0)
        for a, b in pairwise(edges)
    ]


def _unexplained_m_s2(
    nodes: Instants, r_m: NDArray[np.float64], v_m_s: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Mean acceleration of each cell less the modelled one, magnitude, shape (n - 1,).

    The path within a cell is the quintic through position, velocity and modelled
    acceleration at both ends (0.1 m off for nodes 240 s apart in low orbit, 1e-7 m/s^2).
    """
    a_m_s2 = forces_at(nodes, _NO_DRAG).acceleration_eci_m_s2(r_m, v_m_s)
    h = np.diff(nodes.t_s)
    u = 0.5 * (_POINTS + 1.0)
    s, w = u[None, :, None], (1.0 - u)[None, :, None]
    hh = h[:, None, None]
    r0, r1, v0, v1, a0, a1 = (x[:, None, :] for k in (r_m, v_m_s, a_m_s2) for x in (k[:-1], k[1:]))
    path = w**3 * (r0 * (1 + 3 * s + 6 * s**2) + hh * v0 * (s + 3 * s**2) + hh**2 * a0 * s**2 / 2)
    path += s**3 * (r1 * (1 + 3 * w + 6 * w**2) - hh * v1 * (w + 3 * w**2) + hh**2 * a1 * w**2 / 2)
    inner = Instants(nodes.epoch_utc, (nodes.t_s[:-1, None] + h[:, None] * u).ravel())
    flat = path.reshape(-1, 3)
    along = forces_at(inner, _NO_DRAG).acceleration_eci_m_s2(flat, np.zeros_like(flat))
    modelled = np.einsum("kqi,q->ki", along.reshape(len(h), -1, 3), 0.5 * _WEIGHTS)
    return np.asarray(np.linalg.norm(np.diff(v_m_s, axis=0) / h[:, None] - modelled, axis=1))
