"""Parts that all reports share: streams, tables declared by their columns, warnings."""

import os
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from rich.cells import cell_len
from rich.console import Console
from rich.table import Table
from rich.text import Text

What = str | Callable[[Any], object]
Form = str | Callable[[Any], str]
Column = tuple[str, What] | tuple[str, What, Form]

SHOWN_MAX = 100  # lines of what may have any number
_UNBOUNDED = 10_000  # characters of a line in a pipe or file, which knows no width
_GAP = 2


def report_console(*, to_stderr: bool = False) -> Console:
    """As wide as the terminal; as COLUMNS has it or without bounds in pipes and files."""
    console = Console(highlight=False, stderr=to_stderr)
    if not console.is_terminal and "COLUMNS" not in os.environ:
        console.width = _UNBOUNDED
    return console


def print_rows(
    console: Console,
    title: str | None,
    rows: Iterable[Any],
    *columns: Column,
    red: Callable[[Any], object] = lambda _: False,
    sparse: bool = False,
) -> None:
    """In columns where they fit, else each row as what it holds by heading: nothing is cut.

    columns: heading, member of the row or what is made of the row, and its format; a dash is put
    where there is no number. Headings of texts begin with `<`, of one that may take several lines
    with `~`. sparse: columns of dashes only are left out.
    """
    rows = list(rows)
    if not rows:
        return
    filled = [(column[0], [_cell(row, *column[1:]) for row in rows]) for column in columns]
    filled = [(heading, texts) for heading, texts in filled if not sparse or {*texts} != {"-"}]
    lines = [*zip(*(texts for _, texts in filled), strict=True)]
    styles = ["red" if red(row) else "" for row in rows]
    needed = sum(_width(*column) for column in filled) + _GAP * (len(filled) - 1)
    if needed > console.width:
        if title is not None:
            console.print(Text(title, style="bold"))
        for style, line in zip(styles, lines, strict=True):
            parts = [
                Text.assemble((f"{heading.lstrip('<~')} ", "dim"), text)
                for (heading, _), text in zip(filled, line, strict=True)
            ]
            console.print(Text(", ").join(parts), style=style)
        return
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
    for style, line in zip(styles, lines, strict=True):
        table.add_row(*map(Text, line), style=style)
    console.print(table)


def _cell(row: Any, what: What, form: Form = "") -> str:  # noqa: ANN401 (whatever is reported)
    if callable(what):
        value = what(row)
    else:
        value = row
        for name in what.split("."):
            value = value[name]
    if callable(form):
        return form(value)
    return "-" if value is None else format(value, form)


def _width(heading: str, texts: list[str]) -> int:
    """Least characters without cutting anything."""
    texts = [heading.lstrip("<~"), *texts]
    if heading.startswith("~"):
        texts = [word for text in texts for word in text.split()]
    return max(map(cell_len, texts), default=0)


def print_more(console: Console, count: int, where: str = "--csv or --json") -> None:
    """Where the lines beyond SHOWN_MAX are, if there are any."""
    if count > SHOWN_MAX:
        console.print(f"and {count - SHOWN_MAX} more: see {where}")


def print_assumed(console: Console, assumed: Iterable[Mapping[str, Any]]) -> None:
    """What the request left to us: one line for each of its fields, with what was taken."""
    for one in assumed:
        console.print(Text(f"taken for {one['field']}: {one['detail']}"))


def print_warnings(console: Console, warnings: Iterable[str]) -> None:
    """One line each."""
    for warning in warnings:
        console.print(Text(f"warning: {warning}", style="yellow"))
