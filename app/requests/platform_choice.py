"""How does a request name its platform?"""

from collections.abc import Mapping
from typing import Annotated

from pydantic import Discriminator, Field, Tag

from planner.platforms import PLATFORMS, PlatformDefinition, TwoAxisPlatform


def _name_or_definition(value: object) -> str:
    return "definition" if isinstance(value, Mapping | PlatformDefinition) else "name"


PlatformChoice = Annotated[
    Annotated[str, Tag("name"), Field(json_schema_extra={"enum": list(PLATFORMS)})]
    | Annotated[PlatformDefinition, Tag("definition")],
    Discriminator(_name_or_definition),
]


def chosen(choice: str | PlatformDefinition) -> TwoAxisPlatform:
    """The platform registered by that name, or as written out; raises ValueError."""
    if isinstance(choice, PlatformDefinition):
        return choice.platform()
    if choice not in PLATFORMS:
        raise ValueError(
            f"platform must be one of {', '.join(PLATFORMS)}, or axes written out in degrees, "
            f"not {choice[:80]!r}"
        )
    return PLATFORMS[choice]
