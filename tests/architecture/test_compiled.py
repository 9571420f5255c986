"""The cache of compiled code holds nothing that was compiled from other sources."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import planner
from planner.base.compiled import SOURCES

PLANNER = Path(planner.__file__).parent


def test_what_is_compiled_counts_in_the_caches_name() -> None:
    files = {
        path
        for path in PLANNER.rglob("*.py")
        if re.search(r"^@(compiled|nested|lean|inlined)$", path.read_text(), re.MULTILINE)
    }
    assert len(files) > 20
    while others := {path for file in files for path in _compiled_in(file)} - files:
        files |= others
    files.add(PLANNER / "base" / "compiled.py")
    assert sorted(path.relative_to(PLANNER).as_posix() for path in files) == sorted(SOURCES)


def _compiled_in(file: Path) -> Iterator[Path]:
    """The files whose constants and named tuples this one imports."""
    for node in ast.walk(ast.parse(file.read_text())):
        if not isinstance(node, ast.ImportFrom) or not (node.module or "").startswith("planner."):
            continue
        path = PLANNER.parent / (node.module or "").replace(".", "/")
        path = path / "__init__.py" if path.is_dir() else path.with_suffix(".py")
        text = path.read_text()
        for name in (alias.name for alias in node.names):
            if name.isupper() or re.search(rf"class {name}\((NamedTuple|IntEnum)", text):
                yield path
