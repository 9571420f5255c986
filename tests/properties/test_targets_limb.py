"""Behind the Earth or not, and lifted by how much: closed forms and invariants."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planner.world.frames.geodesy import WGS84_A_M, WGS84_F, itrf_from_geodetic
from planner.world.targets.earth_limb import limb_clearance_rad, line_height_m, refract
from planner.world.targets.refraction import bending_rad
from planner.world.targets.standard_atmosphere import refractivity

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
