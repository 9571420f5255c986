"""Every kind of refusal that the product can make, loaded or not."""

import re
from importlib import import_module
from pathlib import Path

from planner.base.errors import Refusal

ROOT = Path(__file__).parents[1]
PACKAGES = ("app", "planner", "estimator")


def refusal_kinds() -> set[type[Refusal]]:
    """With a name of its own; those that only special-case another are left out."""
    return {kind for kind in every_refusal() if "slug" in vars(kind)}


def every_refusal() -> set[type[Refusal]]:
    """The classes themselves, those of tests left out."""
    bases = "|".join(kind.__name__ for kind in _with_special_cases(Refusal))
    for package in PACKAGES:
        for file in (ROOT / package).rglob("*.py"):
            if re.search(rf"^class \w+\((?:{bases})\):", file.read_text(), re.MULTILINE):
                import_module(".".join(file.relative_to(ROOT).with_suffix("").parts))
    known = _with_special_cases(Refusal)
    return {kind for kind in known if kind.__module__.split(".")[0] in PACKAGES}


def _with_special_cases(kind: type[Refusal]) -> set[type[Refusal]]:
    return {kind}.union(*map(_with_special_cases, kind.__subclasses__()))
