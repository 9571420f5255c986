"""The summary of a plan on the terminal."""

from rich.console import Console
from rich.table import Table
from rich.text import Text

from app.answers.comparison import comparison_out
from app.answers.masks import mask_margin_out
from app.answers.plan import keep_out_margin_out, margins_out
from app.answers.pointing import ARCSEC_PER_RAD, PointingOut, pointing_out
from app.cli.report_parts import or_dash, print_warnings, report_table
from planner.frames.time_scales import elapsed_s, utc_text
from planner.sessions.plan import Plan


def print_report(plan: Plan) -> None:
    """Segments, pointing error, margins, the optimal slew against the spline, warnings."""
    console = Console(highlight=False)
    table = plan.table
    total_ms = 1e3 * sum(plan.stage_wall_s.values())
    console.print(
        Text.assemble(
            (plan.scenario.name or "Plan", "bold"),
            f", {plan.scenario.platform.name}: {len(table.angle_rad)} rows from ",
            f"{utc_text(table.epoch_utc, 1)}, planned in {total_ms:.0f} ms",
        )
    )
    pointing = [pointing_out(session) for session in plan.verification.sessions]
    parts = (
        _segments(plan),
        _pointing(pointing),
        _uncertainty(plan),
        _margins(plan),
        _keep_out(plan),
        _masks(plan),
        _comparison(plan),
        _vibration(plan),
    )
    for part in parts:
        if part.row_count:
            console.print(part)
    print_warnings(console, plan.warnings)
    verdict = "passed" if plan.verification.passed else "FAILED"
    console.print(
        Text(f"verification {verdict}", style="green" if plan.verification.passed else "red")
    )


def _segments(plan: Plan) -> Table:
    table = report_table("segments", "<kind", "session", "<start", "<stop", "seconds")
    for segment in plan.segments:
        table.add_row(
            segment.kind,
            _session(segment.session),
            utc_text(segment.start_utc, 1),
            utc_text(segment.stop_utc, 1),
            f"{elapsed_s(segment.stop_utc, segment.start_utc):.1f}",
        )
    return table


def _pointing(pointing: list[PointingOut]) -> Table:
    columns = {
        "session": [str(session.session) for session in pointing],
        "max arcsec": [f"{session.max_arcsec:.3g}" for session in pointing],
        "rms arcsec": [f"{session.rms_arcsec:.3g}" for session in pointing],
        "ground m": [or_dash(session.ground_max_m, ".2g") for session in pointing],
        "least elevation deg": [or_dash(session.elevation_min_deg, ".2f") for session in pointing],
        "least range km": [or_dash(session.range_min_km, ".6g") for session in pointing],
        "above the limb deg": [
            or_dash(session.limb_clearance_min_deg, ".2f") for session in pointing
        ],
    }
    columns = {heading: texts for heading, texts in columns.items() if set(texts) != {"-"}}
    table = report_table("pointing error", *columns)
    for row in zip(*columns.values(), strict=True):
        table.add_row(*row)
    return table


def _uncertainty(plan: Plan) -> Table:
    table = report_table(
        "pointing budget, 1 sigma",
        "session",
        "arcsec",
        "ground m",
        "stays in the frame",
        "<most of it by",
    )
    for number, budget in enumerate(plan.budgets):
        if budget is None:
            continue
        worst = max(budget.contributions, key=lambda part: part.sigma_arcsec)
        table.add_row(
            str(number),
            f"{budget.sigma_arcsec:.0f}",
            or_dash(budget.ground_m, ".0f"),
            f"{budget.probability_in_frame:.1%}",
            worst.cause,
        )
    return table


def _margins(plan: Plan) -> Table:
    table = report_table(
        "least margins", "<axis", "<limit of", "limit", "closest", "margin", "<unit", "<at UTC"
    )
    for axis, margins in margins_out(plan.verification.limits).items():
        for name, margin in margins.items():
            table.add_row(
                axis,
                name,
                f"{margin.limit:.6g}",
                f"{margin.extreme:.6g}",
                f"{margin.margin:.6g}",
                margin.unit,
                margin.at[11:-3],  # to a tenth of a second
                style="red" if margin.margin < 0.0 else None,
            )
    return table


def _keep_out(plan: Plan) -> Table:
    table = report_table(
        "cones to keep out of", "<about", "half angle deg", "closest deg", "<at UTC"
    )
    for cone in map(keep_out_margin_out, plan.verification.keep_out):
        table.add_row(
            Text(cone.about),
            f"{cone.half_angle_deg:g}",
            or_dash(cone.away_min_deg, ".3f"),
            "-" if cone.at is None else cone.at[11:-3],
            style="red" if cone.margin_deg is not None and cone.margin_deg < 0.0 else None,
        )
    return table


def _masks(plan: Plan) -> Table:
    table = report_table("masks to keep out of", "<name", "asked deg", "closest deg", "<at UTC")
    for mask in map(mask_margin_out, plan.verification.masks):
        table.add_row(
            Text(mask.name),
            f"{mask.asked_deg:g}",
            f"{mask.away_min_deg:.3f}",
            mask.at[11:-3],
            style="red" if mask.margin_deg < 0.0 else None,
        )
    return table


def _comparison(plan: Plan) -> Table:
    table = report_table(
        "optimal slew against the spline",
        "<slew",
        "<axis",
        "<by",
        "deg/s",
        "deg/s2",
        "deg/s3",
        "jerk², deg²/s⁵",
        "<breaks",
    )
    for run in plan.slews:
        if run.comparison is None:
            continue
        compared = comparison_out(run.session, run.comparison)
        for axis in run.comparison.axis_names:
            for method, figures in (("ocp", compared.ocp[axis]), ("spline", compared.spline[axis])):
                table.add_row(
                    _session(run.session),
                    axis,
                    method,
                    f"{figures.peak_rate_deg_s:.4f}",
                    f"{figures.peak_acceleration_deg_s2:.4f}",
                    _or_jump(figures.peak_jerk_deg_s3),
                    _or_jump(figures.jerk_squared_integral_deg2_s5),
                    ", ".join(figures.limits_broken) or "-",
                    style="red" if figures.limits_broken else None,
                )
    return table


def _vibration(plan: Plan) -> Table:
    table = report_table(
        "vibration left after the slew", "slew", "<axis", "mode Hz", "ocp arcsec", "spline arcsec"
    )
    for run in plan.slews:
        for residual in run.comparison.residuals if run.comparison else ():
            per_axis = zip(
                plan.table.axis_names, residual.ocp_rad, residual.spline_rad, strict=True
            )
            for axis, ocp_rad, spline_rad in per_axis:
                table.add_row(
                    _session(run.session),
                    axis,
                    f"{residual.mode.frequency_hz:g}",
                    f"{ocp_rad * ARCSEC_PER_RAD:.2g}",
                    f"{spline_rad * ARCSEC_PER_RAD:.2g}",
                )
    return table


def _session(number: int | None) -> str:
    return "final" if number is None else str(number)


def _or_jump(value: float | None) -> str:
    return "jump" if value is None else f"{value:.3g}"
