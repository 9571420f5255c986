"""docs/reproduction.md out of statements and pictures."""

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from reproduction.statements import Picture, Statement

PAPERS = {
    "Sumarokov 2016": "pointing of the high-resolution camera on the ISS by a two-axis platform",
    "Lomaka 2016": "the local vertical from the visible horizon",
    "Platonov 2019": "stabilisation and productivity of an Earth-imaging spacecraft",
}
VERDICTS = ("agrees", "differs", "can't be reproduced")
HEAD = Path(__file__).parent / "head.md"


@dataclass(frozen=True)
class Section:
    text: str  # Markdown with its heading
    statements: Sequence[Statement]
    pictures: Sequence[Picture]


def document(sections: Sequence[Section]) -> str:
    head = HEAD.read_text(encoding="utf-8")
    return "\n".join([head, _summary(sections), *map(_section, sections)])


def row_start(one: Statement, ours: float | str | None) -> str:
    """A statement's row up to the reason of its verdict, with a given number of ours."""
    cells = (one.place, one.says, _number(one.stated, 0.0, one.unit))
    shown = _number(ours, one.tolerance, one.unit)
    return "| " + " | ".join(map(_cell, (*cells, shown))) + f" | **{one.verdict}**"


def _summary(sections: Sequence[Section]) -> str:
    counts: dict[str, Counter[str]] = {paper: Counter() for paper in PAPERS}
    for section in sections:
        for one in section.statements:
            counts[one.paper][one.verdict] += 1
    rows = [
        f"| {paper}: {about} | " + " | ".join(str(counts[paper][v]) for v in VERDICTS) + " |"
        for paper, about in PAPERS.items()
    ]
    return "\n".join(["| paper | " + " | ".join(VERDICTS) + " |", "|---|---|---|---|", *rows, ""])


def _section(section: Section) -> str:
    blocks = [section.text]
    for picture in section.pictures:
        blocks.append(f"![{picture.shows}](images/{picture.file})")
        if picture.text:
            blocks.append(picture.text.strip())
    if section.statements:
        rows = [f"{row_start(one, one.ours)}: {_cell(one.why)} |" for one in section.statements]
        head = ["| where | the paper says | paper | ours | verdict |", "|---|---|---|---|---|"]
        blocks.append("\n".join([*head, *rows]))
    return "\n\n".join(blocks) + "\n"


def _cell(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|")


def _number(value: float | str | None, tolerance: float, unit: str) -> str:
    """As many digits as the tolerance holds; all there are where it holds all."""
    if value is None or isinstance(value, str):
        return "-"
    if abs(value) < 0.5 * tolerance:
        text = "0"
    elif tolerance == 0.0 or value == 0.0:
        text = f"{value:.10g}" if abs(value) < 1e6 else f"{value:.6g}"
    else:
        decimals = math.ceil(-math.log10(tolerance))
        digits = max(1, decimals + 1 + math.floor(math.log10(abs(value))))
        large = abs(value) >= 1e6 or abs(value) < 1e-4
        text = f"{value:.{digits - 1}e}" if large else f"{value:.{max(0, decimals)}f}"
    return f"{text} {unit}".rstrip()
