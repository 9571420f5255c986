"""How is a CCSDS message in KVN put together?"""

from collections.abc import Iterable, Sequence
from datetime import datetime

import numpy as np
from numpy.typing import NDArray

from planner.export.description import TEXT_MAX, carrier
from planner.export.flown import FlownPlan
from planner.frames.time_scales import Instants, utc_text

ORIGINATOR = "SLEWTRACK"


def epochs(instants: Instants) -> list[str]:
    """ASCII time code A of UTC to the millisecond; rows stand on a fifth of a second."""
    return [text.removesuffix("Z") for text in instants.utc_text(3)]


def header(kind: str, version: str, created_utc: datetime, notes: Iterable[str]) -> list[str]:
    """Lines from the version to the originator; long notes are broken at spaces."""
    return [
        f"CCSDS_{kind}_VERS = {version}",
        *(f"COMMENT {line}" for note in notes for line in _wrapped(note)),
        f"CREATION_DATE = {utc_text(created_utc).removesuffix('Z')}",
        f"ORIGINATOR = {ORIGINATOR}",
    ]


def object_lines(plan: FlownPlan) -> list[str]:
    """Which spacecraft, and about which body."""
    named = carrier(plan.scenario.orbit)
    return [
        f"OBJECT_NAME = {named.name}",
        f"OBJECT_ID = {named.designator}",
        "CENTER_NAME = EARTH",
    ]


def data_lines(
    moments: Sequence[str], blocks: Sequence[tuple[NDArray[np.float64], int]]
) -> list[str]:
    """Epoch and numbers; blocks: arrays of shape (n, k) with their decimals."""
    formats = [f"%.{decimals}f" for values, decimals in blocks for _ in range(values.shape[1])]
    layout = " ".join(formats)
    numbers = np.hstack([values for values, _ in blocks]) + 0.0
    rows = zip(moments, map(tuple, numbers.tolist()), strict=True)
    return [f"{moment} {layout % row}" for moment, row in rows]


def _wrapped(note: str) -> list[str]:
    lines = [""]
    for word in note.split(" "):
        if lines[-1] and len(lines[-1]) + len(word) >= TEXT_MAX:
            lines.append("")
        lines[-1] = f"{lines[-1]} {word}".strip()
    return lines
