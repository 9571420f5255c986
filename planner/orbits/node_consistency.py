"""Nodes of an ephemeris that can't be right, seeing their neighbours.

A node with a digit damaged lies off the path that its neighbours lead to, or moves otherwise.
An engine does neither: a thrust within a cell changes the position by no more than its gain of
velocity over the cell, and isn't taken back in the next cell.
"""

from dataclasses import dataclass

import numpy as np

from planner.orbits.cell_defects import CellDefects

# Epochs printed to 1 ms put a state up to 8 m from its place in low orbit: nodes of NASA's ISS
# ephemeris 2025-057 are 7.7 m off for it, all others of NASA's at 240 s below 0.05 m.
WARN_M = 10.0
REFUSE_M = 50.0  # 25 arcsec from 400 km; a state 6 ms late
# Unlike any carrier of a camera, but not unlike states of a turning frame stated as inertial,
# whose Coriolis acceleration is 1.1 m/s^2 in low orbit.
THRUST_MAX_M_S2 = 0.5
_REVERSAL_SHARE = 0.2  # of the gain of velocity may be left after two cells


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
    is_reversed = np.linalg.norm(gain + next_gain, axis=1) < _REVERSAL_SHARE * jump_m_s
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
    thrust_m_s2 = np.where(defects.remainder_m < REFUSE_M, defects.thrust_m_s2, 0.0)
    cell = int(np.argmax(thrust_m_s2))
    return cell if thrust_m_s2[cell] > THRUST_MAX_M_S2 else None
