"""Angles from Sun, Moon, limb and glint: by Skyfield, and by SciPy's shortest way of light."""

import dataclasses
import math

import numpy as np
import pytest
from agile_bodies import smallsat
from opportunity_requests import ISS, START
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

from planner.world.exclusions import Surroundings, exclusion_margins, glint_direction
from planner.world.frames.earth_orientation import c_itrf_from_eci
from planner.world.frames.geodesy import WGS84_A_M, WGS84_B_M
from planner.world.frames.time_scales import Instants, shifted_utc
from planner.world.platforms.body import Exclusion, StarTracker, StarTrackers

REVOLUTION = Instants(START, np.linspace(0.0, 5580.0, 94))
AU_KM = 149597870.7
# Astronomical Almanac: half the Sun's size at 1 au; the Moon's radius in the Earth's equatorial
HALF_SIZE_KM = {
    "sun": math.sin(math.radians(959.63 / 3600.0)) * AU_KM,
    "moon": 0.2725076 * 6378.137,
}


@pytest.fixture(scope="module")
def around():
    ephemeris = ISS.ephemeris(START, shifted_utc(START, 5600.0))
    return Surroundings(REVOLUTION, ephemeris.states(REVOLUTION))


def directions(count):
    vectors = np.random.default_rng(7).normal(size=(count, 3))
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


@pytest.mark.parametrize("body", ["sun", "moon"])
def test_a_disk_is_as_far_as_skyfield_sees_it_and_lapses_behind_the_earth(skyfield, around, body):
    timescale, bodies, satellite = skyfield
    t = timescale.tt_jd(*REVOLUTION.tt_jd())
    observed = (bodies["earth"] + satellite).at(t).observe(bodies[body]).apparent()
    away = directions(len(REVOLUTION))
    expected_rad = np.arccos(np.sum(away.T * observed.position.km, axis=0) / observed.distance().km)
    expected_rad -= np.arcsin(HALF_SIZE_KM[body] / observed.distance().km)
    found_rad = around.apart_rad(away, body)
    counts = around.disk(body)[2] > 0.0
    # the Earth bends nothing; the Almanac's sizes and the IAU's differ by 0.4 arcsec (Sun, 1.5 of
    # 960 for irradiation) and 0.2 (Moon)
    assert found_rad[counts] == pytest.approx(expected_rad[counts], abs=math.radians(1.0 / 3600.0))
    assert np.all(found_rad[~counts] == math.pi)
    behind = observed.is_behind_earth() if body == "moon" else ~satellite.at(t).is_sunlit(bodies)
    # Skyfield's Earth hides a centre; ours is 1.5 deg deeper, 22 s of the orbit, each time
    assert np.all(behind[~counts])
    assert 10 < np.count_nonzero(~counts) <= np.count_nonzero(behind)


def on_ellipsoid(latitude, longitude):
    """By the parametric latitude."""
    return np.array(
        [
            WGS84_A_M * math.cos(latitude) * math.cos(longitude),
            WGS84_A_M * math.cos(latitude) * math.sin(longitude),
            WGS84_B_M * math.sin(latitude),
        ]
    )


def test_glint_is_where_the_light_goes_the_shortest_way(around):
    """Fermat: of all ways by a point of the ellipsoid the mirrored one is shortest."""
    c_itrf = c_itrf_from_eci(REVOLUTION)
    r_m = np.einsum("nij,nj->ni", c_itrf, around.states.r_sat_eci_m)
    sun = np.einsum("nij,nj->ni", c_itrf, around.disk("sun")[0])
    found, counts_rad = glint_direction(sun, r_m)
    compared = 0
    for k in np.flatnonzero(counts_rad > math.radians(3.0)).tolist():

        def way(at, k=k):
            point = on_ellipsoid(*at)
            return (np.linalg.norm(r_m[k] - point) - sun[k] @ point) / WGS84_A_M

        x, y, z = r_m[k]
        begin = [math.atan2(z, math.hypot(x, y)), math.atan2(y, x)]
        options = {"xatol": 1e-9, "fatol": 1e-16, "maxiter": 2000}
        best = minimize(way, begin, method="Nelder-Mead", options=options)
        expected = on_ellipsoid(*best.x) - r_m[k]
        expected /= np.linalg.norm(expected)
        # the minimum of a length is found to the root of its rounding: 1e-8 of the radius,
        # 60 m of 400 km
        assert np.linalg.norm(np.cross(found[k], expected)) < 3e-4
        compared += 1
    assert compared > 40


def test_glint_under_the_sun_is_straight_down_and_none_in_the_night():
    sun = np.array([[1.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    r_m = np.array([[7e6, 0.0, 0.0], [-7e6, 0.0, 0.0]])
    found, counts_rad = glint_direction(sun, r_m)
    assert found[0] == pytest.approx([-1.0, 0.0, 0.0])
    assert counts_rad[0] > 0.0 > counts_rad[1]


def test_the_limb_counts_outwards(around):
    """Straight up it is a right angle and the dip beyond the horizontal: acos(R / r) + 90 deg."""
    r_m = np.linalg.norm(around.states.r_sat_eci_m, axis=1)
    up = around.states.r_sat_eci_m / r_m[:, None]
    expected_rad = math.pi / 2.0 + np.arccos(6371e3 / r_m)
    # the ellipsoid for the sphere: 7 km of height to acos' = 400 km / 2300 km, 0.2 deg
    assert around.apart_rad(up, "limb") == pytest.approx(expected_rad, abs=math.radians(0.4))
    assert np.all(around.apart_rad(-up, "limb") < 0.0)


def test_margins_are_of_the_direction_that_keeps_away(around):
    radiator = Exclusion(
        name="radiator", direction_body=(0.0, 2.0, 0.0), away_from="sun", min_deg=60.0
    )
    camera = Exclusion(name="camera", of="camera", away_from="moon", min_deg=5.0, when="imaging")
    platform = dataclasses.replace(smallsat(), exclusions=(radiator, camera), star_trackers=None)
    q = Rotation.from_rotvec(directions(len(REVOLUTION)) * 2.0)
    of_radiator, of_camera = exclusion_margins(platform, q, around)
    assert [of_radiator.imaging_only, of_camera.imaging_only] == [False, True]
    c = q.as_matrix()
    for margin, axis, body, min_deg in ((of_radiator, 1, "sun", 60.0), (of_camera, 2, "moon", 5.0)):
        apart_rad = around.apart_rad(c[:, :, axis], body)
        counts = apart_rad < math.pi  # not while the Earth hides it
        assert counts.any()
        expected_rad = np.where(counts, apart_rad - math.radians(min_deg), math.pi)
        assert margin.margin_rad == pytest.approx(expected_rad, abs=1e-9)


def test_a_direction_stays_near_with_all_of_the_disk(around):
    panels = Exclusion(name="panels", direction_body=(0.0, 0.0, -3.0), near="sun", max_deg=40.0)
    platform = dataclasses.replace(smallsat(), exclusions=(panels,), star_trackers=None)
    q = Rotation.from_rotvec(directions(len(REVOLUTION)) * 2.0)
    (margin,) = exclusion_margins(platform, q, around)
    centre_eci, half_rad, counts_rad = around.disk("sun")
    normal_eci = -q.as_matrix()[:, :, 2]
    from_centre_rad = np.arccos(np.sum(normal_eci * centre_eci, axis=1))
    expected_rad = math.radians(40.0) - from_centre_rad - half_rad
    expected_rad = np.where(counts_rad > 0.0, expected_rad, math.pi)
    assert (expected_rad < 0.0).any()
    assert margin.margin_rad == pytest.approx(expected_rad, abs=1e-8)
    assert margin.side == "farther from"


def test_of_star_trackers_the_last_one_needed_counts(around):
    """Of three the best, the second and the worst, each by its own least angle."""
    axes = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    each = tuple(
        StarTracker(name=f"st{k}", boresight_body=axis, sun_deg=35.0, limb_deg=20.0)
        for k, axis in enumerate(axes)
    )
    q = Rotation.from_rotvec(directions(len(REVOLUTION)))
    alone = []
    for tracker in each:
        seen = q.apply(tracker.boresight_body)
        from_sun_rad = around.apart_rad(seen, "sun") - math.radians(35.0)
        from_limb_rad = around.apart_rad(seen, "limb") - math.radians(20.0)
        from_moon_rad = around.apart_rad(seen, "moon")
        alone.append(np.minimum(np.minimum(from_sun_rad, from_limb_rad), from_moon_rad))
    ordered = np.sort(alone, axis=0)
    for needed, expected_rad in ((1, ordered[2]), (2, ordered[1]), (3, ordered[0])):
        platform = dataclasses.replace(
            smallsat(), exclusions=(), star_trackers=StarTrackers(needed=needed, each=each)
        )
        [margin] = exclusion_margins(platform, q, around)
        assert margin.margin_rad == pytest.approx(expected_rad)
