"""The parts of the report, in its order: one line each, a module of this package.

A part named x is x.py with `statements()` and `pictures(folder)`, which draws
reproduction_*.png into the folder, and x.md: its heading and what stands above its pictures.
"""

import importlib
from pathlib import Path
from typing import Protocol, cast

from reproduction.statements import Picture, Statement

PARTS = (
    "sumarokov_equipment",
    "sumarokov_attitude",
    "sumarokov_orbit",
    "sumarokov_angles",
    "sumarokov_transfer",
    "sumarokov_sessions",
    "sumarokov_las_vegas",
    "sumarokov_flight",
    "sumarokov_boston",
    "sumarokov_modes",
    "lomaka_vertical",
    "lomaka_experiment",
    "platonov_spacecraft",
    "platonov_imaging",
    "platonov_laws",
)


class Part(Protocol):
    def statements(self) -> list[Statement]: ...

    def pictures(self, folder: Path) -> list[Picture]: ...


def load(name: str) -> Part:
    return cast("Part", importlib.import_module(f"reproduction.{name}"))


def text(name: str) -> str:
    """The part's own words, its heading one level down."""
    return "#" + (Path(__file__).parent / f"{name}.md").read_text(encoding="utf-8").strip()
