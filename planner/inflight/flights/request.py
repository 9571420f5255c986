"""The request for flights of a plan."""

from typing import Annotated

from planner.base.spec import Within, spec

SEED_MAX = 2**32 - 1


@spec
class MovingObject:
    """Something that moves over the ground at the target, whose shift from frame to frame counts.

    speed_m_s: over the ground.
    course_deg: clockwise from north.
    interval_s: from one frame of a series to the next; the paper's series had 10 s.
    """

    speed_m_s: Annotated[float, Within(0.0, 10e3)]
    course_deg: Annotated[float, Within(-180.0, 360.0)] = 0.0
    interval_s: Annotated[float, Within(0.1, 3600.0)] = 10.0


@spec
class FlightsRequest:
    """A plan's table flown many times, with errors drawn anew for each run.

    name: your name for it, shown in lists. E.g. `"Las Vegas, before uplink"`.
    runs: number of runs; 400 give a probability to 0.05 with 95 % confidence, 1,000 to 0.03.
    seed: of the errors; the same seed draws the same ones, run by run, however many runs there are.
    moving_object: something that moves over the ground at the target, whose shift from frame to
    frame is given.
    """

    name: str = ""
    runs: Annotated[int, Within(2, 20_000)] = 400
    seed: Annotated[int, Within(0, SEED_MAX)] = 0
    moving_object: MovingObject | None = None
