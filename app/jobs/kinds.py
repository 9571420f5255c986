"""The kinds of job, one entry each: the work, its bounds, what its result becomes.

A new kind is a module with its work, which a child imports, and a line in JOB_KINDS.
"""

import hashlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from sqlalchemy import Connection

from app.jobs.child import Bounds
from app.store import flights, jobs, plans
from app.store.ids import JobState, new_id
from app.store.jobs import Job, NewJob
from app.store.listing import Listing
from app.store.packed import NewPlan
from app.store.plans import StoredPlan
from app.work.campaign import NewCampaign, Part, choose, without_refused
from app.work.flights import NewFlights, fly_part, prepare_flights
from app.work.plan import plan_and_pack
from app.work.spacecraft import plan_and_pack_session

_PART_RANK = 1  # after what somebody waits for


class Settled(NamedTuple):
    """The state a job has when its work has ended, `running` while it waits for parts.

    plan: as it was stored, for who waits for it; None where none was made.
    """

    state: JobState
    plan: StoredPlan | None = None


@dataclass(frozen=True, kw_only=True)
class JobKind:
    """One kind of job.

    work: in a child, of a request's bytes and the request as it was read, None where it is to read
    it; what it returns and raises goes through pickle.
    store: puts that into the database, in the transaction that finishes the job, whose row it
    holds.
    iterations: of a solver, counted in the metrics.
    stages: when each that its work or its parts report begins, in percent of the whole time, in
    order; as jobs that take long have been seen to share it.
    has_parts: jobs of their own, which the result names.
    """

    name: str
    bounds: Bounds
    work: Callable[[bytes, Any], Any]
    store: Callable[[Connection, Job, Any], Settled]
    iterations: Callable[[Any], int | None] = lambda _: None
    stages: Mapping[str, int] = field(default_factory=dict)
    has_parts: bool = False

    def percent(self, stage: str, done: int = 0, of: int = 1) -> int | None:
        """Of the time until a job is done, when so much of a stage is; None where none can say."""
        if stage not in self.stages:
            return None
        begins = self.stages[stage]
        ends = next((later for later in self.stages.values() if later > begins), 100)
        return begins + int((ends - begins) * min(done / max(of, 1), 1.0))


def _store_plan(connection: Connection, job: Job, new: NewPlan) -> Settled:
    revises = job.options.get("revises")
    jobs.list_anew(connection, job, new.listing)
    return Settled(new.state, plans.store(connection, job.id, job.kind, revises, new))


PLAN = JobKind(
    name="plan",
    # As SLEWTRACK_JOB_DEADLINE_S has it unless set, so that the operator decides.  The most that
    # can be asked, 200 sessions that all shorten each other, took 23 s of a core and 0.3 GB.
    bounds=Bounds(deadline_s=300.0, memory_mib=2000),
    work=plan_and_pack,
    store=_store_plan,
    iterations=lambda new: new.iterations,
    stages={
        "orbit": 0,
        "slews and tracks": 2,
        "comparison": 75,
        "pointing budget": 80,
        "verification": 87,
    },
)
SPACECRAFT_PLAN = JobKind(
    name="spacecraft",
    # The most that can be asked, an hour with 200 requests and 100 closed-loop runs, took 212 s
    # and 2.6 GB on two cores that had four other things to do.
    bounds=Bounds(deadline_s=300.0, memory_mib=3000),
    work=plan_and_pack_session,
    store=_store_plan,
    stages={
        "candidates": 0,
        "choice and slews": 4,
        "gimbals": 55,
        "verification": 58,
        "flight": 62,
        "alternatives": 95,
    },
)


def _store_campaign(connection: Connection, job: Job, new: NewCampaign) -> Settled:
    if job.cancel_requested:
        return Settled("cancelled")
    plans.store_choice(connection, job.id, new.document)
    for part in new.parts:
        deadline_s = min(PLAN.bounds.deadline_s, job.deadline_s)
        _accept_part(connection, part, job.id, job.key_id, deadline_s)
    return Settled("running" if new.parts else "done")


CAMPAIGN = JobKind(
    name="campaign",
    # 1,000 targets over 7 days, the most one request may ask for, took 48 s of a core and 0.8 GB.
    bounds=Bounds(deadline_s=600.0, memory_mib=4000),
    work=choose,
    store=_store_campaign,
    has_parts=True,
    stages={
        "opportunities": 0,
        "ways": 10,
        "slews": 15,
        "choosing": 35,
        "mixing": 60,
        "rounding": 65,
        "exchanging": 68,
        "bound": 75,
        "plans": 80,
    },
)


def _store_flights(connection: Connection, job: Job, new: NewFlights) -> Settled:
    if job.cancel_requested:
        return Settled("cancelled")
    flights.store(connection, job.id, new.document)
    for number, request in enumerate(new.parts):
        jobs.accept(
            connection,
            NewJob(
                id=new_id(),
                kind=RUNS.name,
                name=f"{job.name} part {number}",
                request=request,
                request_sha256=hashlib.sha256(request).hexdigest(),
                deadline_s=min(RUNS.bounds.deadline_s, job.deadline_s),
                key_id=job.key_id,
                parent_id=job.id,
                rank=_PART_RANK,
            ),
        )
    return Settled("running")


def _store_runs(connection: Connection, job: Job, outcomes: bytes) -> Settled:
    flights.store(connection, job.id, outcomes)
    return Settled("done")


FLIGHTS = JobKind(
    name="flights",
    # 5.5 hours of one star flown once took 6 s of a core and 0.6 GB, 200 short sessions 3 s.
    bounds=Bounds(deadline_s=300.0, memory_mib=3000),
    work=prepare_flights,
    store=_store_flights,
    has_parts=True,
    stages={"as planned": 0, "runs": 3},
)
RUNS = JobKind(
    name="flight runs",
    # 5 to 10 s of a core as a rule; two flights of 5.5 hours 11 s and 0.7 GB.
    bounds=Bounds(deadline_s=300.0, memory_mib=3000),
    work=fly_part,
    store=_store_runs,
)

JOB_KINDS = {kind.name: kind for kind in (PLAN, SPACECRAFT_PLAN, CAMPAIGN, FLIGHTS, RUNS)}


def replace_refused(connection: Connection, refused: Job, problem: Mapping[str, Any]) -> None:
    """Accept a campaign's pass once more without the look at fault, if any other is left.

    In the transaction that finishes the refused plan, whose row it holds, so that the campaign
    never sees itself complete in between.
    """
    part = Part(
        request=jobs.request_of(connection, refused.id) or b"",
        name=refused.name,
        listing=Listing(platform=refused.platform or ""),
        facts=refused.options["campaign"],
    )
    repaired = without_refused(part, problem.get("field"), problem["detail"])
    if repaired is not None and refused.parent_id is not None:
        _accept_part(connection, repaired, refused.parent_id, refused.key_id, refused.deadline_s)


def _accept_part(
    connection: Connection, part: Part, whole_id: str, key_id: str | None, deadline_s: float
) -> None:
    """The plan of one pass."""
    jobs.accept(
        connection,
        NewJob(
            id=new_id(),
            kind=PLAN.name,
            name=part.name,
            request=part.request,
            request_sha256=hashlib.sha256(part.request).hexdigest(),
            deadline_s=deadline_s,
            options={"campaign": dict(part.facts)},
            key_id=key_id,
            parent_id=whole_id,
            rank=_PART_RANK,
            listing=part.listing,
        ),
    )
