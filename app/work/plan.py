"""A child's work for a plan, and the reading of its stored table."""

import zlib
from dataclasses import replace
from datetime import UTC, datetime
from typing import Any

from app.answers.members import ProvenanceOut, provenance
from app.answers.plan import dry_run_json, plan_document, require_verified, table_json
from app.requests.listings import listing_of_scenario
from app.requests.plan import PlanRequest, read_kept_plan_request, read_plan_request
from app.store.packed import PackedColumns, pack, unpack
from app.work.horizon import horizon_checks
from app.work.progress import report
from app.work.result import Result
from planner.base.commands import Channel, CommandTable
from planner.base.spec import as_kept
from planner.output.export import EXPORTERS
from planner.verification import Finding, VerificationReport
from planner.world.frames.time_scales import utc_from_text, utc_text
from planner.world.plan import FlightPlan, Segment, SegmentKind


def plan_and_pack(body: bytes, request: PlanRequest | None = None) -> Result:
    """Read unless that is done, plan, judge and pack; raises a Refusal."""
    from planner.planning.sessions.pipeline import make_plan

    now_utc = datetime.now(UTC)
    request = request or read_plan_request(body)
    plan = make_plan(request, report)
    listing = listing_of_scenario(plan.scenario)
    checks = horizon_checks(plan, request.horizon_cameras)
    document = zlib.compress(plan_document(plan, checks, provenance(now_utc, body)))
    return Result(
        content=(document, pack(packed_plan(plan, plan.verification))),
        state="done" if plan.verification.passed else "failed",
        listing=replace(listing, probability_in_frame=plan.probability_in_frame),
        iterations=sum(run.iterations for run in plan.slews),
    )


def try_plan(request: PlanRequest, provenance: ProvenanceOut) -> bytes:
    """The answer to a dry run: planned and judged, nothing kept; raises a Refusal."""
    from planner.planning.sessions.pipeline import make_plan

    return dry_run_json(make_plan(request), provenance)


def stored_table_json(table_columns: bytes) -> bytes:
    return table_json(stored_table(unpack(table_columns)))


def stored_table_file(
    request: bytes, table_columns: bytes, format_name: str, created_utc: datetime
) -> bytes:
    """The table by itself; raises Unverified, OutsideCoverage."""
    packed = unpack(table_columns)
    require_verified_table(packed)
    return EXPORTERS[format_name].write(stored_plan(request, packed), created_utc)


def require_verified_table(packed: PackedColumns) -> None:
    require_verified(_finding(**error) for error in packed.facts["errors"])


def stored_plan(request: bytes, packed: PackedColumns) -> FlightPlan:
    """With its sessions as they were left after conflicts; raises KeptUnreadable.

    request: what was asked, unless the facts tell of the sessions that were made of it.
    """
    scenario = read_kept_plan_request(packed.facts.get("request", "").encode() or request)
    times = zip(scenario.sessions, packed.facts["sessions"], strict=True)
    with as_kept():
        sessions = tuple(
            replace(session, start=start, stop=stop, target=session.target.starting(begun))
            for session, at in times
            for start, stop, begun in [map(utc_from_text, (*at, at[0])[:3])]
        )
        scenario = replace(scenario, sessions=sessions)
    segments = tuple(segment_of(*facts) for facts in packed.facts["segments"])
    return FlightPlan(scenario=scenario, segments=segments, table=stored_table(packed))


def segment_of(kind: SegmentKind, session: int | None, start: str, stop: str) -> Segment:
    start_utc, stop_utc = utc_from_text(start), utc_from_text(stop)
    return Segment(kind=kind, session=session, start_utc=start_utc, stop_utc=stop_utc)


def packed_plan(plan: FlightPlan, judged: VerificationReport | None = None) -> PackedColumns:
    """What is stored of a plan beside its request."""
    table = plan.table
    return PackedColumns(
        columns={
            name: column
            for name in ("position", "rate_rad_s", "acceleration_rad_s2", "extra_rad")
            if (column := getattr(table, name)) is not None
        },
        facts={
            "epoch": _exact(table.epoch_utc),
            "channels": table.channels,
            "sessions": [
                [_exact(at) for at in (s.start, s.stop, getattr(s.target, "start", s.start))]
                for s in plan.scenario.sessions
            ],
            "segments": [
                [s.kind, s.session, _exact(s.start_utc), _exact(s.stop_utc)] for s in plan.segments
            ],
            "errors": [
                {name: getattr(found, name) for name in ("limit", "axis", "t_s", "detail")}
                | {"at": None if found.at_utc is None else _exact(found.at_utc)}
                for found in (judged.findings if judged else ())
                if found.severity == "error"
            ],
            "levels": {one.name: one.last for one in (judged.resources if judged else ())},
        },
    )


def stored_table(packed: PackedColumns) -> CommandTable:
    epoch_utc = utc_from_text(packed.facts["epoch"])
    channels = tuple(Channel(*channel) for channel in packed.facts["channels"])
    return CommandTable(epoch_utc=epoch_utc, channels=channels, **packed.columns)


def _finding(at: str | None, **members: Any) -> Finding:  # noqa: ANN401 (as stored)
    return Finding(at_utc=None if at is None else utc_from_text(at), **members)


def _exact(moment: datetime) -> str:
    return utc_text(moment, 6)
