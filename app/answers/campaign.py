"""The answer about a campaign: the choice of looks, and the state of its passes' plans."""

import json
from collections.abc import Sequence
from dataclasses import dataclass

from pydantic import SerializeAsAny

from app.answers.job import JobResponse, job_members
from app.answers.members import from_store, to_json
from app.answers.problem import Problem
from app.ids import JobState
from app.store.job import Job
from app.store.packed import unzip
from planner.base.answer_members import Count, NotNegative, answer
from planner.planning.campaigns.chosen import (
    ChosenLook,
)
from planner.planning.campaigns.revision import PassResources
from planner.planning.campaigns.told import CampaignChoiceOut, FleetChoiceOut


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

    number: from 0, in order of time; of a revision after that of the passes that stay. E.g. `1`.
    plan: id of its plan, GET /v1/plans/{id}. E.g. `"01a203fd-cbae-73f8-8276-319f76b8842c"`.
    state: state of the work on that plan.
    start: row 0 of its table; UTC. E.g. `"2015-02-27T17:32:46.000Z"`.
    stop: last row of its table; UTC. E.g. `"2015-02-27T17:38:08.000Z"`.
    resources: levels as it starts and as it stops; null without any.
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
    resources: SerializeAsAny[PassResources] | None  # likewise
    looks: list[SerializeAsAny[ChosenLook]]  # as they were told and stored
    left_out: list[LookLeftOut]
    problem: Problem | None


@dataclass(frozen=True, kw_only=True)
class FleetPassOut(CampaignPassOut):
    """Looks of one of several carriers planned together.

    carrier: id of the carrier that flies it. E.g. `"north"`.
    """

    carrier: str


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


@answer
class CampaignResponse(JobResponse):
    """A campaign as it stands.

    choice: the looks chosen; null until they are.
    planned: progress of the passes' plans.
    passes: those with looks, in order of time.
    """

    choice: SerializeAsAny[CampaignChoiceOut | FleetChoiceOut] | None
    planned: PlannedOut
    passes: list[FleetPassOut | CampaignPassOut]


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


def campaign_json(job: Job, document: bytes | None, parts: Sequence[Job]) -> bytes:
    """A CampaignResponse as UTF-8 JSON.

    document: what was chosen, None before.  parts: all plans of its passes, the oldest first.
    """
    choice = None if document is None else json.loads(unzip(document))
    latest = {part.options["campaign"]["pass"]: part for part in parts}
    by_number = [latest[number] for number in sorted(latest)]
    return to_json(
        CampaignResponse(
            **job_members(job) | {"choice": choice},
            planned=_planned_out(by_number),
            passes=[_pass_out(part) for part in by_number],
        )
    )


def _pass_out(part: Job) -> CampaignPassOut:
    facts = part.options["campaign"]
    told = CampaignPassOut(
        number=facts["pass"],
        plan=part.id,
        state=part.state,
        start=facts["start"],
        stop=facts["stop"],
        resources=facts.get("resources"),
        looks=facts["looks"],
        left_out=[from_store(LookLeftOut, look) for look in facts["left_out"]],
        problem=job_members(part)["problem"],
    )
    return FleetPassOut(**vars(told), carrier=facts["carrier"]) if "carrier" in facts else told


def _planned_out(parts: Sequence[Job]) -> PlannedOut:
    states = [one.state for one in parts]
    made = [one.options["campaign"]["looks"] for one in parts if one.state == "done"]
    values = [look["value"] for looks in made for look in looks]
    return PlannedOut(
        done=states.count("done"),
        open=states.count("queued") + states.count("running"),
        refused=states.count("refused"),
        failed=states.count("failed"),
        cancelled=states.count("cancelled"),
        looks=len(values),
        value=sum(values, 0.0),
    )
