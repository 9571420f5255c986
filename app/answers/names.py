"""Platforms, places and stars that a request can name, as listed."""

from dataclasses import dataclass

from planner.world.platforms import (
    BODIES,
    PLATFORMS,
    BodyPlatform,
    PlatformDefinition,
    definition_of,
)
from planner.world.targets.autocomplete import KnownPlace, KnownStar


@dataclass(frozen=True, kw_only=True)
class PlatformList:
    """Every registered platform, written as a request may write out its own.

    platforms: all there are, two-axis ones first.
    """

    platforms: list[PlatformDefinition | BodyPlatform]


def platform_list() -> PlatformList:
    return PlatformList(platforms=[*map(definition_of, PLATFORMS.values()), *BODIES.values()])


@dataclass(frozen=True, kw_only=True)
class KnownPlaces:
    """Places whose names begin so.

    places: the most populous first; of those of another name, a twentieth of the people counts.
    """

    places: list[KnownPlace]


@dataclass(frozen=True, kw_only=True)
class KnownStars:
    """Stars whose names begin so.

    stars: the brightest first.
    """

    stars: list[KnownStar]
