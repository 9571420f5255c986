"""The first line of a file states what the file holds."""

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
FILES = sorted(
    file
    for room in ("app", "slewtrack")
    for file in (ROOT / room).rglob("*.py")
    if file.read_text(encoding="utf-8").strip()
)
ASKS = re.compile(r"(What|How|Where|When|Whether|Which|Who|Why)\b|.*\?")


@pytest.mark.parametrize("file", FILES, ids=lambda file: str(file.relative_to(ROOT)))
def test_the_first_line_is_a_statement(file):
    docstring = ast.get_docstring(ast.parse(file.read_text(encoding="utf-8")))
    assert docstring, "say in the first line what the file holds"
    first = docstring.splitlines()[0]
    assert not ASKS.match(first), f"a question, or half of one: {first}"
    assert first.endswith("."), f"no sentence: {first}"
