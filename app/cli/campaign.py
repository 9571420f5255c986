"""`slewtrack campaign`: a campaign is chosen, planned pass by pass and reported."""

import json as json_text
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.text import Text

from app.cli.files import RequestFile, problem_to, read_request, takes_standard_output, write
from app.cli.planner import Members
from app.cli.progress_bar import progress_bar, reported_work
from app.cli.report_parts import (
    SHOWN_MAX,
    print_assumed,
    print_more,
    print_rows,
    print_warnings,
    report_console,
)
from app.work.result import Part, Result
from planner.base.errors import Refusal


@dataclass(frozen=True, kw_only=True)
class PlannedPass:
    """A pass with its plan; None where it was not wanted, or where no look can be flown: why."""

    part: Part
    plan: Result | None
    refusal: str | None


def campaign(
    file: RequestFile,
    plans: Annotated[
        Path | None, typer.Option(help="Write each pass's plan and its request into this folder.")
    ] = None,
    csv: Annotated[Path | None, typer.Option(help="Write one line per look here.")] = None,
    json: Annotated[
        Path | None,
        typer.Option(help="Write the choice, its bound, and each pass with its looks here."),
    ] = None,
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Only choose; plan and write nothing.")
    ] = False,
) -> None:
    """Choose and plan sessions of many targets over days."""
    from app.work.campaign_files import looks_csv

    with problem_to(json):
        console = report_console(to_stderr=takes_standard_output(csv, json))
        body, _ = read_request(file)
        choice, passes = run_campaign(body, plans_too=not dry_run)
        print_campaign(console, choice, passes)
        if dry_run:
            return
        if plans:
            write_plans(plans, passes)
        if csv:
            made = (one.part.facts for one in passes if one.plan)
            looks = ((facts["pass"], look) for facts in made for look in facts["looks"])
            write(csv, looks_csv(looks).encode())
        if json:
            write(json, campaign_json(choice, passes))


def run_campaign(body: bytes, *, plans_too: bool) -> tuple[Members, list[PlannedPass]]:
    """Choose and plan, with a bar on a terminal; raises a Refusal of the request."""
    from app.store.packed import unzip
    from app.work.campaign import choose

    with reported_work("opportunities"):
        chosen = choose(body)
    passes: list[PlannedPass] = []
    with progress_bar("plans") as tell:
        for part in chosen.parts:
            tell("plans", len(passes), len(chosen.parts))
            unplanned = PlannedPass(part=part, plan=None, refusal=None)
            passes.append(_plan_pass(part) if plans_too else unplanned)
    return json_text.loads(unzip(chosen.document)), passes


def _plan_pass(part: Part) -> PlannedPass:
    """The pass, without what can't be flown of it."""
    from app.work.campaign import without_refused
    from app.work.plan import plan_and_pack

    while True:
        try:
            return PlannedPass(part=part, plan=plan_and_pack(part.request), refusal=None)
        except Refusal as refusal:
            repaired = without_refused(part, refusal.field, refusal.detail)
            if repaired is None:
                return PlannedPass(part=part, plan=None, refusal=refusal.detail)
            part = repaired


def print_campaign(console: Console, document: Members, passes: Sequence[PlannedPass]) -> None:
    """What was chosen and how far from the best that can be; a line per look."""
    looks = [
        {"pass": str(one.part.facts["pass"]), **look}
        for one in passes
        for look in one.part.facts["looks"]
    ]
    planned = [one for one in passes if not one.refusal]
    console.print(
        Text.assemble(
            (f"{sum(len(one.part.facts['looks']) for one in planned)} looks", "bold"),
            f" in {len(planned)} passes, worth {document['value']:.6g}; at most "
            f"{document['bound']:.6g} can be had, {document['gap_share']:.2%} more; taking each "
            f"pass by itself {document['greedy_value']:.6g}",
        )
    )
    print_assumed(console, document["assumed"])
    print_rows(
        console, None, looks[:SHOWN_MAX],
        ("<pass", "pass"), ("<target", "target"),
        ("<start", lambda look: f"{look['start'][:10]} {look['start'][11:21]}"),
        ("<stop", lambda look: look["stop"][11:21]), ("<value", "value", ".4g"),
        ("quality", "quality", ".2f"), ("elev deg", "elevation_deg", ".1f"),
    )  # fmt: skip
    print_more(console, len(looks))
    for name, meaning in (("unseen", "can't be seen"), ("left_out", "left out for others")):
        told = document[name]
        for one in told[:SHOWN_MAX]:
            console.print(Text(f"{meaning}: {one['target']}, {one['because']}{_highest(one)}"))
        print_more(console, len(told), "--json")
    for planned_pass in passes:
        print_warnings(console, _losses(planned_pass))
    print_warnings(console, document["warnings"])


def _highest(one: Members) -> str:
    if "best_elevation_deg" not in one:
        return ""
    when = one["best_time"][:16].replace("T", " ")
    return f" (at most {one['best_elevation_deg']:.1f} deg high, {when})"


def _losses(one: PlannedPass) -> Iterator[str]:
    for left_out in one.part.facts["left_out"]:
        yield (
            f"pass {one.part.facts['pass']}: {left_out['target']} was left out, "
            f"{left_out['because']}"
        )
    if one.refusal is not None:
        yield f"pass {one.part.facts['pass']} can't be flown: {one.refusal}"


def campaign_json(document: Members, passes: list[PlannedPass]) -> bytes:
    """What was chosen, with `passes` as a service tells them, but for where their plans are."""
    told = [
        {
            **{name: one.part.facts[name] for name in ("start", "stop", "looks", "left_out")},
            "number": one.part.facts["pass"],
            "state": "refused" if one.plan is None else one.plan.state,
        }
        for one in passes
    ]
    return json_text.dumps({**document, "passes": told}).encode()


def write_plans(folder: Path, passes: list[PlannedPass]) -> None:
    """pass-N.json: each plan with its table; pass-N-request.json: what it was planned from."""
    from app.store.packed import unzip
    from app.work.plan import stored_table_json

    folder.mkdir(parents=True, exist_ok=True)
    for one in passes:
        if one.plan is None:
            continue
        stem = f"pass-{one.part.facts['pass']}"
        document = unzip(one.plan.document)
        table = stored_table_json(one.plan.table_columns)
        whole = b"".join([document.rstrip()[:-1], b',"table":', table, b"}"])
        (folder / f"{stem}.json").write_bytes(whole)
        (folder / f"{stem}-request.json").write_bytes(one.part.request)
