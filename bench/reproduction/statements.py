"""The papers' statements, as statements.toml has them, beside our numbers."""

import math
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

FILE = Path(__file__).with_name("statements.toml")
VERDICTS = ("reproduced", "set", "ours")
Numbers = dict[str, float | str]  # of a part: by its statements' names, and what reasons tell


@dataclass(frozen=True, kw_only=True)
class Statement:
    """A number or a claim of a paper; statements.toml says what each field holds."""

    paper: str
    place: str
    name: str
    says: str
    verdict: Literal["reproduced", "set", "ours"]
    why: str
    stated: float | None = None
    unit: str = ""
    function: str | None = None
    tolerance: float = 0.0
    within: float | None = None
    sense: Literal["at most", "at least"] | None = None

    def __post_init__(self) -> None:
        wrong = {
            f"the verdict {self.verdict}": self.verdict not in VERDICTS,
            "a number of the paper's that isn't one": self.stated is not None
            and not math.isfinite(self.stated),
            f"a tolerance of {self.tolerance}": not self.tolerance >= 0.0,
            "reproduced without a number of the paper's": self.verdict == "reproduced"
            and self.stated is None,
            "a number of the paper's that is ours alone": self.verdict == "ours"
            and self.stated is not None,
            "reproduced without one of within and sense": (self.verdict == "reproduced")
            != ((self.within is None) != (self.sense is None)),
            "nothing computed": self.verdict != "ours" and self.function is None,
        }
        for what in (what for what, is_so in wrong.items() if is_so):
            raise ValueError(f"{self.paper}, {self.name}: {what}")

    def agrees(self, ours: float) -> bool:
        """Is our number the paper's, as nearly as print and reading allow?"""
        assert self.stated is not None
        if self.sense is None:
            assert self.within is not None
            return abs(ours - self.stated) <= self.within
        return ours <= self.stated if self.sense == "at most" else ours >= self.stated


@dataclass(frozen=True)
class Row:
    """A statement beside our number, as docs/reproduction.csv keeps it; `result` is "agrees" or
    "differs" of what is reproduced, else empty."""

    paper: str
    place: str
    name: str
    says: str
    sense: str
    stated: float | None
    ours: float | None
    unit: str
    tolerance: float
    verdict: str
    result: str
    why: str


def read_statements(file: Path = FILE) -> list[Statement]:
    tables = tomllib.loads(file.read_text(encoding="utf-8"))
    found = [Statement(paper=paper, **one) for paper, rows in tables.items() for one in rows]
    names = [(one.paper, one.name) for one in found]
    for twice in {name for name in names if names.count(name) > 1}:
        raise ValueError(f"{twice[0]} has two statements named {twice[1]}")
    return found


def row(one: Statement, numbers: Mapping[str, float | str]) -> Row:
    ours = None if one.function is None else float(numbers[one.name])
    if ours is not None and not math.isfinite(ours):
        raise ValueError(f"{one.paper}, {one.name}: {ours} is no number to state")
    result = ""
    if one.verdict == "reproduced" and ours is not None:
        result = "agrees" if one.agrees(ours) else "differs"
    return Row(
        paper=one.paper,
        place=one.place,
        name=one.name,
        says=one.says,
        sense=one.sense or "",
        stated=one.stated,
        ours=ours,
        unit=one.unit,
        tolerance=one.tolerance,
        verdict=one.verdict,
        result=result,
        why=one.why.format_map(numbers),
    )
