"""The motion of the axes while each target can be looked at, on a common grid of time."""

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from planner.base.arrays import Array, Indices
from planner.motion.pointing.angles import axis_angles, axis_motion, singular_margin_rad
from planner.planning.campaigns.passes import Looks
from planner.planning.campaigns.view import Viewing
from planner.planning.opportunities.carrier import Carrier
from planner.planning.opportunities.sights import Sight, in_sights
from planner.world.platforms import AxisLimits, TwoAxisPlatform
from planner.world.targets import Target


@dataclass(frozen=True, kw_only=True)
class BranchFollowingOptions:
    """How closely a track's limits are looked at before it is planned."""

    delta_s: float = 1.0  # rates and accelerations are differences over it
    within: float = 0.98  # of each limit: what lies between the steps keeps it too
    singular_rad: float = 1e-3  # nearer to the outer axis, angles turn too fast to be followed
    batch: int = 100_000  # samples treated at a time: some 100 MB


OPTIONS = BranchFollowingOptions()

TURN_RAD = 2.0 * math.pi


@dataclass(frozen=True, kw_only=True, eq=False)
class Ways:
    """Every way to follow every target, ordered by pass; arrays of shape (w,).

    A way is an unbroken run of steps on one branch of `axis_angles` within all limits.
    first_step, steps: the run on the grid, at step_s k after the grid's start.
    offset: of its first row in axis_states (n, 3, 2): angle, rate, acceleration of both axes,
    and in quality (n,), of the view.
    """

    step_s: float
    target: Indices
    pass_number: Indices
    first_step: Indices
    steps: Indices
    offset: Indices
    axis_states: Array
    quality: Array


_Run = tuple[Indices, Indices, Indices, Array, Array]
"""Ways found in one batch: row of `looks`, first_step and steps of each, and of all steps the
axis_states and the quality."""


def ways_to_follow(
    looks: Looks,
    targets: Sequence[Target],
    least_s: Array,
    carrier: Carrier,
    viewing: Viewing,
    step_s: float,
    grid_s: float,
) -> Ways:
    """looks: as found.  least_s: (targets,), shorter ways are of no use.

    grid_s: where step 0 lies on the carrier's clock, which `looks` counts on.
    """
    first = np.ceil((looks.from_s - grid_s) / step_s - 1e-9).astype(np.intp)
    last = np.floor((looks.to_s - grid_s) / step_s + 1e-9).astype(np.intp)
    least = np.ceil(least_s / step_s - 1e-9).astype(np.intp)
    found = [
        run
        for rows, sight, which in _sight_batches(looks, targets, carrier, last - first + 1)
        for run in _usable_runs(rows, first, last, sight, which, viewing, step_s, grid_s)
    ]
    return _gather_runs(found, looks, least, step_s)


def _sight_batches(
    looks: Looks, targets: Sequence[Target], carrier: Carrier, steps: Indices
) -> Iterator[tuple[Indices, Sight, Indices]]:
    """Rows of `looks` (observations) seen alike, how, and the number of each one's target in it."""
    for rows, sight, which in in_sights(looks.target, targets, carrier):
        batch = np.cumsum(steps[rows]) // OPTIONS.batch
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
    platform = viewing.platform
    counts = np.maximum(last[rows] - first[rows] + 1, 0)
    look = np.repeat(rows, counts)
    if not len(look):
        return
    begins = np.cumsum(counts) - counts
    step = np.arange(len(look)) - np.repeat(begins, counts) + np.repeat(first[rows], counts)
    t_s = grid_s + step * step_s
    seen = np.repeat(which, counts)
    quality = viewing.quality(sight, seen, t_s, begins[counts > 0])
    before, los, after = (
        sight.sighting(seen, at_s).los_platform
        for at_s in (t_s - OPTIONS.delta_s, t_s, t_s + OPTIONS.delta_s)
    )
    los_rate_s = (after - before) / (2.0 * OPTIONS.delta_s)
    los_acceleration_s2 = (after - 2.0 * los + before) / OPTIONS.delta_s**2
    for angle_rad in axis_angles(platform, los).angle_rad:
        motion = axis_motion(platform, angle_rad, los, los_rate_s, los_acceleration_s2)
        off_keyhole = singular_margin_rad(platform, angle_rad, los) > OPTIONS.singular_rad
        for turned_rad in _whole_turns(platform, angle_rad):
            axis_states = np.stack([turned_rad, *motion], axis=1)
            usable = off_keyhole & _keep_limits(axis_states, platform.axis_limits)
            yield _split_runs(look, step, axis_states, quality, usable)


def _whole_turns(platform: TwoAxisPlatform, angle_rad: Array) -> Iterator[Array]:
    """The angles (n, 2) whole turns away, as far as the stops can let them be."""
    choices = [
        range(
            math.floor((limits.angle_min_rad + math.pi) / TURN_RAD),
            math.ceil((limits.angle_max_rad - math.pi) / TURN_RAD) + 1,
        )
        for limits in platform.axis_limits
    ]
    for turns in itertools.product(*choices):
        yield angle_rad + TURN_RAD * np.array(turns)


def _keep_limits(axis_states: Array, limits: tuple[AxisLimits, ...]) -> NDArray[np.bool_]:
    """Which states (n, 3, 2) keep every limit; NaN keeps none."""
    margin_rad = np.array([(1.0 - OPTIONS.within) * axis.rate_max_rad_s for axis in limits])
    low = np.array([axis.angle_min_rad for axis in limits]) + margin_rad
    high = np.array([axis.angle_max_rad for axis in limits]) - margin_rad
    rate = OPTIONS.within * np.array([axis.rate_max_rad_s for axis in limits])
    acceleration = OPTIONS.within * np.array([axis.acceleration_max_rad_s2 for axis in limits])
    angle_rad, rate_rad_s, acceleration_rad_s2 = (
        axis_states[:, 0],
        axis_states[:, 1],
        axis_states[:, 2],
    )
    kept = (angle_rad >= low) & (angle_rad <= high) & (np.abs(rate_rad_s) <= rate)
    return np.asarray((kept & (np.abs(acceleration_rad_s2) <= acceleration)).all(axis=1))


def _split_runs(
    look: Indices, step: Indices, axis_states: Array, quality: Array, usable: NDArray[np.bool_]
) -> _Run:
    """Runs of usable samples: of one observation, step after step, without a turn over."""
    here = np.flatnonzero(usable)
    look, step, axis_states = look[here], step[here], axis_states[here]
    goes_on = (look[1:] == look[:-1]) & (step[1:] == step[:-1] + 1)
    goes_on &= (np.abs(np.diff(axis_states[:, 0], axis=0)) < math.pi).all(axis=1)
    begins = np.flatnonzero(np.append(True, ~goes_on)[: len(look)])
    steps = np.diff(np.append(begins, len(look)))
    return look[begins], step[begins], steps, axis_states, quality[here]


def _gather_runs(runs: Sequence[_Run], looks: Looks, least_steps: Indices, step_s: float) -> Ways:
    """The runs longer than the least of their targets, (targets,), by pass and time."""
    none = np.empty(0, np.intp)
    columns = zip((none, none, none, np.empty((0, 3, 2)), np.empty(0)), *runs, strict=True)
    look, first_step, steps, axis_states, quality = map(np.concatenate, columns)
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
        axis_states=axis_states[rows],
        quality=quality[rows],
    )
