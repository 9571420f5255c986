"""Stars by their proper names: those the IAU settled and others in use."""

import csv
from functools import cache
from pathlib import Path

from planner.world.targets.names import key_of, nearest_keys

_NAMES = Path(__file__).parent / "data" / "star_names.csv"


def hipparcos_number(name: str) -> int:
    """Raises ValueError with the names most like it."""
    known = _star_numbers()
    found = known.get(key_of(name))
    if found is None:
        alike = [_star_spellings()[key] for key in nearest_keys(key_of(name), known)]
        raise ValueError(
            f"name {name!r} is none of the {len(known)} star names known here"
            + (f" (do you mean {' or '.join(alike)}?)" if alike else "")
            + "; give the star's Hipparcos number as hip, or its ra_deg and dec_deg"
        )
    return found


@cache
def _star_numbers() -> dict[str, int]:
    return {key_of(name): number for name, number in star_names()}


@cache
def _star_spellings() -> dict[str, str]:
    return {key_of(name): name for name, _ in star_names()}


@cache
def star_names() -> list[tuple[str, int]]:
    """Every name with its Hipparcos number."""
    with _NAMES.open(encoding="utf-8", newline="") as file:
        lines = (line for line in file if not line.startswith("#"))
        return [(row["name"], int(row["hip"])) for row in csv.DictReader(lines)]
