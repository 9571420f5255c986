"""Parts that all reports share: streams, tables, numbers without a meaning, warnings."""

import os
from collections.abc import Iterable

from rich.cells import cell_len
from rich.console import Console
from rich.table import Column, Table
from rich.text import Text

_UNBOUNDED = 10_000  # characters of a line in a pipe or file, which knows no width
_GAP = 2


def report_console(*, to_stderr: bool = False) -> Console:
    """As wide as the terminal; as COLUMNS has it or without bounds in pipes and files."""
    console = Console(highlight=False, stderr=to_stderr)
    if not console.is_terminal and "COLUMNS" not in os.environ:
        console.width = _UNBOUNDED
    return console


def report_table(title: str | None, *columns: str, wrapped: str | None = None) -> Table:
    """Columns of text start with `<` in their heading, the rest are numbers.

    wrapped: heading of a column of text that may take several lines.
    """
    table = Table(
        title=title,
        title_justify="left",
        title_style="bold",
        box=None,
        pad_edge=False,
        padding=(0, _GAP, 0, 0),
    )
    for column in columns:
        heading = column.removeprefix("<")
        table.add_column(
            heading,
            justify="right" if heading == column else "left",
            no_wrap=heading != wrapped,
        )
    return table


def print_table(console: Console, table: Table) -> None:
    """In columns where they fit, else each row as what it holds by heading: nothing is cut."""
    if not table.row_count:
        return
    needed = sum(map(_width, table.columns)) + _GAP * (len(table.columns) - 1)
    if needed <= console.width:
        console.print(table)
        return
    if table.title is not None:
        console.print(Text(str(table.title), style="bold"))
    for row, cells in zip(
        table.rows, zip(*(column.cells for column in table.columns), strict=True), strict=True
    ):
        parts = [
            Text.assemble(
                (f"{column.header} ", "dim"), cell if isinstance(cell, Text) else str(cell)
            )
            for column, cell in zip(table.columns, cells, strict=True)
        ]
        console.print(Text(", ").join(parts), style=row.style)


def _width(column: Column) -> int:
    """Least characters without cutting anything."""
    texts = [str(column.header), *map(str, column.cells)]
    if not column.no_wrap:
        texts = [word for text in texts for word in text.split()]
    return max(map(cell_len, texts), default=0)


def or_dash(value: float | None, form: str) -> str:
    """The number in this format, where there is one."""
    return "-" if value is None else format(value, form)


def print_assumed(console: Console, fields_and_details: Iterable[tuple[str, str]]) -> None:
    """What the request left to us: one line for each of its fields, with what was taken."""
    for field, detail in fields_and_details:
        console.print(Text(f"taken for {field}: {detail}"))


def print_warnings(console: Console, warnings: Iterable[str]) -> None:
    """One line each."""
    for warning in warnings:
        console.print(Text(f"warning: {warning}", style="yellow"))
