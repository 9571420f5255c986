"""Burns that an ephemeris holds: when each begins and what it adds to the velocity."""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime

import numpy as np

from planner.base.arrays import Array
from planner.world.frames.earth_orientation import eci_from_frame_state
from planner.world.frames.time_scales import Instants, elapsed_s, shifted_utc
from planner.world.messages.oem import OemSegment
from planner.world.orbits.cell_defects import OPTIONS as CELL_DEFECT_OPTIONS
from planner.world.orbits.cell_defects import cell_defects


@dataclass(frozen=True, kw_only=True)
class BurnOptions:
    """Which burns are told, and how they are searched for."""

    # Less moves the carrier by less in a day than the rest of an operator's forecast is wrong by.
    along_min_m_s: float = 0.01
    cells: int = 300  # at a time: 35 MB of the field's harmonics


OPTIONS = BurnOptions()


@dataclass(frozen=True)
class Burn:
    """From ignition_utc on; gain_m_s of velocity, along_m_s of it along the track."""

    ignition_utc: datetime
    gain_m_s: float
    along_m_s: float


def burns_between(
    segments: Sequence[OemSegment], start_utc: datetime, stop_utc: datetime
) -> tuple[Burn, ...]:
    """Burns that begin from start to stop, within segments or as a jump from one to the next.

    Leaves out burns between states too far apart to tell (10 minutes in low orbit).
    """
    t_s, r_eci_m, v_eci_m_s = _node_timeline(segments, start_utc, stop_utc)
    found = [
        cell_defects(Instants(start_utc, t_s[near]), r_eci_m[near], v_eci_m_s[near])
        for near in (
            slice(first, first + OPTIONS.cells + 1)
            for first in range(0, len(t_s) - 1, OPTIONS.cells)
        )
    ]
    if not found:
        return ()
    gain_m_s = np.concatenate([defects.velocity_m_s for defects in found])
    remainder_m = np.concatenate([defects.remainder_m for defects in found])
    step_s = np.diff(t_s)
    thrust_m_s2 = np.linalg.norm(gain_m_s, axis=1) / step_s
    # The method's own error moves a cell's end, too.
    least_m_s2 = np.maximum(CELL_DEFECT_OPTIONS.thrust_min_m_s2, 4.0 * remainder_m / step_s**2)
    burning = (thrust_m_s2 > least_m_s2) & (remainder_m < CELL_DEFECT_OPTIONS.refuse_m)
    edges = np.flatnonzero(np.diff(burning, prepend=False, append=False)).reshape(-1, 2)
    burns = []
    for first, last in edges:
        gain = gain_m_s[first:last].sum(axis=0)
        along_m_s = float(gain @ v_eci_m_s[first] / np.linalg.norm(v_eci_m_s[first]))
        if t_s[first] >= 0.0 and abs(along_m_s) > OPTIONS.along_min_m_s:
            ignition_utc = shifted_utc(start_utc, float(t_s[first]))
            burns.append(Burn(ignition_utc, float(np.linalg.norm(gain)), along_m_s))
    return tuple(burns)


def _node_timeline(
    segments: Sequence[OemSegment], start_utc: datetime, stop_utc: datetime
) -> tuple[Array, Array, Array]:
    """Nodes of all segments in order, seconds from start_utc and states in ECI, the first of those
    that overlap, from one before start to one after stop.
    """
    nodes: list[tuple[Array, Array, Array]] = []
    reach_s, span_s = -np.inf, elapsed_s(stop_utc, start_utc)
    for segment in segments:
        t_s = segment.t_s + elapsed_s(segment.epoch_utc, start_utc)
        first = max(int(np.searchsorted(t_s, 0.0, side="right")) - 1, 0)
        first = max(first, int(np.searchsorted(t_s, reach_s, side="right")))
        near = slice(first, int(np.searchsorted(t_s, span_s)) + 1)
        if len(t_s[near]):
            at = Instants(segment.epoch_utc, segment.t_s[near])
            states = eci_from_frame_state(segment.frame, segment.r_m[near], segment.v_m_s[near], at)
            nodes.append((t_s[near], *states))
            reach_s = float(t_s[near][-1])
    if not nodes:
        return np.zeros(0), np.zeros((0, 3)), np.zeros((0, 3))
    t_s, r_eci_m, v_eci_m_s = (np.concatenate(parts) for parts in zip(*nodes, strict=True))
    return t_s, r_eci_m, v_eci_m_s
