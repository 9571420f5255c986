"""Windows of imaging modes: when each scan can begin and be held to its end."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from planner.base import effort
from planner.base.arrays import Array, Mask
from planner.planning.opportunities.carrier import Carrier
from planner.planning.opportunities.platforms.lookout import HeldScans, Lookout
from planner.planning.opportunities.scans import ModeScan
from planner.planning.opportunities.sights import scan_sight
from planner.world.platforms import RollRule


@dataclass(frozen=True, kw_only=True)
class ScanWindowOptions:
    """How closely the begins of scans are looked at."""

    step_s: float = 1.0  # between begins that are tried: no attitude comes and goes in less
    edge_s: float = 1e-3  # of a window: a session begins on rows 0.2 s apart
    sample_rows: float = 1.0  # of `effort`, to look at one instant of one scan


OPTIONS = ScanWindowOptions()


@dataclass(frozen=True, kw_only=True, eq=False)
class ScanWindows:
    """Windows of a scan, (k, 2) each, since the start of what is asked.

    begins_s: from its first begin to its last, with every condition held through all of it.
    held_s: the longest part of each in which a session can begin, NaN where none can.
    """

    scan: ModeScan
    begins_s: Array
    held_s: Array


def windows_of_scans(
    scans: Sequence[ModeScan],
    rolls: Mapping[int, RollRule | None],
    lookout: Lookout,
    carrier: Carrier,
) -> Iterator[ScanWindows]:
    """Windows of scans as `scans_by_pass` finds them.

    rolls: rule by which a body lies on the lines of a mode, by row.
    Edges are within a millisecond of those of the margins.  Gaps and windows of less than a second
    may be missed, and of a line what comes and goes between looks a second apart.
    Raises WorkLimitReached.
    """
    for scan in scans:
        windows_s, sessions_s = [np.empty((0, 2))], [np.empty((0, 2))]
        held_at = partial(_held_at, scan, rolls[scan.row], lookout, carrier)
        for start_s, stop_s in scan.begins_s.tolist():
            cells = max(math.ceil((stop_s - start_s) / OPTIONS.step_s), 1)
            t_s = np.linspace(start_s, stop_s, cells + 1)
            found = held_at(t_s)
            for column, spans_s in enumerate((windows_s, sessions_s)):
                spans_s.append(_runs(t_s, found[column], held_at, column))
        begins_s = np.concatenate(windows_s)
        # A session lasts whole rows, up to one longer than its line.
        whole_s = begins_s - np.array([0.0, scan.duration_s - scan.path.duration_s])
        held_s = _longest_within(whole_s, np.concatenate(sessions_s))
        yield ScanWindows(scan=scan, begins_s=begins_s, held_s=held_s)


def _held_at(
    scan: ModeScan, roll: RollRule | None, lookout: Lookout, carrier: Carrier, begins_s: Array
) -> HeldScans:
    around_s = lookout.settle_s + OPTIONS.step_s
    samples = math.ceil((scan.duration_s + lookout.settle_s) / OPTIONS.step_s) + 1
    effort.charge(OPTIONS.sample_rows * samples * len(begins_s))
    sight = scan_sight(carrier, scan.path, roll, begins_s, around_s)
    return lookout.held_scans(sight, begins_s, scan.duration_s)


def _runs(t_s: Array, is_held: Mask, held_at: Callable[[Array], HeldScans], column: int) -> Array:
    """Spans over which scans are held, (k, 2), edges halved until they are known.

    is_held: at t_s.  column: of `HeldScans`, which that is.
    """
    steps = np.diff(np.concatenate([[False], is_held, [False]]).astype(np.int8))
    firsts, lasts = np.flatnonzero(steps == 1), np.flatnonzero(steps == -1) - 1
    inside_s = np.concatenate([t_s[firsts], t_s[lasts]])
    outside_s = np.concatenate(
        [t_s[np.maximum(firsts - 1, 0)], t_s[np.minimum(lasts + 1, len(t_s) - 1)]]
    )
    while len(inside_s) and np.abs(inside_s - outside_s).max() > OPTIONS.edge_s:
        middle_s = 0.5 * (inside_s + outside_s)
        is_in = held_at(middle_s)[column]
        inside_s, outside_s = (
            np.where(is_in, middle_s, inside_s),
            np.where(is_in, outside_s, middle_s),
        )
    return inside_s.reshape(2, -1).T


def _longest_within(windows_s: Array, sessions_s: Array) -> Array:
    """Of each window the longest span of sessions within it, or NaN, (k, 2)."""
    longest_s = np.full(windows_s.shape, math.nan)
    for row, (start_s, stop_s) in enumerate(windows_s.tolist()):
        within_s = np.clip(sessions_s, start_s, stop_s)
        lasts_s = within_s[:, 1] - within_s[:, 0]
        if len(lasts_s) and lasts_s.max() > 0.0:
            longest_s[row] = within_s[np.argmax(lasts_s)]
    return longest_s
