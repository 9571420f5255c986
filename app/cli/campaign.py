"""`slewtrack campaign`: a campaign is chosen, planned pass by pass and reported."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, get_args

import typer
from rich.console import Console
from rich.text import Text

from app.cli import files
from app.cli import report_parts as parts
from app.cli.planner import Members, planner_at, told_progress
from app.requests.json_reader import json_document
from planner.base.errors import InvalidInput

if TYPE_CHECKING:
    from app.cli.local import Local
    from app.cli.service import TellingClient


def campaign(
    file: files.RequestFile,
    plans: Annotated[
        Path | None, typer.Option(help="Write each pass's plan and its request into this folder.")
    ] = None,
    csv: Annotated[Path | None, typer.Option(help="Write one line per look here.")] = None,
    json: Annotated[
        Path | None,
        typer.Option(help="Write the choice, its bound, and each pass with its looks here."),
    ] = None,
    export: Annotated[
        list[str] | None,
        typer.Option(
            metavar="FORMAT=PATH",
            help="Write the looks as csv, geojson or kml, or each pass's table and request as a "
            "zip archive (may be repeated).",
        ),
    ] = None,
    revises: Annotated[
        str | None,
        typer.Option(
            metavar="CAMPAIGN",
            help="Revise this campaign: a file that --json wrote, or the id of one that the "
            "service of --url keeps.",
        ),
    ] = None,
    frozen_until: Annotated[
        str | None,
        typer.Option(
            metavar="TIME",
            help="Keep passes that begin before it as --revises chose them; UTC.",
        ),
    ] = None,
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Only choose; plan and write nothing.")
    ] = False,
    settings: files.Settings = None,
    url: files.Url = None,
) -> None:
    """Choose and plan sessions of many targets over days."""
    from app.work.campaign import looks_csv, plans_that_stay, require_both
    from slewtrack.client.calls import CAMPAIGN_FILES

    with files.report_beside(json, csv, exports=export) as console:
        wanted = files.formats_and_paths(export, CAMPAIGN_FILES)
        body = files.read_request(file, settings)
        flags = "--revises", "--frozen-until"
        require_both(revises, frozen_until, flags, flags)
        before: Sequence[Members] = ()
        if revises is not None and (url is None or Path(revises).exists()):
            body, before = _revised_by(body, frozen_until, Path(revises))
            revises = frozen_until = None
        elif revises is not None and csv:  # which the service has whole
            wanted, csv = [*wanted, ("csv", csv)], None
        if dry_run and url is not None:
            raise InvalidInput(
                "a service plans what it chooses: leave out --url, or --dry-run", field="--dry-run"
            )
        if dry_run:
            from app.cli.local import chosen

            with told_progress("opportunities") as tell:
                found = chosen(body, tell)
            print_campaign(console, **found)
            return
        with planner_at(url) as planner:
            with told_progress("opportunities") as tell:
                made = planner.campaign(
                    body, revises=revises, frozen_until=frozen_until, progress=tell
                )
            choice, passes = made.members["choice"], made.members["passes"]
            print_campaign(console, choice, passes)
            if wanted and before:
                told = "files of --export lack the passes that stay: a file of --json has no tables"
                parts.print_warnings(console, [told])
            if url is not None:
                console.print(f"kept as {made.id}")
            for name, path in wanted:
                files.write(path, planner.export_campaign(made, name))
            if plans:
                _write_plans(plans, planner, passes)
        stay = plans_that_stay(choice)
        passes = [*(one for one in before if one["plan"] in stay), *passes]
        if csv:
            flown = [one for one in passes if one["problem"] is None]
            looks = ({**_of(one), **look} for one in flown for look in one["looks"])
            files.write(csv, looks_csv(looks).encode())
        files.write_json(json, {**choice, "passes": passes})


def _write_plans(folder: Path, planner: "Local | TellingClient", passes: Sequence[Members]) -> None:
    for one in passes:
        if one["problem"] is None:
            stem = f"{folder}/pass-{_number(one)}"
            files.write_json(Path(f"{stem}.json"), planner.get(one["plan"]).members)
            files.write_json(Path(f"{stem}-request.json"), planner.request(one["plan"]))


def _revised_by(
    body: bytes, frozen_until: str | None, file: Path
) -> tuple[bytes, Sequence[Members]]:
    """The request with the looks of an answer that --json wrote, or a service gave; its passes."""
    from app.work.campaign import revised

    answer = json_document(file.read_bytes())
    try:
        return revised(body, frozen_until, answer), answer["passes"]  # type: ignore[arg-type,index]  # or refused here
    except (AttributeError, LookupError, TypeError) as fault:
        raise InvalidInput(
            f"{str(file)[:80]!r} holds no campaign's answer, such as --json writes ({fault})",
            field="--revises",
        ) from None


def _number(one: Members) -> int:
    """Of a pass, counted from 1, as everything that people read; the answer's is an index."""
    return int(one["number"]) + 1


def _of(one: Members) -> dict[str, Any]:
    """By which looks are told apart: the pass, and its carrier where there are several."""
    return {"pass": _number(one), **({"carrier": one["carrier"]} if "carrier" in one else {})}


def print_campaign(console: Console, choice: Members, passes: Sequence[Members]) -> None:
    from planner.planning.campaigns.chosen import KeptResource

    looks = [{**_of(one), **look} for one in passes for look in one["looks"]]
    planned = [one for one in passes if one["problem"] is None]
    console.print(
        Text.assemble(
            (f"{sum(len(one['looks']) for one in planned)} looks", "bold"),
            f" in {len(planned)} passes, worth {choice['value']:.6g}; at most "
            f"{choice['bound']:.6g} can be had, {choice['gap_share']:.2%} more; taking each "
            f"pass by itself {choice['greedy_value']:.6g}",
        )
    )
    carrier = [("<carrier", "carrier")] if "carriers" in choice else []
    parts.print_assumed(console, choice["assumed"])
    parts.print_rows(
        console, None, looks[: parts.SHOWN_MAX],
        ("<pass", lambda look: str(look["pass"])), *carrier, ("<target", "target"),
        ("<start", lambda look: f"{look['start'][:10]} {look['start'][11:21]}"),
        ("<stop", lambda look: look["stop"][11:21]), ("<value", "value", ".4g"),
        ("quality", "quality", ".2f"), ("elev deg", "elevation_deg", ".1f"), keys=2 + len(carrier),
    )  # fmt: skip
    parts.print_more(console, len(looks))
    if revision := choice["revision"]:
        _print_revision(console, revision)
    parts.print_reasons(console, "can't be seen", choice["unseen"])
    for lacks in (None, *get_args(KeptResource)):
        left_out = [one for one in choice["left_out"] if one.get("lacks") == lacks]
        parts.print_reasons(
            console, f"left out for {(lacks or 'others').replace('_', ' ')}", left_out
        )
    parts.print_warnings(console, [*_losses(passes), *choice["warnings"]])


def _print_revision(console: Console, revision: Members) -> None:
    """What stays, and a line per target whose looks are others than before."""
    frozen, changes = revision["frozen"], ("kept", "moved", "dropped", "added")
    console.print(
        f"{len(frozen)} looks worth {revision['frozen_value']:.6g} stay, of passes that begin "
        f"before {revision['frozen_until'][:19]}Z; targets "
        + ", ".join(f"{revision[change]} {change}" for change in changes)
    )
    changed = [one for one in revision["targets"] if one["change"] != "kept"]
    parts.print_rows(
        console, None, changed[: parts.SHOWN_MAX], ("<target", "target"), ("<change", "change"),
        ("<before", lambda one: _told(one["before"])), ("<now", lambda one: _told(one["now"])),
    )  # fmt: skip
    parts.print_more(console, len(changed))


def _told(looks: Sequence[Members]) -> str:
    """When each begins, and by which carrier where there are several."""
    return ", ".join(
        " ".join(filter(None, (look["start"][:10], look["start"][11:21], look["carrier"])))
        for look in looks
    )


def _losses(passes: Sequence[Members]) -> Iterator[str]:
    for one in passes:
        for lost in one["left_out"]:
            yield f"pass {_number(one)}: {lost['target']} was left out, {lost['because']}"
        if one["problem"] is not None:
            yield f"pass {_number(one)} can't be flown: {one['problem']['detail']}"
