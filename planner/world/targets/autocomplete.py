"""Names that go on as somebody has begun to type them: of places, of stars."""

from typing import Annotated

from planner.base.answer_members import Count, Member, Signed, answer
from planner.world.targets.gazetteer import places_named_from, told_apart
from planner.world.targets.names import key_of
from planner.world.targets.star_names import star_names


@answer
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
    latitude_deg: Annotated[float, Member(least=-90.0, greatest=90.0)]
    longitude_deg: Annotated[float, Member(least=-180.0, greatest=180.0)]
    height_m: Signed


@answer
class KnownStar:
    """A star with a proper name.

    name: for `name` of a target of mode `star`. E.g. `"Vega"`.
    hip: Hipparcos number. E.g. `91262`.
    """

    name: str
    hip: Count


def places_beginning(begun: str, most: int) -> list[KnownPlace]:
    """Each with the shortest name that means it alone; see `places_named_from`."""
    return [
        KnownPlace(
            name=told_apart(place),
            words=place.in_words,
            latitude_deg=place.latitude_deg,
            longitude_deg=place.longitude_deg,
            height_m=place.height_m,
        )
        for place in places_named_from(begun)[:most]
    ]


def stars_beginning(begun: str, most: int) -> list[KnownStar]:
    """In order of the alphabet."""
    key = key_of(begun)
    found = [(name, number) for name, number in star_names() if key_of(name).startswith(key)]
    return [KnownStar(name=name, hip=hip) for name, hip in sorted(found)[:most]] if key else []
