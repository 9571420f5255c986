"""Defects of an ephemeris's cells: its miss of each next node under natural forces alone.

What is left shows engines that burn, and nodes that were damaged on their way to us.  A burn
makes a kink in the acceleration that a polynomial must not cross: it ends an arc.

A node with a digit damaged lies off the path that its neighbours lead to, or moves otherwise.
An engine does neither: a thrust within a cell changes the position by no more than its gain of
velocity over the cell, and isn't taken back in the next cell.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from planner.base.arrays import Array
from planner.world.frames.time_scales import Instants
from planner.world.orbits.forces import forces_at

_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(5)


@dataclass(frozen=True, kw_only=True)
class CellDefectOptions:
    """When states of an ephemeris are told to contradict each other, or a burn."""

    # A path between nodes too far apart, or damaged, may run through the Earth, where the field's
    # harmonics mean nothing.
    path_radius_min_m: float = 6.0e6
    # The unexplained mean acceleration above which a cell holds a burn.  In NASA's ISS
    # ephemerides coasting cells reach 3e-6 (drag, their other field), reboosts 1.8e-3.
    thrust_min_m_s2: float = 5e-5
    # Epochs printed to 1 ms put a state up to 8 m from its place in low orbit: nodes of NASA's
    # ISS ephemeris 2025-057 are 7.7 m off for it, all others of NASA's at 240 s below 0.05 m.
    warn_m: float = 10.0
    refuse_m: float = 50.0  # 25 arcsec from 400 km; a state 6 ms late
    # Unlike any carrier of a camera, but not unlike states of a turning frame stated as inertial,
    # whose Coriolis acceleration is 1.1 m/s^2 in low orbit.
    thrust_max_m_s2: float = 0.5
    reversal_share: float = 0.2  # of the gain of velocity may be left after two cells


OPTIONS = CellDefectOptions()


@dataclass(frozen=True, eq=False)
class CellDefects:
    """Of each of the cells between n nodes, in time's order.

    step_s: shape (n - 1,).  velocity_m_s: gain of velocity that gravity doesn't explain,
    shape (n - 1, 3), ECI.  position_m: shape (n - 1, 3), where the cell ends against where a
    steady thrust of that gain would end: a thrust anywhere within the cell is off by at most
    |velocity_m_s| step_s / 2.  remainder_m: shape (n - 1,), bound of the method's own error
    (0.06 m for nodes 240 s apart in low orbit, 43 m for 720 s).
    """

    step_s: Array
    velocity_m_s: Array
    position_m: Array
    remainder_m: Array

    @property
    def thrust_m_s2(self) -> Array:
        """Mean acceleration of each cell less the modelled one, magnitude, shape (n - 1,)."""
        return np.asarray(np.linalg.norm(self.velocity_m_s, axis=1) / self.step_s)

    @property
    def beyond_thrust_m(self) -> Array:
        """What no thrust of that gain explains of the position, shape (n - 1,)."""
        position_m = np.linalg.norm(self.position_m, axis=1)
        return np.asarray(position_m - 0.5 * self.thrust_m_s2 * self.step_s**2)


def cell_defects(nodes: Instants, r_eci_m: Array, v_eci_m_s: Array) -> CellDefects:
    """r_eci_m, v_eci_m_s: shape (n, 3), n >= 2.

    The path within a cell is the quintic through position, velocity and modelled
    acceleration at both ends (0.1 m off for nodes 240 s apart in low orbit, 1e-7 m/s^2).
    Leaves out drag (3e-6 m/s^2 on the ISS).
    """
    a_m_s2 = forces_at(nodes, 0.0).acceleration_eci_m_s2(r_eci_m, v_eci_m_s)
    h = np.diff(nodes.t_s)
    u = 0.5 * (_POINTS + 1.0)
    s, w = u[None, :, None], (1.0 - u)[None, :, None]
    hh = h[:, None, None]
    ends = [x[:, None, :] for k in (r_eci_m, v_eci_m_s, a_m_s2) for x in (k[:-1], k[1:])]
    r0, r1, v0, v1, a0, a1 = ends
    path = w**3 * (r0 * (1 + 3 * s + 6 * s**2) + hh * v0 * (s + 3 * s**2) + hh**2 * a0 * s**2 / 2)
    path += s**3 * (r1 * (1 + 3 * w + 6 * w**2) - hh * v1 * (w + 3 * w**2) + hh**2 * a1 * w**2 / 2)
    path *= np.maximum(1.0, OPTIONS.path_radius_min_m / np.linalg.norm(path, axis=2, keepdims=True))
    inner = Instants(nodes.epoch_utc, (nodes.t_s[:-1, None] + h[:, None] * u).ravel())
    flat = path.reshape(-1, 3)
    along = forces_at(inner, 0.0).acceleration_eci_m_s2(flat, np.zeros_like(flat))
    along = along.reshape(len(h), -1, 3)
    mean_m_s2 = np.einsum("kqi,q->ki", along, 0.5 * _WEIGHTS)
    early_m_s2 = np.einsum("kqi,q->ki", along, 0.5 * _WEIGHTS * (0.5 - u))
    mean_v_m_s = 0.5 * (v_eci_m_s[:-1] + v_eci_m_s[1:])
    radius_m, speed_m_s = (np.linalg.norm(x, axis=1) for x in (r_eci_m, v_eci_m_s))
    # The remainder of quintic Hermite interpolation, of circular motion at the faster end.
    swept_rad = np.maximum((speed_m_s / radius_m)[:-1], (speed_m_s / radius_m)[1:]) * h
    return CellDefects(
        step_s=h,
        velocity_m_s=np.diff(v_eci_m_s, axis=0) - h[:, None] * mean_m_s2,
        position_m=np.diff(r_eci_m, axis=0)
        - h[:, None] * mean_v_m_s
        - h[:, None] ** 2 * early_m_s2,
        remainder_m=radius_m[:-1] * swept_rad**6 / 46080.0,
    )


@dataclass(frozen=True)
class SmoothArc:
    """Nodes first..last inclusive; thrust_m_s2: 0 while coasting, else the mean thrust."""

    first: int
    last: int
    thrust_m_s2: float


def smooth_arcs(defects: CellDefects) -> list[SmoothArc]:
    """Runs of coasting and of burning cells, in order; neighbours share a node."""
    thrust_m_s2 = defects.thrust_m_s2
    burning = thrust_m_s2 > OPTIONS.thrust_min_m_s2
    changes = np.flatnonzero(np.diff(burning)) + 1
    edges = [0, *changes.tolist(), len(burning)]
    return [
        SmoothArc(a, b, float(np.max(thrust_m_s2[a:b])) if burning[a] else 0.0)
        for a, b in pairwise(edges)
    ]


@dataclass(frozen=True)
class OddNodes:
    """Nodes first..last (one, or two of which either may be wrong), by how much they are off."""

    first: int
    last: int
    off_m: float


def odd_nodes(defects: CellDefects) -> OddNodes:
    """What is oddest among n >= 2 nodes; off_m is beyond what the method itself leaves.

    A node is told from its neighbour by the cells on both its sides; the first and the last
    can't be.  A wrong velocity counts by what it moves the middle of the longer cell's end,
    gain times step / 2.
    """
    beyond_m = defects.beyond_thrust_m - defects.remainder_m
    worst = int(np.argmax(beyond_m))
    odd = OddNodes(worst, worst + 1, float(beyond_m[worst]))
    if len(beyond_m) == 1:
        return odd
    displacement_m = np.minimum(beyond_m[:-1], beyond_m[1:])
    gain, next_gain = defects.velocity_m_s[:-1], defects.velocity_m_s[1:]
    jump_m_s = 0.5 * np.linalg.norm(gain - next_gain, axis=1)
    is_reversed = np.linalg.norm(gain + next_gain, axis=1) < OPTIONS.reversal_share * jump_m_s
    step_s = np.maximum(defects.step_s[:-1], defects.step_s[1:])
    remainder_m = np.maximum(defects.remainder_m[:-1], defects.remainder_m[1:])
    jump_m = np.where(is_reversed, 0.5 * jump_m_s * step_s - remainder_m, 0.0)
    at_node_m = np.maximum(displacement_m, jump_m)
    node = int(np.argmax(at_node_m))
    # Both cells of a damaged node are bad; a step between two good halves has but one.
    if at_node_m[node] >= 0.5 * odd.off_m:
        return OddNodes(node + 1, node + 1, float(max(at_node_m[node], beyond_m[node])))
    return odd


def strongest_push(defects: CellDefects) -> int | None:
    """The cell of the strongest thrust, if it is more than any carrier's engine gives.

    Cells too long for the method to tell are left out.
    """
    thrust_m_s2 = np.where(defects.remainder_m < OPTIONS.refuse_m, defects.thrust_m_s2, 0.0)
    cell = int(np.argmax(thrust_m_s2))
    return cell if thrust_m_s2[cell] > OPTIONS.thrust_max_m_s2 else None
