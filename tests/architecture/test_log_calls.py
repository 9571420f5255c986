"""Log calls of ours put no data into their text: the record's makers can't tell it apart."""

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
FILES = sorted((ROOT / "app").rglob("*.py"))
LEVELS = {"debug", "info", "warning", "error", "exception", "critical"}
# What would make text of an exception or a request, out of the reach of `app.log`.
AS_TEXT = {"repr", "str", "format", "ascii", "format_exc", "format_exception", "join"}


def log_calls(tree):
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
            owner = ast.unparse(node.func.value)
            if owner in ("log", "logger", "logging") and node.func.attr in LEVELS:
                yield node


def makes_text(value) -> bool:
    called = (ast.unparse(node.func) for node in ast.walk(value) if isinstance(node, ast.Call))
    return any(isinstance(node, ast.JoinedStr) for node in ast.walk(value)) or any(
        name.rpartition(".")[2] in AS_TEXT for name in called
    )


def faults(source: str) -> list[str]:
    found = []
    for call in log_calls(ast.parse(source)):
        text, *more = call.args
        if not (isinstance(text, ast.Constant) and isinstance(text.value, str)) or more:
            found.append(f"{call.lineno}: its text isn't one literal")
        for word in call.keywords:
            if word.arg is None or makes_text(word.value):
                found.append(f"{call.lineno}: {word.arg or '**'} is made into text")
            if word.arg == "exc_info" and not isinstance(word.value, ast.Name):
                found.append(f"{call.lineno}: exc_info isn't the exception")
    return found


def test_log_calls_hand_over_values_not_texts():
    found = {str(path.relative_to(ROOT)): faults(path.read_text()) for path in FILES}
    assert len(found) > 100
    assert {path: wrong for path, wrong in found.items() if wrong} == {}


@pytest.mark.parametrize(
    "call",
    [
        "log.error(f'lost {job}')", "log.error('lost %s', job)", "log.error(told)",
        "log.error('lost', error=repr(error))", "log.error('lost', why=str(error))",
        "log.error('lost', why=f'{error}')", "log.error('lost', why=traceback.format_exc())",
        "log.error('lost', exc_info=True)", "log.error('lost', **everything)",
    ],
)  # fmt: skip
def test_other_calls_are_found(call):
    assert len(faults(call)) == 1
