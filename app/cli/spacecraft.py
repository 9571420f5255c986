"""`slewtrack spacecraft`: an imaging session is planned and reported."""

from rich.console import Console
from rich.text import Text

from app.cli import files
from app.cli.plan import say_whether_it_flies
from app.cli.planner import Members, planner_at, told_progress
from app.cli.report_parts import print_rows, print_warnings


def spacecraft(
    file: files.RequestFile,
    csv: files.TableCsv = None,
    export: files.Exports = None,
    json: files.WholeAnswer = None,
    dry_run: files.DryRun = False,
    settings: files.Settings = None,
    url: files.Url = None,
) -> None:
    """Plan an imaging session of the CMG spacecraft and report."""
    with files.report_beside(json, csv, exports=export) as console:
        body = files.read_request(file, settings)
        from app.requests.spacecraft import read_spacecraft_request
        from planner.output.export import EXPORTERS

        exports = files.formats_and_paths(export, EXPORTERS)
        asked = read_spacecraft_request(body)
        with planner_at(url) as planner, told_progress("planning") as tell:
            if dry_run:
                say_whether_it_flies(console, planner.spacecraft.check(body))
                return
            made = planner.spacecraft.plan(body, progress=tell)
            print_session(console, made.members, asked.definition().gyros.turns.momentum_max_n_m_s)
            if url is not None:
                console.print(f"kept as {made.id}")
            files.write_json(json, made.members)
            if csv:
                files.write(csv, files.table_only(planner.spacecraft.export(made.id, "csv")))
            for name, path in exports:
                files.write(path, planner.spacecraft.export(made.id, name))


def print_session(console: Console, plan: Members, momentum_sphere_n_m_s: float) -> None:
    """Windows with how steady they were, slews, what is left out, limits, the verdict."""
    table, choice, found = plan["table"], plan["choice"], plan["verification"]
    console.print(
        Text.assemble(
            (plan["name"] or "Session", "bold"),
            f", {plan['spacecraft']}: {len(table['t_s'])} rows from {table['epoch']}, worth "
            f"{choice['value']:g} of at most {choice['bound']:g} (by priority alone "
            f"{choice['greedy_value']:g})",
        ),
    )
    stabilisation = plan["stabilisation"]
    steadiness = stabilisation["windows"] or [{}] * len(plan["windows"])
    print_rows(
        console, "imaging",
        (one | flown for one, flown in zip(plan["windows"], steadiness, strict=True)),
        ("<request", "request"), ("look", "look"), ("<start", "start", lambda utc: utc[11:-1]),
        ("<stop", "stop", lambda utc: utc[11:-1]), ("across", "across_deg", ".1f"),
        ("along", "along_deg", ".1f"),
        ("deg/s off", lambda one: max(one.get("rate_error_deg_s", ()), default=None), ".5f"),
        ("smear px", lambda one: one.get("smear_px"), ".3f"),
    )  # fmt: skip
    print_rows(
        console, "slews", plan["slews"],
        ("<start", "start", lambda utc: utc[11:-1]), ("deg", "angle_deg", ".1f"),
        ("seconds", "duration_s", ".1f"), ("eigenaxis", "eigenaxis_s", ".1f"), ("<by", "method"),
        ("Nm/s", "torque_rate_peak_n_m_s", ".1f"),
        ("eigenaxis", "eigenaxis_torque_rate_peak_n_m_s", ".1f"),
    )  # fmt: skip
    for one in plan["left_out"]:
        console.print(Text(f"left out: {one['name']}: {one['reason']}", style="yellow"))
    console.print(
        f"torque {found['torque_max_n_m']:.1f} N m, momentum {found['momentum_max_n_m_s']:.1f} of "
        f"{momentum_sphere_n_m_s:.0f} N m s, gimbals {found['gimbal_rate_max_deg_s']:.1f} deg/s"
    )
    if stabilisation["share_steady"] is not None:
        console.print(
            f"steady within 0.001 deg/s in {stabilisation['share_steady']:.0%} of the intervals "
            f"of {stabilisation['runs']} closed-loop runs"
        )
    print_warnings(console, plan["warnings"])
    console.print(Text("verification passed", style="green"))
