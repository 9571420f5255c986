"""Looks that were chosen, and targets that got none, as answers tell them."""

from typing import Annotated, Literal

from planner.base.answer_members import Count, Internal, Member, NotNegative, Share, answer
from planner.planning.opportunities.closing import Height, Unseen
from planner.world.frames.time_scales import Utc
from planner.world.targets import GroundPathTarget

KeptResource = Literal["battery", "memory", "momentum", "duty_cycle"]


@answer
class ChosenLook:
    """A look at a target as it was chosen; its plan states what a slew took from it.

    target: id of the target, as the request gives it.
    part: of an imaging mode, number of the scan from 1; `of` of the plan's session says the target.
    E.g. `2`.
    parts: number of scans that the mode is done by in this pass. E.g. `3`.
    start_utc: from when; UTC.
    stop_utc: until when; UTC.
    value: worth of the look.
    quality: of the view, a mean over the look, which `value` holds.
    elevation_rad: of the carrier in the target's sky at the middle of the look; above the limb for
    a target in space.
    off_nadir_rad: at the middle of the look; null for a target in space.
    ground_sample_m: the longer side of a pixel on the ground then; null for a target in space.
    sun_elevation_rad: in the target's sky then; null for a target in space.
    probability_in_frame: that the target is in the frame at that instant; over all of a look it is
    less, see its plan.
    clear_probability: that no cloud stands over the target at that instant, by `clouds`, which
    `value` and `quality` hold; null where these say nothing. E.g. `0.8`.
    """

    row: Internal[int]  # of the request's targets
    path: Internal[GroundPathTarget | None]  # that is scanned
    target: str
    part: Count | None
    parts: Count | None
    start_utc: Utc
    stop_utc: Utc
    value: NotNegative
    quality: Share
    elevation_rad: Height
    off_nadir_rad: Annotated[float, Member("deg", 0.0, 180.0, decimals=3)] | None
    ground_sample_m: NotNegative | None
    sun_elevation_rad: Annotated[float, Member("deg", -90.0, 90.0, decimals=3)] | None
    probability_in_frame: Share
    clear_probability: Share | None


@answer
class UnchosenTarget:
    """A target that could be looked at, and what stood in its way.

    target: id of the target, as the request gives it. E.g. `"Phoenix"`.
    because: the worth of its look, and of what it would displace. E.g.
    `"a look from 2015-02-27T17:36:08.0Z would be worth 0.31, and what it displaces is worth 1.9"`.
    start_utc: of the look it came nearest to; UTC. E.g. `"2015-02-27T17:36:08.000Z"`.
    stop_utc: of that look; UTC. E.g. `"2015-02-27T17:36:48.000Z"`.
    value: of that look. E.g. `0.31`.
    displaced_by: ids of the targets whose looks can't be flown beside it. E.g. `["Los Angeles"]`.
    displaced_value: their worth together. E.g. `1.9`.
    lacks: the resource, or the imaging of the duty cycle, that the look would take too much of, in
    the place of what it displaces.
    """

    row: Internal[int]  # of the request's targets
    target: str
    because: str
    start_utc: Utc
    stop_utc: Utc
    value: NotNegative
    displaced_by: tuple[str, ...]  # none where only the looks after it would have to move
    displaced_value: NotNegative
    lacks: KeptResource | None = None


@answer
class UnchosenByAll(UnchosenTarget):
    """A target that some carrier could look at, and what stood in its way.

    carrier: id of the carrier whose look would have displaced least. E.g. `"north"`.
    """

    carrier: str


@answer
class UnseenByAll(Unseen):
    """A target that no carrier can look at for as long as it must, by the one that comes nearest.

    carrier: id of that one: it has the target in view, or else stands highest in its sky. E.g.
    `"north"`.
    """

    carrier: str
