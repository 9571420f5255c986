"""Refraction and the air that makes it, against printed figures."""

import numpy as np
import pytest

from planner.world.targets.refraction import bending_rad, raised_m
from planner.world.targets.standard_atmosphere import density_kg_m3, refractivity

EARTH_RADIUS_M = 6371e3


@pytest.mark.parametrize(
    ("height_m", "density"),
    [
        (0.0, 1.2250), (5e3, 7.3643e-1), (11e3, 3.6480e-1), (20e3, 8.8910e-2), (32e3, 1.3555e-2),
        (50e3, 1.0269e-3), (60e3, 3.0968e-4), (80e3, 1.8458e-5),
    ],
)  # fmt: skip
def test_density_matches_the_standards_table(height_m, density):
    """U.S. Standard Atmosphere 1976, table I."""
    assert density_kg_m3(height_m) == pytest.approx(density, rel=5e-5)  # five printed digits


def test_standard_air_refracts_as_measured():
    """Ciddor 1996 at 550 nm, 15 C, 101325 Pa, dry, 450 ppm CO2: n - 1 = 2.7790e-4."""
    assert refractivity(0.0) == pytest.approx(2.779e-4, rel=1e-3)  # 0.03 % between the formulas


def displacement_along_ground_m(off_nadir_deg, orbit_height_m, target_height_m=0.0):
    r_target = EARTH_RADIUS_M + target_height_m
    r_sat = EARTH_RADIUS_M + orbit_height_m
    off_nadir = np.radians(off_nadir_deg)
    zenith = np.arcsin(r_sat / r_target * np.sin(off_nadir))
    range_m = r_target * np.sin(zenith - off_nadir) / np.sin(off_nadir)
    raised = raised_m(np.array([zenith]), np.array([range_m]), np.array([target_height_m]))
    return raised[0] * np.tan(zenith)


@pytest.mark.parametrize(
    ("off_nadir_deg", "published_m", "last_digit_m"), [(30, 2.0, 1.0), (45, 7.5, 0.5)]
)
def test_displacement_matches_yan_2016(off_nadir_deg, published_m, last_digit_m):
    """Yan et al. 2016, PE&RS 82, 427: "about 2 m and 7.5 m" off-pointing DMC-3, 651 km high."""
    displaced_m = displacement_along_ground_m(off_nadir_deg, 651e3)
    assert displaced_m == pytest.approx(published_m, abs=last_digit_m / 2.0)


def test_displacement_on_a_plateau_matches_noerdlinger_1999():
    """ISPRS J. Photogramm. 54, 360, 1.3.3: 2000 m high at 45 deg zenith angle "about 4 m"."""
    off_nadir_deg = np.degrees(np.arcsin(np.sin(np.radians(45.0)) * 6373.0 / 7076.0))
    assert displacement_along_ground_m(off_nadir_deg, 705e3, 2000.0) == pytest.approx(4.0, abs=0.5)


def test_ray_grazing_the_sea_bends_twice_as_the_setting_sun():
    """Horizontal refraction of the ISA, Sinclair's formula as given by Bennett 1982: 33.6 arcmin.

    The ray from space touches the sea and leaves again.  1.77 km is (n - 1) Earth radii.
    """
    bent_arcmin = np.degrees(bending_rad(1.771e3)) * 60.0
    assert bent_arcmin == pytest.approx(
        2.0 * 33.6, rel=0.03
    )  # formulas for the horizon: +-1 arcmin
