"""Platforms, places and stars that a request can name, as listed."""

from dataclasses import dataclass

from app.answers.platform import definition_of
from app.answers.ranges import Count, LatitudeDeg, LongitudeDeg, Signed
from planner.world.platforms import PLATFORMS, PlatformDefinition
from planner.world.targets.autocomplete import places_beginning, stars_beginning


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
    latitude_deg: geodetic, WGS84; north positive.
    longitude_deg: WGS84; east positive.
    height_m: above the WGS84 ellipsoid.
    """

    name: str
    words: str
    latitude_deg: LatitudeDeg
    longitude_deg: LongitudeDeg
    height_m: Signed


@dataclass(frozen=True, kw_only=True)
class KnownPlaces:
    """Those of just the letters given first, then those whose own name they begin.

    places: of each kind the most populous first.
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

    stars: in order of the alphabet.
    """

    stars: list[KnownStar]


def platform_list() -> PlatformList:
    """All there are."""
    return PlatformList(platforms=[definition_of(platform) for platform in PLATFORMS.values()])


def known_places(begin: str, limit: int) -> KnownPlaces:
    """The first that begin so."""
    return KnownPlaces(
        places=[
            KnownPlace(
                name=name,
                words=place.in_words,
                latitude_deg=place.latitude_deg,
                longitude_deg=place.longitude_deg,
                height_m=place.height_m,
            )
            for name, place in places_beginning(begin, limit)
        ]
    )


def known_stars(begin: str, limit: int) -> KnownStars:
    """The first that begin so."""
    found = stars_beginning(begin, limit)
    return KnownStars(stars=[KnownStar(name=name, hip=hip) for name, hip in found])
