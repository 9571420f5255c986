"""Campaigns on the command line: chosen, planned pass by pass, reported."""

import csv
import io
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table
from rich.text import Text

from app.cli.report_parts import print_warnings
from app.store.packed import NewPlan
from app.work import progress
from app.work.campaign import NewCampaign, Part, choose, without_refused
from app.work.plan import plan_and_pack, stored_table_json
from planner.errors import Refusal

SHOWN_MAX = 100


@dataclass(frozen=True, kw_only=True)
class PlannedPass:
    """A pass with its plan; None where no look of it can be flown, and then why."""

    part: Part
    plan: NewPlan | None
    refusal: str | None


def run_campaign(body: bytes) -> tuple[NewCampaign, list[PlannedPass]]:
    """Choose and plan, with a bar on a terminal; raises a Refusal of the request."""
    with _bar() as bar:
        task = bar.add_task("opportunities", total=None)
        progress.report_through(
            lambda told: bar.update(
                task, description=told.stage, completed=told.done or 0, total=told.of
            )
        )
        chosen = choose(body)
        progress.report_through(lambda _: None)
        bar.update(task, description="plans", completed=0, total=len(chosen.parts))
        flown = []
        for part in chosen.parts:
            flown.append(_plan_pass(part))
            bar.advance(task)
    return chosen, flown


@contextmanager
def _bar() -> Iterator[Progress]:
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
    )
    console = Console(stderr=True)
    off = not console.is_terminal  # where it would leave an empty line
    with Progress(*columns, console=console, transient=True, disable=off) as bar:
        yield bar


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


def print_campaign(told: dict[str, object], flown: list[PlannedPass]) -> None:
    """What was chosen and how far from the best that can be; a line per look."""
    console = Console(highlight=False)
    looks = sum(len(one.part.told["looks"]) for one in flown if one.plan)
    console.print(
        Text.assemble(
            (f"{looks} looks", "bold"),
            f" in {sum(one.plan is not None for one in flown)} passes, worth {told['value']:.6g}; "
            f"at most {told['bound']:.6g} can be had, {told['gap_share']:.2%} more; taking each "
            f"pass by itself {told['greedy_value']:.6g}",
        )
    )
    if flown:
        console.print(_table(flown))
    for name, meaning in (("unseen", "can't be seen"), ("left_out", "left out for others")):
        ids = told[name]
        assert isinstance(ids, list)
        if ids:
            console.print(Text(f"{meaning}: {', '.join(ids[:SHOWN_MAX])}"))
    for one in flown:
        print_warnings(console, _losses(one))
    warnings = told["warnings"]
    assert isinstance(warnings, list)
    print_warnings(console, warnings)


def _losses(one: PlannedPass) -> Iterator[str]:
    for left_out in one.part.told["left_out"]:
        yield (
            f"pass {one.part.told['pass']}: {left_out['target']} was left out, "
            f"{left_out['because']}"
        )
    if one.refusal is not None:
        yield f"pass {one.part.told['pass']} can't be flown: {one.refusal}"


def _table(flown: list[PlannedPass]) -> Table:
    table = Table(box=None, pad_edge=False)
    for heading in ("pass", "target", "start", "stop", "value"):
        table.add_column(heading, no_wrap=True)
    rows = [(one.part.told["pass"], look) for one in flown for look in one.part.told["looks"]]
    for number, look in rows[:SHOWN_MAX]:
        table.add_row(
            str(number),
            Text(look["target"]),
            look["start"][:10] + " " + look["start"][11:-1],
            look["stop"][11:-1],
            f"{look['value']:.4g}",
        )
    if len(rows) > SHOWN_MAX:
        table.add_row("", f"and {len(rows) - SHOWN_MAX} more: see --csv or --json")
    return table


def campaign_csv(flown: list[PlannedPass]) -> str:
    """One line per look of the plans made."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["pass", "target", "start", "stop", "value"])
    for one in flown:
        for look in one.part.told["looks"] if one.plan else ():
            columns = (look[name] for name in ("target", "start", "stop", "value"))
            writer.writerow([one.part.told["pass"], *columns])
    return text.getvalue()


def write_plans(folder: Path, flown: list[PlannedPass]) -> None:
    """pass-N.json: each plan with its table; pass-N-request.json: what it was planned from."""
    folder.mkdir(parents=True, exist_ok=True)
    for one in flown:
        if one.plan is None:
            continue
        stem = f"pass-{one.part.told['pass']}"
        document = zlib.decompress(one.plan.document)
        table = stored_table_json(one.plan.table_columns)
        whole = b"".join([document.rstrip()[:-1], b',"table":', table, b"}"])
        (folder / f"{stem}.json").write_bytes(whole)
        (folder / f"{stem}-request.json").write_bytes(one.part.request)
