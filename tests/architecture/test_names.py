"""Every number that is a quantity says its unit."""

import ast
import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
FILES = sorted(
    path for room in ("app", "planner", "estimator") for path in (ROOT / room).rglob("*.py")
)
UNIT = re.compile(
    r"_(m|km|m2|mm|um|nm|s|us|ms|days?|orbits|seconds|jyear|mjd|jd|rad2?|deg2?|arcsec2?|mas|hz|px2?|kg"
    r"|n_m|n_m_s|pa|k|e|bytes|kg_m2|kg_m3|m3_s2|mas_yr|rad_yr|m_s2?|km_s|rad_s[23]?|arcsec_s|arcmin_s|deg_s[23]?|(deg|rad)2_s5"
    r"|per_s[23]?|ticks|rows|w|wh|gbit|gbit_s)$"
)
# What has no unit, by the word a name holds.
PURE = re.compile(
    r"(^|_)(probability|share|ratio|damping|coefficient|weight|gain|score|priority|price|cost|factor|scale"
    r"|value|extreme|margin|limit|bound|sigma|cover|depth|density|sign|step|gamma|exposure|blur"
    r"|correlation|ozone|airglow|moonlight|quality|glare|land|up|default|bstar|eccentricity|error|integral|spread"
    r"|objective|level|capacity|size|inclusive|threshold|least|greatest|exponent|cosine|sine|contrast"
    r"|transmittance|index|tau)(_|$)"
)


# An array that ends in its frame and no unit is a direction, `x_from_y` a rotation.
DIRECTION = re.compile(
    r"_(itrf|gcrf|eci|lvlh|body|base|platform|payload|camera|sensor|enu|wheel|gyro|orbit|mean)$|(^|_)\w+_from_"
)
# The parts of a state have several units, which stand beside it; a position is angles of axes or
# the quaternion of a body.
PURE_ARRAY = re.compile(
    r"(^|_)(positions?|xyzw|directions?|cosines?|normals?|axis|axes|rotation|matrix|weights?|coefficients?|mask|image|unit"
    r"|numbers|signs|mrp|states?|basis|limits|shares?|probabilities|priorities|knots|scores?|costs?|parameters)(_|$)"
)
NUMBER = ("float", "float | None")
ARRAY = re.compile(
    r"(Array|NDArray\[np\.float64\]|np\.ndarray|(tuple|list|Sequence)\[[^=]*(Array|float)[^=]*\])"
    r"( \| None)?"
)
NORMALISED = "normalised time: the motion lasts 1"
# A textbook's letter inside a cited formula.
SYMBOL = re.compile(r"[a-zA-Z]\d?")
CASADI = ("x0",)  # by whose name it is passed on


def holds_settings(node):
    """Whether it is a dataclass of nothing but fields with values."""
    fields = [item for item in node.body if not isinstance(item, ast.Expr)]
    is_dataclass = any("dataclass(" in ast.unparse(of) for of in node.decorator_list)
    return is_dataclass and all(isinstance(item, ast.AnnAssign) and item.value for item in fields)


def annotated(tree):
    """Attributes of classes and parameters of functions: (line, name, annotation, is private).

    Settings are left out: most are counts and shares, each with a line that says of what.
    """
    for node in ast.walk(tree):
        if isinstance(node, ast.ClassDef) and not holds_settings(node):
            for item in node.body:
                if isinstance(item, ast.AnnAssign) and isinstance(item.target, ast.Name):
                    yield item.lineno, item.target.id, ast.unparse(item.annotation), False
        elif isinstance(node, ast.FunctionDef):
            for argument in (*node.args.args, *node.args.kwonlyargs):
                if argument.annotation:
                    private = node.name.startswith("_")
                    yield node.lineno, argument.arg, ast.unparse(argument.annotation), private


def has_unit_or_needs_none(name, annotation, private):
    if (
        name in CASADI
        or UNIT.search(f"_{name}")
        or PURE.search(name)
        or (private and SYMBOL.fullmatch(name))
    ):
        return True
    if annotation in NUMBER:
        return False
    return (
        not ARRAY.fullmatch(annotation)
        or DIRECTION.search(name) is not None
        or PURE_ARRAY.search(name) is not None
    )


def bare(path):
    """Where a file says that it works in normalised time, none has one."""
    room, tree = path.relative_to(ROOT).as_posix(), ast.parse(path.read_text())
    if NORMALISED in " ".join((ast.get_docstring(tree) or "").lower().split()):
        return []
    return [
        f"{room}:{line}: {name}: {annotation}"
        for line, name, annotation, private in annotated(tree)
        if not has_unit_or_needs_none(name, annotation, private)
    ]


def test_quantities_carry_their_unit():
    assert len(FILES) > 200
    assert [fault for path in FILES for fault in bare(path)] == []
