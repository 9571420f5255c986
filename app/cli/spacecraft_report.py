"""The summary of an imaging session on the terminal."""

import math

from rich.console import Console
from rich.table import Table
from rich.text import Text

from app.answers.spacecraft import row_text
from app.cli.report_parts import print_table, print_warnings, report_table
from planner.spacecraft.plan import ImagingPlan
from planner.spacecraft.slews.slew_choice import AttitudeSlewComparison


def print_session(console: Console, plan: ImagingPlan) -> None:
    """Windows with how steady they were, slews, what is left out, limits, the verdict."""
    console.print(
        Text.assemble(
            (plan.request.name or "Session", "bold"),
            f", {plan.spacecraft.name}: {len(plan.table.t_s)} rows from "
            f"{row_text(plan.table, 0)}, worth {plan.choice.value:g} (best found; "
            f"by priority alone {plan.choice.greedy_value:g})",
        ),
    )
    for part in (_windows(plan), _turns(plan)):
        print_table(console, part)
    for one in plan.left_out:
        console.print(Text(f"left out: {one.name}: {one.reason}", style="yellow"))
    found = plan.verification
    console.print(
        f"torque {found.torque_max_n_m:.1f} N m, momentum {found.momentum_max_n_m_s:.1f} of "
        f"{plan.spacecraft.slew.momentum_sphere_n_m_s:.0f} N m s, gimbals "
        f"{found.gimbal_rate_max_deg_s:.1f} deg/s"
    )
    if plan.stabilisation.share_steady is not None:
        console.print(
            f"steady within 0.001 deg/s in {plan.stabilisation.share_steady:.0%} of the intervals "
            f"of {plan.stabilisation.runs} closed-loop runs"
        )
    print_warnings(console, plan.warnings)
    console.print(Text("verification passed", style="green"))


def _windows(plan: ImagingPlan) -> Table:
    table = report_table(
        "imaging", "<request", "look", "<start", "<stop", "across", "along", "deg/s off", "smear px"
    )
    steadiness = plan.stabilisation.windows or [None] * len(plan.verification.windows)
    for seen, steady in zip(plan.verification.windows, steadiness, strict=True):
        table.add_row(
            Text(seen.request),
            str(seen.look),
            row_text(plan.table, seen.first_row)[11:-1],
            row_text(plan.table, seen.last_row)[11:-1],
            f"{seen.across_deg:.1f}",
            f"{seen.along_deg:.1f}",
            "-" if steady is None else f"{math.degrees(max(steady.rate_error_rad_s)):.5f}",
            "-" if steady is None else f"{steady.smear_px:.3f}",
        )
    return table


def _made_by(slew: AttitudeSlewComparison) -> str:
    if slew.time_from in (None, slew.method):
        return slew.method
    return f"{slew.method}, in the quickest {slew.time_from}'s time"


def _turns(plan: ImagingPlan) -> Table:
    table = report_table(
        "slews", "<start", "deg", "seconds", "eigenaxis", "<by", "Nm/s", "eigenaxis"
    )
    for slew in plan.slews:
        compared = slew.comparison
        table.add_row(
            row_text(plan.table, slew.first_row)[11:-1],
            f"{math.degrees(compared.angle_rad):.1f}",
            f"{compared.duration_s:.1f}",
            f"{compared.eigenaxis_s:.1f}",
            _made_by(compared),
            f"{compared.torque_rate_peak_n_m_s:.1f}",
            f"{compared.eigenaxis_torque_rate_peak_n_m_s:.1f}",
        )
    return table
