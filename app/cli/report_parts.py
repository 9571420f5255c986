"""What all reports share: tables, numbers that have no meaning, warnings."""

from collections.abc import Iterable

from rich.console import Console
from rich.table import Table
from rich.text import Text


def report_table(title: str | None, *columns: str, no_wrap: bool = True) -> Table:
    """Columns of text start with `<` in their heading, the rest are numbers."""
    table = Table(title=title, title_justify="left", title_style="bold", box=None, pad_edge=False)
    for column in columns:
        heading = column.removeprefix("<")
        table.add_column(heading, justify="right" if heading == column else "left", no_wrap=no_wrap)
    return table


def or_dash(value: float | None, form: str) -> str:
    """The number in this format, where there is one."""
    return "-" if value is None else format(value, form)


def print_warnings(console: Console, warnings: Iterable[str]) -> None:
    """One line each."""
    for warning in warnings:
        console.print(Text(f"warning: {warning}", style="yellow"))
