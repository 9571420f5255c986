"""Parts that all reports share: the stream, tables declared by their columns, warnings."""

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

from rich.cells import cell_len
from rich.console import Console
from rich.table import Table
from rich.text import Text

What = str | Callable[[Any], object]
Form = str | Callable[[Any], str]
Column = tuple[str, What] | tuple[str, What, Form] | tuple[str, What, Form, Form]
Filled = tuple[str, Sequence[str]]  # heading, and a text a row

SHOWN_MAX = 100  # lines of what may have any number
UNBOUNDED = 10_000  # characters of a line in a pipe or file, which knows no width
_GAP = 2


def report_console(*, to_stderr: bool = False) -> Console:
    """As wide as the terminal; as COLUMNS has it or without bounds in pipes and files."""
    console = Console(highlight=False, stderr=to_stderr)
    if not console.is_terminal and "COLUMNS" not in os.environ:
        console.width = UNBOUNDED
    return console


def print_rows(
    console: Console,
    title: str | None,
    rows: Iterable[Any],
    *columns: Column,
    red: Callable[[Any], object] = lambda _: False,
    keys: int = 1,
    sparse: bool = False,
) -> None:
    """In a table where it fits; else in short forms, or in several that begin with the key columns.

    Where not even these fit, each row is told as what it holds by heading: nothing is cut.

    columns: heading, member of the row or what is made of the row, its format, and a short one; a
    dash is put where there is no number. Headings of texts begin with `<`, of one that may take
    several lines with `~`. keys: of the first columns, which tell the rows from each other.
    sparse: columns of dashes only are left out.
    """
    rows = list(rows)
    if not rows:
        return
    styles = ["red" if red(row) else "" for row in rows]
    for form in (2, 3):
        filled = [_filled(rows, column, form) for column in columns]
        filled = [one for one in filled if not sparse or {*one[1]} != {"-"}]
        if _width(filled) <= console.width:
            _print_table(console, title, filled, styles)
            return
    tables: list[list[Filled]] = []
    for column in filled[keys:]:
        if not tables or _width([*tables[-1], column]) > console.width:
            tables.append(filled[:keys])
        tables[-1] = [*tables[-1], column]
    if max(map(_width, tables)) <= console.width:
        for table in tables:
            _print_table(console, title, table, styles)
            title = None
        return
    if title is not None:
        console.print(Text(title, style="bold"))
    for style, line in zip(styles, zip(*(texts for _, texts in filled), strict=True), strict=True):
        parts = [
            Text.assemble((f"{heading.lstrip('<~')} ", "dim"), text)
            for (heading, _), text in zip(filled, line, strict=True)
            if text
        ]
        console.print(Text(", ").join(parts), style=style)


def _print_table(
    console: Console, title: str | None, filled: Sequence[Filled], styles: Sequence[str]
) -> None:
    table = Table(
        title=title,
        title_justify="left",
        title_style="bold",
        box=None,
        pad_edge=False,
        padding=(0, _GAP, 0, 0),
    )
    for heading, _ in filled:
        table.add_column(
            heading.lstrip("<~"),
            justify="left" if heading.startswith(("<", "~")) else "right",
            no_wrap=not heading.startswith("~"),
        )
    for style, line in zip(styles, zip(*(texts for _, texts in filled), strict=True), strict=True):
        table.add_row(*map(Text, line), style=style)
    console.print(table)


def _filled(rows: Sequence[Any], column: Column, form: int) -> Filled:
    heading, what, *forms = column
    used = forms[min(form - 2, len(forms) - 1)] if forms else ""
    return heading, [_cell(row, what, used) for row in rows]


def _cell(row: Any, what: What, form: Form) -> str:  # noqa: ANN401 (whatever is reported)
    if callable(what):
        value = what(row)
    else:
        value = row
        for name in what.split("."):
            value = value[name]
    if callable(form):
        return form(value)
    return "-" if value is None else format(value, form)


def _width(filled: Sequence[Filled]) -> int:
    """Least characters of a table without cutting anything."""
    width = _GAP * (len(filled) - 1)
    for heading, texts in filled:
        parts = [word for text in texts for word in text.split()] if heading[0] == "~" else texts
        width += max(cell_len(text) for text in (heading.lstrip("<~"), *parts))
    return width


def print_more(console: Console, count: int, where: str = "--csv or --json") -> None:
    """Where the lines beyond SHOWN_MAX are, if there are any."""
    if count > SHOWN_MAX:
        console.print(f"and {count - SHOWN_MAX} more: see {where}")


def print_assumed(console: Console, assumed: Iterable[Mapping[str, Any]]) -> None:
    """What the request left to us: one line for each of its fields, with what was taken."""
    for one in assumed:
        console.print(Text(f"taken for {one['field']}: {one['detail']}"))


def print_reasons(console: Console, meaning: str, targets: Sequence[Mapping[str, Any]]) -> None:
    """Why each has no look or no window, one line each."""
    for one in targets[:SHOWN_MAX]:
        highest = ""
        if "best_elevation_deg" in one:
            when = one["best_time"][:16].replace("T", " ")
            highest = f" (at most {one['best_elevation_deg']:.1f} deg high, {when})"
        console.print(Text(f"{meaning}: {one['target']}, {one['because']}{highest}"))
    print_more(console, len(targets), "--json")


def print_warnings(console: Console, warnings: Iterable[str]) -> None:
    for warning in warnings:
        console.print(Text(f"warning: {warning}", style="yellow"))
