"""Closed forms and invariants behind the third paper's part of the report."""

import numpy as np
import pytest
from reproduction.platonov import gyro_reach_deg_s, needed_gyro_n_m_s, spin_up_s

from planner.world.platforms.cmg_array import CmgArray


def test_four_channels_reach_sqrt_3_of_one():
    assert gyro_reach_deg_s() == pytest.approx(1.6 * np.sqrt(3.0), rel=1e-6)


def test_spin_up_takes_the_momentum_over_the_torque_and_the_torque_its_rise():
    # J w / M + M / M': a trapezoid of torque.
    expected = 800.0 * np.deg2rad(3.5) / 30.0 + 30.0 / 40.0
    assert spin_up_s(3.5, 30.0) == pytest.approx(expected, rel=0.03)


def test_the_least_gyro_for_a_momentum_along_z_is_a_quarter_of_it():
    array = CmgArray()
    rows = np.array([array.gimbal_angles(np.array([0.0, 0.0, h])) for h in (0.0, 20.0)])
    assert needed_gyro_n_m_s(rows) == pytest.approx(5.0, abs=0.02)
