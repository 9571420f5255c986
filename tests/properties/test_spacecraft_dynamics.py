"""The simulated body obeys mechanics: conservation, Euler's equations, order of steps."""

import dataclasses

import numpy as np
import pytest
from nominal_spacecraft import nominal
from scipy.integrate import solve_ivp
from scipy.signal import lti, step
from scipy.spatial.transform import Rotation

from planner.inflight.simulation.gyros.dispersed import plant
from planner.inflight.simulation.gyros.dynamics import (
    ETA,
    G,
    advance,
    advance_servos,
    array_momentum,
    body_at,
    body_rate,
    servo_step,
)
from planner.spacecraft.vehicle import AgileSpacecraft

CRAFT = AgileSpacecraft().craft
M = len(CRAFT.modes)


UPRIGHT = np.array([0.0, 0.0, 0.0, 1.0])


def flown(step_s, seconds, command):
    real = plant(CRAFT, nominal(CRAFT), float("inf"), step_s)
    gimbal_rad = CRAFT.array.gimbal_angles(np.array([2.0, -1.0, 3.0]))
    body = body_at(real, UPRIGHT, np.array([0.004, -0.002, 0.01]), gimbal_rad)
    for k in range(round(seconds / step_s)):
        advance(real, body, command, np.zeros(3), k * step_s)
    return real, body


COMMAND = np.array([0.02, -0.03, 0.01, 0.025])


def test_momentum_is_conserved_and_seen_so_from_the_outside():
    """Re-added from rate, swinging modes and gyros, as an observer would: 1e-9 promised."""
    real, last = flown(0.005, 60.0, COMMAND)
    _, first = flown(0.005, 0.0, COMMAND)
    totals = []
    for body in (first, last):
        gyros, rate = np.zeros(3), np.zeros(3)
        array_momentum(real, body.servo_states, 0.0, gyros)
        body_rate(real, body.state, gyros, rate)
        swing = body.state[ETA + M :] - real.couplings_sqrt_kg_m @ rate
        seen = real.inertia_kg_m2 @ rate + real.couplings_sqrt_kg_m.T @ swing + gyros
        totals.append(Rotation.from_quat(body.state[:G]).apply(seen))
    assert np.linalg.norm(totals[1] - totals[0]) < 1e-9 * np.linalg.norm(totals[0])


def test_integrator_is_of_fourth_order():
    _, reference = flown(0.0005, 4.0, COMMAND)
    errors = [
        np.abs(flown(h, 4.0, COMMAND)[1].state - reference.state).max()
        for h in (0.008, 0.004, 0.002)
    ]
    order = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.all(order > 3.7)  # 4 in the limit; 10 Hz modes at 8 ms aren't quite there


def test_body_follows_eulers_equations():
    """J w' = -d^T eta'' - H' - w x (J w + d^T eta' + H), written with accelerations, by DOP853."""
    real, body = flown(0.002, 3.0, COMMAND)
    inertia, d = real.inertia_kg_m2, real.couplings_sqrt_kg_m
    array = CRAFT.array
    gimbal0 = array.gimbal_angles(np.array([2.0, -1.0, 3.0]))
    w2, xi = array.servo_rad_s**2, array.servo_damping

    def slope(_, y):
        w, eta, eta1, g, g1, g2 = np.split(y, [3, 3 + M, 3 + 2 * M, 7 + 2 * M, 11 + 2 * M])
        gyro_rate = array.momentum_n_m_s * array.jacobian(g) @ g1
        carried = inertia @ w + d.T @ eta1 + array.momentum(g)
        force = -real.stiffness_per_s2 * eta - real.damping_per_s * eta1
        # eta'' = force - d w'
        left = inertia - d.T @ d
        w1 = np.linalg.solve(left, -d.T @ force - gyro_rate - np.cross(w, carried))
        g3 = w2 * (COMMAND - g1) - 2 * xi * array.servo_rad_s * g2
        return np.concatenate([w1, eta1, force - d @ w1, g1, g2, g3])

    y0 = np.concatenate([[0.004, -0.002, 0.01], np.zeros(2 * M), gimbal0, np.zeros(8)])
    theirs = solve_ivp(slope, (0.0, 3.0), y0, method="DOP853", rtol=1e-11, atol=1e-14).y[:, -1]
    # RK4 at 2 ms of 10 Hz modes swinging with 1e-4 rad/s: 1e-9 rad/s
    np.testing.assert_allclose(body.omega_body_rad_s, theirs[:3], atol=2e-9)
    np.testing.assert_allclose(body.servo_states[:, 0], theirs[3 + 2 * M : 7 + 2 * M], atol=1e-9)


def test_servo_is_the_papers_transfer_function():
    servo, rates = np.zeros((4, 3)), []
    for _ in range(60):
        advance_servos(servo_step(50.0, 0.7, 0.005), np.array([1.0, 2.0, 0.0, -1.0]), servo)
        rates.append(servo[:, 1].copy())
    times = 0.005 * np.arange(61)
    _, expected = step(lti([1.0], [1 / 2500.0, 2 * 0.7 / 50.0, 1.0]), T=times)
    # both exact; scipy's own state-space step rounds at 1e-12
    np.testing.assert_allclose(np.array(rates)[:, 0], expected[1:], atol=1e-9)
    np.testing.assert_allclose(np.array(rates)[:, 1], 2.0 * expected[1:], atol=2e-9)


def test_gravity_gradient_turns_like_its_formula():
    real = plant(CRAFT, nominal(CRAFT), 7.0e6, 0.01)
    assert real.gravity_per_s2 == pytest.approx(3 * 3.986004418e14 / 7.0e6**3)
    rigid = dataclasses.replace(CRAFT, modes=())
    real = plant(rigid, nominal(rigid), 7.0e6, 0.01)
    body = body_at(real, UPRIGHT, np.zeros(3), CRAFT.array.gimbal_angles(np.zeros(3)))
    nadir = np.array([0.6, 0.64, 0.48])
    advance(real, body, np.zeros(4), nadir, 0.0)
    expected = real.gravity_per_s2 * np.cross(nadir, real.inertia_kg_m2 @ nadir) * 0.01
    np.testing.assert_allclose(body.state[G:ETA], expected, atol=1e-11)  # it barely turns in 10 ms
