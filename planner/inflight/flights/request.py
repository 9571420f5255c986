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
