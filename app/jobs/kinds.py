"""The kinds of job, one entry each: the work, its bounds, and its parts.

A new kind is a module with its work, which a child imports, and a line in JOB_KINDS.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from app.jobs.child import Bounds
from app.jobs.shares import Shares
from app.work.campaign import choose, may_be_shared, split_by_carrier
from app.work.flights import fly_part, prepare_flights
from app.work.plan import plan_and_pack
from app.work.result import Result
from app.work.spacecraft import plan_and_pack_session
from planner.planning.campaigns.apart import find_looks


@dataclass(frozen=True, kw_only=True)
class JobKind:
    """One kind of job.

    work: in a child, of a request's bytes and the request as it was read, None where it is to read
    it; what it returns and raises goes through pickle.
    makes_plans: each is a revision in a series.
    shares: of its work, done by several processes before the rest.
    parts: the kind of the jobs that its result waits for.
    stages: when each that its work or its parts report begins, in percent of the whole time, in
    order; as jobs that take long have been seen to share it.
    """

    name: str
    bounds: Bounds
    work: Callable[[bytes, Any], Result]
    makes_plans: bool = False
    shares: Shares | None = None
    parts: "JobKind | None" = None
    stages: Mapping[str, int] = field(default_factory=dict)

    def percent(self, stage: str, done: int = 0, of: int = 1) -> int | None:
        """Of the time until a job is done, when so much of a stage is; None where none can say."""
        if stage not in self.stages:
            return None
        begins = self.stages[stage]
        ends = next((later for later in self.stages.values() if later > begins), 100)
        return begins + int((ends - begins) * min(done / max(of, 1), 1.0))


PLAN = JobKind(
    name="plan",
    # As SLEWTRACK_JOB_DEADLINE_S has it unless set, so that the operator decides.  The most that
    # can be asked, 200 sessions that all shorten each other, took 23 s of a core and 0.3 GB.
    bounds=Bounds(deadline_s=300.0, memory_mib=2000),
    work=plan_and_pack,
    makes_plans=True,
    stages={
        "orbit": 0,
        "slews and tracks": 2,
        "alternatives": 40,  # to sessions that can't be flown as asked
        "comparison": 75,
        "resources": 78,  # to a plan that takes no more than there is
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
    makes_plans=True,
    stages={
        "candidates": 0,
        "choice and slews": 4,
        "comparison": 55,
        "resources": 56,
        "pointing budget": 57,
        "verification": 58,
        "bound": 60,
        "flight": 62,
        "alternatives": 95,
    },
)


CARRIERS = Shares(
    may_be=may_be_shared, split=split_by_carrier, work=find_looks, stage="opportunities"
)
CAMPAIGN = JobKind(
    name="campaign",
    # Of 100 carriers and 10,000 targets the choice takes 230 s and 2.8 GB (bench/fleet.py).
    bounds=Bounds(deadline_s=1800.0, memory_mib=4000),
    work=choose,
    shares=CARRIERS,
    parts=PLAN,
    stages={
        "opportunities": 0,
        "ways": 10,
        "slews": 15,
        "choosing": 35,
        "mixing": 60,
        "bound": 65,
        "rounding": 72,
        "exchanging": 75,
        "proof": 78,  # nothing is left to prove, unless prices are of what resources allow
        "plans": 80,
    },
)
ORDER = replace(CAMPAIGN, name="order")  # of one target, by STAPI


RUNS = JobKind(
    name="flight runs",
    # 5 to 10 s of a core as a rule; two flights of 5.5 hours 11 s and 0.7 GB.
    bounds=Bounds(deadline_s=300.0, memory_mib=3000),
    work=fly_part,
)
FLIGHTS = JobKind(
    name="flights",
    # 5.5 hours of one star flown once took 6 s of a core and 0.6 GB, 200 short sessions 3 s.
    bounds=Bounds(deadline_s=300.0, memory_mib=3000),
    work=prepare_flights,
    parts=RUNS,
    stages={"as planned": 0, "runs": 3},
)
JOB_KINDS = {kind.name: kind for kind in (PLAN, SPACECRAFT_PLAN, CAMPAIGN, ORDER, FLIGHTS, RUNS)}
PLANS = frozenset(kind.name for kind in JOB_KINDS.values() if kind.makes_plans)
