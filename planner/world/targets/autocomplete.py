"""Names that go on as somebody has begun to type them: of places, of stars."""

from planner.world.targets.gazetteer import Place, places_named_from, told_apart
from planner.world.targets.names import key_of
from planner.world.targets.star_names import star_names


def places_beginning(begun: str, most: int) -> list[tuple[str, Place]]:
    """Each with the shortest name that means it alone; see `places_named_from`."""
    return [(told_apart(place), place) for place in places_named_from(begun)[:most]]


def stars_beginning(begun: str, most: int) -> list[tuple[str, int]]:
    """Name and Hipparcos number, in order of the alphabet."""
    key = key_of(begun)
    found = [(name, number) for name, number in star_names() if key_of(name).startswith(key)]
    return sorted(found)[:most] if key else []
