"""Places by name, from a packaged extract of GeoNames.

The file has two parts.  First a line per place, the most populous first; then, after an empty
line, every name's key with the numbers of the lines it means, sorted, so that a name is found
by halving.  `tests/oracles/make_names.py` of commit a69fc61e made it and says where heights come
from.
Source: GeoNames (geonames.org), CC BY 4.0.
"""

import csv
import lzma
import math
from bisect import bisect_left
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from unicodedata import normalize

import numpy as np

from planner.base.arrays import Array
from planner.world.frames.geodesy import up_itrf
from planner.world.targets.names import key_of, may_suggest, nearest_keys
from planner.world.targets.refraction import EARTH_RADIUS_M

_DATA = Path(__file__).parent / "data"
_OTHERWISE = "give latitude_deg, longitude_deg and height_m with mode ground"


@dataclass(frozen=True, kw_only=True)
class GazetteerOptions:
    """How names are understood."""

    candidates: int = 8  # told of a name that several places have
    looked_at: int = 1000  # of those that a few letters begin, the most populous
    far_more: float = 20.0  # times as populous: who means one of the others says which
    metropolis_km: float = 20.0  # a suburb is told by its city's name
    near_km: float = 100.0  # a town farther off tells nobody where a place is


OPTIONS = GazetteerOptions()


class NameUnclear(ValueError):
    """A name that means no one place.

    candidates: names that each mean one, of those it may mean or that are spelt like it.
    """

    def __init__(self, detail: str, candidates: tuple[str, ...] = ()) -> None:
        super().__init__(detail)
        self.candidates = candidates


@dataclass(frozen=True, kw_only=True)
class Place:
    """A point for a whole town: GeoNames' own, on WGS84.

    region_code: where it is in letters, as in the United States; else empty.
    country: ISO 3166 code of two letters.
    height_m: above the ellipsoid; that of the terrain within 90 m, of some within 5 km.
    population: of the town, as GeoNames has it.
    """

    name: str
    region_code: str
    region: str
    country: str
    geonames_id: int
    latitude_deg: float
    longitude_deg: float
    height_m: float
    population: int

    @property
    def words(self) -> str:
        """Name, region and country."""
        return ", ".join(filter(None, (self.name, self.region, self.country)))


def find_place(asked: str) -> Place:
    """The place of a name, which may be followed by region, country or GeoNames number.

    Of several the one that is far more populous than all others.  Raises NameUnclear where there
    is none, with those spelt alike, or more than one, with what tells them apart.
    """
    found = _matching_places(asked)
    if found and is_far_larger(found):
        return found[0]
    if found:
        shown = found[: OPTIONS.candidates if may_suggest() else 1]
        names = tuple(map(told_apart, shown))
        told = [f"{name!r}{_where_text(one)}" for name, one in zip(names, shown, strict=True)]
        more = len(found) - len(shown)
        raise NameUnclear(
            f"name {asked!r} may be {' or '.join(told)}{f' or {more} more' if more else ''}; "
            f"write one of these, or {_OTHERWISE}",
            names,
        )
    name, *rest = asked.split(",")
    same_name = _places_of(key_of(name))
    suggests = may_suggest()
    alike = same_name if rest and same_name else _alike_places(key_of(name)) if suggests else []
    names = tuple(map(told_apart, alike[: OPTIONS.candidates] if suggests else ()))
    suggested = " or ".join(map(repr, names))
    raise NameUnclear(
        f"name {asked!r} is not among the places of 15,000 people or more known here"
        + (f" (do you mean {suggested}?)" if suggested else "")
        + f"; {_OTHERWISE}",
        names,
    )


def places_of_name(asked: str) -> int:
    """How many places have it."""
    return len(_matching_places(asked))


def is_far_larger(found: list[Place]) -> bool:
    """Whether nobody who just writes the name means any but the first of those who bear it.

    It is far more populous than others of this name, and more than those that are also called so.
    """
    first, *others = found
    own = [one.population for one in others if key_of(one.name) == key_of(first.name)]
    most = max((one.population for one in others), default=-1)
    return first.population > max(most, OPTIONS.far_more * max(own, default=-1))


def town_near(latitude_deg: float, longitude_deg: float) -> str | None:
    """The name of the largest town in the same metropolis, or else of the nearest; None far off.

    Distances are angles between verticals times the mean radius: 0.7 % off at most.
    """
    up = up_itrf(math.radians(latitude_deg), math.radians(longitude_deg))
    off_rad = np.arccos(np.minimum(_town_verticals() @ up, 1.0))
    off_km = off_rad * EARTH_RADIUS_M / 1e3
    same = np.flatnonzero(off_km < OPTIONS.metropolis_km)  # the most populous comes first
    number = int(same[0] if len(same) else np.argmin(off_km))
    return _read_place(number).name if off_km[number] < OPTIONS.near_km else None


@cache
def _town_verticals() -> Array:
    """Unit vectors (n, 3) of all places, in ITRF."""
    angles = [line.rsplit("\t", 4)[1:3] for line in _read_file()[0]]
    latitude_rad, longitude_rad = np.deg2rad(np.array(angles, dtype=float)).T
    return up_itrf(latitude_rad, longitude_rad)


def _where_text(place: Place) -> str:
    return f" ({place.latitude_deg:.2f}, {place.longitude_deg:.2f})"


def told_apart(place: Place) -> str:
    """The shortest name that means this place alone."""
    parts = (place.country,), (place.region, place.country), (str(place.geonames_id),)
    names = [", ".join(filter(None, (place.name, *part))) for part in parts]
    return next((name for name in names if _matching_places(name) == [place]), names[-1])


def _matching_places(asked: str) -> list[Place]:
    """Places whose own name it is first, the most populous first among each."""
    name, *rest = asked.split(",")
    key = key_of(name)
    wanted = [word for part in rest if (word := _compact_text(part))]
    found = (
        place for place in _places_of(key) if all(word in _qualifiers(place) for word in wanted)
    )
    return sorted(found, key=lambda place: key_of(place.name) != key)


def places_named_from(begun: str) -> list[Place]:
    """Whose name in any language goes on so; after a comma region or country, likewise.

    Those spelt with the same accents first, if any were typed.  The most populous first; of those
    of another name, a twentieth of the people counts.
    """
    name, *rest = begun.split(",")
    key = key_of(name)
    if not key:
        return []
    numbers = _numbers_of(key) if rest else sorted(_numbers_from(key))
    begins = [word for part in rest if (word := _compact_text(part))]
    found = [
        place
        for place in map(_read_place, numbers[: OPTIONS.looked_at])
        if all(any(one.startswith(word) for one in _qualifiers(place)) for word in begins)
    ]

    typed = normalize("NFC", name).strip().casefold()

    def weight(place: Place) -> tuple[bool, float]:
        is_own = key_of(place.name).startswith(key)
        is_spelt_so = not typed.isascii() and place.name.casefold().startswith(typed)
        return is_spelt_so, place.population * (OPTIONS.far_more if is_own else 1.0)

    return sorted(found, key=weight, reverse=True)


def other_name_from(place: Place, key: str) -> str:
    """The first key of the place's names that begins so."""
    start, stop = _line_from(key), _line_from(key + "\U0010ffff")
    for line in _read_keys()[start:stop].decode().splitlines():
        name, _, numbers = line.partition("\t")
        if any(_read_place(int(number)) == place for number in numbers.split()):
            return name
    return key


def _numbers_from(key: str) -> set[int]:
    start, stop = _line_from(key), _line_from(key + "\U0010ffff")
    lines = _read_keys()[start:stop].decode().splitlines()
    return {int(number) for line in lines for number in line.partition("\t")[2].split()}


def _qualifiers(place: Place) -> set[str]:
    country = _country_names().get(place.country, "")
    told = (place.country, country, place.region_code, place.region, str(place.geonames_id))
    return {_compact_text(word) for word in told}


def _compact_text(text: str) -> str:
    """D.C. is DC."""
    return key_of(text).replace(" ", "")


def _places_of(key: str) -> list[Place]:
    return [_read_place(number) for number in _numbers_of(key)]


def _numbers_of(key: str) -> list[int]:
    start = _line_from(key)
    line = _read_keys()[start : _read_keys().find(b"\n", start)].decode()
    found, _, numbers = line.partition("\t")
    return [int(number) for number in numbers.split()] if found == key else []


def _alike_places(key: str) -> list[Place]:
    """The places of names that begin with the same letter and are most like it."""
    if not key:
        return []
    start, stop = _line_from(key[0]), _line_from(key[0] + "\U0010ffff")
    lines = _read_keys()[start:stop].decode().splitlines()
    near = nearest_keys(key, (line.partition("\t")[0] for line in lines))
    return list({place.geonames_id: place for one in near for place in _places_of(one)}.values())


def _line_from(key: str) -> int:
    """Where the line of the first key that isn't less than this begins."""
    keys, wanted = _read_keys(), key.encode()

    def key_at(byte: int) -> bytes:
        start = keys.rfind(b"\n", 0, byte) + 1
        return keys[start : keys.find(b"\t", start)]

    byte = bisect_left(range(len(keys)), wanted, key=key_at)
    return keys.rfind(b"\n", 0, byte) + 1


@cache
def _read_file() -> tuple[list[str], bytes]:
    text = lzma.decompress((_DATA / "cities.tsv.xz").read_bytes())
    places, _, keys = text.partition(b"\n\n")
    return places.decode().split("\n"), keys


def _read_keys() -> bytes:
    return _read_file()[1]


def _read_place(number: int) -> Place:
    name, code, region, country, geonames_id, *numbers = _read_file()[0][number].split("\t")
    latitude_deg, longitude_deg, height_m, population = map(float, numbers)
    return Place(
        name=name,
        region_code=code,
        region=region,
        country=country,
        geonames_id=int(geonames_id),
        latitude_deg=latitude_deg,
        longitude_deg=longitude_deg,
        height_m=height_m,
        population=int(population),
    )


@cache
def _country_names() -> dict[str, str]:
    return dict(_country_rows())


def _country_rows() -> Iterator[tuple[str, str]]:
    with (_DATA / "countries.csv").open(encoding="utf-8", newline="") as file:
        for row in csv.DictReader(line for line in file if not line.startswith("#")):
            yield row["code"], row["name"]
