"""Outcomes of plausible requests, and of the starts that refusals advise."""

import copy
import json
import math
import re
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from datetime import UTC, datetime
from typing import Any

from plan_oracle import faults

from app.answers.members import PlanHead, provenance, whole_answer
from app.answers.problem import problem_of
from app.requests.plan import read_plan_request
from app.work.plan import plan_document, table_json
from planner.base import effort
from planner.base.effort import at_most
from planner.base.errors import Refusal
from planner.planning.sessions.pipeline import make_plan
from planner.planning.sessions.plan import Plan

Fields = dict[str, Any]
SLUG = re.compile(r"[a-z]+(-[a-z]+)*")
OURS = ("internal-error", "verification-failed", "solver-failed")  # never the planner's to mend


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """kind: `planned`, `baseline` for a spline that says it failed, a refusal's, or `bug`.

    faults: all that is wrong with the table or the refusal.  cpu_s: until the answer is written.
    work_rows: what of it `effort` counted.
    """

    kind: str
    cpu_s: float
    work_rows: float
    problem: Fields = field(default_factory=dict)
    faults: list[str] = field(default_factory=list)

    @property
    def advises(self) -> bool:
        return "earliest_feasible_start" in self.problem


def outcome(request: Fields) -> Outcome:
    """Plan it and look at what comes."""
    answered, refusal, bug = b"", None, None
    asked = json.dumps(request).encode()
    effort.count(0.0)  # what a ledger of `bench/work_costs.py` has seen since is the oracle's
    begun_s = time.process_time()
    with at_most(math.inf) as work:
        try:
            plan = make_plan(read_plan_request(asked))
            answered = _answer_of(plan)
        except Refusal as refused:
            refusal = refused
        except Exception as error:  # noqa: BLE001 (counted, and told with its request)
            bug = f"{type(error).__name__}: {error}"
    effort.count(0.0)  # and since the last thing counted, verdict and answer
    seen = {"cpu_s": time.process_time() - begun_s, "work_rows": work.done_rows}
    if refusal is not None:
        problem = problem_of(refusal)
        return Outcome(kind=refusal.slug, problem=problem, faults=list(_misshapen(problem)), **seen)
    if bug is not None:
        return Outcome(kind="bug", faults=[bug], **seen)
    told = json.loads(answered)
    if request["slew"]["method"] == "spline" and told["state"] == "failed":
        return Outcome(kind="baseline", **seen)
    wrong = faults(request, told)
    if told["state"] != "done":
        wrong.append(f"its state is {told['state']}")
    return Outcome(kind="planned", faults=wrong, **seen)


def answer(request: Fields) -> Fields:
    """That of a request that can be planned."""
    plan = make_plan(read_plan_request(json.dumps(request).encode()))
    return dict(json.loads(_answer_of(plan)))


def _answer_of(plan: Plan) -> bytes:
    """Whole, under a new id."""
    document = plan_document(plan, (), provenance(datetime.now(UTC)))
    state = "done" if plan.verification.passed else "failed"
    head = PlanHead(id="made", state=state, revision=1, revises=None, requested_by=None)
    return whole_answer(head, document, table_json(plan.table))


def as_advised(request: Fields, problem: Fields) -> Fields:
    """The request with the start and stop that its refusal advises, less what it costs."""
    changed = copy.deepcopy(request)
    named = re.match(r"sessions\.(\d+)", problem.get("field", ""))
    assert named is not None, problem
    session = changed["sessions"][int(named[1])]
    session["start"] = problem["earliest_feasible_start"]
    session["stop"] = problem.get("feasible_stop", session["stop"])
    costs = problem.get("costs_sessions", ())
    kept = [one for number, one in enumerate(changed["sessions"]) if number not in costs]
    return changed | {"sessions": kept}


def _misshapen(problem: Fields) -> Iterator[str]:
    slug = problem["type"].rpartition("/")[2].rpartition(":")[2]
    if slug in OURS or not SLUG.fullmatch(slug):
        yield f"is refused as {slug}: {problem['detail']}"
    if problem["status"] != 422:
        yield f"is refused with {problem['status']}"
    if not problem["title"] or not problem["detail"] or len(problem["detail"]) > 3000:
        yield "is refused without a title or a detail of a page at most"
    if "feasible_stop" in problem and "earliest_feasible_start" not in problem:
        yield "is advised a stop without a start"
    if "earliest_feasible_start" in problem and "field" not in problem:
        yield "is advised a start for no session"
    for word in ("nan", "inf", "None", "Traceback"):
        if re.search(rf"\b{word}\b", problem["detail"]):
            yield f"is told of {word}: {problem['detail']}"
