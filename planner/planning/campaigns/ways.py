"""Motions of a platform while each target can be looked at, on a common grid of time."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from planner.base.arrays import Array, Indices, Mask
from planner.planning.campaigns.passes import Looks
from planner.planning.campaigns.platforms.follower import Following
from planner.planning.campaigns.view import Viewing
from planner.planning.opportunities.carrier import Carrier
from planner.planning.opportunities.sights import Sight, Wanted, in_sights, scan_sight
from planner.planning.opportunities.tracking import OPTIONS as TRACKING
from planner.world.platforms import RollRule
from planner.world.targets import GroundPathTarget

BATCH = 100_000  # samples treated at a time: some 100 MB


class ScannedLook(NamedTuple):
    """A line that is scanned, how the platform lies on it, and what it takes on the grid.

    path_at: the line as it is scanned if that begins then, on the carrier's clock.
    """

    path_at: Callable[[float], GroundPathTarget]
    roll: RollRule | None
    settle_steps: int
    scan_steps: int


@dataclass(frozen=True, kw_only=True, eq=False)
class Ways:
    """Every way to follow every target, ordered by pass; arrays of shape (w,).

    A way is an unbroken run of steps of one `Following` within all limits.
    look: row of the `Looks` it was found in.
    spare_s: (w, 2), of ways off the grid, how long before a step a look that ends then has ended,
    and how long after it one that begins then begins; empty where all are on it.
    first_step, steps: the run on the grid, at step_s k after the grid's start.
    offset: of its first row in states (n, s), as of `slew_fits`, and in quality (n,), of the view.
    scanned: whether it is a scan's: its states are then those in which a scan that began earlier
    leaves its line, and begin_states (n, s) those in which one that begins then joins it; NaN where
    none does.  Of all others both are the same.
    """

    step_s: float
    target: Indices
    pass_number: Indices
    first_step: Indices
    steps: Indices
    offset: Indices
    states: Array
    quality: Array
    scanned: Mask
    begin_states: Array
    look: Indices
    spare_s: Array = field(default_factory=lambda: np.empty((0, 2)))


_Run = tuple[Indices, Indices, Indices, Array, Array, Array]
"""Ways found in one batch: row of `looks`, first_step and steps of each, and of all steps the
states, the quality and the states in which a look begins."""


def ways_to_follow(
    looks: Looks,
    wanted: Indices,
    targets: Sequence[Wanted],
    scanned: Mapping[int, ScannedLook],
    least_steps: Indices,
    carrier: Carrier,
    viewing: Viewing,
    step_s: float,
    grid_s: float,
) -> Ways:
    """looks: as found.  wanted: rows of them.  scanned: those that scan, by row of targets.
    least_steps: (targets,), shorter ways are of no use.

    grid_s: where step 0 lies on the carrier's clock, which `looks` counts on.
    """
    first = np.ceil((looks.from_s - grid_s) / step_s - 1e-9).astype(np.intp)
    last = np.floor((looks.to_s - grid_s) / step_s + 1e-9).astype(np.intp)
    is_scan = np.isin(np.arange(len(targets)), list(scanned))
    found: list[_Run] = []
    for rows, sight, which in _sight_batches(looks, wanted, targets, carrier, last - first + 1):
        held = ~is_scan[looks.target[rows]]
        found += _usable_runs(rows[held], first, last, sight, which[held], viewing, step_s, grid_s)
        for row, number in zip(rows[~held].tolist(), which[~held].tolist(), strict=True):
            span = int(first[row]), int(last[row])
            look = scanned[int(looks.target[row])]
            found += _scan_runs(row, span, sight, number, look, viewing, step_s, grid_s)
    return _gather_runs(found, looks, is_scan, least_steps, step_s)


def _sight_batches(
    looks: Looks,
    wanted: Indices,
    targets: Sequence[Wanted],
    carrier: Carrier,
    steps: Indices,
) -> Iterator[tuple[Indices, Sight, Indices]]:
    """Rows of `looks` (observations) seen alike, how, and the number of each one's target in it."""
    for seen, sight, which in in_sights(looks.target[wanted], targets, carrier):
        rows = wanted[seen]
        batch = np.cumsum(steps[rows]) // BATCH
        cuts = np.flatnonzero(np.diff(batch)) + 1
        for part, number in zip(np.split(rows, cuts), np.split(which, cuts), strict=True):
            yield part, sight, number


def _usable_runs(
    rows: Indices,
    first: Indices,
    last: Indices,
    sight: Sight,
    which: Indices,
    viewing: Viewing,
    step_s: float,
    grid_s: float,
) -> Iterator[_Run]:
    counts = np.maximum(last[rows] - first[rows] + 1, 0)
    look = np.repeat(rows, counts)
    if not len(look):
        return
    begins = np.cumsum(counts) - counts
    step = np.arange(len(look)) - np.repeat(begins, counts) + np.repeat(first[rows], counts)
    t_s = grid_s + step * step_s
    seen = np.repeat(which, counts)
    quality = viewing.quality(sight, seen, t_s, begins[counts > 0])
    for way in viewing.follower.ways(sight, seen, t_s):
        yield _split_runs(look, step, way, quality)


def _scan_runs(
    row: int,
    span: tuple[int, int],
    sight: Sight,
    number: int,
    look: ScannedLook,
    viewing: Viewing,
    step_s: float,
    grid_s: float,
) -> Iterator[_Run]:
    """Runs of steps at which a scan may begin; steps before are for settling, steps after for it.

    sight, number: of the middle of its line.
    """
    begin_steps = np.arange(span[0] + look.settle_steps, span[1] - look.scan_steps + 1)
    if not len(begin_steps):
        return
    begins_s = np.asarray(grid_s + begin_steps * step_s, np.float64)
    path = look.path_at(float(begins_s.mean()))
    around_s = (look.settle_steps + look.scan_steps + 2) * step_s - path.duration_s
    seen = scan_sight(sight.carrier, path, look.roll, begins_s, around_s)
    lead_s, tail_s = look.settle_steps * step_s, look.scan_steps * step_s
    after_s = np.linspace(-lead_s, tail_s, math.ceil((lead_s + tail_s) / TRACKING.step_s) + 1)
    which = np.repeat(np.arange(len(begins_s)), len(after_s))
    t_s = (begins_s[:, None] + after_s).ravel()
    more = look.settle_steps + look.scan_steps
    for way in viewing.follower.ways(seen, which, t_s):
        goes_on = np.append(way.goes_on, True).reshape(-1, len(after_s))[:, :-1].all(axis=1)
        usable = np.asarray(way.usable.reshape(-1, len(after_s)).all(axis=1) & goes_on)
        states = way.states.reshape(*usable.shape, len(after_s), -1)
        for run in np.split(np.arange(len(usable)), np.flatnonzero(~usable)):
            at = run[usable[run]]
            if not len(at):
                continue
            none = np.full((more, states.shape[2]), math.nan)
            steps = np.arange(len(at) + more)
            first = begin_steps[at[0]] - look.settle_steps
            quality = viewing.quality(
                sight,
                np.full(len(steps), number),
                grid_s + (first + steps) * step_s,
                np.zeros(1, np.intp),
            )
            yield (
                np.array([row]),
                np.array([first]),
                np.array([len(steps)]),
                np.concatenate([none, states[at, -1]]),
                quality,
                np.concatenate([states[at, 0], none]),
            )


def _split_runs(look: Indices, step: Indices, way: Following, quality: Array) -> _Run:
    """Runs of usable samples: of one observation, step after step, each following from the last."""
    here = np.flatnonzero(way.usable)
    goes_on = (look[here[1:]] == look[here[:-1]]) & (step[here[1:]] == step[here[:-1]] + 1)
    goes_on &= way.goes_on[here[:-1]]
    begins = np.flatnonzero(np.append(True, ~goes_on)[: len(here)])
    steps = np.diff(np.append(begins, len(here)))
    first = here[begins]
    states = way.states[here]
    return look[first], step[first], steps, states, quality[here], states


def _gather_runs(
    runs: Sequence[_Run], looks: Looks, is_scan: Mask, least_steps: Indices, step_s: float
) -> Ways:
    """The runs longer than the least of their targets, (targets,), by pass and time."""
    none = np.empty(0, np.intp)
    width = runs[0][3].shape[1] if runs else 0
    nothing = np.empty((0, width))
    columns = zip((none, none, none, nothing, np.empty(0), nothing), *runs, strict=True)
    look, first_step, steps, states, quality, begin_states = map(np.concatenate, columns)
    begins = np.cumsum(steps) - steps
    order = np.flatnonzero(steps > least_steps[looks.target[look]])
    order = order[np.lexsort((first_step[order], looks.pass_number[look[order]]))]
    look, steps = look[order], steps[order]
    offset = np.cumsum(steps) - steps
    rows = np.repeat(begins[order] - offset, steps) + np.arange(steps.sum())
    kept = states[rows]
    return Ways(
        step_s=step_s,
        target=looks.target[look],
        pass_number=looks.pass_number[look],
        first_step=first_step[order],
        steps=steps,
        offset=offset,
        states=kept,
        quality=quality[rows],
        scanned=is_scan[looks.target[look]],
        begin_states=begin_states[rows] if is_scan.any() else kept,
        look=look,
    )
