"""The answer to a plan: degrees, UTC text and plain numbers."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict

from app.answers.comparison import SlewComparisonOut, comparison_out
from app.answers.horizon_view import HorizonCheckOut
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
from planner.commands import COMMAND_STEP_S, CommandTable
from planner.errors import Unverified
from planner.export import Segment, SegmentKind
from planner.frames.time_scales import utc_text
from planner.sessions.plan import Plan
from planner.verification import Finding, LimitMargin
from planner.verification.report import KeepOutMargin

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
    """A stretch of the table: at rest, on the way to a session's target, or tracking it.

    brake: moving axes are brought to rest, to wait.  session: null on the way to the final state.
    """

    kind: SegmentKind
    session: int | None
    start: str
    stop: str


class TableOut(BaseModel):
    """The command table, one array per column.

    Per axis NAME of the platform two more: `NAME_deg` and `NAME_rate_deg_s` (for `iss-hrc`
    `alpha_deg`, `beta_deg`, `alpha_rate_deg_s`, `beta_rate_deg_s`).  Between rows the
    platform flies the cubic Hermite of two rows.
    """

    model_config = ConfigDict(extra="allow", frozen=True)
    __pydantic_extra__: dict[str, list[float]]

    epoch: str
    step_s: float
    t_s: list[float]


@dataclass(frozen=True, kw_only=True)
class MarginOut:
    """The closest an axis comes to a limit, anywhere on or between rows; negative when broken.

    acceleration_jump: the step of the acceleration from one 0.2 s cell to the next.
    """

    limit: float
    extreme: float
    margin: float
    unit: str
    t_s: float
    at: str


@dataclass(frozen=True, kw_only=True)
class KeepOutMarginOut:
    """How near the boresight comes to the axis of one cone of `slew.keep_out`, by its number.

    away_min_deg, margin_deg, at: null when the cone never counts (the Earth hides its body).
    """

    number: int
    about: str
    half_angle_deg: float
    away_min_deg: float | None
    margin_deg: float | None
    at: str | None


@dataclass(frozen=True, kw_only=True)
class FindingOut:
    """One thing the verification found wrong or worth knowing."""

    severity: Literal["error", "warning"]
    limit: str
    axis: str | None
    at: str | None
    detail: str


@dataclass(frozen=True, kw_only=True)
class VerificationOut:
    """The verdict of a judge that shares no code with the planner's geometry and solver."""

    passed: bool
    findings: list[FindingOut]
    taken_as_given: list[str]


@dataclass(frozen=True, kw_only=True)
class SlewRunOut:
    """How one slew was solved; minimum_s is the least time the limits allow.

    session: null for the slew to the final state.
    """

    session: int | None
    backend: str
    status: str
    iterations: int
    wall_s: float
    duration_s: float
    minimum_s: float


@dataclass(frozen=True, kw_only=True)
class SolverOut:
    """All slews together, then one by one; stages_wall_s is the time of the whole plan."""

    backend: str
    status: str
    iterations: int
    wall_s: float
    slews: list[SlewRunOut]
    stages_wall_s: dict[str, float]


@dataclass(frozen=True, kw_only=True)
class PlanDocument:
    """What is known of a plan beside its table.

    slow_stretches: outside of the sessions, so on slews; those of a session are in `pointing`.
    """

    name: str
    platform: str
    segments: list[SegmentOut]
    margins: dict[str, dict[str, MarginOut]]
    keep_out: list[KeepOutMarginOut]
    pointing: list[PointingOut]
    slow_stretches: list[SlowStretchOut]
    uncertainty: list[UncertaintyOut]
    verification: VerificationOut
    comparison: list[SlewComparisonOut]
    horizon_checks: list[HorizonCheckOut]
    solver: SolverOut
    warnings: list[str]
    provenance: ProvenanceOut


@dataclass(frozen=True, kw_only=True)
class PlanResponse(PlanHead, PlanDocument):
    """A plan and the judge's verdict on it.

    state: `done` when the verification passed.  `failed` when it did not, which only the
    baseline `spline` can answer: its table is for comparison, never for flight.
    margins: by axis, then by limit.  uncertainty: of every session that looks at a target.
    """

    table: TableOut


@dataclass(frozen=True, kw_only=True)
class DryRunResponse:
    """The request can be read; nothing was planned."""

    valid: Literal[True]
    name: str
    platform: str
    sessions: int
    provenance: ProvenanceOut


def plan_json(
    plan: Plan, provenance: ProvenanceOut, checks: Sequence[HorizonCheckOut] = ()
) -> bytes:
    """The whole answer as UTF-8 JSON, under a new id."""
    document = plan_document(plan, checks, provenance)
    return whole_answer(new_head(verdict_state(plan)), document, table_json(plan.table))


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


def verdict_state(plan: Plan) -> Literal["done", "failed"]:
    """Whether the judge passed it."""
    return "done" if plan.verification.passed else "failed"


def table_json(table: CommandTable) -> bytes:
    """The table as the answer holds it."""
    return to_json(table_out(table))


def plan_document(
    plan: Plan, checks: Sequence[HorizonCheckOut], provenance: ProvenanceOut
) -> bytes:
    """A PlanDocument as UTF-8 JSON."""
    report = plan.verification
    return to_json(
        PlanDocument(
            name=plan.scenario.name,
            platform=plan.scenario.platform.name,
            segments=[_segment(segment) for segment in plan.segments],
            margins=margins_out(report.limits),
            keep_out=[keep_out_margin_out(margin) for margin in report.keep_out],
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
            solver=_solver(plan),
            warnings=list(plan.warnings),
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


def _solver(plan: Plan) -> SolverOut:
    runs = plan.slews
    return SolverOut(
        backend=" ".join(dict.fromkeys(run.backend for run in runs)),
        status=" ".join(dict.fromkeys(run.status for run in runs)),
        iterations=sum(run.iterations for run in runs),
        wall_s=sum(run.wall_s for run in runs),
        slews=[fill(SlewRunOut, run) for run in runs],
        stages_wall_s=dict(plan.stage_wall_s),
    )
