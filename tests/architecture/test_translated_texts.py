"""Patterns by which the page translates the service's texts are made of texts the service has."""

import ast
import json
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PATTERNS = json.loads((ROOT / "web/src/i18n/ru/service.json").read_text())
HOLE = re.compile(r"\{\w+\}|<\w+>")
LEAST = 12  # letters of a piece that is worth looking for


@pytest.fixture(scope="module")
def texts() -> str:
    """All strings of the service's code but docstrings, each between ends of lines."""
    files = [
        path for name in ("app", "planner", "estimator") for path in ROOT.glob(f"{name}/**/*.py")
    ]
    found = []
    for path in files:
        nodes = list(ast.walk(ast.parse(path.read_text())))
        told = {id(node.value) for node in nodes if isinstance(node, ast.Expr)}
        found += [
            node.value
            for node in nodes
            if isinstance(node, ast.Constant)
            and isinstance(node.value, str)
            and id(node) not in told
        ]
    return "\n".join(["", *found, ""])


def is_made_of(piece: str, texts: str, before: str = "") -> bool:
    """Whether it lies in one string, or in several of which each goes on where one ends."""
    if before + piece in texts:
        return True
    for at in range(1, len(piece)):
        if before + piece[:at] not in texts:
            return False  # nor is anything longer
        if f"{before}{piece[:at]}\n" in texts and is_made_of(piece[at:], texts, "\n"):
            return True
    return False


@pytest.mark.parametrize("pattern", PATTERNS)
def test_a_pattern_is_made_of_what_the_service_says(pattern, texts):
    pieces = [piece for piece in HOLE.split(pattern) if len(piece) >= LEAST]
    assert [piece for piece in pieces if not is_made_of(piece, texts)] == []


def test_a_text_that_nobody_says_is_found_out(texts):
    assert not is_made_of(" days from the plan: expect a mistake of some ", texts)
