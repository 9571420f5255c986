"""One thing a paper states, beside what slewtrack finds."""

import math
from dataclasses import dataclass
from typing import Literal

Paper = Literal["Sumarokov 2016", "Lomaka 2016", "Platonov 2019"]
Verdict = Literal["agrees", "differs", "can't be reproduced"]


@dataclass(frozen=True, kw_only=True)
class Statement:
    """A number or a claim of a paper, and ours.

    name: short, unique within its paper; the kept number is found by it.
    place: where the paper says it: "Fig. 3", "eq. 11", "p. 86".
    says: what it says, in words.  stated: its number in `unit`, where it has one.
    ours: what the product computes, in `unit`; None where nothing can be computed.
    tolerance: how far ours may move, in `unit`, before somebody must look; it also sets the
    digits shown.
    why: the reason for the verdict; it may hold numbers computed on the way.
    """

    paper: Paper
    place: str
    name: str
    says: str
    stated: float | None = None
    ours: float | None
    unit: str = ""
    tolerance: float = 0.0
    verdict: Verdict
    why: str

    def __post_init__(self) -> None:
        label = f"{self.paper}, {self.name}"
        for number in (self.stated, self.ours, self.tolerance):
            if number is not None and not math.isfinite(number):
                raise ValueError(f"{label}: {number} is no number to state")
        if self.ours is None and self.verdict != "can't be reproduced":
            raise ValueError(f"{label}: a verdict needs a number of ours")
        if self.tolerance < 0.0:
            raise ValueError(f"{label}: a tolerance of {self.tolerance}")


@dataclass(frozen=True, kw_only=True)
class Picture:
    """A picture a part has drawn: `file` in docs/images/, what it shows, how to read it."""

    file: str
    shows: str
    text: str = ""


def judge(stated: float, ours: float, within: float) -> Verdict:
    """Do the two agree within what the paper's rounding or its reading off a figure allows?"""
    return "agrees" if abs(ours - stated) <= within else "differs"


def holds(claim: bool) -> Verdict:
    """Does a claim without a number hold for us?"""
    return "agrees" if claim else "differs"
