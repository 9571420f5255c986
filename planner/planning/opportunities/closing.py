"""Reasons for which a target can't be looked at, as answers tell them."""

from typing import Annotated, Literal

from planner.base.answer_members import Internal, Member, answer
from planner.planning.opportunities.windows import Cause
from planner.world.frames.time_scales import Utc

Height = Annotated[float, Member("deg", -90.0, 180.0, decimals=3)]
# What keeps a target from being looked at.
Closing = Cause | Literal["exclusion", "scan", "due", "duration", "rest", "motion", "work"]


@answer
class Unseen:
    """A target that can't be looked at, or not for as long as it must, and why.

    target: id of the target, as the request gives it. E.g. `"Reykjavik"`.
    closed_by: the condition that leaves nothing of its windows; `ground_sample`: a pixel is longer
    on the ground than it may be, `carrier_light`: the carrier is never in the light asked for,
    `reach`: no angles within the stops, `exclusion`: a direction is too near to what it keeps
    away from or too far from what it stays near, `rate`: it would turn too fast, `scan`: no
    line of an imaging mode is held to its end, `due`: no window is left from its release to its
    due, `duration`: no window lasts long enough, `rest`: none does beside the time to and from
    rest, `motion`: the axes can't follow, `work`: to find out takes more work than one request may
    make.
    because: the condition that fails instead. E.g. `"the carrier stays below 30 deg in its sky"`.
    best_elevation_rad: the carrier's highest in the target's sky at any time, whatever the
    conditions; above the limb for a target in space. E.g. `12.3`.
    best_time_utc: time of it; UTC. E.g. `"2015-02-27T17:36:08.000Z"`.
    """

    row: Internal[int]  # of the request's targets
    target: str
    closed_by: Closing
    because: str
    best_elevation_rad: Height
    best_time_utc: Utc
