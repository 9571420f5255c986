"""What does the on-board computer do every 0.2 s?  Estimate, filter, steer.

Two ways to fly: `TABLE` follows the command table with feed-forward; `PAPER` runs the
published pair of laws (turn about the Euler axis, then hold) on the goal attitude alone.
Source: Platonov, Sumarokov 2019, "Control law of the gyro system"; the feed-forward is ours.
"""

import math
from typing import NamedTuple

import numpy as np

from planner.arrays import Array
from planner.compiled import compiled
from planner.spacecraft.vehicle.cmg_array import rotor_momentum, steer
from planner.spacecraft.vehicle.dynamics import rotate, unrotate

TABLE = 0
PAPER = 1
LEARNING_RATE_RAD_S = math.radians(0.5)
PRIOR = 1e-3  # rad^2/s^2: three cycles at 1 deg/s weigh as much as the design's inertia


class Computer(NamedTuple):
    """What the on-board computer believes and how it is tuned."""

    inertia: Array  # (3,)
    rotor: Array  # (4, 3)
    torque: Array  # (4, 3)
    momentum_n_m_s: float
    rate_max_rad_s: float  # gimbal
    rate_step: float
    k1_per_s: float
    k2_per_s2: float
    butterworth: Array  # (5,): b0 b1 b2 a1 a2
    null_gain: float
    gyro_range_rad_s: float
    law: int
    turn_acceleration_rad_s2: float  # a1 of the paper's laws
    turn_rate_rad_s: float
    tick_s: float
    servo_tick: Array  # (3, 3), transition of gimbal angle, rate, acceleration over a tick
    servo_input: Array  # (3,)
    gimbal_gain: float


class Memory(NamedTuple):
    """What it remembers from tick to tick."""

    filter: Array  # (2, 3)
    total_momentum: Array  # (3,), inertial
    wanted: Array  # (2, 4), gimbal rates the steering law wants: now, a tick ago
    command: Array  # (2, 4), the same with gimbal feedback, as sent
    servo: Array  # (4, 3), where the gimbals would be had they executed what was wanted
    turn: Array  # (1,): time since the turn was commanded
    inertia: Array  # (3, 3): believed inertia; sums of rate x momentum and of rate^2 behind it


@compiled
def multiply_inverse(a: Array, b: Array, out: Array) -> None:
    """out = a^-1 o b, scalar-last, with the shorter sense (w >= 0)."""
    out[3] = a[3] * b[3] + a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    out[0] = a[3] * b[0] - a[0] * b[3] - a[1] * b[2] + a[2] * b[1]
    out[1] = a[3] * b[1] - a[1] * b[3] - a[2] * b[0] + a[0] * b[2]
    out[2] = a[3] * b[2] - a[2] * b[3] - a[0] * b[1] + a[1] * b[0]
    if out[3] < 0.0:
        for k in range(4):
            out[k] = -out[k]


@compiled
def sensed_rate(
    computer: Computer, memory: Memory, attitude: Array, gimbal: Array, gyro: Array, out: Array
) -> bool:
    """Rate from the gyro's channels, or from the momentum model when two saturate.

    gyro: (4,), X, Y, Z and the diagonal.  Returns whether the gyro gave it.
    """
    bad, which = 0, 0
    for k in range(3):
        out[k] = gyro[k]
        if abs(gyro[k]) >= computer.gyro_range_rad_s:
            bad += 1
            which = k
    if bad == 0:
        return True
    if bad == 1 and abs(gyro[3]) < computer.gyro_range_rad_s:
        out[which] = math.sqrt(3.0) * gyro[3] - gyro[0] - gyro[1] - gyro[2] + gyro[which]
        return True
    total, rotors = np.empty(3), np.empty(3)
    unrotate(attitude, memory.total_momentum, total)
    rotor_momentum(gimbal, computer.momentum_n_m_s, computer.rotor, computer.torque, rotors)
    for k in range(3):
        out[k] = (total[k] - rotors[k]) / memory.inertia[0, k]
    return False


@compiled
def update_total_momentum(
    computer: Computer, memory: Memory, attitude: Array, gimbal: Array, rate: Array, gain: float
) -> None:
    """Low-pass the total momentum seen through gyro and gimbal angles."""
    rotors, seen = np.empty(3), np.empty(3)
    rotor_momentum(gimbal, computer.momentum_n_m_s, computer.rotor, computer.torque, rotors)
    for k in range(3):
        rotors[k] += memory.inertia[0, k] * rate[k]
    rotate(attitude, rotors, seen)
    for k in range(3):
        memory.total_momentum[k] += gain * (seen[k] - memory.total_momentum[k])


@compiled
def learn_inertia(
    computer: Computer, memory: Memory, attitude: Array, gimbal: Array, rate: Array
) -> None:
    """Least squares of the moments of inertia: in a turn, momentum the gyros gave over rate."""
    rotors, total = np.empty(3), np.empty(3)
    rotor_momentum(gimbal, computer.momentum_n_m_s, computer.rotor, computer.torque, rotors)
    unrotate(attitude, memory.total_momentum, total)
    for k in range(3):
        if abs(rate[k]) > LEARNING_RATE_RAD_S:
            memory.inertia[1, k] += rate[k] * (total[k] - rotors[k])
            memory.inertia[2, k] += rate[k] * rate[k]
        memory.inertia[0, k] = memory.inertia[1, k] / memory.inertia[2, k]


@compiled
def _filtered(computer: Computer, memory: Memory, value: Array, out: Array) -> None:
    b, state = computer.butterworth, memory.filter
    for k in range(3):
        y = b[0] * value[k] + state[0, k]
        state[0, k] = b[1] * value[k] - b[3] * y + state[1, k]
        state[1, k] = b[2] * value[k] - b[4] * y
        out[k] = y


@compiled
def _paper_acceleration(
    computer: Computer, memory: Memory, error: Array, rate_error: Array, out: Array
) -> None:
    """Body acceleration by the two published laws; error: (4,), ref^-1 o attitude."""
    size = math.sqrt(error[0] ** 2 + error[1] ** 2 + error[2] ** 2)
    angle = 2.0 * math.atan2(size, error[3])
    brake = math.sqrt(2.0 * computer.turn_acceleration_rad_s2 * angle)
    near = angle * computer.k2_per_s2 / computer.k1_per_s <= min(brake, computer.turn_rate_rad_s)
    speed = min(brake, computer.turn_rate_rad_s, computer.turn_acceleration_rad_s2 * memory.turn[0])
    for k in range(3):
        if near:
            out[k] = -computer.k2_per_s2 * 2.0 * error[k] - computer.k1_per_s * rate_error[k]
        else:
            out[k] = -computer.k1_per_s * (rate_error[k] + speed * error[k] / size)


@compiled
def decide(
    computer: Computer,
    memory: Memory,
    attitude: Array,
    rate: Array,
    gimbal: Array,
    q_ref: Array,
    w_ref: Array,
    ahead: Array,
    imaging: bool,
) -> float:
    """Gimbal rates for the next tick, into memory.wanted[0]; returns det(D D^T).

    q_ref (4,), w_ref (3,): the table's row.  ahead: (2, 7), attitude and rate of the table one
    servo lag later, now and a tick on: their reference momenta's difference is fed forward.
    """
    error, turned, difference = np.empty(4), np.empty(3), np.empty(3)
    smooth, acceleration = np.empty(3), np.empty(3)
    multiply_inverse(q_ref, attitude, error)
    unrotate(error, w_ref, turned)
    for k in range(3):
        difference[k] = rate[k] - turned[k]
    _filtered(computer, memory, difference, smooth)
    if computer.law == PAPER:
        _paper_acceleration(computer, memory, error, smooth, acceleration)
    else:
        for k in range(3):
            acceleration[k] = -computer.k2_per_s2 * 2.0 * error[k] - computer.k1_per_s * smooth[k]
    total, now, later = np.empty(3), np.empty(3), np.empty(3)
    unrotate(attitude, memory.total_momentum, total)
    wanted = np.empty(3)
    if computer.law == PAPER:
        wanted[0] = -(rate[1] * total[2] - rate[2] * total[1])
        wanted[1] = -(rate[2] * total[0] - rate[0] * total[2])
        wanted[2] = -(rate[0] * total[1] - rate[1] * total[0])
    else:
        unrotate(ahead[0, :4], memory.total_momentum, now)
        unrotate(ahead[1, :4], memory.total_momentum, later)
        for k in range(3):
            step = later[k] - now[k] - memory.inertia[0, k] * (ahead[1, 4 + k] - ahead[0, 4 + k])
            wanted[k] = step / computer.tick_s
        wanted[0] -= smooth[1] * total[2] - smooth[2] * total[1]
        wanted[1] -= smooth[2] * total[0] - smooth[0] * total[2]
        wanted[2] -= smooth[0] * total[1] - smooth[1] * total[0]
    for k in range(3):
        wanted[k] -= memory.inertia[0, k] * acceleration[k]
    null_gain = 0.0 if imaging else computer.null_gain
    middle, command = gimbal.copy(), memory.wanted[0]
    det = 0.0
    for _ in range(2):
        det = steer(
            middle,
            wanted,
            computer.momentum_n_m_s,
            computer.rotor,
            computer.torque,
            computer.rate_max_rad_s,
            null_gain,
            command,
        )
        for i in range(4):
            middle[i] = gimbal[i] + 0.5 * computer.tick_s * command[i]
    return det


@compiled
def send(computer: Computer, memory: Memory, gimbal: Array, delay: int) -> None:
    """Turn wanted into sent gimbal rates, memory.command[0]: feedback on the gimbal angles.

    The angles are compared with where the wanted rates would have brought them, and the
    difference is made good: execution errors and the rate step then leave a bounded error of
    momentum instead of a growing one.  Call once a tick, after `decide`.
    """
    t = computer.servo_tick
    for i in range(4):
        lag = memory.servo[i, 0] - gimbal[i]
        if delay == 1:
            lag -= (memory.command[1, i] - memory.wanted[1, i]) * computer.tick_s
        rate = memory.wanted[0, i] + computer.gimbal_gain * lag / computer.tick_s
        rate = min(max(rate, -computer.rate_max_rad_s), computer.rate_max_rad_s)
        if computer.rate_step > 0.0:
            rate = computer.rate_step * round(rate / computer.rate_step)
        memory.command[0, i] = rate
        given = memory.wanted[delay, i]
        angle, speed, acceleration = memory.servo[i]
        for k in range(3):
            memory.servo[i, k] = (
                t[k, 1] * speed + t[k, 2] * acceleration + computer.servo_input[k] * given
            )
        memory.servo[i, 0] += angle
