"""CSV (RFC 4180) whose texts no spreadsheet takes for a formula."""

import re
from collections.abc import Iterable

# Source: OWASP, CSV injection; the wide forms are those of East Asian keyboards.
_FORMULA = ("=", "+", "-", "@", "\t", "\r", "\n", "＝", "＋", "－", "＠")
_PARTS = re.compile(r"[\",;\r\n]")
# In a line of text, what a spreadsheet takes for a cell of its own, numbers of a vector apart.
_CELL_WITHIN = re.compile(r"([,;]\s*)(?=[=@＝＋－＠]|[+-](?![\d.]+(?:e[+-]?\d+)?[\],]))")


def csv_lines(rows: Iterable[Iterable[object]]) -> str:
    """A line a row: texts, numbers as they are, None an empty cell.

    A text that begins as a formula gets an apostrophe before it, which spreadsheets don't show.
    """
    return "".join(",".join(map(_cell, row)) + "\n" for row in rows)


def comment_lines(notes: Iterable[str]) -> str:
    """Each a line that begins with `#`; notes: a line of text each."""
    return "".join("# " + _CELL_WITHIN.sub(r"\1'", note) + "\n" for note in notes)


def _cell(value: object) -> str:
    if not isinstance(value, str):
        return "" if value is None else str(value)
    text = f"'{value}" if value.startswith(_FORMULA) else value
    return '"' + text.replace('"', '""') + '"' if _PARTS.search(text) else text
