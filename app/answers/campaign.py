"""The answer about a campaign: what was chosen, and how far it is planned."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from app.answers.job import JobProblem, JobResponse, job_out, page
from app.answers.members import fill, from_store, to_json
from app.store.ids import JobState

if TYPE_CHECKING:  # children answer without a database
    from app.store.jobs import Job


@dataclass(frozen=True, kw_only=True)
class CampaignChoiceOut:
    """What the looks chosen are worth together, and what they could be at most.

    bound: no choice is worth more whose looks begin on the grid of `step_s`, have one of the
    lengths tried (least, wanted, half-way) and lie in the same passes.  gap_share: how much
    more than `value` that is at most, as a share of the bound.  greedy_value: what taking pass
    after pass whatever is worth most there is worth.  windows: there were to choose from.
    unseen: targets that can't be looked at for as long as they must.  left_out: that can, but
    others are worth more.
    """

    value: float
    bound: float
    gap_share: float
    greedy_value: float
    windows: int
    looks: int
    passes: int
    unseen: list[str]
    left_out: list[str]
    warnings: list[str]


@dataclass(frozen=True, kw_only=True)
class CampaignLookOut:
    """A look at a target as it was chosen; its plan tells what a slew took from it."""

    target: str
    start: str
    stop: str
    value: float


@dataclass(frozen=True, kw_only=True)
class LookLeftOut:
    """A look that planning refused, and why."""

    target: str
    because: str


@dataclass(frozen=True, kw_only=True)
class CampaignPassOut:
    """Looks planned together: from rest at `start` to rest at `stop`.

    plan: its id, GET /v1/plans/{id}.  state: of that plan.  left_out: looks that could not be
    flown; a plan without them took the place of the one that was refused.
    """

    number: int
    plan: str
    state: JobState
    start: str
    stop: str
    looks: list[CampaignLookOut]
    left_out: list[LookLeftOut]
    problem: JobProblem | None


@dataclass(frozen=True, kw_only=True)
class PlannedOut:
    """How far the passes are planned.

    value: of the looks in plans that are made.
    """

    done: int
    open: int
    refused: int
    failed: int
    cancelled: int
    looks: int
    value: float


@dataclass(frozen=True, kw_only=True)
class CampaignResponse(JobResponse):
    """A campaign as it stands; `choice` is null until it is made."""

    choice: CampaignChoiceOut | None
    planned: PlannedOut
    passes: list[CampaignPassOut]


@dataclass(frozen=True, kw_only=True)
class CampaignList:
    """The latest first; `next` is the `cursor` of what comes after, null at the end."""

    campaigns: list[JobResponse]
    next: str | None


@dataclass(frozen=True, kw_only=True)
class CampaignDryRun:
    """The request is sound; nothing was chosen."""

    valid: bool
    name: str
    targets: int


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
