"""Platforms, places and stars that a request can name, as listed."""

from dataclasses import dataclass

from app.answers.ranges import Count, LatitudeDeg, LongitudeDeg, Signed
from planner.world.platforms import PlatformDefinition


@dataclass(frozen=True, kw_only=True)
class PlatformList:
    """Every registered platform, written as a request may write out its own.

    platforms: all there are.
    """

    platforms: list[PlatformDefinition]


@dataclass(frozen=True, kw_only=True)
class KnownPlace:
    """A town of 15,000 people or more.

    name: the shortest that means it alone, for `name` of a target of mode `place`. E.g.
    `"London, GB"`.
    words: its name with region and country. E.g. `"London, England, GB"`.
    other_name: another name of it, which what was typed begins; null where its own does. E.g.
    `"Cologne"`.
    latitude_deg: geodetic, WGS84; north positive.
    longitude_deg: WGS84; east positive.
    height_m: above the WGS84 ellipsoid.
    """

    name: str
    words: str
    other_name: str | None
    latitude_deg: LatitudeDeg
    longitude_deg: LongitudeDeg
    height_m: Signed


@dataclass(frozen=True, kw_only=True)
class KnownPlaces:
    """Places whose names begin so.

    places: the most populous first; of those of another name, a twentieth of the people counts.
    """

    places: list[KnownPlace]


@dataclass(frozen=True, kw_only=True)
class KnownStar:
    """A star with a proper name.

    name: for `name` of a target of mode `star`. E.g. `"Vega"`.
    hip: Hipparcos number. E.g. `91262`.
    """

    name: str
    hip: Count


@dataclass(frozen=True, kw_only=True)
class KnownStars:
    """Stars whose names begin so.

    stars: the brightest first.
    """

    stars: list[KnownStar]
