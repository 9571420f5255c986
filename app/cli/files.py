"""Files that commands read and write, or with `-` the standard streams."""

import json
import sys
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated, Any

import typer

from app.cli.planner import Members, ParsedAnswer
from planner.base.errors import InvalidInput, Refusal, Unverified

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
Exports = Annotated[
    list[str] | None,
    typer.Option(
        metavar="FORMAT=PATH",
        help="Write the table in a format that states its frames and units: docs/http.md lists "
        "them, and so does the refusal of an unknown one (may be repeated).",
    ),
]


def read_request(file: str) -> tuple[bytes, datetime]:
    """A request as it stands in its file, and when it was read."""
    body = sys.stdin.buffer.read() if file == "-" else Path(file).read_bytes()
    return body, datetime.now(UTC)


def write(path: Path, content: bytes) -> None:
    """The folder is made where there is none."""
    if path == STANDARD_STREAM:
        sys.stdout.buffer.write(content)
        sys.stdout.buffer.flush()
        return
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(content)


def takes_standard_output(*paths: Path | None) -> bool:
    """Whether one of them does: the report then goes to stderr; raises InvalidInput for two."""
    count = sum(path == STANDARD_STREAM for path in paths)
    if count > 1:
        raise InvalidInput("only one output can be -, standard output", field="-")
    return count == 1


def formats_and_paths(
    texts: list[str] | None, formats: Collection[str]
) -> Iterator[tuple[str, Path]]:
    """Of `FORMAT=PATH`."""
    for text in texts or ():
        name, _, path = text.partition("=")
        if name not in formats or not path:
            raise InvalidInput(
                f"{text[:80]!r} is no FORMAT=PATH; the formats are {', '.join(formats)}",
                field="--export",
            )
        yield name, Path(path)


def picture_format(plot: Path | None, *, by_service: bool = False) -> str | None:
    """As the file's name ends, png where it doesn't; raises InvalidInput."""
    if plot is None:
        return None
    image_format = plot.suffix.lstrip(".").lower() or "png"
    if image_format not in (PICTURES[:2] if by_service else PICTURES):
        drawn = ".png or .svg, which a service draws" if by_service else ".png, .svg or .pdf"
        raise InvalidInput(f"must end in {drawn}, not .{image_format[:20]}", field="--plot")
    return image_format


def write_json(path: Path | None, members: Members) -> None:
    """As it was answered, if anywhere."""
    if path is not None:
        whole = members.text if isinstance(members, ParsedAnswer) else None
        write(path, whole or json.dumps(dict(members)).encode() + b"\n")


@contextmanager
def problem_to(path: Path | None) -> Iterator[None]:
    """A refusal of what is inside is written there, as the service would answer it.

    Not of a table alone: the whole answer tells its verdict.
    """
    try:
        yield
    except Unverified:
        raise
    except Refusal as refusal:
        if path is not None:
            write(path, json.dumps(_problem(refusal)).encode() + b"\n")
        raise


def _problem(refusal: Refusal) -> dict[str, Any]:
    """Its members, a service's own where one refused it."""
    from app.answers.problem import problem_of
    from app.ids import new_id

    there = getattr(refusal, "problem", None)
    if there is not None:
        return dict(there.members)
    return problem_of(refusal) | {"instance": f"urn:uuid:{new_id()}"}
