"""Imaging from a CMG spacecraft: Platonov, Sumarokov 2019, Figs. 3 to 9."""

from pathlib import Path

from reproduction.statements import Picture, Statement


def statements() -> list[Statement]:
    return []


def pictures(folder: Path) -> list[Picture]:
    return []
