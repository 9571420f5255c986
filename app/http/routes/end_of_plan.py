"""A request that continues where a kept plan ends: `initial_state.after`."""

import json
from typing import Any

from app.jobs.kinds import PLANS
from app.jobs.refusals import Conflict
from app.requests.json_reader import json_document
from app.requests.plain_text import require_plain
from app.requests.plan import read_plan_request
from app.store import plans
from app.store.database import Database
from app.store.packed import unpack
from app.work.plan import stored_plan
from planner.base.errors import InvalidInput
from planner.world.conditions import OPTIONS as CONDITIONS
from planner.world.frames.time_scales import elapsed_s, shifted_utc, utc_text
from planner.world.plan import FlightPlan
from planner.world.resources import MOMENTA
from planner.world.rules.registry import POSITIONS, rules_of
from planner.world.scenario import PastLook, Scenario

_FIELD = "initial_state.after"
_REST_RAD_S = 2e-12  # by which it turns 0.00001 deg in a day


def may_go_on_after(body: bytes) -> bool:
    """Whether a request can name a plan to go on after, at a glance."""
    return b'"after"' in body


def from_end_of_plan(database: Database, body: bytes) -> bytes:
    """The request with the state in which the plan it names ends; the same where it names none.

    What rests, or keeps its idle attitude, waits so until it is time for the first slew; but where
    resources go on with what the plan leaves, the table begins at its end.
    Raises InvalidInput and Conflict where there is no such plan, or not yet.
    """
    document: Any = json_document(body)
    state = document.get("initial_state") if isinstance(document, dict) else None
    if not isinstance(state, dict) or not isinstance(state.get("after"), str):
        return body
    if state.keys() & {*POSITIONS}:  # as an earlier request was filled in
        return body
    if others := sorted(state.keys() - {"after"}):
        raise InvalidInput(
            f"the plan's end says {', '.join(others)} already; leave out all but after",
            field=_FIELD,
        )
    try:
        plan_id = require_plain(state["after"])
    except ValueError as fault:
        raise InvalidInput(str(fault), field=_FIELD) from None
    before, levels = _plan_of(database, plan_id)
    goes_on = _carry_levels(document.get("resources"), levels)
    table, ended = before.table, before.scenario
    end_utc = shifted_utc(table.epoch_utc, float(table.t_s[-1]))
    at_end = rules_of(ended.platform).state_at_end(table)
    position = {name: value for name, value in at_end.items() if name in POSITIONS}
    past = _past_looks(ended)
    rests = abs(table.rate_rad_s[-1]).max() <= _REST_RAD_S
    for waits, begins in ((ended.final_state == "idle", past), (rests, state | position | past)):
        if waits and not goes_on:
            filled = json.dumps(document | {"initial_state": begins}).encode()
            if read_plan_request(filled).may_wait_after(ended.platform, end_utc):
                return filled
    state.update(position if rests else at_end, epoch=utc_text(end_utc, 1), **past)
    return json.dumps(document).encode()


def _past_looks(ended: Scenario) -> dict[str, Any]:
    """What it imaged and what was before, as far back as a rule may count."""
    sessions = (one for one in ended.sessions if one.target.images)
    looks = [PastLook(start=one.start, stop=one.stop) for one in sessions]
    looks = [*ended.initial_state.past_looks, *looks][-PastLook.most :]
    told = [
        one.told for one in looks if elapsed_s(looks[-1].stop, one.stop) <= CONDITIONS.span_max_s
    ]
    return {"past_looks": told} if told else {}


def _carry_levels(resources: Any, levels: dict[str, float]) -> bool:  # noqa: ANN401 (as sent)
    """Into what a request begins with of each resource, unless it says so; whether any is."""
    wheels = [levels[name] for name in MOMENTA if name in levels]
    starts = {
        "battery": ("start_wh", levels.get("battery")),
        "memory": ("start_gbit", levels.get("memory")),
        "momentum": ("start_n_m_s", wheels or None),
    }
    begun = [
        resources[name].setdefault(member, level) is level
        for name, (member, level) in starts.items()
        if level is not None
        if isinstance(resources, dict) and isinstance(resources.get(name), dict)
    ]
    return any(begun)


def _plan_of(database: Database, plan_id: str) -> tuple[FlightPlan, dict[str, float]]:
    """One that may be flown, and what its resources hold in the end; raises KeptUnreadable."""
    with database.reading() as connection:
        job, plan, request = plans.find(connection, plan_id, PLANS)
    if job is None:
        raise InvalidInput(
            f"there is no plan {plan_id!r}; GET /v1/plans lists them, or give epoch and motion",
            field=_FIELD,
        )
    if plan is None or plan.state != "done":
        raise Conflict(
            f"there is no end of the plan to go on from: its state is {job.state}", field=_FIELD
        )
    packed = unpack(plan.table_columns)
    return stored_plan(request, packed), packed.facts.get("levels", {})
