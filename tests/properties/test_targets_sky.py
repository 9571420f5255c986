"""Targets in the sky: smooth lines of sight, honest refusals, fields checked."""

from datetime import UTC, datetime

import numpy as np
import pytest

from planner.world.frames.solar_system import BODIES
from planner.world.frames.time_scales import Instants
from planner.world.orbits.ephemeris import OrbitStates
from planner.world.targets import BodyTarget, StarTarget

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
