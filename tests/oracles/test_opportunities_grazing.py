"""Windows of milliseconds, as the carrier grazes the least elevation, and the highest of slow ones.

The elevations that judge are Skyfield's turn of the Earth on the planner's orbit.
"""

import dataclasses
import math
from datetime import UTC, datetime, timedelta
from functools import partial

import numpy as np
import pytest
from opportunity_requests import ISS, ROOT, START, iss_request
from scipy.optimize import brentq
from skyfield.api import Star, wgs84
from skyfield.framelib import itrs
from test_opportunities_exact import MOLNIYA

from planner.planning.opportunities import (
    OpportunityConditions,
    OpportunityTarget,
    find_opportunities,
)
from planner.world.attitude.lvlh import LvlhAttitude
from planner.world.frames.time_scales import Instants
from planner.world.orbits import OemOrbit, StateVectorOrbit
from planner.world.targets import GroundTarget, MovingGroundTarget, StarTarget

STATE = StateVectorOrbit(
    frame="EME2000",
    epoch=datetime(2022, 1, 17, 12, tzinfo=UTC),
    position_km=(545.284043961596, 4217.41745999061, 5288.80993327732),
    velocity_km_s=(-7.63639664838008, 0.168827885257, 0.65634287389035),
)
OEM = OemOrbit(content=(ROOT / "tests" / "data" / "iss_oem_2022-038_excerpt.xml").read_text())
CASES = {
    "elements": (ISS, START, 0.5),
    "ephemeris": (OEM, datetime(2022, 2, 8, 7, 26, tzinfo=UTC), 1.2 / 24.0),
    "state": (STATE, STATE.epoch, 0.5),
    "eccentric": (MOLNIYA, START, 1.0),
}
# By which elevations from two Earth orientations and orbits differ: 5 cm at 400 km
ERROR_RAD = 1.5e-7
SHORTEST_S = 1.2e-3  # a millisecond, promised, and how well the bend is known
EQUATOR_M = 6378137.0  # radius, WGS84


def places(count):
    rng = np.random.default_rng(45)
    latitudes_deg = np.degrees(np.arcsin(rng.uniform(-0.9, 0.9, count)))
    return [
        GroundTarget(latitude_deg=latitude_deg, longitude_deg=longitude_deg)
        for latitude_deg, longitude_deg in zip(
            latitudes_deg.tolist(), rng.uniform(-180.0, 180.0, count).tolist(), strict=True
        )
    ]


def ships_and_aircraft(count):
    """East along the equator, where the way is an arc of a circle."""
    rng = np.random.default_rng(46)
    return [
        MovingGroundTarget(
            epoch=START,
            latitude_deg=0.0,
            longitude_deg=longitude_deg,
            course_deg=90.0,
            speed_m_s=speed_m_s,
        )
        for longitude_deg, speed_m_s in zip(
            rng.uniform(-180.0, 180.0, count).tolist(),
            np.exp(rng.uniform(1.0, 6.0, count)).tolist(),
            strict=True,
        )
    ]


def searched(orbit, start, days, targets, **fields):
    request = iss_request(
        0.0,
        orbit=orbit,
        start=start,
        stop=start + timedelta(days=days),
        targets=tuple(OpportunityTarget(id=f"{n}", target=one) for n, one in enumerate(targets)),
        samples=2,
        **fields,
    )
    return request, find_opportunities(request).windows


def elevation_rad(timescale, request, target, t_s):
    instants = Instants(request.start, t_s)
    ephemeris = request.orbit.ephemeris(request.start, request.stop)
    r_m = ephemeris.states(instants).r_sat_eci_m
    turned = itrs.rotation_at(timescale.tt_jd(*instants.tt_jd()))
    passed_rad = np.asarray(t_s) * getattr(target, "speed_m_s", 0.0) / EQUATOR_M
    longitude = math.radians(target.longitude_deg) + passed_rad
    latitude = np.full(len(longitude), math.radians(target.latitude_deg))
    place = wgs84.latlon(np.degrees(latitude), np.degrees(longitude))
    apart_m = np.einsum("ijn,nj->ni", turned, r_m) - place.itrs_xyz.m.T
    up = (
        np.cos(latitude) * np.cos(longitude),
        np.cos(latitude) * np.sin(longitude),
        np.sin(latitude),
    )
    return np.arcsin(np.einsum("ni,in->n", apart_m, up) / np.linalg.norm(apart_m, axis=1))


def above_limb_rad(skyfield, request, star, t_s):
    """Skyfield's direction from the Earth's centre, whose motion the limb shares, and the ray of
    the same plane that just touches the ellipsoid."""
    timescale, kernel, satellite = skyfield
    at = timescale.tt_jd(*Instants(request.start, t_s).tt_jd())
    place = Star(ra_hours=star.ra_deg / 15.0, dec_degrees=star.dec_deg)
    seen = kernel["earth"].at(at).observe(place).apparent().position.m
    turned = itrs.rotation_at(at)
    squeezed = np.array([1.0, 1.0, 1.0 / (1.0 - 1.0 / 298.257223563)]) / EQUATOR_M
    found = []
    for direction, r_m in zip(
        np.einsum("ijn,jn->ni", turned, seen / np.linalg.norm(seen, axis=0)),
        np.einsum("ijn,jn->ni", turned, satellite.at(at).position.m),
        strict=True,
    ):
        nadir = -r_m / np.linalg.norm(r_m)
        aside = direction - (direction @ nadir) * nadir
        from_nadir_rad = math.atan2(np.linalg.norm(aside), direction @ nadir)
        aside /= np.linalg.norm(aside)
        start = r_m * squeezed

        def discriminant(angle_rad, nadir=nadir, aside=aside, start=start):
            line = (math.cos(angle_rad) * nadir + math.sin(angle_rad) * aside) * squeezed
            return (line @ start) ** 2 - (line @ line) * (start @ start - 1.0)

        found.append(from_nadir_rad - brentq(discriminant, 0.5, 0.5 * math.pi, xtol=1e-14))
    return np.array(found)


def shortened(seen_rad, high_s, high_rad, rng):
    """How long a window to ask for, the least elevation that leaves it, and how far the greatest
    elevation is from the one seen; by instants close to it for how much it bends."""
    step_s = 10.0
    for _ in range(3):
        at_rad = seen_rad(high_s + step_s * np.array([-1.0, 0.0, 1.0]))
        bend_rad_s2 = (2.0 * at_rad[1] - at_rad[0] - at_rad[2]) / step_s**2
        step_s = min(0.05 / math.sqrt(bend_rad_s2), 30.0)
    # above what double precision leaves of an elevation: 1e-15 rad
    least_s = max(SHORTEST_S, math.sqrt(8e-14 / bend_rad_s2))
    duration_s = math.exp(rng.uniform(math.log(least_s), 0.0))
    return duration_s, high_rad - bend_rad_s2 * duration_s**2 / 8.0, at_rad[1] - high_rad


def require_held(found, seen_rad, least_rad, high_s, duration_s):
    """One about the instant, which is known within a millisecond, and none where it's too low."""
    holds = (found.rise_s < high_s + 1e-3) & (found.set_s > high_s - 1e-3)
    assert np.count_nonzero(holds) == 1, duration_s
    lasts_s = (found.set_s - found.rise_s)[holds][0]
    assert 0.9 * duration_s - 1e-4 < lasts_s < 1.1 * duration_s + 2e-3
    assert np.all(seen_rad(0.5 * (found.rise_s + found.set_s)) > least_rad - ERROR_RAD)


def test_stars_seen_for_milliseconds_are_found(skyfield):
    """Above the limb by what is left of their greatest height for so long a window."""
    rng, checked = np.random.default_rng(47), 0
    for ra_deg, dec_deg in zip(
        rng.uniform(60.0, 260.0, 12).tolist(), rng.uniform(-60.0, 60.0, 12).tolist(), strict=True
    ):  # far from the Sun
        star = StarTarget(ra_deg=ra_deg, dec_deg=dec_deg, grazing_altitude_km=0.0)
        up = LvlhAttitude(roll_deg=180.0)
        request, whole = searched(ISS, START, 0.3, [star], attitude=up)

        def seen_rad(t_s, request=request, star=star):
            return above_limb_rad(skyfield, request, star, t_s)

        for high_s, high_rad in zip(whole.highest_s, whole.highest_rad, strict=True):
            if 30.0 < high_s < 0.3 * 86400.0 - 30.0 and high_rad < math.radians(90.0):
                duration_s, least_rad, off_rad = shortened(seen_rad, high_s, high_rad, rng)
                assert abs(off_rad) < ERROR_RAD
                asked = OpportunityConditions(min_elevation_deg=math.degrees(least_rad))
                _, found = searched(ISS, START, 0.3, [star], attitude=up, conditions=asked)
                require_held(found, seen_rad, least_rad, high_s, duration_s)
                checked += 1
    assert checked > 20


@pytest.mark.parametrize(
    ("case", "targets"),
    [*((case, places(200)) for case in CASES), ("elements", ships_and_aircraft(24))],
    ids=[*CASES, "moving"],
)
def test_windows_of_milliseconds_are_found(skyfield, case, targets):
    """The least elevation lies below a pass's greatest by what is left for so long a window."""
    timescale = skyfield[0]
    orbit, start, days = CASES[case]
    request, whole = searched(orbit, start, days, targets)
    rng = np.random.default_rng(1)
    grazing, asked = [], []
    for row in range(len(whole)):
        high_s, high_rad = float(whole.highest_s[row]), float(whole.highest_rad[row])
        inside = min(high_s - whole.rise_s[row], whole.set_s[row] - high_s) > 30.0
        if inside and high_rad < math.radians(85.0):
            target = places_of(request)[whole.target[row]]
            duration_s, least_rad, off_rad = shortened(
                partial(elevation_rad, timescale, request, target), high_s, high_rad, rng
            )
            grazing.append(
                dataclasses.replace(target, min_elevation_deg=float(np.degrees(least_rad)))
            )
            asked.append((high_s, duration_s, off_rad))
    assert len(grazing) > 40
    request, found = searched(orbit, start, days, grazing)
    for number, (high_s, duration_s, off_rad) in enumerate(asked):
        assert abs(off_rad) < ERROR_RAD
        of_target = found.select(found.target == number)
        seen_rad = partial(elevation_rad, timescale, request, grazing[number])
        least_rad = math.radians(grazing[number].min_elevation_deg)
        require_held(of_target, seen_rad, least_rad, high_s, duration_s)


def places_of(request):
    return [wanted.target for wanted in request.targets]


def test_the_highest_of_windows_that_last_for_hours(skyfield):
    """A Molniya's carrier turns more than once in a target's sky; looked at every 20 s."""
    timescale = skyfield[0]
    request = iss_request(
        2.0,
        orbit=MOLNIYA,
        targets=tuple(OpportunityTarget(id=f"{n}", target=one) for n, one in enumerate(places(12))),
        conditions=OpportunityConditions(min_elevation_deg=5.0),
    )
    windows = find_opportunities(request).windows
    humps = 0
    for row in range(len(windows)):
        target = places_of(request)[windows.target[row]]
        t_s = np.append(
            np.arange(windows.rise_s[row], windows.set_s[row], 20.0), windows.set_s[row]
        )
        seen_rad = elevation_rad(timescale, request, target, t_s)
        assert windows.highest_rad[row] > seen_rad.max() - ERROR_RAD
        at = elevation_rad(timescale, request, target, windows.highest_s[row : row + 1])[0]
        assert windows.highest_rad[row] == pytest.approx(at, abs=ERROR_RAD)
        humps += np.count_nonzero(np.diff(np.sign(np.diff(seen_rad))) < 0) > 1
    assert humps > 5
