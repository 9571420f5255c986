"""Words of the sources and pages: first lines, units in names, sentences of the documentation."""

import ast
import re
from pathlib import Path

import pytest

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


ASKS = re.compile(r"(What|How|Where|When|Whether|Which|Who|Why)\b|.*\?")


def first_line(file):
    """Of its docstring, with which it begins; empty where it has none."""
    begin, quotes, line = file.read_text(encoding="utf-8").partition("\n")[0].partition('"""')
    return line.removesuffix('"""') if quotes and not begin else ""


@pytest.mark.parametrize("room", ["app", "slewtrack", "planner", "estimator", "tests", "bench"])
def test_first_lines_are_statements(room):
    files = [file for file in sorted((ROOT / room).rglob("*.py")) if file.read_text().strip()]
    assert files
    assert [str(file) for file in files if ASKS.match(first_line(file))] == []
    product = room in ("app", "slewtrack", "planner", "estimator")
    assert [str(file) for file in files if product and not first_line(file).endswith(".")] == []


# docs/reproduction.md is written by `make reproduce`.
PAGES = [
    ROOT / "README.md",
    ROOT / "CONTRIBUTING.md",
    *sorted(page for page in (ROOT / "docs").rglob("*.md") if page.name != "reproduction.md"),
]
WORDS_OF_PROSE, WORDS_OF_CELL = 40, 60
FENCED = re.compile(r"^( *)(```|\$\$).*?^ *\2$|^    \S[^\n]*$", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"!?\[([^\]]*)\]\([^)]*\)")
BLOCK_START = re.compile(r"\n\s*\n|\n(?=\s*(?:[-*]|\d+\.)\s|#|\|)|(?<=\n)(#+ .*)\n")
SENTENCE_END = re.compile(r"(?<=[.?!;])[)*\"]*\s+(?=[(*\"]*(?:[A-Z0-9Ω°]|slewtrack))|;\s")
WORD = re.compile(r"\w")


def sentences(text: str):
    """Each sentence or cell's sentence with the words that it may have."""
    text = LINK.sub(r"\1", FENCED.sub("", text))  # a link is its words
    text = re.sub(r"`[^`\n]*`", "Code", text)  # and code is one word
    for block in filter(None, BLOCK_START.split(f"\n{text}")):
        is_row = block.startswith("|")
        most = WORDS_OF_CELL if is_row else WORDS_OF_PROSE
        for cell in block.strip("|").split("|") if is_row else [block]:
            yield from ((part, most) for part in SENTENCE_END.split(cell))


def words(sentence: str) -> int:
    return sum(1 for word in sentence.split() if WORD.search(word))


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_sentences_are_short(page):
    long = {
        sentence: f"{words(sentence)} words, {most} at most"
        for sentence, most in sentences(page.read_text(encoding="utf-8"))
        if words(sentence) > most
    }
    assert long == {}


def test_the_count_of_words_sees_prose_lists_and_tables():
    text = "One two `a b c` [four five](x.md). Six\nseven: eight!\n\n- nine ten\n\n| a b | c |\n"
    text += "## Four more\nOne.\n\n    code\n\n```\ncode\n```\nTwo words\n"
    counted = [(words(sentence), most) for sentence, most in sentences(text) if words(sentence)]
    prose = [(5, 40), (3, 40), (2, 40)]
    assert counted == [*prose, (2, 60), (1, 60), (2, 40), (1, 40), (2, 40)]
