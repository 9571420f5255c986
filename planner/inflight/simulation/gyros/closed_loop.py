"""One closed-loop run of a command table, compiled.

Sees the table and the spacecraft only, never how the table was planned.
"""

import math
from typing import NamedTuple

import numpy as np

from planner.base.arrays import Array
from planner.base.commands import COMMAND_STEP_S
from planner.base.compiled import compiled, lean
from planner.inflight.simulation.gyros.dynamics import ETA, G, MovingBody, Plant, advance, body_at
from planner.inflight.simulation.gyros.onboard import (
    Computer,
    OnboardEstimate,
    Reference,
    decide,
    estimate_rate,
    learn,
    memory_at,
    rotation_between,
    send,
)

TRACKER_GAIN = 0.1  # per fix


class Noise(NamedTuple):
    """What is random within a run of n ticks, drawn beforehand, and what is constantly wrong."""

    gyro_rad_s: Array  # (n, 3)
    resolver_rad: Array  # (n, 4)
    gimbal_rate_rad_s: Array  # (n, 4), execution error of every tick
    tracker_rad: Array  # (n, 3)
    tracker_ticks: int
    gyro_bias_rad_s: Array  # (3,)
    gyro_scale: Array  # (3,)


class Log(NamedTuple):
    """What happened in n ticks of s steps; all but the first at the beginning of each tick."""

    rate_error_rad_s: Array  # (n, s, 3), omega minus the table's after every step, body axes
    attitude_error_rad: Array  # (n, 3), small rotation table -> body
    gimbal_rad: Array  # (n, 4)
    gimbal_rate_rad_s: Array  # (n, 4), executed
    h_body_n_m_s: Array  # (n, 3), momentum of the gyros


@compiled
def _read_gyro(omega_body_rad_s: Array, noise: Noise, tick: int, gyro_rad_s: Array) -> None:
    scaled_rad_s = omega_body_rad_s * (1.0 + noise.gyro_scale)
    gyro_rad_s[:3] = scaled_rad_s + noise.gyro_bias_rad_s + noise.gyro_rad_s[tick]
    gyro_rad_s[3] = (gyro_rad_s[0] + gyro_rad_s[1] + gyro_rad_s[2]) / math.sqrt(3.0)


@compiled
def _misjudge(
    q_eci_from_body_xyzw: Array, knowledge_error_rad: Array, q_eci_from_believed_xyzw: Array
) -> None:
    """Turn the true attitude by the (small) knowledge error, body axes."""
    q, out = q_eci_from_body_xyzw, q_eci_from_believed_xyzw
    x, y, z = 0.5 * knowledge_error_rad
    out[0] = q[0] + q[3] * x + q[1] * z - q[2] * y
    out[1] = q[1] + q[3] * y + q[2] * x - q[0] * z
    out[2] = q[2] + q[3] * z + q[0] * y - q[1] * x
    out[3] = q[3] - q[0] * x - q[1] * y - q[2] * z
    out /= math.sqrt(out[0] ** 2 + out[1] ** 2 + out[2] ** 2 + out[3] ** 2)


@lean
def _interpolate_rate(
    reference: Reference, tick: int, share: float, omega_body_rad_s: Array
) -> None:
    """Table's rate at a share of a tick: cubic Hermite of rates and accelerations."""
    omega, alpha = reference.omega_body_rad_s, reference.alpha_body_rad_s2
    for i in range(3):
        a, b = omega[tick, i], omega[tick + 1, i]
        da, db = COMMAND_STEP_S * alpha[tick, i], COMMAND_STEP_S * alpha[tick + 1, i]
        c2, c3 = 3.0 * (b - a) - 2.0 * da - db, 2.0 * (a - b) + da + db
        omega_body_rad_s[i] = a + share * (da + share * (c2 + share * c3))


@compiled
def _fly_tick(
    plant: Plant,
    body: MovingBody,
    reference: Reference,
    tick: int,
    command_rad_s: Array,
    nadir_eci: Array,
    rate_error_rad_s: Array,
    turned_rad: Array,
) -> None:
    """Integrate one control cycle of s steps.

    rate_error_rad_s: (s, 3), rate minus the table's after each step.  turned_rad: (3,), the
    integral of the rate.
    """
    table_rad_s = np.empty(3)
    steps = len(rate_error_rad_s)
    turned_rad[:] = 0.0
    for j in range(steps):
        advance(plant, body, command_rad_s, nadir_eci, (tick * steps + j) * plant.step_s)
        _interpolate_rate(reference, tick, (j + 1) / steps, table_rad_s)
        for k in range(3):
            rate_error_rad_s[j, k] = body.omega_body_rad_s[k] - table_rad_s[k]
            turned_rad[k] += body.omega_body_rad_s[k] * plant.step_s


@compiled
def fly(
    plant: Plant,
    computer: Computer,
    reference: Reference,
    noise: Noise,
    gimbal_rad: Array,
    nadir_eci: Array,
) -> Log:
    """Fly the table from its first row, at rest on the profile.

    gimbal_rad: (4,), start angles.  nadir_eci: (n + 1, 3).  The attitude knowledge error obeys
    e' = (rate believed - rate true), corrected by star trackers between imaging intervals.
    """
    n, steps = len(reference.imaging), round(COMMAND_STEP_S / plant.step_s)
    body = body_at(
        plant, reference.q_eci_from_body_xyzw[0], reference.omega_body_rad_s[0], gimbal_rad
    )
    q_eci_from_body_xyzw = body.state[:G]
    memory = memory_at(computer, body.state[G:ETA], body.servo_states)
    estimate = OnboardEstimate(np.empty(4), np.empty(3), np.empty(4))
    log = Log(
        np.empty((n, steps, 3)), np.empty((n, 3)), np.empty((n, 4)), np.empty((n, 4)),
        np.empty((n, 3)),
    )  # fmt: skip
    knowledge_error_rad, turned_rad = np.zeros(3), np.empty(3)
    gyro_rad_s, q_table_from_body_xyzw = np.empty(4), np.empty(4)
    for tick in range(n):
        if reference.commanded[tick]:
            memory.turn_s[0] = 0.0
        _misjudge(q_eci_from_body_xyzw, knowledge_error_rad, estimate.q_eci_from_body_xyzw)
        estimate.gimbal_rad[:] = body.servo_states[:, 0] + noise.resolver_rad[tick]
        _read_gyro(body.omega_body_rad_s, noise, tick, gyro_rad_s)
        gyro_read = estimate_rate(computer, memory, estimate, gyro_rad_s)
        if gyro_read:
            learn(computer, memory, estimate)
        memory.wanted_rad_s[1] = memory.wanted_rad_s[0]
        memory.command_rad_s[1] = memory.command_rad_s[0]
        decide(computer, memory, estimate, reference, tick)
        memory.turn_s[0] += COMMAND_STEP_S
        send(computer, memory, estimate.gimbal_rad)
        command_rad_s = memory.command_rad_s[computer.delay_ticks]
        executed_rad_s = command_rad_s * plant.rate_scale + noise.gimbal_rate_rad_s[tick]
        log.gimbal_rad[tick] = body.servo_states[:, 0]
        log.gimbal_rate_rad_s[tick] = body.servo_states[:, 1]
        log.h_body_n_m_s[tick] = body.h_body_n_m_s
        rotation_between(
            reference.q_eci_from_body_xyzw[tick], q_eci_from_body_xyzw, q_table_from_body_xyzw
        )
        log.attitude_error_rad[tick] = 2.0 * q_table_from_body_xyzw[:3]
        _fly_tick(
            plant, body, reference, tick, executed_rad_s, nadir_eci[tick],
            log.rate_error_rad_s[tick], turned_rad,
        )  # fmt: skip
        if gyro_read:
            drift_rad = noise.gyro_bias_rad_s * COMMAND_STEP_S + noise.gyro_scale * turned_rad
        else:
            drift_rad = estimate.omega_body_rad_s * COMMAND_STEP_S - turned_rad
        knowledge_error_rad += drift_rad
        if tick % noise.tracker_ticks == 0 and not reference.imaging[tick]:
            fixed_rad = knowledge_error_rad + noise.tracker_rad[tick]
            knowledge_error_rad -= TRACKER_GAIN * fixed_rad
    return log
