"""No function knows a platform by two axes outside that kind's own modules.

Everything else asks the platform, its rules, mover, judge or flyer, so that a third kind is one
module in each registry.  Named are functions whose code has a word that two axes alone have."""

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
# What two axes are and how they move, and the registries that name the kinds.
OWN = (
    "planner/motion", "planner/inflight/simulation", "planner/inflight/telemetry/platforms",
    "planner/output/view/platforms", "planner/planning/campaigns/platforms",
    "planner/planning/opportunities/platforms", "planner/planning/sessions/platforms",
    "planner/verification/platforms", "planner/world/platforms", "planner/world/rules",
)  # fmt: skip
WORD = re.compile(
    r"\b(axis_names|axis_limits|axis_angles|angles_deg|two_axis|AxisState|AxisTrack|AxisLimits"
    r"|TwoAxisPlatform|(outer|inner)_(axis|limits|name|rad|rate)\w*|q_platform_from_body\w*"
    r"|(los|seen|boresight|directions?|axis|axes|q_eci_from|q_itrf_from)_(rate_)?platform\w*)\b"
)


def functions_with_words(module: str) -> list[str]:
    """Their names; a text or comment isn't code."""
    found = []
    if not WORD.search(module):
        return found  # to parse all would take seconds
    for node in ast.walk(ast.parse(module)):
        if isinstance(node, ast.FunctionDef):
            node.body = [part for part in node.body if not is_text(part)] or [ast.Pass()]
            if WORD.search(ast.unparse(node)):
                found.append(node.name)
    return found


def is_text(node: ast.stmt) -> bool:
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)


def test_no_function_knows_two_axes() -> None:
    places = [
        f"{path.relative_to(ROOT)}: {name}"
        for package in ("planner", "app", "slewtrack")
        for path in sorted((ROOT / package).rglob("*.py"))
        if not path.relative_to(ROOT).as_posix().startswith(OWN)
        for name in functions_with_words(path.read_text())
    ]
    assert places == [], "ask the platform, its rules, mover, judge or flyer"


@pytest.mark.parametrize(
    ("module", "names"),
    [
        ("def f(p):\n    return p.two_axis.camera", ["f"]),
        ("def f(inner_rad):\n    pass\ndef g(los_platform):\n    pass", ["f", "g"]),
        ("def f(p):\n    'of two_axis'\n    return p.platform.dof_names  # axis_names", []),
    ],
)
def test_code_that_counts(module: str, names: list[str]) -> None:
    assert functions_with_words(module) == names


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
