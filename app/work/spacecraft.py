"""A child's work for an imaging session, and the reading of what is stored of it."""

import json
import zlib
from dataclasses import asdict, replace
from datetime import UTC, datetime
from typing import TYPE_CHECKING

from app.answers.members import ProvenanceOut, provenance
from app.answers.spacecraft import (
    attitude_table_json,
    spacecraft_document,
    spacecraft_dry_run_json,
)
from app.requests.listings import listing_of_imaging
from app.requests.plan import write_plan_request
from app.requests.spacecraft import read_kept_spacecraft_request, read_spacecraft_request
from app.store.packed import PackedColumns, pack, unpack
from app.work.plan import packed_plan, stored_table
from app.work.progress import report
from app.work.result import Result
from planner.spacecraft.ground import SessionTable
from planner.spacecraft.requests import ImagingPlanRequest
from planner.spacecraft.table import AttitudeTable, ImagingWindow

if TYPE_CHECKING:
    from planner.spacecraft.plan import ImagingPlan


def plan_and_pack_session(body: bytes, request: ImagingPlanRequest | None = None) -> Result:
    """Read unless that is done, plan, judge, fly and pack; raises a Refusal."""
    from planner.spacecraft.plan import plan_imaging

    now_utc = datetime.now(UTC)
    plan = plan_imaging(request or read_spacecraft_request(body), report)
    document = zlib.compress(spacecraft_document(plan, provenance(now_utc, body)))
    return Result(
        content=(document, pack(_packed(plan, body))),
        listing=listing_of_imaging(plan.request),
    )


def try_session(request: ImagingPlanRequest, provenance: ProvenanceOut) -> bytes:
    """The answer to a dry run: planned, judged and flown, nothing kept; raises a Refusal."""
    from planner.spacecraft.plan import plan_imaging

    return spacecraft_dry_run_json(plan_imaging(request), provenance)


def stored_session_json(table_columns: bytes) -> bytes:
    """The table as the answer holds it."""
    return attitude_table_json(stored_table(unpack(table_columns)))


def stored_session(request: bytes, packed: PackedColumns) -> SessionTable:
    """What was asked, and the table as it was stored; raises KeptUnreadable."""
    windows = tuple(ImagingWindow(**window) for window in packed.facts["windows"])
    return SessionTable(
        request=read_kept_spacecraft_request(request),
        table=AttitudeTable.of_body(stored_table(packed), windows),
    )


def _packed(plan: "ImagingPlan", body: bytes) -> PackedColumns:
    """A plan's columns and facts, and the request for its sessions, which the body isn't."""
    packed = packed_plan(plan.flight)
    orbit = json.loads(body)["orbit"]
    facts = {
        "request": write_plan_request(plan.flight.scenario, {"orbit": orbit}, ()).decode(),
        "windows": [asdict(window) for window in plan.table.windows],
    }
    return replace(packed, facts={**packed.facts, **facts})
