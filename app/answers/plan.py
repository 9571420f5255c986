"""The answer to a plan: degrees, UTC text and plain numbers."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

from pydantic import BaseModel, ConfigDict

from app.answers.comparison import SlewComparisonOut, comparison_out
from app.answers.horizon_view import HorizonCheckOut
from app.answers.masks import MaskMarginOut, mask_margin_out
from app.answers.members import (
    PlanHead,
    ProvenanceOut,
    degrees,
    degrees_of,
    fill,
    new_head,
    to_json,
    whole_answer,
)
from app.answers.pointing import PointingOut, SlowStretchOut, UncertaintyOut, pointing_out
from app.answers.ranges import Count, HalfTurnDeg, NotNegative, Signed
from app.answers.solver import SolverOut, solver_out
from app.answers.summary import PlanSummaryOut, summary_out
from planner.base.assumed import Assumed
from planner.base.commands import COMMAND_STEP_S, CommandTable
from planner.base.errors import Unverified
from planner.verification import Finding, LimitMargin
from planner.verification.report import KeepOutMargin
from planner.world.frames.time_scales import utc_text
from planner.world.plan import Segment, SegmentKind

if TYPE_CHECKING:
    from planner.planning.sessions.plan import Plan

_UNITS = {
    "angle_min": "deg",
    "angle_max": "deg",
    "rate": "deg/s",
    "acceleration": "deg/s2",
    "acceleration_jump": "deg/s2",
    "jerk": "deg/s3",
}


@dataclass(frozen=True, kw_only=True)
class SegmentOut:
    """A stretch of the table.

    kind: at rest, brought to rest in order to wait, on the way to a session's target, or tracking
    it.
    session: number of the session it belongs to, from 0; null on the way to the final state.
    start: its first row; UTC.
    stop: its last row; UTC.
    """

    kind: SegmentKind
    session: Count | None
    start: str
    stop: str


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


@dataclass(frozen=True, kw_only=True)
class MarginOut:
    """The closest an axis comes to a limit, anywhere on or between rows.

    limit: the most the axis may. [see `unit`]
    extreme: the nearest to it that the axis comes. [see `unit`]
    margin: distance from the limit; negative when the limit is broken. [see `unit`]
    unit: of limit, extreme and margin.
    t_s: time of the margin, since the table's epoch.
    at: the same instant; UTC.
    """

    limit: Signed
    extreme: Signed
    margin: Signed
    unit: str
    t_s: NotNegative
    at: str


@dataclass(frozen=True, kw_only=True)
class KeepOutMarginOut:
    """The least angle between the boresight and the axis of one cone of `slew.keep_out`.

    number: of the cone in the request, from 0. E.g. `0`.
    about: the body or direction at the cone's centre. E.g. `"the Sun"`.
    half_angle_deg: of the cone. E.g. `25.0`.
    away_min_deg: least angle between boresight and the cone's axis; null when the cone never counts
    (the Earth hides its body). E.g. `31.2`.
    margin_deg: least angle less the half angle; null when the cone never counts. E.g.
    `6.2`.
    at: time of the least angle; UTC, null when the cone never counts. E.g.
    `"2015-02-27T17:36:10.000Z"`.
    """

    number: Count
    about: str
    half_angle_deg: HalfTurnDeg
    away_min_deg: HalfTurnDeg | None
    margin_deg: Signed | None
    at: str | None


@dataclass(frozen=True, kw_only=True)
class FindingOut:
    """One thing the verification found wrong or worth knowing.

    severity: an error fails the plan.
    limit: the property that was checked. E.g. `"rate"`.
    axis: its name; null when it is no single axis's. E.g. `"alpha"`.
    at: time of the finding; UTC, null when it has no time. E.g. `"2015-02-27T17:36:10.000Z"`.
    detail: the finding in words. E.g. `"alpha reaches 3.1 deg/s, 0.1 deg/s past its limit of 3
    deg/s"`.
    """

    severity: Literal["error", "warning"]
    limit: str
    axis: str | None
    at: str | None
    detail: str


@dataclass(frozen=True, kw_only=True)
class VerificationOut:
    """The verdict of a judge that shares no code with the planner's geometry and solver.

    passed: true when the table may be flown.
    findings: faults, and what is worth knowing.
    taken_as_given: inputs that the verification did not derive for itself.
    """

    passed: bool
    findings: list[FindingOut]
    taken_as_given: list[str]


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
    summary: PlanSummaryOut
    segments: list[SegmentOut]
    margins: dict[str, dict[str, MarginOut]]
    keep_out: list[KeepOutMarginOut]
    masks: list[MaskMarginOut]
    pointing: list[PointingOut]
    slow_stretches: list[SlowStretchOut]
    uncertainty: list[UncertaintyOut]
    verification: VerificationOut
    comparison: list[SlewComparisonOut]
    horizon_checks: list[HorizonCheckOut]
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
    `["the elements' epoch 2015-02-27T11:40:53Z is 9.0 days from the plan"]`.
    """

    valid: Literal[True]
    flies: bool
    name: str
    platform: str
    sessions: Count
    rows: Count
    warnings: list[str]
    provenance: ProvenanceOut


def plan_json(
    plan: "Plan", provenance: ProvenanceOut, checks: Sequence[HorizonCheckOut] = ()
) -> bytes:
    """The whole answer as UTF-8 JSON, under a new id."""
    document = plan_document(plan, checks, provenance)
    return whole_answer(new_head(verdict_state(plan)), document, table_json(plan.table))


def dry_run_json(plan: "Plan", provenance: ProvenanceOut) -> bytes:
    """A DryRunResponse as UTF-8 JSON."""
    return to_json(
        DryRunResponse(
            valid=True,
            flies=plan.verification.passed,
            name=plan.scenario.name,
            platform=plan.scenario.platform.name,
            sessions=len(plan.scenario.sessions),
            rows=len(plan.table.angle_rad),
            warnings=list(plan.warnings),
            provenance=provenance,
        )
    )


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


def verdict_state(plan: "Plan") -> Literal["done", "failed"]:
    """Whether the judge passed it."""
    return "done" if plan.verification.passed else "failed"


def table_json(table: CommandTable) -> bytes:
    """The table as the answer holds it."""
    return to_json(table_out(table))


def plan_document(
    plan: "Plan", checks: Sequence[HorizonCheckOut], provenance: ProvenanceOut
) -> bytes:
    """A PlanDocument as UTF-8 JSON."""
    report = plan.verification
    return to_json(
        PlanDocument(
            name=plan.scenario.name,
            platform=plan.scenario.platform.name,
            summary=summary_out(plan),
            segments=[_segment(segment) for segment in plan.segments],
            margins=margins_out(report.limits),
            keep_out=[keep_out_margin_out(margin) for margin in report.keep_out],
            masks=[mask_margin_out(margin) for margin in report.masks],
            pointing=[pointing_out(session) for session in report.sessions],
            slow_stretches=[fill(SlowStretchOut, slow) for slow in report.slow_stretches],
            uncertainty=[
                fill(UncertaintyOut, budget, session=session)
                for session, budget in enumerate(plan.budgets)
                if budget is not None
            ],
            verification=fill(
                VerificationOut,
                report,
                findings=[fill(FindingOut, finding) for finding in report.findings],
            ),
            comparison=[
                comparison_out(run.session, run.comparison)
                for run in plan.slews
                if run.comparison is not None
            ],
            horizon_checks=list(checks),
            solver=solver_out(plan),
            warnings=list(plan.warnings),
            assumed=list(plan.scenario.assumed),
            provenance=provenance,
        )
    )


def table_out(table: CommandTable) -> TableOut:
    """The table in degrees, rounded to 1e-9."""
    columns: dict[str, Any] = {}
    for column, axis in enumerate(table.axis_names):
        columns[f"{axis}_deg"] = degrees_of(table.angle_rad[:, column])
    for column, axis in enumerate(table.axis_names):
        columns[f"{axis}_rate_deg_s"] = degrees_of(table.rate_rad_s[:, column])
    # Constructed without validation: 2,000 floats that numpy has just made.
    return TableOut.model_construct(
        epoch=utc_text(table.epoch_utc, 1),
        step_s=COMMAND_STEP_S,
        t_s=table.t_s.tolist(),
        **columns,
    )


def margins_out(limits: tuple[LimitMargin, ...]) -> dict[str, dict[str, MarginOut]]:
    """By axis, then by limit."""
    margins: dict[str, dict[str, MarginOut]] = {}
    for found in limits:
        margins.setdefault(found.axis, {})[found.limit] = MarginOut(
            limit=degrees(found.limit_value),
            extreme=degrees(found.extreme),
            margin=degrees(found.margin),
            unit=_UNITS[found.limit],
            t_s=round(found.t_s, 6),
            at=utc_text(found.at_utc),
        )
    return margins


def keep_out_margin_out(margin: KeepOutMargin) -> KeepOutMarginOut:
    """In degrees."""
    away_rad = margin.away_min_rad
    return KeepOutMarginOut(
        number=margin.number,
        about=margin.about,
        half_angle_deg=degrees(margin.half_angle_rad),
        away_min_deg=None if away_rad is None else degrees(away_rad),
        margin_deg=None if away_rad is None else degrees(away_rad - margin.half_angle_rad),
        at=None if away_rad is None else utc_text(margin.at_utc),
    )


def _segment(segment: Segment) -> SegmentOut:
    return fill(
        SegmentOut,
        segment,
        start=utc_text(segment.start_utc, 1),
        stop=utc_text(segment.stop_utc, 1),
    )
