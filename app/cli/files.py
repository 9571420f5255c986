"""Files that commands read and write, or with `-` the standard streams, and their options."""

import json
import sys
from collections.abc import Collection, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from app.cli.planner import Members
from planner.base.errors import InvalidInput, Refusal, Unverified

if TYPE_CHECKING:
    from rich.console import Console

STANDARD_STREAM = Path("-")
PICTURES = ("png", "svg", "pdf")

RequestFile = Annotated[
    str, typer.Argument(help="Read the request (JSON) from this file; - is standard input.")
]
WholeAnswer = Annotated[
    Path | None,
    typer.Option(
        help="Write the whole answer of the HTTP service here, or the problem of a refusal; "
        "- is standard output."
    ),
]
TableCsv = Annotated[
    Path | None,
    typer.Option(help="Write the table here as CSV, columns only; - is standard output."),
]
Exports = Annotated[
    list[str] | None,
    typer.Option(
        metavar="FORMAT=PATH",
        help="Write the table in a format that states its frames and units: docs/http.md lists "
        "them, and so does the refusal of an unknown one (may be repeated).",
    ),
]
Settings = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="FIELD=VALUE",
        help="Change a field of the request first, by its name in refusals: platform=agile-cmg, "
        "attitude=null, or a file's content, terrain.content=@dem.tif; targets=@cities.csv has a "
        "line per target, its columns named as fields: id,target.mode (may be repeated).",
    ),
]
DryRun = Annotated[
    bool, typer.Option("--dry-run", help="Only check whether it can be flown; write nothing.")
]
Url = Annotated[
    str | None,
    typer.Option(
        help="Ask this service, which keeps what it makes: http://127.0.0.1:8000. The API key is "
        "SLEWTRACK_KEY."
    ),
]
KeptUrl = Annotated[
    str | None,
    typer.Option(
        help="Ask this service; SLEWTRACK_URL by default, or http://127.0.0.1:8000. The API key "
        "is SLEWTRACK_KEY."
    ),
]


def read_request(file: str, settings: Sequence[str] | None) -> bytes:
    """A request as it stands in its file, or with what is set of it."""
    from app.cli.changes import with_settings

    body = sys.stdin.buffer.read() if file == "-" else Path(file).read_bytes()
    return with_settings(body, settings)


def write(path: Path, content: bytes) -> None:
    """The folder is made where there is none."""
    if path == STANDARD_STREAM:
        sys.stdout.buffer.write(content)
        sys.stdout.buffer.flush()
        return
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(content)


def write_json(path: Path | None, members: Members) -> None:
    """As it was answered, if anywhere."""
    if path is not None:
        text: bytes | None = getattr(members, "text", None)
        write(path, text or json.dumps(dict(members)).encode() + b"\n")


def formats_and_paths(
    texts: Sequence[str] | None, formats: Collection[str]
) -> list[tuple[str, Path]]:
    """Of `FORMAT=PATH`; raises InvalidInput."""
    pairs = [text.partition("=")[::2] for text in texts or ()]
    for name, path in pairs:
        if name not in formats or not path:
            wrong = "is no format there is" if path else "is no FORMAT=PATH"
            raise InvalidInput(
                f"{name[:80]!r} {wrong}; the formats are {', '.join(formats)}", field="--export"
            )
    return [(name, Path(path)) for name, path in pairs]


def picture_format(plot: Path | None, *, by_service: bool = False) -> str | None:
    """As the file's name ends, png where it doesn't; raises InvalidInput."""
    if plot is None:
        return None
    image_format = plot.suffix.lstrip(".").lower() or "png"
    if image_format not in (PICTURES[:2] if by_service else PICTURES):
        drawn = ".png or .svg, which a service draws" if by_service else ".png, .svg or .pdf"
        raise InvalidInput(f"must end in {drawn}, not .{image_format[:20]}", field="--plot")
    return image_format


def table_only(csv: bytes) -> bytes:
    """Without the lines that say what the columns don't."""
    return b"".join(line for line in csv.splitlines(keepends=True) if not line.startswith(b"#"))


@contextmanager
def report_beside(
    json_file: Path | None, *files: Path | None, exports: Sequence[str] | None = None
) -> "Iterator[Console]":
    """Where a report goes: to stderr if one of the files takes standard output.

    A refusal of what is inside is written to `json_file`, as the service would answer it.  Not of a
    table alone: the whole answer tells its verdict.
    """
    from app.cli.report_parts import report_console

    paths = [json_file, *files, *(Path(text.partition("=")[2]) for text in exports or ())]
    try:
        if paths.count(STANDARD_STREAM) > 1:
            raise InvalidInput("only one output can be -, standard output", field="-")
        yield report_console(to_stderr=STANDARD_STREAM in paths)
    except Unverified:
        raise
    except Refusal as refusal:
        if json_file is not None:
            write(json_file, json.dumps(_problem(refusal)).encode() + b"\n")
        raise


def _problem(refusal: Refusal) -> dict[str, Any]:
    """Its members, a service's own where one refused it."""
    from app.answers.problem import problem_of
    from app.ids import new_id

    there = getattr(refusal, "problem", None)
    if there is not None:
        return dict(there.members)
    return problem_of(refusal) | {"instance": f"urn:uuid:{new_id()}"}
