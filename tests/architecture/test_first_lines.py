"""The first line of a file states what the file holds."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
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
