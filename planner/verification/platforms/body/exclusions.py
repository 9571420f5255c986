"""Margins of exclusions and star trackers, on the rows and between them."""

import math
from collections.abc import Callable, Iterator
from datetime import datetime

import numpy as np

from planner.base.arrays import Array, Indices, Mask
from planner.base.commands import COMMAND_STEP_S, ROWS_PER_S
from planner.verification.platforms.body.surroundings import Surroundings
from planner.verification.platforms.judge import FlownInstants, Judge
from planner.verification.report import ExclusionMargin
from planner.world.frames.time_scales import Instants, shifted_utc
from planner.world.orbits import Ephemeris, OrbitStates
from planner.world.platforms.body import BodyPlatform, Exclusion

FINER = 20  # instants per cell, 10 ms apart, where a limit is near
# Angles to the Earth's limb and the glint change with the orbit, too: below 0.2 deg/s from 200 km.
ORBIT_RATE_RAD_S = math.radians(0.5)
ROWS_AT_ONCE = 20_000

Margin = Callable[[FlownInstants, OrbitStates, Surroundings], Array]


def exclusion_margins(
    judge: Judge, platform: BodyPlatform, ephemeris: Ephemeris, imaging: Mask, epoch_utc: datetime
) -> tuple[ExclusionMargin, ...]:
    """The least of each.  imaging: of the cells, (n - 1,)."""
    reach_rad = judge.turn_most_rad()[:-1] + ORBIT_RATE_RAD_S * COMMAND_STEP_S
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
            direction_eci = judge.direction_eci(direction_body, at, states)
            away_rad = around.away_rad(direction_eci, exclusion.away_from)
            return np.asarray(away_rad - math.radians(exclusion.min_deg))

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
                            for celestial, least_deg in tracker.angles_deg
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
    """Among the ends of these cells, and every 10 ms inside those from which zero is in reach."""

    def margins_rad(cell: Indices, u_s: Array) -> Array:
        parts = []
        for part in np.array_split(np.arange(len(cell)), len(cell) // ROWS_AT_ONCE + 1):
            instants = Instants(epoch_utc, cell[part] / ROWS_PER_S + u_s[part])
            states = ephemeris.states(instants)
            at = FlownInstants(cell[part], u_s[part], instants)
            parts.append(margin(at, states, Surroundings(instants, states)))
        return np.concatenate(parts)

    cell = np.append(cells, cells[-1:])
    u_s = np.append(np.zeros(len(cells)), np.full(len(cells[-1:]), COMMAND_STEP_S))
    least_rad, t_s = math.inf, None
    if cells.size:
        every_rad = margins_rad(cell, u_s)
        near = cells[every_rad[:-1] < reach_rad[cells]]
        if near.size:
            finer = np.repeat(near, FINER)
            finer_s = np.tile(np.arange(FINER) * (COMMAND_STEP_S / FINER), len(near))
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
