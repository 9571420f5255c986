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
    r"_(m|km|m2|m3|mm|um|nm|s|us|ms|days?|jyear|mjd|jd|rad|rad2|deg|deg2|arcsec2?|arcmin|mas|hz|px|kg"
    r"|n_?m|n_?m_s|pa|k|dn|bits|bytes|w_m2|kg_m2|kg_m3|per_m|per_s|percent|share|ratio|fraction"
    r"|mas_yr|m_s2?|km_s|rad_s[23]?|deg_s[23]?|n_m_s|m_s_2|rad_per_s|platform_s2?|ticks?)$"
)
# Numbers without a unit, by the word their name ends in.
PURE = re.compile(
    r"(^|_)(coefficient|probability|damping|exponent|order|weight|gain|score|share|eccentricity"
    r"|value|extreme|margin|least|greatest|limit_value|bound|objective|integral|factor|scale|k1|k2"
    r"|fx|fy|cx|cy|snr|smear|cost|gap|priority|threshold|sigmas?|chi2|xi|rho|number|level|size)$"
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
