"""docs/reproduction.csv, the rows last accepted, and docs/reproduction.md, made of them alone."""

import csv
import math
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import asdict, fields
from pathlib import Path

from reproduction.statements import VERDICTS, Row

DOCS = Path(__file__).parents[2] / "docs"
TABLE, DOCUMENT, IMAGES = DOCS / "reproduction.csv", DOCS / "reproduction.md", DOCS / "images"
PAGES = Path(__file__).with_name("pages.md")
ROUNDING = 1e-9  # of a number that may not move: its last digits are the processor's


def read(file: Path = TABLE) -> list[Row]:
    with file.open(encoding="utf-8", newline="") as lines:
        return [_row(one) for one in csv.DictReader(lines)]


def _row(cells: dict[str, str]) -> Row:
    numbers = {k: float(cells[k]) if cells[k] else None for k in ("stated", "ours")}
    return Row(**{**cells, **numbers, "tolerance": float(cells["tolerance"])})


def write(rows: Iterable[Row], file: Path = TABLE) -> None:
    with file.open("w", encoding="utf-8", newline="") as lines:
        writer = csv.DictWriter(lines, [field.name for field in fields(Row)], lineterminator="\n")
        writer.writeheader()
        for one in rows:
            shown = "" if one.ours is None else _digits(one.ours, 0.01 * one.tolerance)
            writer.writerow({**asdict(one), "ours": shown})


def differences(rows: Sequence[Row], kept: Sequence[Row]) -> list[str]:
    """What no longer is as it was accepted, one line each; none: all is well."""
    found = []
    before = {(one.paper, one.name): one for one in kept}
    for one in rows:
        label = f"{one.paper}, {one.place}, {one.name}"
        was = before.pop((one.paper, one.name), None)
        if was is None:
            found.append(f"{label}: stated now, not kept")
            continue
        if _moved(one, was):
            found.append(
                f"{label}: {one.ours} {one.unit}, kept {was.ours}, may move {one.tolerance}"
            )
        found += [
            f"{label}: {name} is {getattr(one, name)}, kept {getattr(was, name)}"
            for name in (
                "place",
                "says",
                "sense",
                "stated",
                "unit",
                "tolerance",
                "verdict",
                "result",
            )
            if getattr(one, name) != getattr(was, name)
        ]
    return [*found, *(f"{paper}, {name}: kept, no longer stated" for paper, name in before)]


def _moved(one: Row, was: Row) -> bool:
    if one.ours is None or was.ours is None:
        return one.ours != was.ours
    return abs(one.ours - was.ours) > max(1.01 * one.tolerance, ROUNDING * abs(was.ours))


def document(rows: Sequence[Row]) -> str:
    """The pages' text with the counts and each paper's table in their places."""
    text = PAGES.read_text(encoding="utf-8").replace("<!-- counts -->", _counts(rows))
    for paper in dict.fromkeys(one.paper for one in rows):
        text = text.replace(f"<!-- {paper} -->", _table([r for r in rows if r.paper == paper]))
    return text


def _counts(rows: Sequence[Row]) -> str:
    lines = [
        "| paper | reproduced | of these agree | differ | set | ours |",
        "|---|---|---|---|---|---|",
    ]
    for paper in dict.fromkeys(one.paper for one in rows):
        counts = Counter(one.verdict for one in rows if one.paper == paper)
        results = Counter(one.result for one in rows if one.paper == paper)
        reproduced, *others = (counts[verdict] for verdict in VERDICTS)
        cells = (paper, reproduced, results["agrees"], results["differs"], *others)
        lines.append("| " + " | ".join(map(str, cells)) + " |")
    return "\n".join(lines)


def _table(rows: Sequence[Row]) -> str:
    """What is reproduced; the reason stands where it differs."""
    lines = ["| where | the paper says | paper | ours | |", "|---|---|---|---|---|"]
    for one in (one for one in rows if one.verdict == "reproduced"):
        bound = f"**differs**: {one.why}" if one.result == "differs" else "agrees"
        stated = f"{one.sense} {_shown(one.stated, 0.0, one.unit)}".lstrip()
        cells = (one.place, one.says, stated, _shown(one.ours, one.tolerance, one.unit), bound)
        lines.append(
            "| " + " | ".join(" ".join(c.split()).replace("|", "\\|") for c in cells) + " |"
        )
    return "\n".join(lines)


def _shown(value: float | None, tolerance: float, unit: str) -> str:
    return "-" if value is None else f"{_digits(value, tolerance)} {unit}".rstrip()


def _digits(value: float, tolerance: float) -> str:
    """As many digits as the tolerance holds; ten where it holds all."""
    if abs(value) < 0.5 * tolerance:
        return "0"
    if tolerance == 0.0 or value == 0.0:
        return f"{value:.10g}" if abs(value) < 1e6 else f"{value:.6g}"
    decimals = math.ceil(-math.log10(tolerance))
    digits = max(1, decimals + 1 + math.floor(math.log10(abs(value))))
    if abs(value) >= 1e6 or abs(value) < 1e-4:
        return f"{value:.{digits - 1}e}"
    return f"{value:.{max(0, decimals)}f}"
