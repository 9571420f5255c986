"""A sample of one-place changes of the judges, slews, jobs and requests, for `mutants.py`."""

import ast
import copy
import random
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[1]
ROOMS = (
    "planner/verification",
    "planner/spacecraft/verification.py",
    "planner/slew",
    "app/jobs",
    "app/requests",
)
LEFT_OUT = ("app/requests/examples/",)  # what the pages show, compared with their answers as text

OPPOSITES: dict[type[ast.AST], tuple[type[ast.AST], ...]] = {
    ast.Lt: (ast.LtE, ast.Gt), ast.LtE: (ast.Lt, ast.Gt), ast.Gt: (ast.GtE, ast.Lt),
    ast.GtE: (ast.Gt, ast.Lt), ast.Eq: (ast.NotEq,), ast.NotEq: (ast.Eq,), ast.Is: (ast.IsNot,),
    ast.IsNot: (ast.Is,), ast.In: (ast.NotIn,), ast.NotIn: (ast.In,), ast.Add: (ast.Sub,),
    ast.Sub: (ast.Add,), ast.Mult: (ast.Div,), ast.Div: (ast.Mult,), ast.FloorDiv: (ast.Mult,),
    ast.Mod: (ast.Mult,), ast.Pow: (ast.Mult,), ast.BitAnd: (ast.BitOr,), ast.BitOr: (ast.BitAnd,),
    ast.And: (ast.Or,), ast.Or: (ast.And,),
}  # fmt: skip


@dataclass(frozen=True)
class Mutant:
    """One change: the source's characters from `first` up to `past` become `new`."""

    file: str
    line: int
    first: int
    past: int
    old: str
    new: str


def sample(count: int, seed: int) -> list[Mutant]:
    """At most one mutant a line, in each room as many as its share of all lines."""
    files = {room: _files(room) for room in ROOMS}
    lines = {room: sum(_lines(file) for file in files[room]) for room in ROOMS}
    chosen = []
    for room in ROOMS:
        draw = random.Random(f"{seed} {room}")  # whatever becomes of the other rooms
        by_line: dict[tuple[str, int], list[Mutant]] = {}
        for file in files[room]:
            for mutant in _mutants(file):
                by_line.setdefault((file, mutant.line), []).append(mutant)
        mutants = [draw.choice(of_a_line) for of_a_line in by_line.values()]
        draw.shuffle(mutants)
        chosen += mutants[: round(count * lines[room] / sum(lines.values()))]
    return chosen


def _files(room: str) -> list[str]:
    path = ROOT / room
    found = [path] if path.is_file() else sorted(path.rglob("*.py"))
    names = [str(one.relative_to(ROOT)) for one in found]
    return [name for name in names if not name.startswith(LEFT_OUT)]


def _lines(file: str) -> int:
    return len((ROOT / file).read_text().splitlines())


def _mutants(file: str) -> Iterator[Mutant]:
    source = (ROOT / file).read_text()
    starts = [0]
    for line in source.splitlines(keepends=True):
        starts.append(starts[-1] + len(line.encode()))
    text = source.encode()
    for node, changed in _changes(ast.parse(source)):
        assert isinstance(node, ast.expr | ast.stmt)
        assert node.end_lineno is not None
        assert node.end_col_offset is not None
        first = starts[node.lineno - 1] + node.col_offset
        past = starts[node.end_lineno - 1] + node.end_col_offset
        new = ast.unparse(changed)
        if isinstance(node, ast.expr) and not isinstance(node, ast.Constant):
            new = f"({new})"
        yield Mutant(file, node.lineno, first, past, text[first:past].decode(), new)


def _changes(node: ast.AST) -> Iterator[tuple[ast.AST, ast.AST]]:
    """Each node that may be changed, and what it becomes."""
    if _is_told(node):
        return
    yield from ((node, changed) for changed in _changed(node))
    if isinstance(node, ast.If | ast.IfExp) and not isinstance(node.test, ast.Compare):
        yield node.test, ast.UnaryOp(ast.Not(), node.test)
    for name, value in ast.iter_fields(node):
        if name in ("annotation", "returns", "decorator_list", "type_params", "bases"):
            continue
        for child in value if isinstance(value, list) else [value]:
            if isinstance(child, ast.AST):
                yield from _changes(child)


def _is_told(node: ast.AST) -> bool:
    """Wording, logs, imports and types: nothing that the product does."""
    if isinstance(node, ast.JoinedStr | ast.Import | ast.ImportFrom | ast.pattern):
        return True
    if isinstance(node, ast.Expr) and isinstance(node.value, ast.Call):
        called = ast.unparse(node.value.func)
        return called.startswith(("log.", "_log.", "logger.", "logging.", "warnings."))
    return isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING"


def _changed(node: ast.AST) -> Iterator[ast.AST]:
    if isinstance(node, ast.Constant):
        yield from _other_constants(node)
    elif isinstance(node, ast.Compare):
        for index, operator in enumerate(node.ops):
            for other in OPPOSITES[type(operator)]:
                changed = copy.deepcopy(node)
                changed.ops[index] = other()  # type: ignore[call-overload]  # of the same kind
                yield changed
    elif isinstance(node, ast.BinOp | ast.BoolOp | ast.AugAssign):
        yield from _other_operations(node)
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not | ast.USub):
        yield node.operand
    elif isinstance(node, ast.Return) and node.value and ast.unparse(node.value) != "None":
        yield ast.Return(None)
    elif isinstance(node, ast.Raise | ast.Continue | ast.Break) or (
        isinstance(node, ast.Expr) and isinstance(node.value, ast.Call)
    ):
        yield ast.Pass()


def _other_operations(node: ast.BinOp | ast.BoolOp | ast.AugAssign) -> Iterator[ast.AST]:
    for other in OPPOSITES.get(type(node.op), ()):
        changed = copy.deepcopy(node)
        changed.op = other()  # type: ignore[assignment]  # of the same kind
        yield changed
    if isinstance(node, ast.AugAssign):
        yield ast.Pass()


def _other_constants(node: ast.Constant) -> Iterator[ast.AST]:
    if isinstance(node.value, bool):
        yield ast.Constant(not node.value)
    elif isinstance(node.value, int | float):
        others = {node.value + 1, node.value * 2, 0} - {node.value}
        yield from (ast.Constant(other) for other in sorted(others))
