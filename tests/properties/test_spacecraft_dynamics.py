"""Does the simulated body obey mechanics: conservation, Euler's equations, order of steps?"""

import dataclasses

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.signal import lti, step
from scipy.spatial.transform import Rotation

from planner.spacecraft.flight.simulation import nominal, plant
from planner.spacecraft.vehicle.definition import AGILE_CMG
from planner.spacecraft.vehicle.dynamics import (
    advance,
    array_momentum,
    body_rate,
    scratch,
    servo_half_step,
    servo_transition,
)

M = len(AGILE_CMG.modes)


def start(body, rate, servo):
    state, tools = np.zeros(7 + 2 * M), scratch(7 + 2 * M)
    state[3] = 1.0
    array_momentum(body, servo, 0.0, tools.momenta[2])
    total = tools.momenta[2] + body.inertia @ rate
    state[4:7] = total
    state[7 + M :] = body.couplings @ rate
    return state, tools


def flown(step_s, seconds, command):
    body = plant(AGILE_CMG, nominal(AGILE_CMG), float("inf"), step_s)
    servo = np.zeros((4, 3))
    servo[:, 0] = AGILE_CMG.array.gimbal_angles(np.array([2.0, -1.0, 3.0]))
    state, tools = start(body, np.array([0.004, -0.002, 0.01]), servo)
    for k in range(round(seconds / step_s)):
        advance(body, state, servo, command, np.zeros(3), k * step_s, tools)
    return body, state, servo, tools


COMMAND = np.array([0.02, -0.03, 0.01, 0.025])


def test_momentum_is_conserved_and_seen_so_from_the_outside():
    """Re-added from rate, swinging modes and gyros, as an observer would: 1e-9 promised."""
    body, state, servo, _ = flown(0.005, 60.0, COMMAND)
    _, first, first_servo, _ = flown(0.005, 0.0, COMMAND)
    totals = []
    for s, g in ((first, first_servo), (state, servo)):
        gyros, rate = np.zeros(3), np.zeros(3)
        array_momentum(body, g, 0.0, gyros)
        body_rate(body, s, gyros, rate)
        swing = s[7 + M :] - body.couplings @ rate
        seen = body.inertia @ rate + body.couplings.T @ swing + gyros
        totals.append(Rotation.from_quat(s[:4]).apply(seen))
    assert np.linalg.norm(totals[1] - totals[0]) < 1e-9 * np.linalg.norm(totals[0])


def test_integrator_is_of_fourth_order():
    reference = flown(0.0005, 4.0, COMMAND)[1]
    errors = [np.abs(flown(h, 4.0, COMMAND)[1] - reference).max() for h in (0.008, 0.004, 0.002)]
    order = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.all(order > 3.7)  # 4 in the limit; 10 Hz modes at 8 ms aren't quite there


def test_body_follows_eulers_equations():
    """J w' = -d^T eta'' - H' - w x (J w + d^T eta' + H), written with accelerations, by DOP853."""
    body, state, servo, tools = flown(0.002, 3.0, COMMAND)
    array = AGILE_CMG.array
    gimbal0 = array.gimbal_angles(np.array([2.0, -1.0, 3.0]))
    w2, xi = array.servo_rad_s**2, array.servo_damping

    def slope(_, y):
        w, eta, eta1, g, g1, g2 = np.split(y, [3, 3 + M, 3 + 2 * M, 7 + 2 * M, 11 + 2 * M])
        gyro_rate = array.momentum_n_m_s * array.jacobian(g) @ g1
        carried = body.inertia @ w + body.couplings.T @ eta1 + array.momentum(g)
        force = -body.stiffness * eta - body.damping * eta1
        # eta'' = force - d w'
        left = body.inertia - body.couplings.T @ body.couplings
        w1 = np.linalg.solve(left, -body.couplings.T @ force - gyro_rate - np.cross(w, carried))
        g3 = w2 * (COMMAND - g1) - 2 * xi * array.servo_rad_s * g2
        return np.concatenate([w1, eta1, force - body.couplings @ w1, g1, g2, g3])

    y0 = np.concatenate([[0.004, -0.002, 0.01], np.zeros(2 * M), gimbal0, np.zeros(8)])
    theirs = solve_ivp(slope, (0.0, 3.0), y0, method="DOP853", rtol=1e-11, atol=1e-14).y[:, -1]
    rate = np.zeros(3)
    body_rate(body, state, tools.momenta[2], rate)
    # RK4 at 2 ms of 10 Hz modes swinging with 1e-4 rad/s: 1e-9 rad/s
    np.testing.assert_allclose(rate, theirs[:3], atol=2e-9)
    np.testing.assert_allclose(servo[:, 0], theirs[3 + 2 * M : 7 + 2 * M], atol=1e-9)


def test_servo_is_the_papers_transfer_function():
    half, drive = servo_transition(50.0, 0.7, 0.005)
    body = plant(AGILE_CMG, nominal(AGILE_CMG), float("inf"), 0.01)
    body = body._replace(servo_half=half, servo_input=drive)
    servo, rates = np.zeros((4, 3)), []
    for _ in range(60):
        servo_half_step(body, np.array([1.0, 2.0, 0.0, -1.0]), servo)
        rates.append(servo[:, 1].copy())
    times = 0.005 * np.arange(61)
    _, expected = step(lti([1.0], [1 / 2500.0, 2 * 0.7 / 50.0, 1.0]), T=times)
    # both exact; scipy's own state-space step rounds at 1e-12
    np.testing.assert_allclose(np.array(rates)[:, 0], expected[1:], atol=1e-9)
    np.testing.assert_allclose(np.array(rates)[:, 1], 2.0 * expected[1:], atol=2e-9)


def test_gravity_gradient_turns_like_its_formula():
    body = plant(AGILE_CMG, nominal(AGILE_CMG), 7.0e6, 0.01)
    assert body.gravity_per_s2 == pytest.approx(3 * 3.986004418e14 / 7.0e6**3)
    rigid = dataclasses.replace(AGILE_CMG, modes=())
    body = plant(rigid, nominal(rigid), 7.0e6, 0.01)
    servo = np.zeros((4, 3))
    servo[:, 0] = AGILE_CMG.array.gimbal_angles(np.zeros(3))
    state, tools = np.zeros(7), scratch(7)
    state[3] = 1.0
    array_momentum(body, servo, 0.0, tools.momenta[2])
    nadir = np.array([0.6, 0.64, 0.48])
    advance(body, state, servo, np.zeros(4), nadir, 0.0, tools)
    expected = body.gravity_per_s2 * np.cross(nadir, body.inertia @ nadir) * 0.01
    np.testing.assert_allclose(state[4:7], expected, atol=1e-11)  # it barely turns in 10 ms
