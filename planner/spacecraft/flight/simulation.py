"""The session's table flown closed loop, as a body's plan with gyros is."""

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

from planner.base.commands import CommandTable
from planner.inflight.simulation.gyros.closed_loop import Log
from planner.inflight.simulation.gyros.dispersed import draw_dispersion, fly_table
from planner.spacecraft.table import ImagingWindow, camera_on
from planner.spacecraft.vehicle import AgileSpacecraft
from planner.world.orbits.ephemeris import OrbitStates

Kept = TypeVar("Kept")


def fly_many(
    spacecraft: AgileSpacecraft,
    table: CommandTable,
    windows: tuple[ImagingWindow, ...],
    states: OrbitStates,
    seeds: Sequence[int],
    keep: Callable[[Log], Kept],
    tell: Callable[[int], None] = lambda _: None,
) -> list[Kept]:
    """Dispersed runs, one a seed, on as many threads as there are cores.

    keep: what is wanted of a run; its log (19 MB for an hour) is given up at once.
    tell: is called with how many are flown.
    """
    craft, imaging = spacecraft.craft, camera_on(windows, len(table.position))
    kept: list[Kept] = []
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        for one in pool.map(
            lambda seed: keep(
                fly_table(craft, table, imaging, states, draw_dispersion(craft, seed))
            ),
            seeds,
        ):
            kept.append(one)
            tell(len(kept))
    return kept
