"""Arcs of an ephemeris over which no engine burns.

A burn makes a kink in the acceleration that a polynomial must not cross.  It shows as a change
of velocity between two nodes that gravity and air don't explain.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from planner.orbits.cell_defects import CellDefects

# The unexplained mean acceleration above which a cell holds a burn.  In NASA's ISS ephemerides
# coasting cells reach 3e-6 (drag, their other field), reboosts 1.8e-3.
THRUST_MIN_M_S2 = 5e-5


@dataclass(frozen=True)
class SmoothArc:
    """Nodes first..last inclusive; thrust_m_s2: 0 while coasting, else the mean thrust."""

    first: int
    last: int
    thrust_m_s2: float


def smooth_arcs(defects: CellDefects) -> list[SmoothArc]:
    """Runs of coasting and of burning cells, in order; neighbours share a node."""
    thrust_m_s2 = defects.thrust_m_s2
    burning = thrust_m_s2 > THRUST_MIN_M_S2
    changes = np.flatnonzero(np.diff(burning)) + 1
    edges = [0, *changes.tolist(), len(burning)]
    return [
        SmoothArc(a, b, float(np.max(thrust_m_s2[a:b])) if burning[a] else 0.0)
        for a, b in pairwise(edges)
    ]
