"""Closed forms and invariants behind the third paper's part of the report."""

import sys
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

sys.path.insert(0, str(Path(__file__).parents[2] / "bench"))

from reproduction.platonov import (
    DIPOLE_ITRF_T,
    EXAMPLES,
    INERTIA_KG_M2,
    K2_PER_S2,
    RADIUS_M,
    STEP_S,
    TURN_RATE_RAD_S,
    boresights_body,
    coil_torque_n_m,
    field_eci_t,
    gyro_reach_deg_s,
    hold,
    needed,
    parallel_measure,
    printed_rates_rad_s,
    sigma_arcsec,
    spin_up_s,
    text,
    unload,
)

from planner.spacecraft.vehicle.cmg_array import CmgArray
from planner.world.frames.earth_orientation import c_itrf_from_eci
from planner.world.frames.time_scales import Instants
from planner.world.orbits.ephemeris import OrbitStates

EPOCH = datetime(2024, 6, 1, 10, 0, tzinfo=UTC)


def test_dipole_has_igrf_strength_at_its_equator_and_twice_that_at_its_pole():
    """B0 of IGRF-13 in 2020: 29.8 uT."""
    strength = np.linalg.norm(DIPOLE_ITRF_T)
    assert strength == pytest.approx(29.8e-6, rel=2e-3)
    instants = Instants(EPOCH, np.zeros(2))
    pole = DIPOLE_ITRF_T / strength
    equator = np.cross(pole, [1.0, 0.0, 0.0])
    equator /= np.linalg.norm(equator)
    r = RADIUS_M * np.stack([pole, equator])
    r_eci = np.einsum("nji,nj->ni", c_itrf_from_eci(instants), r)
    found = np.linalg.norm(field_eci_t(r_eci, instants), axis=1)
    np.testing.assert_allclose(found, [2.0 * strength, strength], rtol=1e-9)


@pytest.mark.parametrize("seed", range(20))
def test_coils_torque_is_square_to_the_field_and_never_adds_momentum(seed):
    random = np.random.default_rng(seed)
    h, field = 30.0 * random.standard_normal(3), 3e-5 * random.standard_normal(3)
    torque = coil_torque_n_m(h, field, np.eye(3), 140.0)
    assert torque @ field == pytest.approx(0.0, abs=1e-18)
    assert torque @ h <= 0.0
    # Three coils full make no more than sqrt(3) of one.
    assert np.linalg.norm(torque) <= 140.0 * np.sqrt(3.0) * np.linalg.norm(field)


def test_unloading_keeps_the_momentum_along_a_field_that_stands_still():
    """Over one place of an Earth at rest nothing along the field can be unloaded."""
    n = 400
    r = np.tile([7.0e6, 0.0, 1.0e6], (n, 1))
    states, instants = OrbitStates(r, np.zeros_like(r)), Instants(EPOCH, np.zeros(n))
    field = field_eci_t(r, instants)[0]
    along = field / np.linalg.norm(field)
    start = np.array([3.0, -2.0, 1.0])
    run = unload(states, instants, np.tile(np.eye(3), (n, 1, 1)), start, np.zeros((n, 3)))
    np.testing.assert_allclose(run.h_eci_n_m_s @ along, start @ along, atol=1e-9)
    # A coil of 140 A m^2 takes all across the field in n steps of some mN m.
    assert run.torque_n_m[0] * n * STEP_S > 3.7
    across = run.h_eci_n_m_s[-1] - (start @ along) * along
    assert np.linalg.norm(across) < 0.01


def test_momentum_counted_twice_leaves_the_error_of_a_spring():
    """J k2 2n = omega x H: a constant torque against the law's spring."""
    stored = np.array([0.0, 15.0, 0.0])
    found = hold(TURN_RATE_RAD_S, stored, twice=True)
    # After 40 s, in body axes; the law follows its slow turn by 1.8 s (k1 / k2) late: 5 %.
    turned = Rotation.from_rotvec(-40.0 * TURN_RATE_RAD_S).apply(stored)
    spring = INERTIA_KG_M2 * K2_PER_S2
    expected = np.rad2deg(np.linalg.norm(np.cross(TURN_RATE_RAD_S, turned) / spring))
    assert found.error_deg == pytest.approx(expected, rel=0.05)
    assert hold(TURN_RATE_RAD_S, stored, twice=False).error_deg < 0.02 * expected


def test_the_printed_null_motion_gives_no_torque_and_climbs_towards_parallel_pairs():
    array = CmgArray()
    gimbal = array.gimbal_angles(np.array([8.0, -6.0, 4.0]))
    rates = printed_rates_rad_s(gimbal, np.zeros(3), 0.02, -1.0)
    np.testing.assert_allclose(array.jacobian(gimbal) @ rates, 0.0, atol=1e-12)
    assert parallel_measure(gimbal + 0.01 * rates) > parallel_measure(gimbal)


def test_four_channels_reach_sqrt_3_of_one():
    assert gyro_reach_deg_s() == pytest.approx(1.6 * np.sqrt(3.0), rel=1e-6)


def test_spin_up_takes_the_momentum_over_the_torque_and_the_torque_its_rise():
    # J w / M + M / M': a trapezoid of torque.
    expected = 800.0 * np.deg2rad(3.5) / 30.0 + 30.0 / 40.0
    assert spin_up_s(3.5, 30.0) == pytest.approx(expected, rel=0.03)


def test_the_least_gyro_for_a_momentum_along_z_is_a_quarter_of_it():
    array = CmgArray()
    rows = np.array([array.gimbal_angles(np.array([0.0, 0.0, h])) for h in (0.0, 20.0)])
    assert needed(rows, 0.2).gyro_n_m_s == pytest.approx(5.0, abs=0.02)


def test_trackers_together_know_every_axis():
    cosine = boresights_body() @ boresights_body().T
    # 45 deg from one axis and 120 deg apart about it: cos = 1/2 + cos(120 deg)/2.
    np.testing.assert_allclose(cosine[~np.eye(3, dtype=bool)], 0.25, atol=1e-12)
    assert sigma_arcsec((0,))[-1] == pytest.approx(40.0)
    assert sigma_arcsec((0, 1))[-1] < 5.0 / np.sqrt(1.0 - 0.25**2) * np.sqrt(2.0)


@pytest.mark.parametrize("name", ["strip_and_stereo", "eight_areas"])
def test_examples_are_the_sessions_of_the_report(name):
    assert (EXAMPLES / f"spacecraft_{name}.json").read_text(encoding="utf-8") == text(name)
