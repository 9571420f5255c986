"""Names mean what the world means by them, where the world has them."""

import math
import re

import numpy as np
import pytest
from skyfield.named_stars import named_star_dict

from planner.world.frames.time_scales import Instants, utc_from_text
from planner.world.targets import GroundTarget, PlaceTarget, StarTarget
from planner.world.targets.gazetteer import find_place
from planner.world.targets.star_names import hipparcos_number

# The Bright Star Catalogue, 5th edition (Hoffleit, Warren 1991): J2000, equinox and epoch.
BRIGHT_STARS = """
Achernar 01 37 42.9 -57 14 12
Polaris 02 31 48.7 +89 15 51
Aldebaran 04 35 55.2 +16 30 33
Rigel 05 14 32.3 -08 12 06
Capella 05 16 41.4 +45 59 53
Betelgeuse 05 55 10.3 +07 24 25
Canopus 06 23 57.1 -52 41 44
Sirius 06 45 08.9 -16 42 58
Procyon 07 39 18.1 +05 13 30
Pollux 07 45 18.9 +28 01 34
Regulus 10 08 22.3 +11 58 02
Spica 13 25 11.6 -11 09 41
Arcturus 14 15 39.7 +19 10 57
Antares 16 29 24.4 -26 25 55
Vega 18 36 56.3 +38 47 01
Altair 19 50 47.0 +08 52 06
Deneb 20 41 25.9 +45 16 49
Fomalhaut 22 57 39.1 -29 37 20
"""
J2000 = Instants(utc_from_text("2000-01-01T12:00:00Z"), np.zeros(1))
# Where Wikipedia's list, from which Skyfield has its names, and the IAU's differ.
SETTLED_OTHERWISE_BY_THE_IAU = {
    "Algenib": 1067,
    "Gienah": 59803,
    "Girtab": 87073,
    "Markab": 113963,
    "Toliman": 71681,
    "Wei": 102485,
}


@pytest.mark.parametrize("line", BRIGHT_STARS.strip().splitlines())
def test_stars_are_where_the_bright_star_catalogue_has_them(line):
    name, hour, minute, second, degree, arcmin, arcsec = re.split(" ", line)
    ra = math.radians(15.0 * (int(hour) + int(minute) / 60 + float(second) / 3600))
    size = abs(int(degree)) + int(arcmin) / 60 + int(arcsec) / 3600
    dec = math.copysign(math.radians(size), -1.0 if degree.startswith("-") else 1.0)
    there = [math.cos(dec) * math.cos(ra), math.cos(dec) * math.sin(ra), math.sin(dec)]
    here, _ = StarTarget(name=name).seen_from(J2000, np.zeros((1, 3)))
    # Half the last printed digits are 0.75 and 0.5 arcsec; FK5 is 0.1 arcsec off at worst.
    assert math.degrees(math.acos(min(1.0, np.dot(here[0], there)))) * 3600 < 1.1


def test_names_are_skyfields_but_for_those_the_iau_settled():
    ours = {name: hipparcos_number(name) for name in named_star_dict}
    assert {n: hip for n, hip in ours.items() if named_star_dict[n] != hip} == (
        SETTLED_OTHERWISE_BY_THE_IAU
    )


# As encyclopedias print them: to the minute of arc, and the height above the sea.
@pytest.mark.parametrize(
    ("name", "latitude_deg", "longitude_deg", "above_sea_m"),
    [
        ("Ljubljana", 46 + 3 / 60, 14 + 30 / 60, 295),
        ("Las Vegas, US", 36 + 10 / 60, -115 - 9 / 60, 610),
        ("Denver", 39 + 44 / 60, -104 - 59 / 60, 1609),
        ("Quito", -13 / 60, -78 - 31 / 60, 2850),
        ("La Paz, BO", -16.5, -68 - 9 / 60, 3640),
        ("Amsterdam, NL", 52 + 22 / 60, 4 + 54 / 60, -2),
        ("Singapore", 1 + 17 / 60, 103 + 50 / 60, 15),
        ("Lhasa", 29 + 39 / 60, 91 + 7 / 60, 3656),
        ("Ushuaia", -54 - 48 / 60, -68 - 18 / 60, 23),
        ("Suva, Fiji", -18 - 8 / 60, 178 + 26 / 60, 0),
        ("東京", 35 + 41 / 60, 139 + 41 / 60, 40),
    ],
)
def test_towns_are_where_encyclopedias_have_them(name, latitude_deg, longitude_deg, above_sea_m):
    place = find_place(name)
    east = math.cos(math.radians(latitude_deg))
    north_km = (place.latitude_deg - latitude_deg) * 111.2
    east_km = (place.longitude_deg - longitude_deg) * 111.2 * east
    # A town has no one point: its centre may be a town hall or a mean.
    assert math.hypot(north_km, east_km) < 8.0
    # Nor one height: La Paz climbs 600 m within its bounds; the geoid lies up to 60 m off.
    assert place.height_m == pytest.approx(above_sea_m, abs=260.0)


def test_a_place_lies_where_its_coordinates_say_above_the_ellipsoid():
    """Against Skyfield's own WGS84."""
    from skyfield.api import wgs84

    target, place = PlaceTarget(name="La Paz, BO"), find_place("La Paz, BO")
    there = wgs84.latlon(place.latitude_deg, place.longitude_deg, place.height_m)
    ours_m = target.r_target_itrf_m(J2000)[0]
    assert ours_m == pytest.approx(there.itrs_xyz.m, abs=1e-3)


# Points and what Wikipedia says they lie in or near: a suburb's airport, a lake, an ocean.
@pytest.mark.parametrize(
    ("latitude_deg", "longitude_deg", "town"),
    [
        (36.1147, -115.1728, "Las Vegas"),  # the Strip, in Paradise
        (48.8049, 2.1204, "Paris"),  # the palace of Versailles
        (46.3625, 14.0944, "Kranj"),  # Lake Bled, 24 km off
        (0.0, -30.0, None),  # the middle of the Atlantic
        (-17.83, -179.9, None),  # beyond the date line from Fiji's Taveuni
    ],
)
def test_a_point_is_told_by_a_town_that_people_know(latitude_deg, longitude_deg, town):
    target = GroundTarget(latitude_deg=latitude_deg, longitude_deg=longitude_deg)
    place = f"{latitude_deg:.4f}, {longitude_deg:.4f}"
    assert target.label == (f"near {town} ({place})" if town else place)
