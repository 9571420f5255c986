"""The answer about a campaign: the choice of looks, and the state of its passes' plans."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from app.answers.job import JobResponse, job_out, page
from app.answers.members import BUILT_ON_FIRST_USE, fill, from_store, to_json
from app.answers.problem import Problem
from app.answers.ranges import (
    Count,
    ElevationDeg,
    ElevationOrLimbDeg,
    HalfTurnDeg,
    NotNegative,
    Share,
)
from app.store.ids import JobState
from planner.base.assumed import Assumed
from planner.planning.campaigns import Closing

if TYPE_CHECKING:  # children answer without a database
    from app.store.jobs import Job


@dataclass(frozen=True, kw_only=True)
class UnseenTarget:
    """A target that can't be looked at for as long as it must, and why.

    target: id of the target, as the request gives it. E.g. `"Reykjavik"`.
    closed_by: the condition that leaves nothing of its windows; `reach`: no angles within the
    stops, `duration`: no window lasts long enough, `rest`: none does beside the time to and from
    rest, `motion`: the axes can't follow.
    because: the condition that fails instead. E.g. `"the carrier stays below 30 deg in its sky"`.
    best_elevation_deg: the carrier's highest in the target's sky at any time, whatever the
    conditions; above the limb for a target in space. E.g. `12.3`.
    best_time: time of it; UTC. E.g. `"2015-02-27T17:36:08.000Z"`.
    """

    target: str
    closed_by: Closing
    because: str
    best_elevation_deg: ElevationOrLimbDeg
    best_time: str


@dataclass(frozen=True, kw_only=True)
class TargetLeftOut:
    """A target that could be looked at, and what stood in its way.

    target: id of the target, as the request gives it.
    because: the worth of its look, and of what it would displace. E.g.
    `"a look from 2015-02-27T17:36:08.0Z would be worth 0.31, and what it displaces is worth 1.9"`.
    start: of the look it came nearest to; UTC.
    stop: of that look; UTC.
    value: of that look.
    displaced_by: ids of the targets whose looks can't be flown beside it. E.g. `["Los Angeles"]`.
    displaced_value: their worth together.
    """

    target: str
    because: str
    start: str
    stop: str
    value: NotNegative
    displaced_by: list[str]
    displaced_value: NotNegative


@dataclass(frozen=True, kw_only=True)
class CampaignChoiceOut:
    """The worth of the looks chosen together, and the most that it could be.

    value: of the looks chosen.
    bound: no choice is worth more whose looks begin on the grid of `step_s`, have one of the
    lengths tried (least, wanted, half-way) and lie in the same passes.
    gap_share: the difference between bound and `value`, as a share of the bound.
    greedy_value: worth of the choice that takes whatever is worth most in each pass, one pass after
    another.
    windows: number of windows to choose from.
    looks: number of looks chosen.
    passes: number of passes that hold looks.
    unseen: targets that can't be looked at for as long as they must, and why.
    left_out: targets that can, but others are worth more.
    assumed: places of the targets that the request gives by name only.
    warnings: cautions to read before relying on it. E.g.
    `["the elements' epoch 2015-02-27T11:40:53Z is 9.0 days from the plan"]`.
    """

    value: NotNegative
    bound: NotNegative
    gap_share: Share
    greedy_value: NotNegative
    windows: Count
    looks: Count
    passes: Count
    unseen: list[UnseenTarget]
    left_out: list[TargetLeftOut]
    assumed: list[Assumed]
    warnings: list[str]


@dataclass(frozen=True, kw_only=True)
class CampaignLookOut:
    """A look at a target as it was chosen; its plan states what a slew took from it.

    target: id of the target, as the request gives it.
    start: from when; UTC.
    stop: until when; UTC.
    value: worth of the look.
    quality: of the view, a mean over the look, which `value` holds.
    elevation_deg: of the carrier in the target's sky at the middle of the look; above the limb for
    a target in space.
    off_nadir_deg: at the middle of the look; null for a target in space.
    ground_sample_m: the longer side of a pixel on the ground then; null for a target in space.
    sun_elevation_deg: in the target's sky then; null for a target in space.
    probability_in_frame: that the target is in the frame at that instant; over all of a look it is
    less, see its plan.
    """

    target: str
    start: str
    stop: str
    value: NotNegative
    quality: Share
    elevation_deg: ElevationOrLimbDeg
    off_nadir_deg: HalfTurnDeg | None
    ground_sample_m: NotNegative | None
    sun_elevation_deg: ElevationDeg | None
    probability_in_frame: Share


@dataclass(frozen=True, kw_only=True)
class LookLeftOut:
    """A look that planning refused, and why.

    target: id of the target, as the request gives it. E.g. `"Denver"`.
    because: the refusal's reason. E.g. `"alpha needs 2.500 s to slew but only 1.000 s remain"`.
    """

    target: str
    because: str


@dataclass(frozen=True, kw_only=True)
class CampaignPassOut:
    """Looks planned together: from rest at `start` to rest at `stop`.

    number: from 0, in order of time.
    plan: id of its plan, GET /v1/plans/{id}.
    state: state of the work on that plan.
    start: row 0 of its table; UTC.
    stop: last row of its table; UTC.
    looks: those chosen for this pass.
    left_out: looks that could not be flown; a plan without them took the place of the one that was
    refused.
    problem: the reason why there is no plan; null when there is one or may be.
    """

    number: Count
    plan: str
    state: JobState
    start: str
    stop: str
    looks: list[CampaignLookOut]
    left_out: list[LookLeftOut]
    problem: Problem | None


@dataclass(frozen=True, kw_only=True)
class PlannedOut:
    """Progress of the passes' plans.

    done: passes with a verified plan.
    open: passes that wait or are being planned.
    refused: passes that can't be flown.
    failed: passes whose planning broke down.
    cancelled: passes that were given up on request.
    looks: in plans that are made.
    value: of the looks in plans that are made.
    """

    done: Count
    open: Count
    refused: Count
    failed: Count
    cancelled: Count
    looks: Count
    value: NotNegative


@dataclass(frozen=True, kw_only=True)
class CampaignResponse(JobResponse):
    """A campaign as it stands.

    choice: the looks chosen; null until they are.
    planned: progress of the passes' plans.
    passes: those with looks, in order of time.
    """

    choice: CampaignChoiceOut | None
    planned: PlannedOut
    passes: list[CampaignPassOut]


@dataclass(frozen=True, kw_only=True)
class CampaignList:
    """Campaigns, the latest first.

    campaigns: those of this page.
    next: `cursor` of what comes after, null at the end. E.g.
    `"01a203fd-cbae-73f8-8276-319f76b8842c"`.
    """

    __pydantic_config__ = BUILT_ON_FIRST_USE

    campaigns: list[JobResponse]
    next: str | None


@dataclass(frozen=True, kw_only=True)
class CampaignDryRun:
    """The request is well formed; whether anything can be seen was not looked at.

    valid: always true; what isn't is refused.
    name: the request's.
    targets: number of targets.
    """

    valid: bool
    name: str
    targets: Count


def campaign_json(job: "Job", choice: Mapping[str, Any] | None, parts: "Sequence[Job]") -> bytes:
    """A CampaignResponse as UTF-8 JSON; parts: all plans of its passes, the oldest first."""
    latest = {part.options["campaign"]["pass"]: part for part in parts}
    passes = [_pass_out(latest[number]) for number in sorted(latest)]
    return to_json(
        fill(
            CampaignResponse,
            job_out(job),
            choice=None if choice is None else from_store(CampaignChoiceOut, choice),
            planned=_planned_out(passes),
            passes=passes,
        )
    )


def _pass_out(part: "Job") -> CampaignPassOut:
    facts = part.options["campaign"]
    return CampaignPassOut(
        number=facts["pass"],
        plan=part.id,
        state=part.state,
        start=facts["start"],
        stop=facts["stop"],
        looks=[from_store(CampaignLookOut, look) for look in facts["looks"]],
        left_out=[from_store(LookLeftOut, look) for look in facts["left_out"]],
        problem=job_out(part).problem,
    )


def _planned_out(passes: Sequence[CampaignPassOut]) -> PlannedOut:
    states = [one.state for one in passes]
    looks = [look for one in passes if one.state == "done" for look in one.looks]
    return PlannedOut(
        done=states.count("done"),
        open=states.count("queued") + states.count("running"),
        refused=states.count("refused"),
        failed=states.count("failed"),
        cancelled=states.count("cancelled"),
        looks=len(looks),
        value=sum(look.value for look in looks),
    )


def campaign_list_json(jobs: "Sequence[Job]", limit: int) -> bytes:
    """A CampaignList."""
    campaigns, after = page(jobs, limit)
    return to_json(CampaignList(campaigns=campaigns, next=after))
