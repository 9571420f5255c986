"""Every kind of refusal that the loaded product can make."""

from planner.errors import Refusal


def refusal_kinds() -> set[type[Refusal]]:
    """With a name of its own; those that only special-case another are left out."""
    return {kind for kind in _with_special_cases(Refusal) if "slug" in vars(kind)}


def _with_special_cases(kind: type[Refusal]) -> set[type[Refusal]]:
    return {kind}.union(*map(_with_special_cases, kind.__subclasses__()))
