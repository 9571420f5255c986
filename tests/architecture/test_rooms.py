"""The table of the planner's rooms in docs/architecture.md shows what the code imports."""

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
TABLE = re.findall(
    r"^\| `(\w+)` \| ([\d,]+) \| (.*) \|$",
    (ROOT / "docs/architecture.md").read_text(),
    re.MULTILINE,
)
ROOMS = sorted(
    path.name for path in (ROOT / "planner").iterdir() if (path / "__init__.py").exists()
)


def imported(path: Path) -> set[str]:
    """Rooms of the planner that a file imports from."""
    modules: list[str] = []
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom):
            modules.append(node.module or "")
        elif isinstance(node, ast.Import):
            modules += [name.name for name in node.names]
    return {module.split(".")[1] for module in modules if module.startswith("planner.")}


def test_every_room_has_a_row() -> None:
    assert sorted(room for room, _, _ in TABLE) == ROOMS


@pytest.mark.parametrize(("room", "lines", "imports"), TABLE)
def test_a_row_tells_what_the_room_holds(room: str, lines: str, imports: str) -> None:
    files = sorted((ROOT / "planner" / room).rglob("*.py"))
    found = set().union(*map(imported, files)) - {room}
    assert set(re.findall(r"`(\w+)`", imports)) == found
    counted = sum(len(path.read_text().splitlines()) for path in files)
    assert int(lines.replace(",", "")) == pytest.approx(counted, rel=0.1)
