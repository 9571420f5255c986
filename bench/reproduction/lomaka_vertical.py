"""The vertical from two cameras: Lomaka, Ustyugov 2016, Figs. 3, 5 and 6."""

from pathlib import Path

from reproduction.statements import Picture, Statement


def statements() -> list[Statement]:
    return []


def pictures(folder: Path) -> list[Picture]:
    return []
