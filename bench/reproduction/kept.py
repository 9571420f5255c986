"""The numbers last accepted, and what has moved since."""

import json
from collections.abc import Iterable
from pathlib import Path

from reproduction.report import row_start
from reproduction.statements import Statement

FILE = Path(__file__).parent / "kept.json"
Kept = dict[str, dict[str, dict[str, float | str | None]]]


def read(file: Path = FILE) -> Kept:
    kept: Kept = json.loads(file.read_text(encoding="utf-8"))
    return kept


def write(statements: Iterable[Statement], file: Path = FILE) -> None:
    kept: Kept = {}
    for one in statements:
        of_paper = kept.setdefault(one.paper, {})
        if one.name in of_paper:
            raise ValueError(f"{one.paper} has two statements named {one.name}")
        of_paper[one.name] = {"ours": one.ours, "verdict": one.verdict}
    file.write_text(json.dumps(kept, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


def differences(statements: Iterable[Statement], kept: Kept, document: str) -> list[str]:
    """What no longer is as it was accepted, one line each; none: all is well."""
    found = []
    left = {(paper, name) for paper, of_paper in kept.items() for name in of_paper}
    for one in statements:
        label = f"{one.paper}, {one.place}, {one.name}"
        before = kept.get(one.paper, {}).get(one.name)
        if before is None:
            found.append(f"{label}: stated now, not kept")
            continue
        left.discard((one.paper, one.name))
        if _moved(one, before["ours"]):
            found.append(
                f"{label}: {one.ours} {one.unit}, kept {before['ours']}, may move {one.tolerance}"
            )
        if one.verdict != before["verdict"]:
            found.append(f"{label}: {one.verdict}, kept {before['verdict']}")
        if row_start(one, before["ours"]) not in document:
            found.append(f"{label}: docs/reproduction.md doesn't list it as kept")
    found += [f"{paper}, {name}: kept, no longer stated" for paper, name in sorted(left)]
    return found


def _moved(one: Statement, before: float | str | None) -> bool:
    if one.ours is None or not isinstance(before, float | int):
        return one.ours != before
    return abs(one.ours - before) > one.tolerance
