"""Platforms, places and stars that a request can name, as listed."""

from dataclasses import dataclass

from planner.world.platforms import PlatformDefinition
from planner.world.targets.autocomplete import KnownPlace, KnownStar


@dataclass(frozen=True, kw_only=True)
class PlatformList:
    """Every registered platform, written as a request may write out its own.

    platforms: all there are.
    """

    platforms: list[PlatformDefinition]


@dataclass(frozen=True, kw_only=True)
class KnownPlaces:
    """Those of just the letters given first, then those whose own name they begin.

    places: of each kind the most populous first.
    """

    places: list[KnownPlace]


@dataclass(frozen=True, kw_only=True)
class KnownStars:
    """Stars whose names begin so.

    stars: in order of the alphabet.
    """

    stars: list[KnownStar]
