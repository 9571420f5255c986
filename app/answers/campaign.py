"""The answer about a campaign: what was chosen, and how far it is planned."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from app.answers.job import JobResponse, job_out, page
from app.answers.members import fill, from_store, to_json
from app.answers.problem import Problem
from app.answers.ranges import Count, NotNegative, Share
from app.store.ids import JobState

if TYPE_CHECKING:  # children answer without a database
    from app.store.jobs import Job


@dataclass(frozen=True, kw_only=True)
class CampaignChoiceOut:
    """What the looks chosen are worth together, and what they could be at most.

    value: of the looks chosen.
    bound: no choice is worth more whose looks begin on the grid of `step_s`, have one of the
    lengths tried (least, wanted, half-way) and lie in the same passes.
    gap_share: how much more than `value` that is at most, as a share of the bound.
    greedy_value: what taking pass after pass whatever is worth most there is worth.
    windows: how many there were to choose from.
    looks: how many are chosen.
    passes: how many there are looks in.
    unseen: ids of targets that can't be looked at for as long as they must. E.g. `["Reykjavik"]`.
    left_out: ids of targets that can, but others are worth more. E.g. `["Denver"]`.
    warnings: what one should know before relying on it. E.g.
    `["the elements' epoch 2015-02-27T11:40:53Z is 9.0 days from the plan"]`.
    """

    value: NotNegative
    bound: NotNegative
    gap_share: Share
    greedy_value: NotNegative
    windows: Count
    looks: Count
    passes: Count
    unseen: list[str]
    left_out: list[str]
    warnings: list[str]


@dataclass(frozen=True, kw_only=True)
class CampaignLookOut:
    """A look at a target as it was chosen; its plan tells what a slew took from it.

    target: id of the target, as the request gives it.
    start: from when; UTC.
    stop: until when; UTC.
    value: what it is worth.
    """

    target: str
    start: str
    stop: str
    value: NotNegative


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
    state: where that plan stands.
    start: row 0 of its table; UTC.
    stop: last row of its table; UTC.
    looks: those chosen for this pass.
    left_out: looks that could not be flown; a plan without them took the place of the one that was
    refused.
    problem: why there is no plan; null when there is one or may be.
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
    """How far the passes are planned.

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

    choice: what was chosen; null until it is.
    planned: how far the passes are planned.
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

    campaigns: list[JobResponse]
    next: str | None


@dataclass(frozen=True, kw_only=True)
class CampaignDryRun:
    """The request is sound; nothing was chosen.

    valid: always true; what isn't is refused.
    name: the request's.
    targets: how many there are.
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
