"""Motion of the body while its gyros turn: rigid body, flexible modes, gimbal servos.

The body is integrated in momentum form: the state is the attitude, the total angular momentum
G in inertial axes, modal coordinates eta and modal momenta p = eta' + d.omega, so that

    (J - sum d d^T) omega = R^T G - H(gimbals) - sum d p,
    p' = -w^2 eta - 2 zeta w eta',   G' = R (gravity gradient),

which needs no gimbal acceleration and can't leak momentum: without external torque G stays
bit for bit.  RK4 in fixed steps; the servo, being linear, is propagated exactly.
"""

import math
from typing import NamedTuple

import numpy as np
from scipy.linalg import expm

from planner.base.arrays import Array
from planner.base.compiled import compiled, lean
from planner.world.platforms.cmg_array import Gyros

G, ETA = 4, 7  # where G and eta begin in a state: q_eci_from_body_xyzw, G (N m s), eta, p


class Ripple(NamedTuple):
    """Disturbance torque of each rotor's drive, a cos(w t + phase): (4,) each."""

    torque_n_m: Array
    rate_rad_s: Array
    phase_rad: Array


class ServoStep(NamedTuple):
    """Exact step of a servo's angle, rate and acceleration (rad, s) under a constant command."""

    transition_matrix: Array  # (3, 3)
    input_gain: Array  # (3,), by the commanded rate


class Plant(NamedTuple):
    """The body as it really is: dispersions applied.  m modes."""

    inertia_kg_m2: Array  # (3, 3), swinging parts included
    rigid_inverse_per_kg_m2: Array  # (3, 3), (J - sum d d^T)^-1
    couplings_sqrt_kg_m: Array  # (m, 3)
    stiffness_per_s2: Array  # (m,), w^2
    damping_per_s: Array  # (m,), 2 zeta w
    gyros: Gyros
    gimbal_axes_body: Array  # (4, 3)
    gimbal_inertia_kg_m2: float
    servo_half_step: ServoStep
    step_s: float
    rate_scale: Array  # (4,), executed over commanded gimbal rate
    ripple: Ripple
    gravity_per_s2: float  # 3 mu / r^3


class MovingBody(NamedTuple):
    """The moving body, changed in place; the last four are arrays that a step reuses."""

    state: Array  # (7 + 2 m,)
    servo_states: Array  # (4, 3): gimbal angle rad, rate rad/s, acceleration rad/s^2
    h_body_n_m_s: Array  # (3,), momentum of rotors and gimbal frames
    omega_body_rad_s: Array  # (3,)
    h_start_body_n_m_s: Array
    h_middle_body_n_m_s: Array
    trial_state: Array
    state_slopes: Array  # (4, 7 + 2 m)


@lean
def rotate(q_eci_from_body_xyzw: Array, v_body: Array, v_eci: Array) -> None:
    """v_eci = v_body turned by a unit quaternion, (3,)."""
    q, v = q_eci_from_body_xyzw, v_body
    tx = 2.0 * (q[1] * v[2] - q[2] * v[1])
    ty = 2.0 * (q[2] * v[0] - q[0] * v[2])
    tz = 2.0 * (q[0] * v[1] - q[1] * v[0])
    x, y, z = v[0], v[1], v[2]
    v_eci[0] = x + q[3] * tx + q[1] * tz - q[2] * ty
    v_eci[1] = y + q[3] * ty + q[2] * tx - q[0] * tz
    v_eci[2] = z + q[3] * tz + q[0] * ty - q[1] * tx


@lean
def unrotate(q_eci_from_body_xyzw: Array, v_eci: Array, v_body: Array) -> None:
    """v_body = v_eci turned by the inverse of a unit quaternion, (3,)."""
    q, v = q_eci_from_body_xyzw, v_eci
    tx = 2.0 * (q[2] * v[1] - q[1] * v[2])
    ty = 2.0 * (q[0] * v[2] - q[2] * v[0])
    tz = 2.0 * (q[1] * v[0] - q[0] * v[1])
    x, y, z = v[0], v[1], v[2]
    v_body[0] = x + q[3] * tx - q[1] * tz + q[2] * ty
    v_body[1] = y + q[3] * ty - q[2] * tx + q[0] * tz
    v_body[2] = z + q[3] * tz - q[0] * ty + q[1] * tx


Row = tuple[float, float, float]


@lean
def _matrix(q_eci_from_body_xyzw: Array) -> tuple[Row, Row, Row]:
    """Rows of c_eci_from_body."""
    q = q_eci_from_body_xyzw
    x, y, z, w = q[0], q[1], q[2], q[3]
    return (
        (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)),
        (2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)),
        (2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)),
    )


@lean
def _columns_times(c: tuple[Row, Row, Row], x: float, y: float, z: float) -> Row:
    """The matrix's transpose times a vector."""
    return (
        c[0][0] * x + c[1][0] * y + c[2][0] * z,
        c[0][1] * x + c[1][1] * y + c[2][1] * z,
        c[0][2] * x + c[1][2] * y + c[2][2] * z,
    )


@lean
def _rows_times(matrix: Array, x: float, y: float, z: float) -> Row:
    """A (3, 3) array times a vector."""
    return (
        matrix[0, 0] * x + matrix[0, 1] * y + matrix[0, 2] * z,
        matrix[1, 0] * x + matrix[1, 1] * y + matrix[1, 2] * z,
        matrix[2, 0] * x + matrix[2, 1] * y + matrix[2, 2] * z,
    )


@lean
def _rate(plant: Plant, c: tuple[Row, Row, Row], state: Array, h_body_n_m_s: Array) -> Row:
    x, y, z = _columns_times(c, state[G], state[G + 1], state[G + 2])
    x, y, z = x - h_body_n_m_s[0], y - h_body_n_m_s[1], z - h_body_n_m_s[2]
    m, d = len(plant.stiffness_per_s2), plant.couplings_sqrt_kg_m
    for i in range(m):
        p = state[ETA + m + i]
        x -= d[i, 0] * p
        y -= d[i, 1] * p
        z -= d[i, 2] * p
    return _rows_times(plant.rigid_inverse_per_kg_m2, x, y, z)


@compiled
def body_rate(plant: Plant, state: Array, h_body_n_m_s: Array, omega_body_rad_s: Array) -> None:
    """omega_body_rad_s (3,) from the state and the momentum of the gyros."""
    x, y, z = _rate(plant, _matrix(state), state, h_body_n_m_s)
    omega_body_rad_s[0], omega_body_rad_s[1], omega_body_rad_s[2] = x, y, z


@compiled
def _derivative(
    plant: Plant, state: Array, h_body_n_m_s: Array, nadir_eci: Array, state_slope: Array
) -> None:
    c = _matrix(state)
    x, y, z = _rate(plant, c, state, h_body_n_m_s)
    q0, q1, q2, q3 = state[0], state[1], state[2], state[3]
    state_slope[0] = 0.5 * (q3 * x + q1 * z - q2 * y)
    state_slope[1] = 0.5 * (q3 * y + q2 * x - q0 * z)
    state_slope[2] = 0.5 * (q3 * z + q0 * y - q1 * x)
    state_slope[3] = -0.5 * (q0 * x + q1 * y + q2 * z)
    k = plant.gravity_per_s2
    n0, n1, n2 = _columns_times(c, nadir_eci[0], nadir_eci[1], nadir_eci[2])
    j0, j1, j2 = _rows_times(plant.inertia_kg_m2, n0, n1, n2)
    t0, t1, t2 = k * (n1 * j2 - n2 * j1), k * (n2 * j0 - n0 * j2), k * (n0 * j1 - n1 * j0)
    for i in range(3):
        state_slope[G + i] = c[i][0] * t0 + c[i][1] * t1 + c[i][2] * t2
    m, d = len(plant.stiffness_per_s2), plant.couplings_sqrt_kg_m
    for i in range(m):
        eta, p = state[ETA + i], state[ETA + m + i]
        swing = p - d[i, 0] * x - d[i, 1] * y - d[i, 2] * z
        state_slope[ETA + i] = swing
        state_slope[ETA + m + i] = -plant.stiffness_per_s2[i] * eta - plant.damping_per_s[i] * swing


@compiled
def array_momentum(plant: Plant, servo_states: Array, t_s: float, h_body_n_m_s: Array) -> None:
    """Momentum of rotors and gimbal frames, (3,).

    Each rotor's speed loop ripples: its torque a cos(w t + phase) stores a/w sin in h.
    """
    gyros, ripple = plant.gyros, plant.ripple
    h_body_n_m_s[0] = h_body_n_m_s[1] = h_body_n_m_s[2] = 0.0
    for i in range(4):
        a, w, phase = ripple.torque_n_m[i], ripple.rate_rad_s[i], ripple.phase_rad[i]
        angle, rate = servo_states[i, 0], servo_states[i, 1]
        along_spin = gyros.momentum_n_m_s + a / w * math.sin(w * t_s + phase)
        along_gimbal = plant.gimbal_inertia_kg_m2 * rate
        c, s = along_spin * math.cos(angle), along_spin * math.sin(angle)
        for k in range(3):
            h_body_n_m_s[k] += (
                c * gyros.rotor_axes_body[i, k]
                + s * gyros.torque_axes_body[i, k]
                + along_gimbal * plant.gimbal_axes_body[i, k]
            )


@compiled
def advance_servos(step: ServoStep, command_rad_s: Array, servo_states: Array) -> None:
    """Advance the gimbals under constant commanded rates (4,)."""
    t, b = step.transition_matrix, step.input_gain
    for i in range(4):
        angle, rate, acceleration = servo_states[i, 0], servo_states[i, 1], servo_states[i, 2]
        servo_states[i, 0] = angle + t[0, 1] * rate + t[0, 2] * acceleration
        servo_states[i, 0] += b[0] * command_rad_s[i]
        servo_states[i, 1] = t[1, 1] * rate + t[1, 2] * acceleration + b[1] * command_rad_s[i]
        servo_states[i, 2] = t[2, 1] * rate + t[2, 2] * acceleration + b[2] * command_rad_s[i]


@compiled
def body_at(
    plant: Plant, q_eci_from_body_xyzw: Array, omega_body_rad_s: Array, gimbal_rad: Array
) -> MovingBody:
    """The body at t = 0 with modes and gimbals (4,) at rest."""
    m = len(plant.stiffness_per_s2)
    size = ETA + 2 * m
    body = MovingBody(
        np.zeros(size), np.zeros((4, 3)), np.empty(3), np.empty(3), np.empty(3), np.empty(3),
        np.empty(size), np.empty((4, size)),
    )  # fmt: skip
    body.servo_states[:, 0] = gimbal_rad
    array_momentum(plant, body.servo_states, 0.0, body.h_body_n_m_s)
    total_body_n_m_s = body.h_body_n_m_s.copy()
    for k in range(3):
        for j in range(3):
            total_body_n_m_s[k] += plant.inertia_kg_m2[k, j] * omega_body_rad_s[j]
    for i in range(m):
        for k in range(3):
            p = plant.couplings_sqrt_kg_m[i, k] * omega_body_rad_s[k]
            body.state[ETA + m + i] += p
    body.state[:G] = q_eci_from_body_xyzw
    rotate(q_eci_from_body_xyzw, total_body_n_m_s, body.state[G:ETA])
    body_rate(plant, body.state, body.h_body_n_m_s, body.omega_body_rad_s)
    return body


@compiled
def advance(
    plant: Plant, body: MovingBody, command_rad_s: Array, nadir_eci: Array, t_s: float
) -> None:
    """One RK4 step of body and modes from t_s under constant gimbal rate commands (4,)."""
    h = plant.step_s
    k, state, trial = body.state_slopes, body.state, body.trial_state
    body.h_start_body_n_m_s[:] = body.h_body_n_m_s
    advance_servos(plant.servo_half_step, command_rad_s, body.servo_states)
    array_momentum(plant, body.servo_states, t_s + 0.5 * h, body.h_middle_body_n_m_s)
    advance_servos(plant.servo_half_step, command_rad_s, body.servo_states)
    array_momentum(plant, body.servo_states, t_s + h, body.h_body_n_m_s)
    size = len(state)
    _derivative(plant, state, body.h_start_body_n_m_s, nadir_eci, k[0])
    for j in range(size):
        trial[j] = state[j] + 0.5 * h * k[0, j]
    _derivative(plant, trial, body.h_middle_body_n_m_s, nadir_eci, k[1])
    for j in range(size):
        trial[j] = state[j] + 0.5 * h * k[1, j]
    _derivative(plant, trial, body.h_middle_body_n_m_s, nadir_eci, k[2])
    for j in range(size):
        trial[j] = state[j] + h * k[2, j]
    _derivative(plant, trial, body.h_body_n_m_s, nadir_eci, k[3])
    for j in range(size):
        state[j] += h / 6.0 * (k[0, j] + 2.0 * k[1, j] + 2.0 * k[2, j] + k[3, j])
    norm = math.sqrt(state[0] ** 2 + state[1] ** 2 + state[2] ** 2 + state[3] ** 2)
    for j in range(G):
        state[j] /= norm
    body_rate(plant, state, body.h_body_n_m_s, body.omega_body_rad_s)


def servo_step(bandwidth_rad_s: float, damping: float, span_s: float) -> ServoStep:
    """The step over span_s of W(s) = 1/(T^2 s^2 + 2 xi T s + 1), T = 1/bandwidth.

    W leads from commanded to executed rate.  Source: Platonov, Sumarokov 2019, eq. 2.
    """
    w2 = bandwidth_rad_s**2
    system = np.zeros((4, 4))
    system[0, 1] = system[1, 2] = 1.0
    system[2, 1:] = [-w2, -2.0 * damping * bandwidth_rad_s, w2]
    transition = expm(system * span_s)
    return ServoStep(
        np.ascontiguousarray(transition[:3, :3]), np.ascontiguousarray(transition[:3, 3])
    )
