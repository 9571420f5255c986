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
from numpy.typing import NDArray
from scipy.linalg import expm

from planner.spacecraft.cmg_array import rotor_momentum
from planner.spacecraft.compiled import compiled

Array = NDArray[np.float64]


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


@compiled
def body_rate(plant: Plant, state: Array, momentum: Array, work: Array, out: Array) -> None:
    """omega_body (3,) from the state and the gyros' momentum in body axes."""
    unrotate(state[:4], state[4:7], work)
    m = len(plant.stiffness)
    for k in range(3):
        work[k] -= momentum[k]
    for i in range(m):
        p = state[7 + m + i]
        for k in range(3):
            work[k] -= plant.couplings[i, k] * p
    for k in range(3):
        out[k] = (
            plant.rigid_inverse[k, 0] * work[0]
            + plant.rigid_inverse[k, 1] * work[1]
            + plant.rigid_inverse[k, 2] * work[2]
        )


@compiled
def _derivative(
    plant: Plant, state: Array, momentum: Array, nadir: Array, work: Array, rate: Array, out: Array
) -> None:
    body_rate(plant, state, momentum, work, rate)
    q0, q1, q2, q3 = state[0], state[1], state[2], state[3]
    out[0] = 0.5 * (q3 * rate[0] + q1 * rate[2] - q2 * rate[1])
    out[1] = 0.5 * (q3 * rate[1] + q2 * rate[0] - q0 * rate[2])
    out[2] = 0.5 * (q3 * rate[2] + q0 * rate[1] - q1 * rate[0])
    out[3] = -0.5 * (q0 * rate[0] + q1 * rate[1] + q2 * rate[2])
    if plant.gravity_per_s2 > 0.0:
        unrotate(state[:4], nadir, work)
        n0, n1, n2 = work[0], work[1], work[2]
        j0 = plant.inertia[0, 0] * n0 + plant.inertia[0, 1] * n1 + plant.inertia[0, 2] * n2
        j1 = plant.inertia[1, 0] * n0 + plant.inertia[1, 1] * n1 + plant.inertia[1, 2] * n2
        j2 = plant.inertia[2, 0] * n0 + plant.inertia[2, 1] * n1 + plant.inertia[2, 2] * n2
        work[0] = plant.gravity_per_s2 * (n1 * j2 - n2 * j1)
        work[1] = plant.gravity_per_s2 * (n2 * j0 - n0 * j2)
        work[2] = plant.gravity_per_s2 * (n0 * j1 - n1 * j0)
        rotate(state[:4], work, out[4:7])
    else:
        out[4] = out[5] = out[6] = 0.0
    m = len(plant.stiffness)
    for i in range(m):
        swing = (
            state[7 + m + i]
            - plant.couplings[i, 0] * rate[0]
            - plant.couplings[i, 1] * rate[1]
            - plant.couplings[i, 2] * rate[2]
        )
        out[7 + i] = swing
        out[7 + m + i] = -plant.stiffness[i] * state[7 + i] - plant.damping[i] * swing


@compiled
def array_momentum(plant: Plant, servo: Array, t_s: float, out: Array) -> None:
    """Momentum of rotors and gimbal frames in body axes; servo (4, 3): angle, rate, acceleration.

    Each rotor's speed loop ripples: its torque a cos(w t + phase) stores a/w sin in h.
    """
    rotor_momentum(servo[:, 0], plant.momentum_n_m_s, plant.rotor, plant.torque, out)
    for i in range(4):
        along_gimbal = plant.gimbal_inertia_kg_m2 * servo[i, 1]
        a, w, phase = plant.ripple[i, 0], plant.ripple[i, 1], plant.ripple[i, 2]
        along_spin = a / w * math.sin(w * t_s + phase) if a > 0.0 else 0.0
        c, s = math.cos(servo[i, 0]), math.sin(servo[i, 0])
        for k in range(3):
            out[k] += along_gimbal * plant.gimbal_axes[i, k] + along_spin * (
                c * plant.rotor[i, k] + s * plant.torque[i, k]
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
    work: Array  # (3,)
    rate: Array  # (3,)
    momenta: Array  # (3, 3): at the start, middle and end of the step


@compiled
def scratch(size: int) -> Scratch:
    """Scratch for states of this size."""
    return Scratch(np.empty((4, size)), np.empty(size), np.empty(3), np.empty(3), np.empty((3, 3)))


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
    _derivative(plant, state, memory.momenta[0], nadir, memory.work, memory.rate, k[0])
    for j in range(size):
        trial[j] = state[j] + 0.5 * h * k[0, j]
    _derivative(plant, trial, memory.momenta[1], nadir, memory.work, memory.rate, k[1])
    for j in range(size):
        trial[j] = state[j] + 0.5 * h * k[1, j]
    _derivative(plant, trial, memory.momenta[1], nadir, memory.work, memory.rate, k[2])
    for j in range(size):
        trial[j] = state[j] + h * k[2, j]
    _derivative(plant, trial, memory.momenta[2], nadir, memory.work, memory.rate, k[3])
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
