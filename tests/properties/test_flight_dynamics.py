"""The axes and their carrier keep what mechanics keeps, and the integrator keeps its order.

The energy and momentum are written anew here from velocities, not from the equations flown.
"""

import math

import numpy as np
import pytest
from flight_cases import ROCKING, lossless, rough
from scipy.spatial.transform import Rotation

from planner.inflight.simulation.loop import advance, tolerances
from planner.inflight.simulation.plant import (
    AXIS_STATES,
    MODE_STATES,
    derivative,
    jacobian,
    plant_of,
)
from planner.inflight.simulation.rosenbrock import Torque, scratch_for, step

J_OUTER_KG_M2, J_INNER_KG_M2 = 90.0, 60.0
E = np.array([mode.axis_platform for mode in ROCKING.structural_modes])
M = np.array([mode.inertia_kg_m2 for mode in ROCKING.structural_modes])
OMEGA = 2.0 * math.pi * np.array([mode.frequency_hz for mode in ROCKING.structural_modes])
FIRST = 2 * AXIS_STATES
START = np.array(
    [
        *(0.4, 0.03, 0.0, -0.7, -0.02, 0.0),  # angle, rate, bristle of both axes
        *(1e-3, 0.01, -2e-3, 0.004, 1e-3, -0.003, 5e-4, 0.002),  # turn and swing of each mode
    ]
)
LIMP = np.zeros(2)


def couplings(alpha_rad):
    """Of each mode with both axes, (2, m)."""
    outer, inner = ROCKING.axes_platform
    return np.array([E @ outer, E @ Rotation.from_rotvec(alpha_rad * outer).apply(inner)])


def energy_j(states, plant):
    swing, turn = states[FIRST + 1 :: MODE_STATES], states[FIRST::MODE_STATES]
    kinetic = J_OUTER_KG_M2 * states[1] ** 2 + J_INNER_KG_M2 * states[4] ** 2 + M @ swing**2
    springs = M @ (plant.mode_rad_s * turn) ** 2
    for inertia, axis in ((J_OUTER_KG_M2, 0), (J_INNER_KG_M2, 1)):
        angle = states[AXIS_STATES * axis]
        springs += inertia * plant.stiffness_per_s2[axis] * angle**2
        springs += 2.0 * inertia * plant.tension_rad_s2[axis] * angle
    return 0.5 * (kinetic + springs)


def momentum_n_m_s(states):
    """Of each mode with its share of the axes, (m,)."""
    c = couplings(states[0])
    swing = states[FIRST + 1 :: MODE_STATES]
    return M * swing + J_OUTER_KG_M2 * c[0] * states[1] + J_INNER_KG_M2 * c[1] * states[4]


def fly_freely(plant, states, duration_s, torque_rad_s2=LIMP, precision_share=1e-6):
    """Integrate to precision_share of the simulator's own tolerances."""
    states, modes = states.copy(), len(plant.mode_rad_s)
    torque = Torque(torque_rad_s2, torque_rad_s2, np.zeros(2))
    advance(
        plant, states, np.sign(states[[1, 4]]), torque, precision_share * tolerances(modes),
        np.zeros(2), states[[0, 3]], duration_s, 1e-3, scratch_for(modes),
    )  # fmt: skip
    return states


def test_a_lossless_platform_keeps_its_energy():
    plant = lossless(
        ROCKING, stiffness_per_s2=np.array([0.3, 0.2]), tension_rad_s2=np.array([0.01, -0.02])
    )
    before = energy_j(START, plant)
    for duration_s in (1.0, 10.0, 60.0):
        after = energy_j(fly_freely(plant, START, duration_s), plant)
        assert after == pytest.approx(before, rel=1e-9)


def test_the_axes_do_exchange_energy_with_the_structure():
    """Else the balance above would be kept by standing apart."""
    plant = lossless(ROCKING, stiffness_per_s2=np.array([0.3, 0.2]))
    still = START.copy()
    still[FIRST:] = 0.0
    after = fly_freely(plant, still, 10.0)
    swung = 0.5 * M @ after[FIRST + 1 :: MODE_STATES] ** 2
    assert swung > 1e-3 * energy_j(still, plant)


def test_the_drives_work_is_what_the_energy_gains():
    """A constant torque's work is itself times the turn relative to the base."""
    plant, torque = lossless(ROCKING), np.array([0.004, -0.007])
    after = fly_freely(plant, START, 20.0, torque)
    work_j = np.array([J_OUTER_KG_M2, J_INNER_KG_M2]) * torque @ (after - START)[[0, 3]]
    gained_j = energy_j(after, plant) - energy_j(START, plant)
    assert gained_j == pytest.approx(work_j, rel=1e-9)
    assert abs(work_j) > energy_j(START, plant)


def test_a_free_structure_keeps_its_momentum_under_torque():
    """Torques between base and axis are internal; only springs to the carrier give momentum."""
    plant = lossless(ROCKING, mode_rad_s=np.zeros(len(M)))
    after = fly_freely(plant, START, 20.0, np.array([0.004, -0.007]))
    before = momentum_n_m_s(START)
    scale = np.abs(M * START[FIRST + 1 :: MODE_STATES]).max()
    np.testing.assert_allclose(momentum_n_m_s(after), before, rtol=0, atol=1e-9 * scale)
    assert abs(J_OUTER_KG_M2 * (after - START)[1]) > 0.1 * scale  # while the axes' changes


def test_a_structure_gains_the_momentum_its_springs_and_dampers_give():
    damping_per_s = plant_of(ROCKING, ROCKING.drives).mode_damping_per_s
    plant = lossless(ROCKING)._replace(mode_damping_per_s=damping_per_s)
    states, dt_s, given = START.copy(), 0.002, np.zeros(len(M))
    before = momentum_n_m_s(states)

    def force(states):
        turn, swing = states[FIRST::MODE_STATES], states[FIRST + 1 :: MODE_STATES]
        return -M * (plant.mode_rad_s**2 * turn + plant.mode_damping_per_s * swing)

    for _ in range(600):  # Simpson's rule: 1e-10 at a 250th of the shortest period
        middle = fly_freely(plant, states, dt_s / 2.0)
        after = fly_freely(plant, middle, dt_s / 2.0)
        given += dt_s / 6.0 * (force(states) + 4.0 * force(middle) + force(after))
        states = after
    np.testing.assert_allclose(
        momentum_n_m_s(states) - before, given, rtol=0, atol=1e-9 * np.abs(before).max()
    )


def test_the_integrator_has_order_four():
    """Error over steps halved thrice, against sixteen times finer ones: 2^4 a halving."""
    plant = plant_of(ROCKING, (rough(inertia_kg_m2=90.0), rough()))
    states = START.copy()
    states[[2, 5]] = (4e-6, -3e-6)
    states[[1, 4]] = (4e-5, -3e-5)  # near Stribeck's rate, where friction bends most
    states[FIRST + 1 :: MODE_STATES] *= 1e-3  # neither axis comes to rest
    torque = Torque(np.array([4e-3, -5e-3]), np.array([5e-3, -4e-3]), np.array([0.1, 0.05]))
    signs, duration_s = np.sign(states[[1, 4]]), 0.04

    def end(count):
        y, scratch = states.copy(), scratch_for(len(M))
        for k in range(count):
            step(plant, y, signs, torque, k * duration_s / count, duration_s / count, scratch)
            y[:] = scratch.end_states
        return y

    exact = end(1024)
    errors = [np.abs(end(count) - exact)[[1, 4]].max() for count in (16, 32, 64)]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.all((orders > 3.7) & (orders < 4.6)), (errors, orders)


def test_the_jacobian_is_the_derivative_of_the_derivative():
    """By complex-free central differences; a wrong entry would cost the order."""
    plant = plant_of(ROCKING, (rough(inertia_kg_m2=90.0), rough()))
    states = START.copy()
    states[[2, 5]] = (4e-6, -3e-6)
    states[[1, 4]] *= 0.01
    signs, rubbed, n = np.array([1.0, -1.0]), np.zeros(6), len(states)
    torque, slope, found = np.array([0.01, 0.02]), np.zeros(n), np.zeros((n, n))
    derivative(plant, states, torque, signs, rubbed, slope)
    jacobian(plant, states, slope, signs, rubbed, found)

    def slope_at(moved):
        out = np.zeros(n)
        derivative(plant, moved, torque, signs, rubbed, out)
        return out

    for k in range(n):
        shift = np.zeros(n)
        shift[k] = 1e-9
        column = (slope_at(states + shift) - slope_at(states - shift)) / 2e-9
        np.testing.assert_allclose(
            found[:, k], column, rtol=1e-5, atol=1e-6 * max(1.0, np.abs(column).max())
        )
