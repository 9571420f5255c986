"""Targets in the sky: smooth lines of sight, behind the Earth or not, and lifted by how much."""

from datetime import UTC, datetime

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planner.world.frames.geodesy import WGS84_A_M, WGS84_F, itrf_from_geodetic
from planner.world.frames.solar_system import BODIES
from planner.world.frames.time_scales import Instants
from planner.world.orbits.ephemeris import OrbitStates
from planner.world.targets import BodyTarget, StarTarget
from planner.world.targets.earth_limb import limb_clearance_rad, line_height_m, refract
from planner.world.targets.refraction import bending_rad
from planner.world.targets.standard_atmosphere import refractivity

EPOCH = datetime(2015, 2, 27, 17, 36, 20, tzinfo=UTC)
RATE = 2.0 * np.pi / 5560.0


def orbit(duration_s, step_s=0.2):
    t_s = np.arange(0.0, duration_s, step_s)
    a, b = np.array([0.6, 0.8, 0.0]), np.array([-0.5, 0.375, 0.7806247497997998])
    cos, sin = np.cos(RATE * t_s)[:, None], np.sin(RATE * t_s)[:, None]
    states = OrbitStates(6.79e6 * (cos * a + sin * b), 6.79e6 * RATE * (cos * b - sin * a))
    return Instants(EPOCH, t_s), states


@pytest.mark.parametrize("name", BODIES)
def test_bodies_move_smoothly_over_the_command_grid(name):
    """Accelerations are second differences over 0.2 s: noise must not reach the drives."""
    direction = BodyTarget(name=name).apparent(*orbit(60.0)).direction_eci
    third = np.diff(direction, 3, axis=0)
    # The Moon's parallax turns with the orbit: (r/384,000 km) (rate h)^3 = 2e-13 rad; rounding
    # of 1.5e11 m against 3.6e8 m is 8e-14, eightfold in a third difference.  In acceleration
    # 1e-12 / h^2 = 2.5e-11 rad/s2, a billionth of the drives'.
    assert np.max(np.abs(third)) < 1e-12


def test_a_star_that_sets_through_the_air_moves_smoothly():
    """Newton and spline leave no kink: along the limb the bending's own jerk only."""
    instants, states = orbit(5560.0, 1.0)
    star = StarTarget(ra_deg=30.0, dec_deg=5.0, refraction="standard", grazing_altitude_km=10.0)
    seen = star.apparent(instants, states)
    bare = StarTarget(ra_deg=30.0, dec_deg=5.0).apparent(instants, states)
    lifted = np.linalg.norm(seen.direction_eci - bare.direction_eci, axis=1)
    visible = seen.clearance_rad > 0.0
    assert 0.1 < np.degrees(np.max(lifted[visible])) < 0.5
    setting = np.flatnonzero(visible[:-1] & ~visible[1:])[0]
    times = Instants(EPOCH, np.arange(setting - 40.0, setting, 0.2))
    # The same orbit in closed form at the finer grid.
    a, b = np.array([0.6, 0.8, 0.0]), np.array([-0.5, 0.375, 0.7806247497997998])
    cos, sin = np.cos(RATE * times.t_s)[:, None], np.sin(RATE * times.t_s)[:, None]
    fine = OrbitStates(6.79e6 * (cos * a + sin * b), 6.79e6 * RATE * (cos * b - sin * a))
    direction = star.apparent(times, fine).direction_eci
    jerk = np.max(np.abs(np.diff(direction, 3, axis=0))) / 0.2**3
    # Bending 8e-3 rad with scale height 6.5 km crossed at 2.6 km/s: 8e-3 (2.6/6.5)^3 = 5e-4.
    assert jerk < 1e-3


def test_above_the_air_refraction_changes_nothing():
    instants, states = orbit(60.0)
    star = {"ra_deg": 53.0, "dec_deg": 0.0}
    bare = StarTarget(**star).apparent(instants, states)
    assert bare.clearance_rad.min() > 0.5
    lifted = StarTarget(refraction="standard", **star).apparent(instants, states)
    np.testing.assert_allclose(lifted.direction_eci, bare.direction_eci, rtol=0, atol=1e-15)


def test_a_hidden_target_is_told_by_how_much():
    instants, states = orbit(1.0)
    nadir = -states.r_sat_eci_m[0] / np.linalg.norm(states.r_sat_eci_m[0])
    ra_deg = float(np.degrees(np.arctan2(nadir[1], nadir[0])) % 360.0)
    star = StarTarget(ra_deg=ra_deg, dec_deg=float(np.degrees(np.arcsin(nadir[2]))))
    seen = star.apparent(instants, states)
    assert seen.clearance_rad.max() < -1.0
    assert "below the limb" in star.hidden_because(float(seen.clearance_rad.min()))


def test_a_hipparcos_number_is_the_star_of_its_coordinates():
    instants, states = orbit(1.0)
    by_number = StarTarget(hip=32349).apparent(instants, states)
    by_coordinates = StarTarget(
        ra_deg=101.2885410520664,  # Sirius as CDS I/311 lists it
        dec_deg=-16.713143062644765,
        epoch_jyear=1991.25,
        parallax_mas=379.21,
        pm_ra_cosdec_mas_yr=-546.01,
        pm_dec_mas_yr=-1223.07,
    ).apparent(instants, states)
    np.testing.assert_array_equal(by_number.direction_eci, by_coordinates.direction_eci)


@pytest.mark.parametrize(
    ("fields", "says"),
    [
        ({}, "or ra_deg and dec_deg"),
        ({"ra_deg": 10.0}, "or ra_deg and dec_deg"),
        ({"hip": 11767, "ra_deg": 10.0}, "not both"),
        ({"hip": 11767, "parallax_mas": 10.0}, "already says parallax_mas"),
        ({"hip": 120405}, "give the star's ra_deg"),
        (
            {"ra_deg": 1.0, "dec_deg": 9.0, "grazing_altitude_km": 0.0, "refraction": "standard"},
            "end on the ground",
        ),
    ],
)
def test_impossible_stars_are_refused(fields, says):
    with pytest.raises(ValueError, match=says):
        StarTarget(**fields)


def test_case_does_not_matter_in_the_name_of_a_body():
    assert BodyTarget(name="Jupiter").body_seen() == "jupiter"


B_M = WGS84_A_M * (1.0 - WGS84_F)
angles = st.floats(0.0, 2.0 * np.pi)


def directions(down, aside, from_nadir_rad):
    return np.cos(from_nadir_rad)[:, None] * down + np.sin(from_nadir_rad)[:, None] * aside


@given(longitude=angles, grazing_m=st.floats(0.0, 200e3), height_m=st.floats(250e3, 36e6))
def test_over_the_equator_the_limb_is_a_circles(longitude, grazing_m, height_m):
    """Looking along the equator the Earth is a circle: clearance = angle - asin(R/r)."""
    up = np.array([np.cos(longitude), np.sin(longitude), 0.0])
    east = np.array([-np.sin(longitude), np.cos(longitude), 0.0])
    from_nadir = np.linspace(0.01, np.pi - 0.01, 19)
    r = WGS84_A_M + height_m
    clearance = limb_clearance_rad(
        directions(-up, east, from_nadir), np.broadcast_to(r * up, (19, 3)), grazing_m
    )
    expected = from_nadir - np.arcsin((WGS84_A_M + grazing_m) / r)
    np.testing.assert_allclose(clearance, expected, rtol=0, atol=1e-12)  # rounding of arcsin


@given(azimuth=angles, height_m=st.floats(250e3, 36e6))
def test_over_the_pole_the_limb_is_an_ellipses(azimuth, height_m):
    """Tangent from (0, z) to the meridian ellipse: tan(dip) = a / sqrt(z^2 - b^2)."""
    aside = np.array([[np.cos(azimuth), np.sin(azimuth), 0.0]])
    z = B_M + height_m
    clearance = limb_clearance_rad(aside, np.array([[0.0, 0.0, z]]), 0.0)
    expected = np.pi / 2.0 - np.arctan2(WGS84_A_M, np.sqrt(z**2 - B_M**2))
    assert clearance[0] == pytest.approx(expected, abs=1e-12)


@given(
    latitude=st.floats(-np.pi / 2, np.pi / 2),
    longitude=angles,
    azimuth=angles,
    grazing_m=st.floats(0.0, 100e3),
)
def test_turned_by_its_clearance_a_line_touches_the_raised_earth(
    latitude, longitude, azimuth, grazing_m
):
    r_sat = itrf_from_geodetic(latitude, longitude, 420e3)
    down = -r_sat / np.linalg.norm(r_sat)
    spare = np.linalg.svd(down[None])[2][1:]
    aside = np.cos(azimuth) * spare[0] + np.sin(azimuth) * spare[1]
    line = directions(down, aside, np.array([1.2]))
    clearance = limb_clearance_rad(line, r_sat[None], grazing_m)
    touching = directions(down, aside, 1.2 - clearance)
    assert limb_clearance_rad(touching, r_sat[None], grazing_m)[0] == pytest.approx(0.0, abs=1e-12)
    # The raised ellipsoid differs from the true parallel surface by f times the altitude.
    assert line_height_m(touching, r_sat[None])[0] == pytest.approx(
        grazing_m, abs=2.0 + 2.0 * WGS84_F * grazing_m
    )


def test_straight_down_is_hidden_by_the_whole_dip():
    r_sat = np.array([[7e6, 0.0, 0.0]])
    clearance = limb_clearance_rad(-r_sat / 7e6, r_sat, 0.0)
    assert np.isfinite(clearance[0])
    # Which plane through the vertical is undefined: a meridian's limb is 0.15 deg lower.
    assert clearance[0] == pytest.approx(-np.arcsin(WGS84_A_M / 7e6), abs=np.radians(0.3))


@given(latitude=st.floats(-1.57, 1.57), longitude=angles, azimuth=angles)
def test_light_through_the_limb_is_lifted_by_the_bending_of_the_line_seen(
    latitude, longitude, azimuth
):
    r_sat = itrf_from_geodetic(latitude, longitude, 420e3)
    down = -r_sat / np.linalg.norm(r_sat)
    spare = np.linalg.svd(down[None])[2][1:]
    aside = np.cos(azimuth) * spare[0] + np.sin(azimuth) * spare[1]
    limb_rad = 1.2 - limb_clearance_rad(directions(down, aside, np.array([1.2])), r_sat[None], 0.0)
    true_rad = limb_rad + np.radians(np.linspace(-0.9, 3.0, 40))
    many_r_sat = np.broadcast_to(r_sat, (40, 3))
    true = directions(down, aside, true_rad)
    seen = refract(true, many_r_sat)
    height_m = line_height_m(seen, many_r_sat)
    lifted_rad = np.arctan2(
        np.linalg.norm(np.cross(true, seen), axis=1), np.sum(true * seen, axis=1)
    )
    in_air = (height_m > 3e3) & (height_m < 120e3)
    assert in_air.sum() > 5
    # 1e-9 rad = 0.0002 arcsec: where Newton stops.
    np.testing.assert_allclose(lifted_rad[in_air], bending_rad(height_m[in_air]), rtol=0, atol=1e-9)
    assert np.all(height_m[in_air] >= line_height_m(true, many_r_sat)[in_air])


def test_bending_of_an_exponential_atmosphere():
    """(n - 1) sqrt(2 pi r / H), first order in (n - 1) r / H.

    The isothermal layer at 11-20 km is exponential: H = R T / g0 = 6.34 km in geopotential.
    """
    height_m = 14e3
    radius_m = 6371e3 + height_m
    scale_m = 287.05287 * 216.65 / (9.80665 * (6356766.0 / (6356766.0 + height_m)) ** 2)
    line_height_m_ = height_m + refractivity(height_m) * radius_m
    expected = refractivity(height_m) * np.sqrt(2.0 * np.pi * radius_m / scale_m)
    second_order = refractivity(height_m) * radius_m / scale_m  # 5 %
    assert bending_rad(line_height_m_) == pytest.approx(expected, rel=2.0 * second_order)
