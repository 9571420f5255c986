"""How does the body move when its gyros turn?  Rigid body, flexible modes, gimbal servos.

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

from planner.arrays import Array
from planner.compiled import compiled


class Plant(NamedTuple):
    """The body as it really is: dispersions applied.  Shapes as in the fields' comments."""

    inertia: Array  # (3, 3), swinging parts included
    rigid_inverse: Array  # (3, 3), (J - sum d d^T)^-1
    couplings: Array  # (m, 3)
    stiffness: Array  # (m,), w^2
    damping: Array  # (m,), 2 zeta w
    rotor: Array  # (4, 3)
    torque: Array  # (4, 3)
    gimbal_axes: Array  # (4, 3)
    momentum_n_m_s: float
    gimbal_inertia_kg_m2: float
    servo_half: Array  # (3, 3), transition of gimbal angle, rate, acceleration over half a step
    servo_input: Array  # (3,)
    step_s: float
    rate_scale: Array  # (4,), executed over commanded gimbal rate
    ripple: Array  # (4, 3): N m, rad/s, phase of each rotor drive's disturbance torque
    gravity_per_s2: float  # 3 mu / r^3, 1/s^2


@compiled
def rotate(q: Array, v: Array, out: Array) -> None:
    """out = v turned by the scalar-last unit quaternion q (3,)."""
    tx = 2.0 * (q[1] * v[2] - q[2] * v[1])
    ty = 2.0 * (q[2] * v[0] - q[0] * v[2])
    tz = 2.0 * (q[0] * v[1] - q[1] * v[0])
    x, y, z = v[0], v[1], v[2]
    out[0] = x + q[3] * tx + q[1] * tz - q[2] * ty
    out[1] = y + q[3] * ty + q[2] * tx - q[0] * tz
    out[2] = z + q[3] * tz + q[0] * ty - q[1] * tx


@compiled
def unrotate(q: Array, v: Array, out: Array) -> None:
    """out = v turned by the inverse of q."""
    tx = 2.0 * (q[2] * v[1] - q[1] * v[2])
    ty = 2.0 * (q[0] * v[2] - q[2] * v[0])
    tz = 2.0 * (q[1] * v[0] - q[0] * v[1])
    x, y, z = v[0], v[1], v[2]
    out[0] = x + q[3] * tx - q[1] * tz + q[2] * ty
    out[1] = y + q[3] * ty - q[2] * tx + q[0] * tz
    out[2] = z + q[3] * tz - q[0] * ty + q[1] * tx


Row = tuple[float, float, float]


@compiled
def _matrix(q: Array) -> tuple[Row, Row, Row]:
    """Rows of the matrix that turns like the scalar-last unit quaternion q (4,)."""
    x, y, z, w = q[0], q[1], q[2], q[3]
    return (
        (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)),
        (2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)),
        (2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)),
    )


@compiled
def _columns_times(c: tuple[Row, Row, Row], x: float, y: float, z: float) -> Row:
    """The matrix's transpose times a vector."""
    return (
        c[0][0] * x + c[1][0] * y + c[2][0] * z,
        c[0][1] * x + c[1][1] * y + c[2][1] * z,
        c[0][2] * x + c[1][2] * y + c[2][2] * z,
    )


@compiled
def _rows_times(matrix: Array, x: float, y: float, z: float) -> Row:
    """A (3, 3) array times a vector."""
    return (
        matrix[0, 0] * x + matrix[0, 1] * y + matrix[0, 2] * z,
        matrix[1, 0] * x + matrix[1, 1] * y + matrix[1, 2] * z,
        matrix[2, 0] * x + matrix[2, 1] * y + matrix[2, 2] * z,
    )


@compiled
def _rate(plant: Plant, c: tuple[Row, Row, Row], state: Array, momentum: Array) -> Row:
    x, y, z = _columns_times(c, state[4], state[5], state[6])
    x, y, z = x - momentum[0], y - momentum[1], z - momentum[2]
    m = len(plant.stiffness)
    for i in range(m):
        p = state[7 + m + i]
        x -= plant.couplings[i, 0] * p
        y -= plant.couplings[i, 1] * p
        z -= plant.couplings[i, 2] * p
    return _rows_times(plant.rigid_inverse, x, y, z)


@compiled
def body_rate(plant: Plant, state: Array, momentum: Array, out: Array) -> None:
    """omega_body (3,) from the state and the gyros' momentum in body axes."""
    out[0], out[1], out[2] = _rate(plant, _matrix(state), state, momentum)


@compiled
def _derivative(plant: Plant, state: Array, momentum: Array, nadir: Array, out: Array) -> None:
    c = _matrix(state)
    x, y, z = _rate(plant, c, state, momentum)
    q0, q1, q2, q3 = state[0], state[1], state[2], state[3]
    out[0] = 0.5 * (q3 * x + q1 * z - q2 * y)
    out[1] = 0.5 * (q3 * y + q2 * x - q0 * z)
    out[2] = 0.5 * (q3 * z + q0 * y - q1 * x)
    out[3] = -0.5 * (q0 * x + q1 * y + q2 * z)
    k = plant.gravity_per_s2
    n0, n1, n2 = _columns_times(c, nadir[0], nadir[1], nadir[2])
    j0, j1, j2 = _rows_times(plant.inertia, n0, n1, n2)
    t0, t1, t2 = k * (n1 * j2 - n2 * j1), k * (n2 * j0 - n0 * j2), k * (n0 * j1 - n1 * j0)
    for i in range(3):
        out[4 + i] = c[i][0] * t0 + c[i][1] * t1 + c[i][2] * t2
    m = len(plant.stiffness)
    for i in range(m):
        d0, d1, d2 = plant.couplings[i, 0], plant.couplings[i, 1], plant.couplings[i, 2]
        swing = state[7 + m + i] - d0 * x - d1 * y - d2 * z
        out[7 + i] = swing
        out[7 + m + i] = -plant.stiffness[i] * state[7 + i] - plant.damping[i] * swing


@compiled
def array_momentum(plant: Plant, servo: Array, t_s: float, out: Array) -> None:
    """Momentum of rotors and gimbal frames in body axes; servo (4, 3): angle, rate, acceleration.

    Each rotor's speed loop ripples: its torque a cos(w t + phase) stores a/w sin in h.
    """
    out[0] = out[1] = out[2] = 0.0
    for i in range(4):
        a, w, phase = plant.ripple[i, 0], plant.ripple[i, 1], plant.ripple[i, 2]
        along_spin = plant.momentum_n_m_s + a / w * math.sin(w * t_s + phase)
        along_gimbal = plant.gimbal_inertia_kg_m2 * servo[i, 1]
        c, s = along_spin * math.cos(servo[i, 0]), along_spin * math.sin(servo[i, 0])
        for k in range(3):
            out[k] += (
                c * plant.rotor[i, k]
                + s * plant.torque[i, k]
                + along_gimbal * plant.gimbal_axes[i, k]
            )


@compiled
def servo_half_step(plant: Plant, command: Array, servo: Array) -> None:
    """Advance the gimbals by half a step under constant commanded rates (4,), exactly."""
    t = plant.servo_half
    for i in range(4):
        angle, rate, acceleration = servo[i, 0], servo[i, 1], servo[i, 2]
        servo[i, 0] = angle + t[0, 1] * rate + t[0, 2] * acceleration
        servo[i, 0] += plant.servo_input[0] * command[i]
        servo[i, 1] = t[1, 1] * rate + t[1, 2] * acceleration + plant.servo_input[1] * command[i]
        servo[i, 2] = t[2, 1] * rate + t[2, 2] * acceleration + plant.servo_input[2] * command[i]


class Scratch(NamedTuple):
    """Arrays a step reuses; `scratch` makes them."""

    slopes: Array  # (4, s)
    trial: Array  # (s,)
    momenta: Array  # (3, 3): at the start, middle and end of the step


@compiled
def scratch(size: int) -> Scratch:
    """Scratch for states of this size."""
    return Scratch(np.empty((4, size)), np.empty(size), np.empty((3, 3)))


@compiled
def advance(
    plant: Plant,
    state: Array,
    servo: Array,
    command: Array,
    nadir: Array,
    t_s: float,
    memory: Scratch,
) -> None:
    """One RK4 step of body and modes under constant gimbal rate commands, in place.

    memory.momenta[2] must hold H at the start; it holds H at the end afterwards.
    """
    h = plant.step_s
    k, trial = memory.slopes, memory.trial
    memory.momenta[0, :] = memory.momenta[2]
    servo_half_step(plant, command, servo)
    array_momentum(plant, servo, t_s + 0.5 * h, memory.momenta[1])
    servo_half_step(plant, command, servo)
    array_momentum(plant, servo, t_s + h, memory.momenta[2])
    size = len(state)
    _derivative(plant, state, memory.momenta[0], nadir, k[0])
    for j in range(size):
        trial[j] = state[j] + 0.5 * h * k[0, j]
    _derivative(plant, trial, memory.momenta[1], nadir, k[1])
    for j in range(size):
        trial[j] = state[j] + 0.5 * h * k[1, j]
    _derivative(plant, trial, memory.momenta[1], nadir, k[2])
    for j in range(size):
        trial[j] = state[j] + h * k[2, j]
    _derivative(plant, trial, memory.momenta[2], nadir, k[3])
    for j in range(size):
        state[j] += h / 6.0 * (k[0, j] + 2.0 * k[1, j] + 2.0 * k[2, j] + k[3, j])
    norm = math.sqrt(state[0] ** 2 + state[1] ** 2 + state[2] ** 2 + state[3] ** 2)
    for j in range(4):
        state[j] /= norm


def servo_transition(bandwidth_rad_s: float, damping: float, span_s: float) -> tuple[Array, Array]:
    """Exact transition (3, 3) and input vector (3,) of angle, rate, acceleration over span_s.

    W(s) = 1/(T^2 s^2 + 2 xi T s + 1) from commanded to executed rate, T = 1/bandwidth.
    Source: Platonov, Sumarokov 2019, eq. 2.
    """
    w2 = bandwidth_rad_s**2
    system = np.zeros((4, 4))
    system[0, 1] = system[1, 2] = 1.0
    system[2, 1:] = [-w2, -2.0 * damping * bandwidth_rad_s, w2]
    transition = expm(system * span_s)
    return np.ascontiguousarray(transition[:3, :3]), np.ascontiguousarray(transition[:3, 3])
