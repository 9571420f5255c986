"""Margins of exclusions and star trackers, on the rows and between them."""

import math
from collections.abc import Callable, Iterator
from datetime import datetime

import numpy as np

from planner.base.arrays import Array, Indices, Mask
from planner.base.commands import COMMAND_STEP_S, ROWS_PER_S
from planner.verification.platforms.body.options import OPTIONS
from planner.verification.platforms.judge import FlownInstants, Judge
from planner.verification.report import ExclusionMargin
from planner.verification.surroundings import Surroundings
from planner.world.frames.time_scales import Instants, shifted_utc
from planner.world.orbits import Ephemeris, OrbitStates
from planner.world.platforms.body import BodyPlatform, Exclusion

Margin = Callable[[FlownInstants, OrbitStates, Surroundings], Array]


def exclusion_margins(
    judge: Judge, platform: BodyPlatform, ephemeris: Ephemeris, imaging: Mask, epoch_utc: datetime
) -> tuple[ExclusionMargin, ...]:
    """The least of each.  imaging: of the cells, (n - 1,)."""
    reach_rad = judge.turn_most_rad()[:-1] + OPTIONS.orbit_rate_rad_s * COMMAND_STEP_S
    return tuple(
        _least(name, margin, np.flatnonzero(imaging | always), reach_rad, ephemeris, epoch_utc)
        for name, always, margin in _rules(judge, platform)
    )


def _rules(judge: Judge, platform: BodyPlatform) -> Iterator[tuple[str, bool, Margin]]:
    """Name, whether it counts while nothing is imaged, and its margin at n instants."""
    for exclusion in platform.exclusions:
        direction_body = np.asarray(exclusion.direction_body or platform.camera.boresight_body)

        def margin(
            at: FlownInstants,
            states: OrbitStates,
            around: Surroundings,
            exclusion: Exclusion = exclusion,
            direction_body: Array = direction_body,
        ) -> Array:
            return around.margin_rad(exclusion, judge.direction_eci(direction_body, at, states))

        yield exclusion.name, exclusion.when == "always", margin
    trackers = platform.star_trackers
    if trackers is not None and trackers.needed:

        def of_last_needed(at: FlownInstants, states: OrbitStates, around: Surroundings) -> Array:
            each = []
            for tracker in trackers.each:
                direction_eci = judge.direction_eci(np.asarray(tracker.boresight_body), at, states)
                each.append(
                    np.min(
                        [
                            around.away_rad(direction_eci, celestial) - math.radians(least_deg)
                            for celestial, least_deg in tracker.least_deg
                        ],
                        axis=0,
                    )
                )
            return np.asarray(np.sort(each, axis=0)[-trackers.needed])

        yield "star_trackers", False, of_last_needed


def _least(
    name: str,
    margin: Margin,
    cells: Indices,
    reach_rad: Array,
    ephemeris: Ephemeris,
    epoch_utc: datetime,
) -> ExclusionMargin:
    """Among the ends of these cells, and every 10 ms inside those from which zero is in reach.

    Cells are passed by that can't come nearer than others, nor to zero, since the one before.
    """

    def margins_rad(cell: Indices, u_s: Array) -> Array:
        parts = []
        for part in np.array_split(np.arange(len(cell)), len(cell) // OPTIONS.rows_at_once + 1):
            instants = Instants(epoch_utc, cell[part] / ROWS_PER_S + u_s[part])
            states = ephemeris.states(instants)
            at = FlownInstants(cell[part], u_s[part], instants)
            parts.append(margin(at, states, Surroundings(instants, states)))
        return np.concatenate(parts)

    cells = _near_cells(cells, lambda some: margins_rad(some, np.zeros(len(some))), reach_rad)
    cell = np.append(cells, cells[-1:])
    u_s = np.append(np.zeros(len(cells)), np.full(len(cells[-1:]), COMMAND_STEP_S))
    least_rad, t_s = math.inf, None
    if cells.size:
        every_rad = margins_rad(cell, u_s)
        near = cells[every_rad[:-1] < reach_rad[cells]]
        if near.size:
            finer = np.repeat(near, OPTIONS.finer)
            finer_s = np.tile(
                np.arange(OPTIONS.finer) * (COMMAND_STEP_S / OPTIONS.finer), len(near)
            )
            every_rad = np.append(every_rad, margins_rad(finer, finer_s))
            cell, u_s = np.append(cell, finer), np.append(u_s, finer_s)
        worst = int(np.argmin(every_rad))
        least_rad = float(every_rad[worst])
        t_s = float(cell[worst] / ROWS_PER_S + u_s[worst])
    is_there = math.isfinite(least_rad)
    return ExclusionMargin(
        name=name,
        margin_rad=least_rad if is_there else None,
        t_s=t_s if is_there else None,
        at_utc=shifted_utc(epoch_utc, t_s) if is_there and t_s is not None else None,
    )


def _near_cells(
    cells: Indices, margins_rad: Callable[[Indices], Array], reach_rad: Array
) -> Indices:
    """Of these cells those in which the least margin, or one near zero, may be; the last always.

    Every `stride`th is looked at: what lies between is passed by where the way there is too far,
    or where at both ends there is nothing to keep away from.
    """
    stride = OPTIONS.stride
    if len(cells) <= stride:
        return cells
    first = np.arange(0, len(cells), stride)
    last = np.minimum(first + stride, len(cells) - 1)
    ends_rad = margins_rad(cells[np.append(first, last[-1])])
    before_rad, after_rad = ends_rad[:-1], ends_rad[1:]
    way_rad = np.append(0.0, np.cumsum(reach_rad))[[cells[last], cells[first]]]
    least_rad = max(float(ends_rad.min()), float(reach_rad.max()))
    is_far = before_rad - (way_rad[0] - way_rad[1]) > least_rad
    is_far &= np.isfinite(before_rad) == np.isfinite(after_rad)
    is_far &= cells[last] - cells[first] == last - first
    is_looked_at = np.repeat(~is_far, stride)[: len(cells)]
    is_looked_at[-1] = True
    return np.asarray(cells[is_looked_at])
