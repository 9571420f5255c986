"""The papers' statements beside our numbers: computed, kept in docs/reproduction.csv, published.

docs/reproduction.csv has the rows last accepted, docs/reproduction.md is made of them alone.
"""

import csv
import importlib
import math
import multiprocessing
import time
import tomllib
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass, fields
from functools import partial
from pathlib import Path
from typing import Literal

FILE, PAGES = (Path(__file__).with_name(name) for name in ("statements.toml", "pages.md"))
DOCS = Path(__file__).parents[2] / "docs"
TABLE, DOCUMENT, IMAGES = DOCS / "reproduction.csv", DOCS / "reproduction.md", DOCS / "images"
# A paper's module has a section's numbers in SECTION_numbers() and its pictures, if any, in
# draw_SECTION(folder).  The longest first: two at a time, none then waits alone at the end.
PAPERS = ("platonov", "lomaka", "sumarokov")
VERDICTS = ("reproduced", "set", "ours")
ROUNDING = 1e-9  # of a number that may not move: its last digits are the processor's
Numbers = dict[str, float]  # of a section, by its statements' names


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
    ours: float | None = None
    tolerance: float = 0.0
    within: float | None = None
    sense: Literal["at most", "at least"] | None = None

    def __post_init__(self) -> None:
        reproduced, has_number = self.verdict == "reproduced", self.stated is not None
        wrong = {
            f"the verdict {self.verdict}": self.verdict not in VERDICTS,
            "a number of the paper's that isn't one": self.stated is not None
            and not math.isfinite(self.stated),
            f"a tolerance of {self.tolerance}": not self.tolerance >= 0.0,
            "reproduced without a number of the paper's": reproduced and not has_number,
            "a number of the paper's that is ours alone": self.verdict == "ours" and has_number,
            "reproduced without one of within and sense": reproduced
            != ((self.within is None) != (self.sense is None)),
            "nothing computed": self.function is None
            and (reproduced or (self.verdict == "set" and self.ours is None)),
            "a number of ours beside the function that computes it": self.function is not None
            and self.ours is not None,
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


def row(one: Statement, numbers: Mapping[str, float]) -> Row:
    ours = one.ours if one.function is None else numbers[one.name]
    if ours is not None and not math.isfinite(ours):
        raise ValueError(f"{one.paper}, {one.name}: {ours} is no number to state")
    result = ""
    if one.verdict == "reproduced" and ours is not None:
        result = "agrees" if one.agrees(ours) else "differs"
    known = {field.name: getattr(one, field.name, None) for field in fields(Row)}
    return Row(**{**known, "sense": one.sense or "", "ours": ours, "result": result})


def sections(names: Iterable[str] = ()) -> dict[str, list[str]]:
    """Of each paper's module those that are named, or all."""
    functions = dict.fromkeys(one.function for one in read_statements() if one.function)
    chosen = [one.split(".") for one in functions if not names or one in names]
    return {paper: [name for module, name in chosen if module == paper] for paper in PAPERS}


def _computed(part: tuple[str, list[str]], images: Path | None) -> tuple[dict[str, Numbers], float]:
    """A paper's numbers by section, pictures drawn where a folder is given, and CPU seconds."""
    module, before_s = importlib.import_module(f"reproduction.{part[0]}"), time.process_time()
    found = {f"{part[0]}.{name}": getattr(module, f"{name}_numbers")() for name in part[1]}
    for name in part[1] if images else ():
        getattr(module, f"draw_{name}", lambda folder: None)(images)
    return found, time.process_time() - before_s


def rows_of(parts: Mapping[str, list[str]], images: Path | None) -> list[Row]:
    """Two papers at a time, each in a process of its own so that none warms another's caches."""
    started_s, found = time.perf_counter(), {}
    spawn = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(2, mp_context=spawn, max_tasks_per_child=1) as pool:
        done = pool.map(partial(_computed, images=images), parts.items())
        for paper, (numbers, cpu_s) in zip(parts, done, strict=True):
            print(f"{paper}: {cpu_s:.1f} s of CPU", flush=True)
            found |= numbers
    print(f"{time.perf_counter() - started_s:.0f} s in all")
    return [
        row(one, found.get(one.function or "", {}))
        for one in read_statements()
        if one.function in found or (one.function is None and parts == sections())
    ]


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
            moved = f"{one.ours} {one.unit}, kept {was.ours}, may move {one.tolerance}"
            found.append(f"{label}: {moved}")
        now, then = asdict(one), asdict(was)
        found += [
            f"{label}: {name} is {now[name]}, kept {then[name]}"
            for name in now.keys() - {"ours", "why"}
            if now[name] != then[name]
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
        escaped = (" ".join(cell.split()).replace("|", "\\|") for cell in cells)
        lines.append(f"| {' | '.join(escaped)} |")
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
