"""The answer to a plan: degrees, UTC text and plain numbers."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict

from app.answers.members import PlanHead, ProvenanceOut, to_json
from estimator.found import HorizonCheck
from planner.base.answer_members import Count, NotNegative
from planner.base.assumed import Assumed
from planner.base.commands import COMMAND_STEP_S, CommandTable
from planner.base.errors import Unverified
from planner.motion.comparison import SlewComparison
from planner.planning.sessions.budget import PointingBudget
from planner.planning.sessions.plan import Plan, SlewRun
from planner.planning.sessions.summary import PlanSummary, summarise
from planner.verification import Finding, LimitMargin, Reserve, SessionReport, VerificationReport
from planner.verification.report import (
    ExclusionMargin,
    GyroMargin,
    KeepOutMargin,
    MaskMargin,
    SlowStretch,
)
from planner.world.frames.time_scales import utc_text
from planner.world.plan import Segment


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
class SolverOut:
    """The solution of the slews, all together and one by one.

    backend: the methods, as `slew.method` names them.
    status: quality of the slews, as `slews` states it.
    iterations: of Ipopt.
    wall_s: time it took to solve all slews.
    slews: the solution of each slew.
    stages_wall_s: time of each stage of the whole plan.
    """

    backend: str
    status: str
    iterations: Count
    wall_s: NotNegative
    slews: tuple[SlewRun, ...]
    stages_wall_s: dict[str, NotNegative]


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


def dry_run_json(plan: Plan, provenance: ProvenanceOut) -> bytes:
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
    margins: dict[str, dict[str, LimitMargin]] = {}
    for margin in report.limits:
        margins.setdefault(margin.axis, {})[margin.kind] = margin
    return to_json(
        PlanDocument(
            name=plan.scenario.name,
            platform=plan.scenario.platform.name,
            summary=summarise(plan),
            segments=plan.segments,
            margins=margins,
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
            solver=SolverOut(
                backend=" ".join(dict.fromkeys(run.backend for run in plan.slews)),
                status=" ".join(dict.fromkeys(run.status for run in plan.slews)),
                iterations=sum(run.iterations for run in plan.slews),
                wall_s=sum(run.wall_s for run in plan.slews),
                slews=plan.slews,
                stages_wall_s=plan.stage_wall_s,
            ),
            warnings=list(plan.warnings),
            assumed=list(plan.scenario.assumed),
            provenance=provenance,
        )
    )
