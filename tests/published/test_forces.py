"""The lesser forces are what their sources say."""

from dataclasses import replace
from datetime import UTC, datetime

import numpy as np
import pytest

from planner.world.frames.time_scales import Instants
from planner.world.orbits.atmosphere import density_kg_m3
from planner.world.orbits.forces import GM_MOON_M3_S2, GM_SUN_M3_S2, forces_at

AT = Instants(datetime(2022, 2, 8, 13, tzinfo=UTC), np.zeros(1))
SUN_M = np.array([[1.496e11, 0.0, 0.0]])
ISS, NO_DRAG = 2.0 * 1500.0 / 450e3, 0.0  # m2/kg


@pytest.mark.parametrize(
    ("height_km", "night_g_km3", "bulge_g_km3"),
    # Montenbruck & Gill 2000, table 3.8
    [
        (200.0, 255.7, 316.2),
        (400.0, 2.249, 7.492),
        (420.0, 1.558, 5.684),
        (1000.0, 0.00115, 0.0181),
    ],
)
def test_density_on_the_tables_heights(height_km, night_g_km3, bulge_g_km3):
    lag = np.deg2rad(30.0)
    bulge = 6.8e6 * np.array([[np.cos(lag), np.sin(lag), 0.0]])
    height_m = np.array([height_km * 1e3])
    assert density_kg_m3(bulge, height_m, SUN_M)[0] == pytest.approx(bulge_g_km3 * 1e-12)
    assert density_kg_m3(-bulge, height_m, SUN_M)[0] == pytest.approx(night_g_km3 * 1e-12)


def test_no_air_above_the_table():
    assert density_kg_m3(np.array([[8e6, 0.0, 0.0]]), np.array([1.001e6]), SUN_M)[0] == 0.0


@pytest.mark.parametrize(
    ("name", "gm_m3_s2"), [("r_sun_eci_m", GM_SUN_M3_S2), ("r_moon_eci_m", GM_MOON_M3_S2)]
)
def test_a_third_body_stretches_along_its_line(name, gm_m3_s2):
    """The tide: 2 GM r / d^3 along the line and half of it, inward, across."""
    everything = forces_at(AT, NO_DRAG)
    body_m = getattr(everything, name)
    distance_m = np.linalg.norm(body_m)
    line = body_m / distance_m
    across = np.cross(line, [[0.0, 0.0, 1.0]])
    across /= np.linalg.norm(across)
    nothing = replace(everything, r_sun_eci_m=1e20 * line, r_moon_eci_m=1e20 * line)
    body_alone = replace(nothing, **{name: body_m})

    def pull(direction):
        state = 7e6 * direction, np.zeros((1, 3))
        difference = body_alone.acceleration_eci_m_s2(*state) - nothing.acceleration_eci_m_s2(
            *state
        )
        return (difference @ direction.T).item()

    tide_m_s2 = gm_m3_s2 * 7e6 / distance_m**3
    # the next term of the expansion: 3 r / d of it, 5.5 % for the Moon
    assert pull(line) == pytest.approx(2.0 * tide_m_s2, rel=0.06)
    assert pull(across) == pytest.approx(-tide_m_s2, rel=0.06)


def test_drag_opposes_the_motion_through_the_turning_air():
    r_m = np.array([[6.79e6, 0.0, 0.0]])
    air_m_s = np.array([[0.0, 7.292115e-5 * 6.79e6, 0.0]])
    forces, without = forces_at(AT, ISS), forces_at(AT, NO_DRAG)

    def drag(v_m_s):
        return forces.acceleration_eci_m_s2(r_m, v_m_s) - without.acceleration_eci_m_s2(r_m, v_m_s)

    # polar motion and precession tilt the axis by 2e-3 rad
    assert np.linalg.norm(drag(air_m_s)) < 1e-12
    eastward = drag(air_m_s + np.array([[0.0, 7000.0, 0.0]]))[0]
    # rho v^2 C A / 2 m with the table's 1.1e-12 to 4.4e-12 kg/m^3 at 412 km
    assert -1.1e-6 < eastward[1] < -1.5e-7
    assert abs(eastward[0]) < 1e-10
