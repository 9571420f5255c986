"""A plan flown many times, from its table to probabilities: the whole story in one process."""

from collections.abc import Callable

from planner.inflight.flights.runs import fly_runs
from planner.inflight.flights.scene import session_scenes
from planner.inflight.flights.summary import FlownPlan, summarise
from planner.world.plan import FlightPlan


def fly_plan(
    plan: FlightPlan, runs: int, seed: int = 0, on_run: Callable[[int], None] = lambda _: None
) -> FlownPlan:
    """Of the sessions that look at a target.

    on_run: told how many runs are flown.  Raises InvalidInput where no session does.
    """
    return summarise(fly_runs(session_scenes(plan), seed, 0, runs, on_run))
