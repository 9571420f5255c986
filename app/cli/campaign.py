"""`slewtrack campaign`: a campaign is chosen, planned pass by pass and reported."""

import json
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table
from rich.text import Text

from app.cli.progress_bar import progress_bar, reported_work
from app.cli.report_parts import print_assumed, print_table, print_warnings, report_table
from app.store.packed import NewPlan
from app.work.campaign import NewCampaign, Part, choose, without_refused
from app.work.plan import plan_and_pack, stored_table_json
from planner.base.csv_cells import csv_lines
from planner.base.errors import Refusal
from planner.base.told import told_names
from planner.planning.campaigns.chosen import ChosenLook

SHOWN_MAX = 100
_COLUMNS = tuple(told_names(ChosenLook).values())


@dataclass(frozen=True, kw_only=True)
class PlannedPass:
    """A pass with its plan; None where it was not wanted, or where no look can be flown: why."""

    part: Part
    plan: NewPlan | None
    refusal: str | None


def run_campaign(body: bytes, *, plans_too: bool) -> tuple[NewCampaign, list[PlannedPass]]:
    """Choose and plan, with a bar on a terminal; raises a Refusal of the request."""
    with reported_work("opportunities"):
        choice = choose(body)
    if not plans_too:
        return choice, [PlannedPass(part=part, plan=None, refusal=None) for part in choice.parts]
    with progress_bar("plans") as tell:
        passes: list[PlannedPass] = []
        for part in choice.parts:
            tell("plans", len(passes), len(choice.parts))
            passes.append(_plan_pass(part))
    return choice, passes


def _plan_pass(part: Part) -> PlannedPass:
    """The pass, without what can't be flown of it."""
    while True:
        try:
            return PlannedPass(part=part, plan=plan_and_pack(part.request), refusal=None)
        except Refusal as refusal:
            repaired = without_refused(part, refusal.field, refusal.detail)
            if repaired is None:
                return PlannedPass(part=part, plan=None, refusal=refusal.detail)
            part = repaired


def print_campaign(console: Console, document: dict[str, Any], passes: list[PlannedPass]) -> None:
    """What was chosen and how far from the best that can be; a line per look."""
    looks = sum(len(one.part.facts["looks"]) for one in passes if not one.refusal)
    planned = sum(not one.refusal for one in passes)
    console.print(
        Text.assemble(
            (f"{looks} looks", "bold"),
            f" in {planned} passes, worth {document['value']:.6g}; at most "
            f"{document['bound']:.6g} can be had, {document['gap_share']:.2%} more; taking each "
            f"pass by itself {document['greedy_value']:.6g}",
        )
    )
    print_assumed(console, ((one["field"], one["detail"]) for one in document["assumed"]))
    print_table(console, _table(passes))
    for name, meaning in (("unseen", "can't be seen"), ("left_out", "left out for others")):
        told = document[name]
        for one in told[:SHOWN_MAX]:
            console.print(Text(f"{meaning}: {one['target']}, {one['because']}{_highest(one)}"))
        if len(told) > SHOWN_MAX:
            console.print(Text(f"and {len(told) - SHOWN_MAX} more: see --json"))
    for one in passes:
        print_warnings(console, _losses(one))
    print_warnings(console, document["warnings"])


def _highest(one: dict[str, Any]) -> str:
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


def _table(passes: list[PlannedPass]) -> Table:
    table = report_table(
        None, "<pass", "<target", "<start", "<stop", "<value", "quality", "elev deg"
    )
    rows = [(one.part.facts["pass"], look) for one in passes for look in one.part.facts["looks"]]
    for number, look in rows[:SHOWN_MAX]:
        table.add_row(
            str(number),
            Text(look["target"]),
            look["start"][:10] + " " + look["start"][11:21],
            look["stop"][11:21],
            f"{look['value']:.4g}",
            f"{look['quality']:.2f}",
            f"{look['elevation_deg']:.1f}",
        )
    if len(rows) > SHOWN_MAX:
        table.add_row("", f"and {len(rows) - SHOWN_MAX} more: see --csv or --json")
    return table


def campaign_csv(passes: list[PlannedPass]) -> str:
    """One line per look of the plans made."""
    rows = (
        [one.part.facts["pass"], *(look[name] for name in _COLUMNS)]
        for one in passes
        if one.plan
        for look in one.part.facts["looks"]
    )
    return csv_lines([["pass", *_COLUMNS], *rows])


def campaign_json(document: bytes, passes: list[PlannedPass]) -> bytes:
    """What was chosen, with `passes` as a service tells them, but for where their plans are."""
    told = [
        {
            **{name: one.part.facts[name] for name in ("start", "stop", "looks", "left_out")},
            "number": one.part.facts["pass"],
            "state": "refused" if one.plan is None else one.plan.state,
        }
        for one in passes
    ]
    return json.dumps(json.loads(document) | {"passes": told}).encode()


def write_plans(folder: Path, passes: list[PlannedPass]) -> None:
    """pass-N.json: each plan with its table; pass-N-request.json: what it was planned from."""
    folder.mkdir(parents=True, exist_ok=True)
    for one in passes:
        if one.plan is None:
            continue
        stem = f"pass-{one.part.facts['pass']}"
        document = zlib.decompress(one.plan.document)
        table = stored_table_json(one.plan.table_columns)
        whole = b"".join([document.rstrip()[:-1], b',"table":', table, b"}"])
        (folder / f"{stem}.json").write_bytes(whole)
        (folder / f"{stem}-request.json").write_bytes(one.part.request)
