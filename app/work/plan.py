"""Plans: their making, their stored tables, and the answers."""

import zlib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict

from app.answers.members import PlanHead, ProvenanceOut, provenance, to_json
from app.requests.plan import PlanRequest, read_kept_plan_request, read_plan_request
from app.store.job import Listing
from app.store.packed import PackedColumns, pack, unpack
from app.work.horizon import horizon_checks
from app.work.progress import report
from app.work.result import Result
from estimator.found import HorizonCheck
from planner.base.answer_members import Count, NotNegative
from planner.base.assumed import Assumed
from planner.base.commands import COMMAND_STEP_S, Channel, CommandTable
from planner.base.errors import Unverified
from planner.base.spec import as_kept
from planner.motion.comparison import SlewComparison
from planner.output.export import EXPORTERS
from planner.planning.sessions.budget import PointingBudget
from planner.planning.sessions.plan import Plan, SolverOut
from planner.planning.sessions.summary import PlanSummary, summarise
from planner.verification import Finding, LimitMargin, Reserve, SessionReport, VerificationReport
from planner.verification.report import (
    ExclusionMargin,
    GyroMargin,
    KeepOutMargin,
    MaskMargin,
    SlowStretch,
)
from planner.world.frames.time_scales import utc_from_text, utc_text
from planner.world.plan import FlightPlan, Segment, SegmentKind
from planner.world.scenario import Scenario


class TableOut(BaseModel):
    """The command table, one array per column.

    Per axis NAME of the platform two more: `NAME_deg` and `NAME_rate_deg_s` (for `iss-hrc`
    `alpha_deg`, `beta_deg`, `alpha_rate_deg_s`, `beta_rate_deg_s`). Between rows the platform flies
    the cubic Hermite of two rows.

    epoch: of row 0; UTC.
    step_s: from row to row.
    t_s: of each row, since the epoch.
    """

    model_config = ConfigDict(extra="allow", frozen=True)
    __pydantic_extra__: dict[str, list[float]]

    epoch: str
    step_s: NotNegative
    t_s: list[NotNegative]


class TableAlone(BaseModel, extra="allow"):
    """The table by itself, as `format=json` asks: a list per column, and what they mean.

    name: of the plan, as its request gives it.
    epoch: of row 0; UTC.
    step_s: from row to row.
    t_s: of each row, since the epoch.
    description: frames, units and the interpolation.
    """

    name: str
    epoch: str
    step_s: NotNegative
    t_s: list[NotNegative]
    description: dict[str, Any]


@dataclass(frozen=True, kw_only=True)
class PlanDocument:
    """What is known of a plan beside its table.

    name: as the request gives it.
    platform: the platform's name.
    summary: sessions of the plan, in short.
    segments: slews, tracks and waits of the table, in order of time.
    margins: the least distance of each axis from its limits: by axis, then by limit.
    keep_out: the least angle between the boresight and each cone of the request.
    masks: the least angle between the boresight and each mask of the platform.
    exclusions: the least that a body keeps of each of its exclusions, and its star trackers.
    resources: the least that battery, memory and wheels keep from their limits, where asked for.
    gyros: the least that the gyros of a body keep from their limits.
    pointing: pointing errors of each session.
    slow_stretches: outside of the sessions, so on slews; those of a session are in `pointing`.
    uncertainty: of every session that looks at a target.
    verification: result of the independent verification.
    comparison: each slew beside the paper's spline.
    horizon_checks: views of the carrier's horizon cameras, for each session and camera.
    solver: the solution of the slews.
    warnings: cautions to read before flying it.
    assumed: values that were looked up or filled in for the request, such as the place of a name or
    the initial state.
    """

    name: str
    platform: str
    summary: PlanSummary
    segments: tuple[Segment, ...]
    margins: dict[str, dict[str, LimitMargin]]
    keep_out: tuple[KeepOutMargin, ...]
    masks: tuple[MaskMargin, ...]
    exclusions: tuple[ExclusionMargin, ...]
    resources: tuple[Reserve, ...]
    gyros: tuple[GyroMargin, ...]
    pointing: tuple[SessionReport, ...]
    slow_stretches: tuple[SlowStretch, ...]
    uncertainty: list[PointingBudget]
    verification: VerificationReport
    comparison: list[SlewComparison]
    horizon_checks: list[HorizonCheck]
    solver: SolverOut
    warnings: list[str]
    assumed: list[Assumed]
    provenance: ProvenanceOut


@dataclass(frozen=True, kw_only=True)
class PlanResponse(PlanHead, PlanDocument):
    """A plan and the judge's verdict on it.

    state: `done` when the verification passed. `failed` when it did not, which only the baseline
    `spline` can answer: its table is for comparison, never for flight.
    """

    table: TableOut


@dataclass(frozen=True, kw_only=True)
class DryRunResponse:
    """The request was planned, and nothing is kept of it.

    What can't be flown is refused as the plan itself would be.

    valid: always true; what isn't is refused.
    flies: true when the table passes its verification; only that of the baseline `spline` may not.
    E.g. `true`.
    name: as the request gives it.
    platform: the platform's name.
    sessions: number of sessions.
    rows: of the table. E.g. `1151`.
    warnings: cautions to read before flying it. E.g.
    `["the elements' epoch 2015-02-27T11:40:53Z is 9.0 days from the farthest instant asked for"]`.
    """

    valid: Literal[True]
    flies: bool
    name: str
    platform: str
    sessions: Count
    rows: Count
    warnings: list[str]
    provenance: ProvenanceOut


def require_verified(findings: Iterable[Finding]) -> None:
    """Raise Unverified when the judge found an error: a file by itself carries no verdict."""
    for finding in findings:
        if finding.severity == "error":
            raise Unverified(
                f"the table failed its verification: {finding.detail}; only the whole answer "
                "holds it, beside the verdict",
                field="slew.method",
                axis=finding.axis,
                limit=finding.limit,
                at_utc=finding.at_utc,
            )


def table_json(table: CommandTable) -> bytes:
    # Constructed without validation: 2,000 floats that numpy has just made.
    return to_json(
        TableOut.model_construct(
            epoch=utc_text(table.epoch_utc, 1),
            step_s=COMMAND_STEP_S,
            t_s=table.t_s.tolist(),
            **{one.name: value.tolist() for one, value in table.columns},
        )
    )


def plan_document(plan: Plan, checks: Sequence[HorizonCheck], provenance: ProvenanceOut) -> bytes:
    report = plan.verification
    return to_json(
        PlanDocument(
            name=plan.scenario.name,
            platform=plan.scenario.platform.name,
            summary=summarise(plan),
            segments=plan.segments,
            margins=report.margins,
            keep_out=report.keep_out,
            masks=report.masks,
            exclusions=report.exclusions,
            resources=report.resources,
            gyros=report.gyros,
            pointing=report.sessions,
            slow_stretches=report.slow_stretches,
            uncertainty=[budget for budget in plan.budgets if budget is not None],
            verification=report,
            comparison=[run.comparison for run in plan.slews if run.comparison is not None],
            horizon_checks=list(checks),
            solver=plan.solver,
            warnings=list(plan.warnings),
            assumed=list(plan.scenario.assumed),
            provenance=provenance,
        )
    )


def listing_of_scenario(scenario: Scenario) -> Listing:
    return Listing(
        platform=scenario.platform.name,
        start_utc=scenario.sessions[0].start,
        stop_utc=scenario.sessions[-1].stop,
        targets=tuple(session.label for session in scenario.sessions),
    )


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

    plan = make_plan(request)
    return to_json(
        DryRunResponse(
            valid=True,
            flies=plan.verification.passed,
            name=plan.scenario.name,
            platform=plan.scenario.platform.name,
            sessions=len(plan.scenario.sessions),
            rows=len(plan.table.position),
            warnings=list(plan.warnings),
            provenance=provenance,
        )
    )


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
