"""Names of a package that are loaded when they are first asked for (PEP 562).

A package's face tells what is asked and answered by it; who only reads or writes that must not
load the solvers behind it.
"""

from collections.abc import Callable
from importlib import import_module
from typing import Any


def on_first_use(**module_by_name: str) -> Callable[[str], Any]:
    """A package's `__getattr__`; type checkers are told of the same names by imports."""

    def __getattr__(name: str) -> Any:  # noqa: ANN401, N807 (as Python calls it)
        if name not in module_by_name:
            raise AttributeError(f"there is no {name!r} here")
        return getattr(import_module(module_by_name[name]), name)

    return __getattr__
