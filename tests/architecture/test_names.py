"""Does every number that is a quantity say its unit, and every file its question?"""

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
FILES = sorted(
    path for room in ("app", "planner", "estimator") for path in (ROOT / room).rglob("*.py")
)
UNIT = re.compile(
    r"_(m|km|m2|mm|um|nm|s|us|ms|days?|orbits|seconds|jyear|mjd|jd|rad2?|deg2?|arcsec2?|mas|hz|px|kg"
    r"|n_m|n_m_s|pa|k|e|bytes|kg_m2|kg_m3|mas_yr|rad_yr|m_s2?|km_s|rad_s[23]?|deg_s[23]?|deg2_s5"
    r"|per_s2?|ticks|rows)$"
)
# What has no unit, by the word a name holds.
PURE = re.compile(
    r"(^|_)(probability|share|ratio|damping|coefficient|weight|gain|score|priority|cost|factor|scale"
    r"|value|extreme|margin|limit|bound|sigma|cover|depth|density|sign|step|gamma|exposure|blur"
    r"|ozone|airglow|moonlight|glare|land|up|default|bstar|eccentricity|error|integral|spread"
    r"|objective|level|size|inclusive|threshold|least|greatest)(_|$)"
)


def float_fields(tree):
    """Annotated float attributes of classes: (line, name)."""
    for node in ast.walk(tree):
        if isinstance(node, ast.ClassDef):
            for item in node.body:
                if isinstance(item, ast.AnnAssign) and isinstance(item.target, ast.Name):
                    annotation = ast.unparse(item.annotation)
                    if annotation in ("float", "float | None"):
                        yield item.lineno, item.target.id


def float_parameters(tree):
    """Float parameters of public functions: (line, name)."""
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef) and not node.name.startswith("_"):
            for argument in (*node.args.args, *node.args.kwonlyargs):
                if argument.annotation and ast.unparse(argument.annotation) in (
                    "float",
                    "float | None",
                ):
                    yield node.lineno, argument.arg


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(ROOT)))
def test_quantities_carry_their_unit(path):
    tree = ast.parse(path.read_text())
    bare = [
        f"{path.relative_to(ROOT)}:{line}: {name}"
        for line, name in (*float_fields(tree), *float_parameters(tree))
        if not UNIT.search(f"_{name}") and not PURE.search(name)
    ]
    assert bare == []


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(ROOT)))
def test_every_file_says_what_it_is_for(path):
    tree = ast.parse(path.read_text())
    assert not tree.body or ast.get_docstring(tree)
