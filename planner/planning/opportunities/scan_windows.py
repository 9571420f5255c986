"""Windows of imaging modes: when each scan can begin and be held to its end."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from planner.base import effort
from planner.base.arrays import Array, Mask
from planner.planning.opportunities.carrier import Carrier
from planner.planning.opportunities.platforms.lookout import HeldScans, Lookout
from planner.planning.opportunities.platforms.registry import lookout_of
from planner.planning.opportunities.request import OpportunityRequest
from planner.planning.opportunities.scans import ModeScan, ScansAsked, middle_of, scans_by_pass
from planner.planning.opportunities.sights import scan_sight
from planner.planning.opportunities.windows import WindowEdges
from planner.world.platforms import RollRule
from planner.world.targets import GroundPathTarget, GroundTarget


@dataclass(frozen=True, kw_only=True)
class ScanWindowOptions:
    """How closely the begins of scans are looked at."""

    step_s: float = 1.0  # between begins that are tried: no attitude comes and goes in less
    edge_s: float = 1e-3  # of a window: a session begins on rows 0.2 s apart
    sample_rows: float = 1.0  # of `effort`, to look at one instant of one scan
    look_s: float = 2.0  # in which a look of a stereo with a gap begins


OPTIONS = ScanWindowOptions()


@dataclass(frozen=True, kw_only=True, eq=False)
class ScanWindows:
    """Windows of a scan, (k, 2) each, since the start of what is asked.

    begins_s: from its first begin to its last, with every condition held through all of it.
    held_s: the longest part of each in which a session can begin, NaN where none can.
    causes: what makes the edges.
    """

    scan: ModeScan
    begins_s: Array
    held_s: Array
    causes: NDArray[np.str_]


def windows_of_scans(
    scans: Sequence[ModeScan],
    rolls: Mapping[int, RollRule | None],
    asked: ScansAsked,
    carrier: Carrier,
) -> Iterator[ScanWindows]:
    """Windows of scans as `scans_by_pass` finds them for what is asked.

    rolls: rule by which a body lies on the lines of a mode, by row.
    Edges are within a millisecond of those of the margins.  Gaps and windows of less than a second
    may be missed, and of a line what comes and goes between looks a second apart.
    Raises WorkLimitReached.
    """
    narrower = [
        (one.name, lookout_of(one.platform, asked.attitude))
        for one in lookout_of(asked.platform, asked.attitude).narrowing()
    ]
    lookout = narrower[-1][1]
    for scan in scans:
        windows_s, sessions_s = [np.empty((0, 2))], [np.empty((0, 2))]
        edges_by = [np.empty((0, 2), np.str_)]
        held_at = partial(_held_at, scan, rolls[scan.row], carrier)
        for (start_s, stop_s), causes in zip(scan.begins_s, scan.causes, strict=True):
            cells = max(math.ceil((stop_s - start_s) / OPTIONS.step_s), 1)
            t_s = np.linspace(start_s, stop_s, cells + 1)
            found = held_at(lookout, t_s)
            for column, spans_s in enumerate((windows_s, sessions_s)):
                spans_s.append(_runs(t_s, found[column], partial(held_at, lookout), column))
            beside_s = windows_s[-1] + OPTIONS.edge_s * np.array([-1.0, 1.0])
            is_within = (beside_s > start_s) & (beside_s < stop_s)
            by_platform = [
                [_closed_by(narrower, held_at, t_s) for t_s in row] for row in beside_s.tolist()
            ]
            edges_by.append(
                np.where(is_within, np.reshape(by_platform, (-1, 2)).astype(np.str_), causes)
            )
        begins_s = np.concatenate(windows_s)
        # A session lasts whole rows, up to one longer than its line.
        whole_s = begins_s - np.array([0.0, scan.duration_s - scan.path.duration_s])
        held_s = _longest_within(whole_s, np.concatenate(sessions_s))
        yield ScanWindows(
            scan=scan, begins_s=begins_s, held_s=held_s, causes=np.concatenate(edges_by)
        )


def scan_edges(request: OpportunityRequest, carrier: Carrier) -> WindowEdges:
    """Windows of the scans of a request's imaging modes, each from its first begin to the end of
    what begins last, by target and time.

    Raises WorkLimitReached.
    """
    scans = scans_by_pass(request, request.modes, carrier, OPTIONS.look_s)
    rolls = {row: request.roll_on_scans(row) for row in request.modes}
    found = list(windows_of_scans(scans.found, rolls, request, carrier))
    of_scan = np.repeat(
        np.arange(len(found)), np.array([len(one.begins_s) for one in found], np.intp)
    )
    begins_s, held_s = (
        np.concatenate([np.empty((0, 2)), *(getattr(one, name) for one in found)])
        for name in ("begins_s", "held_s")
    )
    causes = np.concatenate([np.empty((0, 2), np.str_), *(one.causes for one in found)])
    told = np.array([_told(one.scan) for one in found]).reshape(-1, 9)[of_scan]
    edges = WindowEdges(
        target=told[:, 0].astype(np.intp),
        rise_s=begins_s[:, 0],
        set_s=begins_s[:, 1] + told[:, 1],
        held_from_s=held_s[:, 0],
        held_to_s=held_s[:, 1],
        opened_by=causes[:, 0],
        closed_by=causes[:, 1],
        scan_parameters=told[:, 2:],
    )
    in_time = edges.select(np.lexsort((edges.rise_s, edges.target)))
    return in_time.select(in_time.set_s - in_time.rise_s >= request.conditions.min_duration_s)


def _told(scan: ModeScan) -> tuple[float, ...]:
    """Row, duration of the line, then as `WindowEdges.scan_parameters`."""
    first, last = scan.path.points
    return (
        scan.row,
        scan.path.duration_s,
        scan.part,
        scan.parts,
        scan.duration_s,
        first.longitude_deg,
        first.latitude_deg,
        last.longitude_deg,
        last.latitude_deg,
    )


def scanned_path(request: OpportunityRequest, edges: WindowEdges, window: int) -> GroundPathTarget:
    """The line of a window of a scan."""
    mode = request.modes[int(edges.target[window])]
    start_longitude, start_latitude, *end = edges.scan_parameters[window, 3:].tolist()
    return mode.path_between((start_longitude, start_latitude), (end[0], end[1]))


def middles_of(request: OpportunityRequest, edges: WindowEdges) -> list[GroundTarget]:
    """Of the lines of windows of scans."""
    return [middle_of(scanned_path(request, edges, window)) for window in range(len(edges))]


def _closed_by(
    narrower: Sequence[tuple[str, Lookout]],
    held_at: Callable[[Lookout, Array], HeldScans],
    begin_s: float,
) -> str:
    """The first of the platform's conditions, one beside the other, that a scan doesn't keep."""
    at_s = np.array([begin_s])
    kept = (cause for cause, lookout in narrower if not held_at(lookout, at_s).as_window[0])
    return next(kept, narrower[-1][0])


def _held_at(
    scan: ModeScan, roll: RollRule | None, carrier: Carrier, lookout: Lookout, begins_s: Array
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
