"""A request changed on the command line: single fields, or its session moved to the next pass."""

import base64
import csv
import io
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from app.answers.problem import problem_of as members_of
from app.cli.local import Local
from app.cli.service import RefusedThere
from app.requests.json_reader import json_document
from planner.base.errors import InvalidInput, Refusal
from planner.world.frames.time_scales import utc_from_text
from slewtrack.client import next_pass
from slewtrack.client.problems import Refused, problem_of


def with_settings(body: bytes, settings: Sequence[str] | None) -> bytes:
    """The request with each FIELD=VALUE set; FIELD as refusals name it, VALUE JSON, text, @FILE.

    A file whose name ends with .csv is a list: one object a line, its columns named as fields.
    """
    if not settings:
        return body
    document = _object(body)
    for setting in settings:
        field, equals, text = setting.partition("=")
        if not equals or not field:
            raise InvalidInput(f"{setting[:80]!r} is no FIELD=VALUE", field="--set")
        value = _value(text)
        try:
            _set(document, field.split("."), value)
        except (LookupError, TypeError, ValueError):
            raise InvalidInput(
                f"the request has nothing at {field[:80]!r}", field="--set"
            ) from None
    return json.dumps(document).encode()


def _object(body: bytes) -> dict[str, Any]:
    document = json_document(body)
    if not isinstance(document, dict):
        raise InvalidInput("the request must be a JSON object")
    return document


def _value(text: str) -> object:
    if text.startswith("@"):
        content = Path(text[1:]).read_bytes()
        if text.lower().endswith(".csv"):
            return _objects(content.decode("utf-8-sig", errors="replace"))
        return content.decode() if content.isascii() else base64.b64encode(content).decode()
    return _value_of(text)


def _value_of(text: str) -> object:
    try:
        return json.loads(text)
    except ValueError:
        return text


def _objects(text: str) -> list[dict[str, Any]]:
    """A line's cells as fields of an object, those that are empty left out."""
    try:
        names, *rows = filter(None, csv.reader(io.StringIO(text), strict=True))
        objects: list[dict[str, Any]] = [{} for _ in rows]
        for one, row in zip(objects, rows, strict=True):
            for name, cell in zip(names, row, strict=True):
                if cell:  # an id of digits is text, too
                    _set(one, name.split("."), cell if name == "id" else _value_of(cell))
    except (csv.Error, LookupError, TypeError, ValueError) as error:
        raise InvalidInput(
            "the file must be CSV: a line of fields, id,target.mode,target.latitude_deg, say, and "
            f"a line of as many cells for each object ({error})",
            field="--set",
        ) from None
    return objects


def _set(inside: Any, path: Sequence[str], value: object) -> None:  # noqa: ANN401 (JSON)
    """Raises LookupError, TypeError or ValueError where the document has no such place."""
    for name in path[:-1]:
        inside = inside.setdefault(name, {}) if isinstance(inside, dict) else inside[_place(name)]
    inside[path[-1] if isinstance(inside, dict) else _place(path[-1])] = value


def _place(name: str) -> int:
    if not name.isdecimal():
        raise ValueError
    return int(name)


def at_next_pass(body: bytes, start: str | None) -> tuple[bytes, str]:
    """The request with its one session in the first window of its target, and what to say of it.

    start: of the search, RFC 3339; now unless given.
    """
    try:
        start_utc = None if start in (None, "now") else utc_from_text(str(start))
    except ValueError as error:
        raise InvalidInput(str(error), field="--start") from None
    document = _object(body)
    try:
        search = next_pass.search_of(document, start_utc)
        window = next_pass.first_window(Local().opportunities(search, include=next_pass.TOLD))
    except Refusal as refusal:
        refused = next_pass.as_in_plan(problem_of(members_of(refusal)))
        raise RefusedThere(refused.problem) from None
    except Refused as refused:
        raise RefusedThere(refused.problem) from None
    moved = next_pass.moved_to(window, document)
    start, stop = moved["sessions"][0]["start"], moved["sessions"][0]["stop"]
    told = f"next pass: {start} to {stop}, up to {window.highest_deg:.1f} deg high"
    return json.dumps(moved).encode(), told
