"""A child's work for an imaging session, and the reading of its stored table."""

import json
import zlib
from dataclasses import replace
from datetime import UTC, datetime

from app.answers.members import ProvenanceOut, provenance
from app.answers.plan import plan_document
from app.answers.spacecraft import (
    attitude_table_json,
    spacecraft_document,
    spacecraft_dry_run_json,
)
from app.requests.listings import listing_of_imaging
from app.requests.plan import write_plan_request
from app.requests.spacecraft import read_spacecraft_request
from app.store.packed import pack, unpack
from app.work.plan import packed_plan, stored_table
from app.work.progress import report
from app.work.result import Result
from planner.spacecraft.requests import ImagingPlanRequest


def plan_and_pack_session(body: bytes, request: ImagingPlanRequest | None = None) -> Result:
    """Read unless that is done, plan, judge, fly and pack; raises a Refusal.

    It is stored as the plan of its body, beside the request for its sessions, which the body isn't.
    """
    from planner.spacecraft.plan import plan_imaging

    origin = provenance(datetime.now(UTC), body)
    plan = plan_imaging(request or read_spacecraft_request(body), report)
    whole = plan.whole
    asked = write_plan_request(whole.scenario, {"orbit": json.loads(body)["orbit"]}, ()).decode()
    packed = packed_plan(whole)
    documents = (plan_document(whole, (), origin), spacecraft_document(plan, origin))
    document, session_document = map(zlib.compress, documents)
    table_columns = pack(replace(packed, facts={**packed.facts, "request": asked}))
    return Result(
        content=(document, table_columns, session_document),
        listing=listing_of_imaging(plan.request),
        iterations=sum(run.iterations for run in whole.slews),
    )


def try_session(request: ImagingPlanRequest, provenance: ProvenanceOut) -> bytes:
    """The answer to a dry run: planned, judged and flown, nothing kept; raises a Refusal."""
    from planner.spacecraft.plan import plan_imaging

    return spacecraft_dry_run_json(plan_imaging(request), provenance)


def stored_session_json(table_columns: bytes) -> bytes:
    """The table as the answer holds it."""
    return attitude_table_json(stored_table(unpack(table_columns)))
