"""Names that go on as somebody has begun to type them: of places, of stars."""

from planner.world.targets.gazetteer import Place, other_name_from, places_named_from, told_apart
from planner.world.targets.names import key_of
from planner.world.targets.star_names import star_names


def places_beginning(begun: str, most: int) -> list[tuple[str, Place]]:
    """Each with the shortest name that means it alone; see `places_named_from`."""
    return [(told_apart(place), place) for place in places_named_from(begun)[:most]]


def name_begun(place: Place, begun: str) -> str | None:
    """The other name of the place that goes on so, in capitals and small letters; None: its own."""
    key = key_of(begun.partition(",")[0])
    return None if key_of(place.name).startswith(key) else other_name_from(place, key).title()


def stars_beginning(begun: str, most: int) -> list[tuple[str, int]]:
    """Name and Hipparcos number, the brightest first."""
    key = key_of(begun)
    found = [(name, number) for name, number in star_names() if key_of(name).startswith(key)]
    return found[:most] if key else []
