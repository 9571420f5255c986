"""Three consecutive sessions, Las Vegas and the gallery: Sumarokov 2016, Fig. 2."""

from pathlib import Path

from reproduction.statements import Picture, Statement


def statements() -> list[Statement]:
    return []


def pictures(folder: Path) -> list[Picture]:
    return []
