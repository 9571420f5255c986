"""Dense imaging sessions against better choices of the same planner: point 10 of bench/truth.py.

14 strips in 260 s.  With slew times estimated shorter (`SHORTER`), choices worth more are found in
some, and their plans pass the judge: nothing told of a choice may say that there are none.
"""

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
from imaging_cases import line, session_request, sun_synchronous
from truth_rows import Row

from planner.spacecraft.plan import ImagingPlan, plan_imaging
from planner.spacecraft.requests import GeoLineString, ImagingPlanRequest, StripRequest
from planner.spacecraft.slews import slew_time

SESSIONS, STRIPS, SECONDS = 5, 14, 260.0
SHORTER = slew_time.SlewTimeOptions(smooth=1.0, allowance_s=0.0)


def rows() -> Iterator[Row]:
    pairs = [_both(seed) for seed in range(SESSIONS)]
    told = [vars(plan.choice).keys() & {"bound", "proven_optimal"} for plan, _ in pairs]
    seen = ", ".join(
        f"{better.choice.value:.2f} over {plan.choice.value:.2f}" for plan, better in pairs
    )
    yield Row(10, "dense imaging sessions: choices worth more over told", "no bound that is passed",
              seen, not any(told))  # fmt: skip


def _both(seed: int) -> tuple[ImagingPlan, ImagingPlan]:
    request = _dense_session(seed)
    plan = plan_imaging(request)
    with _shorter_slew_times():
        return plan, plan_imaging(request)


def _dense_session(seed: int) -> ImagingPlanRequest:
    random = np.random.default_rng(seed)
    orbit = sun_synchronous(640.0)

    def strip(number: int) -> StripRequest:
        where = line(orbit, random.uniform(60.0, 200.0), 15.0, random.uniform(-200.0, 200.0))
        return StripRequest(
            name=f"strip {number}",
            priority=float(random.uniform(1.0, 5.0)),
            geometry=GeoLineString(coordinates=where),
        )

    strips = tuple(strip(number) for number in range(STRIPS))
    return session_request(orbit, SECONDS, strips, simulation_runs=0)


@contextmanager
def _shorter_slew_times() -> Iterator[None]:
    usual, slew_time.OPTIONS = slew_time.OPTIONS, SHORTER
    try:
        yield
    finally:
        slew_time.OPTIONS = usual


if __name__ == "__main__":
    for row in rows():
        print(row)
