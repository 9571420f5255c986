"""Points that move over the ground: speed, straightness, corners, light time, refusals."""

from datetime import UTC, datetime, timedelta

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planner.base.errors import InvalidInput
from planner.world.frames.earth_orientation import OMEGA_EARTH_RAD_S, c_itrf_from_eci
from planner.world.frames.geodesy import geodetic_from_itrf, itrf_from_geodetic
from planner.world.frames.time_scales import Instants
from planner.world.orbits.ephemeris import OrbitStates
from planner.world.targets import GroundPathTarget, MovingGroundTarget
from planner.world.targets.apparent import SPEED_OF_LIGHT_M_S, aberrate
from planner.world.targets.ground_path import PathPoint
from planner.world.targets.ground_sample import sample_along_m

EPOCH = datetime(2015, 2, 27, 17, 36, 20, tzinfo=UTC)
STEP_S = 0.2
latitudes = st.floats(-90.0, 90.0)
longitudes = st.floats(-180.0, 360.0)


def instants(duration_s, step_s=STEP_S):
    return Instants(EPOCH, np.arange(0.0, duration_s, step_s))


def moving(**changes):
    fields = {"epoch": EPOCH, "latitude_deg": 36.0, "longitude_deg": -115.0, "course_deg": 75.0}
    return MovingGroundTarget(**(fields | {"speed_m_s": 250.0} | changes))


@given(latitudes, longitudes, st.floats(-180.0, 360.0), st.floats(0.1, 3000.0))
def test_moving_point_keeps_its_speed_and_stays_on_the_ellipsoid(
    latitude, longitude, course, speed
):
    """Poles and antimeridian included; a geodesic never turns within the surface."""
    target = moving(
        latitude_deg=latitude, longitude_deg=longitude, course_deg=course, speed_m_s=speed
    )
    r_m = target.r_target_itrf_m(instants(60.0, 1.0))
    v_m_s = (r_m[2:] - r_m[:-2]) / 2.0
    # The chord of 2 s is shorter than the arc by (v/R)^2/6; positions round at 1e-9 m.
    np.testing.assert_allclose(np.linalg.norm(v_m_s, axis=1), speed, rtol=5e-8, atol=1e-8)
    latitude_rad, longitude_rad, height_m = geodetic_from_itrf(r_m)
    assert np.max(np.abs(height_m)) < 1e-6
    acceleration = r_m[2:] - 2.0 * r_m[1:-1] + r_m[:-2]
    up = np.stack(
        [
            np.cos(latitude_rad) * np.cos(longitude_rad),
            np.cos(latitude_rad) * np.sin(longitude_rad),
            np.sin(latitude_rad),
        ],
        axis=1,
    )[1:-1]
    along_surface = acceleration - np.sum(acceleration * up, axis=1, keepdims=True) * up
    # v^2/R is up to 1.4 m/s2, of which a turning course would leave a part along the surface;
    # positions round at 1e-9 m each, and latitude and longitude behind them at 7e-10 m.
    assert np.max(np.abs(along_surface)) < 3e-8 + 1e-7 * speed**2 / 6.4e6


def test_course_points_where_a_compass_says():
    east = moving(course_deg=90.0, latitude_deg=0.0).r_target_itrf_m(instants(1.0, 0.5))
    latitude, longitude, _ = geodetic_from_itrf(east)
    assert longitude[1] > longitude[0]
    assert latitude[1] == pytest.approx(0.0, abs=1e-15)
    north = moving(course_deg=0.0).r_target_itrf_m(instants(1.0, 0.5))
    assert geodetic_from_itrf(north)[0][1] > geodetic_from_itrf(north)[0][0]


def carrier(times):
    """Over the target, 400 km up at 7.6 km/s."""
    c = c_itrf_from_eci(times)
    overhead = itrf_from_geodetic(np.radians(37.0), np.radians(-114.0), 400e3)
    r_m = np.einsum("nji,j->ni", c, overhead)
    v_m_s = np.cross(r_m / np.linalg.norm(r_m, axis=1, keepdims=True), [0.0, 0.0, 1.0]) * -7600.0
    return OrbitStates(r_m + v_m_s * times.t_s[:, None], v_m_s)


@pytest.mark.parametrize("speed_m_s", [0.0, 300.0, 7000.0])
def test_light_leaves_a_moving_target_where_it_was(speed_m_s):
    """Solved again by bisection on the emission time, the Earth turned back in full."""
    times = instants(3.0)
    states = carrier(times)
    target = moving(speed_m_s=speed_m_s)
    seen = target.apparent(times, states)
    pole = c_itrf_from_eci(times)[:, 2, :]
    before_s, after_s = np.full(len(times.t_s), 0.1), np.zeros(len(times.t_s))
    for _ in range(60):
        tau = (before_s + after_s) / 2.0
        emitted = Instants(EPOCH, times.t_s - tau)
        r_m = np.einsum("nji,nj->ni", c_itrf_from_eci(times), target.r_target_itrf_m(emitted))
        angle = (-OMEGA_EARTH_RAD_S * tau)[:, None]
        r_m = (
            r_m * np.cos(angle)
            + np.cross(pole, r_m) * np.sin(angle)
            + pole * np.sum(pole * r_m, axis=1, keepdims=True) * (1.0 - np.cos(angle))
        )
        late = np.linalg.norm(r_m - states.r_sat_eci_m, axis=1) < SPEED_OF_LIGHT_M_S * tau
        before_s, after_s = np.where(late, tau, before_s), np.where(late, after_s, tau)
    los = r_m - states.r_sat_eci_m
    expected = aberrate(los / np.linalg.norm(los, axis=1, keepdims=True), states.v_sat_eci_m_s)
    # 2e-9 rad = 0.0004 arcsec = 1 mm: two passes leave v^2/c^2 of the range.
    np.testing.assert_allclose(seen.direction_eci, expected, rtol=0, atol=2e-9)


def path(*points, **changes):
    fields = {"speed_m_s": 2000.0, "start": EPOCH}
    where = tuple(
        PathPoint(latitude_deg=point[0], longitude_deg=point[1], height_m=sum(point[2:]))
        for point in points
    )
    return GroundPathTarget(points=where, **(fields | changes))


CORNERED = ((36.0, -115.0, 600.0), (36.3, -114.6, 1200.0), (36.0, -114.2), (36.4, -114.0, 300.0))


def test_path_passes_its_ends_and_leaves_on_time():
    target = path(*CORNERED)
    ends = Instants(EPOCH, np.array([0.0, target.duration_s]))
    expected = [
        itrf_from_geodetic(*np.radians(p[:2]), sum(p[2:])) for p in (CORNERED[0], CORNERED[-1])
    ]
    np.testing.assert_allclose(target.r_target_itrf_m(ends), expected, rtol=0, atol=1e-3)


def test_path_keeps_its_speed_on_the_legs_and_drops_it_in_corners():
    target = path((10.0, 20.0), (10.0, 20.6), (10.5, 20.6), corner_s=4.0)
    times = instants(target.duration_s, 0.05)
    r_m = target.r_target_itrf_m(times)
    speed = np.linalg.norm(r_m[2:] - r_m[:-2], axis=1) / 0.1
    # At sea level over the surface; a chord of 200 m is 1e-11 short.
    assert np.median(speed) == pytest.approx(2000.0, rel=1e-7)
    assert np.max(speed) < 2000.0 * (1.0 + 1e-6)
    # Halfway through a right angle the velocity is the mean of both: cos(45 deg); the azimuth
    # of a parallel's chord leaves the angle 0.1 deg off.
    assert np.min(speed) == pytest.approx(2000.0 * np.sqrt(0.5), rel=2e-3)


def test_corner_has_the_acceleration_and_the_cut_it_promises():
    target = path((10.0, 20.0), (10.0, 20.6), (10.5, 20.6), corner_s=4.0)
    times = instants(target.duration_s, 0.05)
    r_m = target.r_target_itrf_m(times)
    acceleration = np.linalg.norm(r_m[2:] - 2.0 * r_m[1:-1] + r_m[:-2], axis=1) / 0.05**2
    expected = 4.375 * 2000.0 * np.sin(np.pi / 4.0) / 4.0  # 35/16 of the velocity's turn over 4 s
    assert np.max(acceleration) == pytest.approx(expected, rel=5e-3)
    corner_m = itrf_from_geodetic(np.radians(10.0), np.radians(20.6), 0.0)
    cut_m = np.min(np.linalg.norm(r_m - corner_m, axis=1))
    assert cut_m == pytest.approx(0.13672 * 4.0 * 2000.0 * np.sin(np.pi / 4.0), rel=5e-3)


@settings(max_examples=25)
@given(latitudes, longitudes, st.floats(0.0, 360.0))
def test_path_is_smooth_anywhere_on_earth(latitude, longitude, course):
    """Across poles and the antimeridian: no jump that a 0.2 s difference would see."""
    away = moving(
        latitude_deg=latitude, longitude_deg=longitude, course_deg=course, speed_m_s=20e3 / 3
    )
    where = geodetic_from_itrf(away.r_target_itrf_m(instants(19.0, 6.0)))
    points = [(np.degrees(a), np.degrees(b)) for a, b in zip(where[0], where[1], strict=True)]
    r_m = path(*points).r_target_itrf_m(instants(70.0))
    third = np.diff(r_m, 3, axis=0) / STEP_S**3
    # A straight line of points: only the Earth's curvature, v^3/R^2 = 2e-4 m/s3, and positions
    # that agree to 0.1 mm between neighbouring points: 4 * 1e-4 / 0.2^3 = 0.05 m/s3.
    assert np.max(np.abs(third)) < 0.06


def test_path_without_a_start_takes_the_sessions():
    target = path(*CORNERED, start=None)
    with pytest.raises(InvalidInput, match="start"):
        target.r_target_itrf_m(instants(1.0))
    later = EPOCH + timedelta(seconds=10)
    assert target.starting(later).start == later
    assert path(*CORNERED).starting(later).start == EPOCH


@pytest.mark.parametrize(
    ("points", "changes", "says"),
    [
        (CORNERED[:1], {}, "points must hold 2"),
        (CORNERED, {"corner_s": 40.0}, "lower corner_s or the speed"),
        (CORNERED, {"start": datetime(2015, 2, 27)}, "no UTC offset"),  # noqa: DTZ001
        (CORNERED, {"refraction": "standard"}, "raise min_elevation_deg"),
    ],
)
def test_impossible_paths_are_refused(points, changes, says):
    with pytest.raises(ValueError, match=says):
        path(*points, **changes)


def plane_path(**changes):
    points = (
        PathPoint(latitude_deg=43.9, longitude_deg=-19.9, height_m=300.0),
        PathPoint(latitude_deg=44.5, longitude_deg=-19.1, height_m=300.0),
    )
    members = {"points": points, "speed_m_s": 5000.0, "start": EPOCH, "line": "plane"} | changes
    return GroundPathTarget(**members)


def test_a_line_in_a_plane_keeps_to_it_and_to_its_height():
    path = plane_path()
    t_s = np.linspace(-5.0, path.duration_s + 5.0, 50)
    r_itrf_m = path.r_target_itrf_m(Instants(EPOCH, t_s))
    at_ends = path.r_target_itrf_m(Instants(EPOCH, np.array([0.0, path.duration_s])))
    ends = [
        itrf_from_geodetic(*np.deg2rad([p.latitude_deg, p.longitude_deg]), 300.0)
        for p in path.points
    ]
    np.testing.assert_allclose(at_ends, ends, rtol=0, atol=1e-6)
    feet = [
        itrf_from_geodetic(*np.deg2rad([p.latitude_deg, p.longitude_deg]), 0.0) for p in path.points
    ]
    normal = np.cross(*feet)
    # A height stands on the ellipsoid, 3 mrad at most off the radius: 1 m across at 300 m.
    assert np.max(np.abs(r_itrf_m @ normal / np.linalg.norm(normal))) < 1.1
    np.testing.assert_allclose(geodetic_from_itrf(r_itrf_m)[2], 300.0, atol=1e-3)
    speed_m_s = np.linalg.norm(np.diff(r_itrf_m, axis=0), axis=1) / np.diff(t_s)
    np.testing.assert_allclose(speed_m_s, 5000.0, rtol=3e-4)


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        (
            {"points": (*plane_path().points, PathPoint(latitude_deg=45, longitude_deg=-18))},
            "not 3",
        ),
        ({"refraction": "standard", "min_elevation_deg": 10.0}, "refraction 'standard'"),
    ],
)
def test_a_line_in_a_plane_is_refused_where_it_is_not_known(changes, told):
    with pytest.raises(ValueError, match=told):
        plane_path(**changes)


RADIUS_M, PIXEL_RAD = 6378137.0, 3.3e-6


def range_at_m(elevation_rad, height_m):
    sine = np.sin(elevation_rad)
    return np.sqrt((RADIUS_M * sine) ** 2 + height_m * (2 * RADIUS_M + height_m)) - RADIUS_M * sine


def on_circle_m(elevation_rad, height_m):
    """By the two rays through the pixel's edges; NaN where one passes the circle by."""
    height_ratio = RADIUS_M / (RADIUS_M + height_m)
    off_nadir_rad = np.arcsin(height_ratio * np.cos(elevation_rad))
    edges_rad = off_nadir_rad + PIXEL_RAD * np.array([-0.5, 0.5])
    sine = np.sin(edges_rad) / height_ratio
    if (sine > 1.0).any():
        return np.nan
    return RADIUS_M * float(np.diff(np.arcsin(sine) - edges_rad)[0])


@pytest.mark.parametrize("height_m", [350e3, 420e3, 800e3])
@pytest.mark.parametrize(
    ("elevation_deg", "share"), [(90.0, 1e-6), (30.0, 1e-5), (2.0, 1e-4), (0.5, 1e-3), (0.25, 5e-3)]
)
def test_a_pixel_is_as_long_as_the_ground_between_its_edges(height_m, elevation_deg, share):
    elevation_rad = np.radians(elevation_deg)
    range_m = np.array([range_at_m(elevation_rad, height_m)])
    told_m = sample_along_m(np.sin([elevation_rad]), range_m, PIXEL_RAD)[0]
    assert told_m == pytest.approx(on_circle_m(elevation_rad, height_m), rel=share)


@pytest.mark.parametrize("height_m", [350e3, 800e3])
def test_a_pixel_that_reaches_the_horizon_has_no_length(height_m):
    """And the last that doesn't is a few kilometres long, never more."""
    elevation_rad = np.radians(np.linspace(-0.1, 0.2, 301))
    range_m = range_at_m(elevation_rad, height_m)
    told_m = sample_along_m(np.sin(elevation_rad), range_m, PIXEL_RAD)
    ends = [np.isfinite(on_circle_m(e, height_m)) and e > 0.0 for e in elevation_rad]
    disagree = np.isfinite(told_m) != ends
    assert disagree.sum() <= 1, elevation_rad[disagree]  # at the limit itself
    assert np.nanmax(told_m) < 10e3


def test_no_length_in_space():
    assert np.isnan(sample_along_m(np.ones(1), np.array([np.inf]), PIXEL_RAD)).all()
