"""Names that go on as somebody has begun to type them: of places, of stars."""

from typing import Annotated

from planner.base.answer_members import Count, Member, Signed, answer
from planner.world.targets.gazetteer import (
    Place,
    other_name_from,
    places_named_from,
    told_apart,
)
from planner.world.targets.names import key_of
from planner.world.targets.star_names import star_names


@answer
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
            words=place.words,
            other_name=_name_begun(place, begun),
            latitude_deg=place.latitude_deg,
            longitude_deg=place.longitude_deg,
            height_m=place.height_m,
        )
        for place in places_named_from(begun)[:most]
    ]


def _name_begun(place: Place, begun: str) -> str | None:
    """The other name of the place that goes on so, in capitals and small letters; None: its own."""
    key = key_of(begun.partition(",")[0])
    return None if key_of(place.name).startswith(key) else other_name_from(place, key).title()


def stars_beginning(begun: str, most: int) -> list[KnownStar]:
    """The brightest first."""
    key = key_of(begun)
    found = [(name, number) for name, number in star_names() if key_of(name).startswith(key)]
    return [KnownStar(name=name, hip=hip) for name, hip in found[:most]] if key else []
