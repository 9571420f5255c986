"""A platform in a request: by its registered name, or written out in degrees."""

from collections.abc import Mapping
from typing import Annotated

from pydantic import Discriminator, Field, GetPydanticSchema, Tag
from pydantic_core import core_schema

from planner.base.spec import About
from planner.world.platforms.body import BodyPlatform
from planner.world.platforms.definition import PlatformDefinition
from planner.world.platforms.iss_hrc import ISS_HRC
from planner.world.platforms.two_axis import TwoAxisPlatform

PLATFORMS = {platform.name: platform for platform in (ISS_HRC,)}


def _name_or_definition(value: object) -> str:
    return "definition" if isinstance(value, Mapping | PlatformDefinition) else "name"


_NameOrDefinition = Annotated[
    Annotated[str, Tag("name"), Field(json_schema_extra={"enum": list(PLATFORMS)})]
    | Annotated[PlatformDefinition, Tag("definition")],
    Discriminator(_name_or_definition),
]


def _find_platform(choice: str | PlatformDefinition) -> TwoAxisPlatform:
    if isinstance(choice, PlatformDefinition):
        return choice.platform()
    if choice not in PLATFORMS:
        raise ValueError(
            f"must be one of {', '.join(PLATFORMS)}, or axes written out in degrees, "
            f"not {choice[:80]!r}"
        )
    return PLATFORMS[choice]


def _kind_or_name(value: object) -> str:
    is_body = isinstance(value, BodyPlatform) or (
        isinstance(value, Mapping) and value.get("kind") == BodyPlatform.kind
    )
    return "body" if is_body else "two_axis"


# A TwoAxisPlatform wherever Python says which; only requests name it or write it out.
Platform = Annotated[
    TwoAxisPlatform,
    GetPydanticSchema(
        lambda _, handler: core_schema.no_info_after_validator_function(
            _find_platform, handler(_NameOrDefinition)
        )
    ),
    About("A registered name, or a two-axis platform written out in degrees."),
]
AnyPlatform = Annotated[
    Annotated[Platform, Tag("two_axis")] | Annotated[BodyPlatform, Tag("body")],
    Discriminator(_kind_or_name),
    About(
        'A registered name, a two-axis platform written out in degrees, or, with "kind": "body", a '
        "spacecraft that turns as a whole."
    ),
]
