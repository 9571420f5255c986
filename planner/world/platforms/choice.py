"""A platform in a request: by its registered name, or written out in degrees by its kind."""

from collections.abc import Mapping
from typing import Annotated

from pydantic import Discriminator, Field, GetPydanticSchema, Tag
from pydantic_core import core_schema

from planner.base.spec import About
from planner.world.platforms.agile_cmg import AGILE_CMG
from planner.world.platforms.body import BodyPlatform
from planner.world.platforms.definition import PlatformDefinition
from planner.world.platforms.iss_hrc import ISS_HRC
from planner.world.platforms.smallsat_120kg import SMALLSAT_120KG
from planner.world.platforms.two_axis import TwoAxisPlatform

PLATFORMS = {platform.name: platform for platform in (ISS_HRC,)}
BODIES = {platform.name: platform for platform in (SMALLSAT_120KG, AGILE_CMG)}


def _name_or_kind(value: object) -> str:
    if isinstance(value, Mapping):
        return str(value.get("kind", TwoAxisPlatform.kind))
    return str(getattr(value, "kind", "name"))


_TwoAxis = Annotated[PlatformDefinition, Tag("two_axis")]
_NameOrTwoAxis = Annotated[
    Annotated[str, Tag("name"), Field(json_schema_extra={"enum": list(PLATFORMS)})] | _TwoAxis,
    Discriminator(
        _name_or_kind,
        custom_error_type="unknown_kind",
        custom_error_message="must be two_axis here, which may be left out",
        custom_error_context={"member": "kind"},
    ),
]
_NameOrAny = Annotated[
    Annotated[str, Tag("name"), Field(json_schema_extra={"enum": [*PLATFORMS, *BODIES]})]
    | _TwoAxis
    | Annotated[BodyPlatform, Tag("body")],
    Discriminator(
        _name_or_kind,
        custom_error_type="unknown_kind",
        custom_error_message="must be one of two_axis, body",
        custom_error_context={"member": "kind"},
    ),
]


def _find_two_axis(choice: str | PlatformDefinition) -> TwoAxisPlatform:
    if isinstance(choice, PlatformDefinition):
        return choice.platform()
    if choice not in PLATFORMS:
        raise ValueError(
            f"must be one of {', '.join(PLATFORMS)}, or axes written out in degrees, "
            f"not {choice[:80]!r}"
        )
    return PLATFORMS[choice]


def _find_any(choice: str | PlatformDefinition | BodyPlatform) -> TwoAxisPlatform | BodyPlatform:
    if isinstance(choice, BodyPlatform):
        return choice
    if isinstance(choice, str) and choice in BODIES:
        return BODIES[choice]
    return _find_two_axis(choice)


# A TwoAxisPlatform wherever Python says which; only requests name it or write it out.
Platform = Annotated[
    TwoAxisPlatform,
    GetPydanticSchema(
        lambda _, handler: core_schema.no_info_after_validator_function(
            _find_two_axis, handler(_NameOrTwoAxis)
        )
    ),
    About("A registered name, or a two-axis platform written out in degrees."),
]
AnyPlatform = Annotated[
    TwoAxisPlatform | BodyPlatform,
    GetPydanticSchema(
        lambda _, handler: core_schema.no_info_after_validator_function(
            _find_any, handler(_NameOrAny)
        )
    ),
    About(
        'A registered name, a two-axis platform written out in degrees, or, with "kind": "body", a '
        "spacecraft that turns as a whole."
    ),
]
