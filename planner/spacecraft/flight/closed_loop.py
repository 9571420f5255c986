"""What happens when a command table is flown closed loop?  One run, compiled.

Sees the table and the spacecraft only, never how the table was planned.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from planner.arrays import Array
from planner.compiled import compiled
from planner.spacecraft.vehicle.dynamics import (
    Plant,
    Scratch,
    advance,
    array_momentum,
    body_rate,
    rotate,
    scratch,
)
from planner.spacecraft.vehicle.onboard import (
    PRIOR,
    Computer,
    Memory,
    decide,
    learn_inertia,
    multiply_inverse,
    send,
    sensed_rate,
    update_total_momentum,
)

MOMENTUM_GAIN = 0.02  # per tick; 10 s, long against the modes, short against an orbit
TRACKER_GAIN = 0.1  # per fix


class Reference(NamedTuple):
    """The table made ready for the loop; quaternions are eci_from_body, scalar last."""

    q: Array  # (n + 1, 4)
    rate: Array  # (n + 1, 3)
    acceleration: Array  # (n + 1, 3)
    ahead: Array  # (n + 1, 7): attitude and rate one servo lag later
    imaging: NDArray[np.bool_]  # (n,)
    commanded: NDArray[np.bool_]  # (n,): a new goal is given at this tick (the paper's laws)
    nadir: Array  # (n + 1, 3), inertial unit vectors


class Noise(NamedTuple):
    """What is random within a run, drawn beforehand, and what is constantly wrong in it."""

    gyro: Array  # (n, 3), rad/s
    resolver: Array  # (n, 4), rad
    gimbal_rate: Array  # (n, 4), rad/s, execution error of every tick
    tracker: Array  # (n, 3), rad
    tracker_ticks: int
    gyro_bias: Array  # (3,)
    gyro_scale: Array  # (3,)


class Log(NamedTuple):
    """rate_error: (n s, 3) at every step; the rest per tick."""

    rate_error: Array  # omega minus the table's, body axes
    attitude_error: Array  # (n, 3), rad, small rotation table -> body
    knowledge_error: Array  # (n, 3), rad
    rate: Array  # (n, 3)
    gimbal: Array  # (n, 4)
    gimbal_rate: Array  # (n, 4), executed
    command: Array  # (n, 4), as sent
    margin: Array  # (n,), det(D D^T)
    momentum: Array  # (n, 3), of the array, body axes
    state: Array  # (n, s): attitude, total momentum, modal coordinates and momenta


@compiled
def _gyro(rate: Array, noise: Noise, tick: int, out: Array) -> None:
    for k in range(3):
        out[k] = rate[k] * (1.0 + noise.gyro_scale[k]) + noise.gyro_bias[k] + noise.gyro[tick, k]
    out[3] = (out[0] + out[1] + out[2]) / math.sqrt(3.0)


@compiled
def _believed(true: Array, knowledge: Array, out: Array) -> None:
    """out = true attitude turned by the (small) knowledge error, body axes."""
    x, y, z = 0.5 * knowledge[0], 0.5 * knowledge[1], 0.5 * knowledge[2]
    out[0] = true[0] + true[3] * x + true[1] * z - true[2] * y
    out[1] = true[1] + true[3] * y + true[2] * x - true[0] * z
    out[2] = true[2] + true[3] * z + true[0] * y - true[1] * x
    out[3] = true[3] - true[0] * x - true[1] * y - true[2] * z
    norm = math.sqrt(out[0] ** 2 + out[1] ** 2 + out[2] ** 2 + out[3] ** 2)
    for k in range(4):
        out[k] /= norm


@compiled
def _reference_rate(reference: Reference, k: int, u: float, tick: float, out: Array) -> None:
    """Table's rate at share u of tick k: cubic Hermite of rates and accelerations."""
    for i in range(3):
        a, b = reference.rate[k, i], reference.rate[k + 1, i]
        da, db = tick * reference.acceleration[k, i], tick * reference.acceleration[k + 1, i]
        c2, c3 = 3.0 * (b - a) - 2.0 * da - db, 2.0 * (a - b) + da + db
        out[i] = a + u * (da + u * (c2 + u * c3))


@compiled
def _at_start(plant: Plant, reference: Reference, modes: Array, gyros: Array, state: Array) -> None:
    """Fill the state: on the profile, modes as given, total momentum to match."""
    m, work = len(plant.stiffness), gyros.copy()
    state[:4] = reference.q[0]
    for k in range(3):
        for j in range(3):
            work[k] += plant.inertia[k, j] * reference.rate[0, j]
    for i in range(m):
        state[7 + i] = modes[i]
        state[7 + m + i] = modes[m + i]
        for k in range(3):
            state[7 + m + i] += plant.couplings[i, k] * reference.rate[0, k]
            work[k] += plant.couplings[i, k] * modes[m + i]
    rotate(state[:4], work, state[4:7])


@compiled
def _drift(
    noise: Noise, tick: int, tick_s: float, turned: Array, assumed: Array, gyro_read: bool,
    fix: bool, knowledge: Array,
) -> None:  # fmt: skip
    """Advance the attitude knowledge error by a tick; a star-tracker fix mends a tenth of it."""
    for k in range(3):
        if gyro_read:
            knowledge[k] += noise.gyro_bias[k] * tick_s + noise.gyro_scale[k] * turned[k]
        else:
            knowledge[k] += assumed[k] * tick_s - turned[k]
        if fix:
            knowledge[k] -= TRACKER_GAIN * (knowledge[k] + noise.tracker[tick, k])


@compiled
def _fly_tick(
    plant: Plant,
    reference: Reference,
    tick: int,
    tick_s: float,
    state: Array,
    servo: Array,
    command: Array,
    tools: Scratch,
    errors: Array,
    rate: Array,
    turned: Array,
) -> None:
    """Integrate one control cycle; errors: (s, 3), rate minus the table's after each step."""
    wanted = np.empty(3)
    steps = len(errors)
    turned[:] = 0.0
    for j in range(steps):
        t_s = (tick * steps + j) * plant.step_s
        advance(plant, state, servo, command, reference.nadir[tick], t_s, tools)
        body_rate(plant, state, tools.momenta[2], rate)
        _reference_rate(reference, tick, (j + 1) / steps, tick_s, wanted)
        for k in range(3):
            errors[j, k] = rate[k] - wanted[k]
            turned[k] += rate[k] * plant.step_s


@compiled
def _empty_log(n: int, steps: int, size: int) -> Log:
    return Log(
        np.empty((n * steps, 3)),
        np.empty((n, 3)),
        np.empty((n, 3)),
        np.empty((n, 3)),
        np.empty((n, 4)),
        np.empty((n, 4)),
        np.empty((n, 4)),
        np.empty(n),
        np.empty((n, 3)),
        np.empty((n, size)),
    )


@compiled
def fly(
    plant: Plant,
    computer: Computer,
    reference: Reference,
    noise: Noise,
    gimbal: Array,
    modes_start: Array,
    delay_ticks: int,
) -> Log:
    """Fly the table from its first row, at rest on the profile.  gimbal: (4,), start angles.

    modes_start: (2 m,), modal coordinates and velocities.  The knowledge error obeys
    e' = (rate believed - rate true), corrected by star trackers between imaging intervals.
    """
    n, steps = len(reference.imaging), round(computer.tick_s / plant.step_s)
    state, servo = np.zeros(7 + 2 * len(plant.stiffness)), np.zeros((4, 3))
    servo[:, 0] = gimbal
    tools = scratch(len(state))
    array_momentum(plant, servo, 0.0, tools.momenta[2])
    _at_start(plant, reference, modes_start, tools.momenta[2], state)
    memory = Memory(
        np.zeros((2, 3)),
        state[4:7].copy(),
        np.zeros((2, 4)),
        np.zeros((2, 4)),
        servo.copy(),
        np.zeros(1),
        np.empty((3, 3)),
    )
    memory.inertia[0] = computer.inertia
    memory.inertia[1] = PRIOR * computer.inertia
    memory.inertia[2] = PRIOR
    log = _empty_log(n, steps, len(state))
    knowledge, turned, rate, believed_rate = np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(3)
    believed, channels, error, seen = np.zeros(4), np.zeros(4), np.zeros(4), np.zeros(4)
    body_rate(plant, state, tools.momenta[2], rate)
    for tick in range(n):
        if reference.commanded[tick]:
            memory.turn[0] = 0.0
        _believed(state[:4], knowledge, believed)
        seen[:] = servo[:, 0] + noise.resolver[tick]
        _gyro(rate, noise, tick, channels)
        gyro_read = sensed_rate(computer, memory, believed, seen, channels, believed_rate)
        if gyro_read:
            learn_inertia(computer, memory, believed, seen, believed_rate)
            update_total_momentum(computer, memory, believed, seen, believed_rate, MOMENTUM_GAIN)
        memory.wanted[1] = memory.wanted[0]
        memory.command[1] = memory.command[0]
        future = min(tick + delay_ticks, n - 1)
        log.margin[tick] = decide(
            computer,
            memory,
            believed,
            believed_rate,
            seen,
            reference.q[tick],
            reference.rate[tick],
            reference.ahead[future : future + 2],
            reference.imaging[tick],
        )
        memory.turn[0] += computer.tick_s
        send(computer, memory, seen, delay_ticks)
        log.command[tick] = memory.command[delay_ticks]
        executed = log.command[tick] * plant.rate_scale + noise.gimbal_rate[tick]
        log.gimbal[tick] = servo[:, 0]
        log.gimbal_rate[tick] = servo[:, 1]
        log.state[tick] = state
        log.rate[tick] = rate
        log.momentum[tick] = tools.momenta[2]
        multiply_inverse(reference.q[tick], state[:4], error)
        log.attitude_error[tick] = 2.0 * error[:3]
        log.knowledge_error[tick] = knowledge
        errors = log.rate_error[tick * steps : (tick + 1) * steps]
        _fly_tick(
            plant, reference, tick, computer.tick_s, state, servo, executed, tools, errors, rate,
            turned,
        )  # fmt: skip
        fix = tick % noise.tracker_ticks == 0 and not reference.imaging[tick]
        _drift(noise, tick, computer.tick_s, turned, believed_rate, gyro_read, fix, knowledge)
    return log
