"""Motions of a platform while each target can be looked at, on a common grid of time."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Array, Indices
from planner.planning.campaigns.passes import Looks
from planner.planning.campaigns.platforms.follower import Following
from planner.planning.campaigns.view import Viewing
from planner.planning.opportunities.carrier import Carrier
from planner.planning.opportunities.sights import Sight, Wanted, in_sights

BATCH = 100_000  # samples treated at a time: some 100 MB


@dataclass(frozen=True, kw_only=True, eq=False)
class Ways:
    """Every way to follow every target, ordered by pass; arrays of shape (w,).

    A way is an unbroken run of steps of one `Following` within all limits.
    first_step, steps: the run on the grid, at step_s k after the grid's start.
    offset: of its first row in states (n, s), as of `slew_fits`, and in quality (n,), of the view.
    """

    step_s: float
    target: Indices
    pass_number: Indices
    first_step: Indices
    steps: Indices
    offset: Indices
    states: Array
    quality: Array


_Run = tuple[Indices, Indices, Indices, Array, Array]
"""Ways found in one batch: row of `looks`, first_step and steps of each, and of all steps the
states and the quality."""


def ways_to_follow(
    looks: Looks,
    targets: Sequence[Wanted],
    least_steps: Indices,
    carrier: Carrier,
    viewing: Viewing,
    step_s: float,
    grid_s: float,
) -> Ways:
    """looks: as found.  least_steps: (targets,), shorter ways are of no use.

    grid_s: where step 0 lies on the carrier's clock, which `looks` counts on.
    """
    first = np.ceil((looks.from_s - grid_s) / step_s - 1e-9).astype(np.intp)
    last = np.floor((looks.to_s - grid_s) / step_s + 1e-9).astype(np.intp)
    found = [
        run
        for rows, sight, which in _sight_batches(looks, targets, carrier, last - first + 1)
        for run in _usable_runs(rows, first, last, sight, which, viewing, step_s, grid_s)
    ]
    return _gather_runs(found, looks, least_steps, step_s)


def _sight_batches(
    looks: Looks, targets: Sequence[Wanted], carrier: Carrier, steps: Indices
) -> Iterator[tuple[Indices, Sight, Indices]]:
    """Rows of `looks` (observations) seen alike, how, and the number of each one's target in it."""
    for rows, sight, which in in_sights(looks.target, targets, carrier):
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


def _split_runs(look: Indices, step: Indices, way: Following, quality: Array) -> _Run:
    """Runs of usable samples: of one observation, step after step, each following from the last."""
    here = np.flatnonzero(way.usable)
    goes_on = (look[here[1:]] == look[here[:-1]]) & (step[here[1:]] == step[here[:-1]] + 1)
    goes_on &= way.goes_on[here[:-1]]
    begins = np.flatnonzero(np.append(True, ~goes_on)[: len(here)])
    steps = np.diff(np.append(begins, len(here)))
    first = here[begins]
    return look[first], step[first], steps, way.states[here], quality[here]


def _gather_runs(runs: Sequence[_Run], looks: Looks, least_steps: Indices, step_s: float) -> Ways:
    """The runs longer than the least of their targets, (targets,), by pass and time."""
    none = np.empty(0, np.intp)
    width = runs[0][3].shape[1] if runs else 0
    columns = zip((none, none, none, np.empty((0, width)), np.empty(0)), *runs, strict=True)
    look, first_step, steps, states, quality = map(np.concatenate, columns)
    begins = np.cumsum(steps) - steps
    order = np.flatnonzero(steps > least_steps[looks.target[look]])
    order = order[np.lexsort((first_step[order], looks.pass_number[look[order]]))]
    look, steps = look[order], steps[order]
    offset = np.cumsum(steps) - steps
    rows = np.repeat(begins[order] - offset, steps) + np.arange(steps.sum())
    return Ways(
        step_s=step_s,
        target=looks.target[look],
        pass_number=looks.pass_number[look],
        first_step=first_step[order],
        steps=steps,
        offset=offset,
        states=states[rows],
        quality=quality[rows],
    )
