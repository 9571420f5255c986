"""The on-board computer: every 0.2 s it estimates, filters and steers.

`TABLE` follows the command table with feed-forward; `PAPER` runs the published pair of laws
(turn about the Euler axis, then hold) on the goal attitude alone.
Source: Platonov, Sumarokov 2019, "Control law of the gyro system"; the feed-forward is ours.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from planner.base.arrays import Array
from planner.base.commands import COMMAND_STEP_S
from planner.base.compiled import compiled, lean
from planner.inflight.simulation.gyros.dynamics import ServoStep, rotate, unrotate
from planner.world.platforms.cmg_array import Gyros
from planner.world.platforms.steering import rotor_momentum, steer

TABLE = 0
PAPER = 1
LEARNING_RATE_RAD_S = math.radians(0.5)
PRIOR_PER_S2 = 1e-3  # three cycles at 1 deg/s weigh as much as the design's inertia
MOMENTUM_GAIN = 0.02  # per tick; 10 s, long against the modes, short against an orbit


class Computer(NamedTuple):
    """What the on-board computer believes and how it is tuned."""

    inertia_kg_m2: Array  # (3, 3)
    gyros: Gyros
    rate_step_rad_s: float
    k1_per_s: float
    k2_per_s2: float
    butterworth_coefficients: Array  # (5,): b0 b1 b2 a1 a2
    null_gain_rad_s: float
    gyro_range_rad_s: float
    law: int
    turn_acceleration_rad_s2: float  # a1 of the paper's laws
    turn_rate_rad_s: float
    servo_tick: ServoStep
    gimbal_gain: float
    delay_ticks: int


class Reference(NamedTuple):
    """The table made ready for the loop, n ticks; `ahead`: one servo lag later."""

    q_eci_from_body_xyzw: Array  # (n + 1, 4)
    omega_body_rad_s: Array  # (n + 1, 3)
    alpha_body_rad_s2: Array  # (n + 1, 3)
    ahead_q_eci_from_body_xyzw: Array  # (n + 1, 4)
    ahead_omega_body_rad_s: Array  # (n + 1, 3)
    imaging: NDArray[np.bool_]  # (n,)
    commanded: NDArray[np.bool_]  # (n,): a new goal is given at this tick (the paper's laws)


class OnboardEstimate(NamedTuple):
    """What the sensors make the computer believe at a tick."""

    q_eci_from_body_xyzw: Array  # (4,)
    omega_body_rad_s: Array  # (3,)
    gimbal_rad: Array  # (4,)


class OnboardMemory(NamedTuple):
    """What it remembers from tick to tick."""

    filter_rad_s: Array  # (2, 3), of the Butterworth
    momentum_eci_n_m_s: Array  # (3,), total
    wanted_rad_s: Array  # (2, 4), gimbal rates the steering law wants: now, a tick ago
    command_rad_s: Array  # (2, 4), the same with gimbal feedback, as sent
    servo_states: Array  # (4, 3), where the gimbals would be had they executed what was wanted
    turn_s: Array  # (1,): time since the turn was commanded
    inertia_kg_m2: Array  # (3, 3), its diagonal as learned: the quotient of the two sums
    rate_momentum_sum_n_m: Array  # (3,)
    rate_square_sum_per_s2: Array  # (3,)


@compiled
def memory_at(computer: Computer, momentum_eci_n_m_s: Array, servo_states: Array) -> OnboardMemory:
    """The memory at the start of a run."""
    return OnboardMemory(
        np.zeros((2, 3)),
        momentum_eci_n_m_s.copy(),
        np.zeros((2, 4)),
        np.zeros((2, 4)),
        servo_states.copy(),
        np.zeros(1),
        computer.inertia_kg_m2.copy(),
        PRIOR_PER_S2 * np.diag(computer.inertia_kg_m2),
        np.full(3, PRIOR_PER_S2),
    )


@compiled
def rotation_between(
    q_eci_from_a_xyzw: Array, q_eci_from_b_xyzw: Array, q_a_from_b_xyzw: Array
) -> None:
    """The third from the first two, in the shorter sense (w >= 0)."""
    a, b, out = q_eci_from_a_xyzw, q_eci_from_b_xyzw, q_a_from_b_xyzw
    out[3] = a[3] * b[3] + a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    out[0] = a[3] * b[0] - a[0] * b[3] - a[1] * b[2] + a[2] * b[1]
    out[1] = a[3] * b[1] - a[1] * b[3] - a[2] * b[0] + a[0] * b[2]
    out[2] = a[3] * b[2] - a[2] * b[3] - a[0] * b[1] + a[1] * b[0]
    if out[3] < 0.0:
        out[:] = -out


@compiled
def estimate_rate(
    computer: Computer, memory: OnboardMemory, estimate: OnboardEstimate, gyro_rad_s: Array
) -> bool:
    """Rate from the gyro's channels, or from the momentum model when two saturate.

    gyro_rad_s: (4,), X, Y, Z and the diagonal.  Returns whether the gyro gave it.
    """
    estimate.omega_body_rad_s[:] = gyro_rad_s[:3]
    saturated = np.flatnonzero(np.abs(gyro_rad_s[:3]) >= computer.gyro_range_rad_s)
    if len(saturated) == 0:
        return True
    x, y, z, diagonal = gyro_rad_s
    if len(saturated) == 1 and abs(diagonal) < computer.gyro_range_rad_s:
        which = saturated[0]
        estimate.omega_body_rad_s[which] = math.sqrt(3.0) * diagonal - x - y - z + gyro_rad_s[which]
        return True
    total_n_m_s, rotors_n_m_s = np.empty(3), np.empty(3)
    unrotate(estimate.q_eci_from_body_xyzw, memory.momentum_eci_n_m_s, total_n_m_s)
    rotor_momentum(computer.gyros, estimate.gimbal_rad, rotors_n_m_s)
    estimate.omega_body_rad_s[:] = np.linalg.solve(memory.inertia_kg_m2, total_n_m_s - rotors_n_m_s)
    return False


@compiled
def learn(computer: Computer, memory: OnboardMemory, estimate: OnboardEstimate) -> None:
    """Learn inertia and total momentum from the gyro's rate and the gimbal angles.

    The moments by least squares: in a turn, momentum the gyros gave over rate; the products are
    the design's.  The total momentum by a low-pass.
    """
    seen_body_n_m_s, seen_eci_n_m_s, total_n_m_s = np.empty(3), np.empty(3), np.empty(3)
    rotor_momentum(computer.gyros, estimate.gimbal_rad, seen_body_n_m_s)
    unrotate(estimate.q_eci_from_body_xyzw, memory.momentum_eci_n_m_s, total_n_m_s)
    products, squares = memory.rate_momentum_sum_n_m, memory.rate_square_sum_per_s2
    rate_rad_s = estimate.omega_body_rad_s
    turning = np.abs(rate_rad_s) > LEARNING_RATE_RAD_S
    inertia_kg_m2 = memory.inertia_kg_m2
    own_n_m_s = total_n_m_s - seen_body_n_m_s  # of each axis by its own rate
    for i in range(3):
        for k in range(3):
            if k != i:
                own_n_m_s[i] -= inertia_kg_m2[i, k] * rate_rad_s[k]
    products += np.where(turning, rate_rad_s * own_n_m_s, 0.0)
    squares += np.where(turning, rate_rad_s * rate_rad_s, 0.0)
    for i in range(3):
        inertia_kg_m2[i, i] = products[i] / squares[i]
    seen_body_n_m_s += inertia_kg_m2 @ rate_rad_s
    rotate(estimate.q_eci_from_body_xyzw, seen_body_n_m_s, seen_eci_n_m_s)
    kept_n_m_s = memory.momentum_eci_n_m_s
    kept_n_m_s += MOMENTUM_GAIN * (seen_eci_n_m_s - kept_n_m_s)


@compiled
def _low_pass(computer: Computer, memory: OnboardMemory, rate_error_rad_s: Array) -> None:
    """The Butterworth's output in place of its input (3,)."""
    b0, b1, b2, a1, a2 = computer.butterworth_coefficients
    state = memory.filter_rad_s
    x = rate_error_rad_s.copy()
    y = b0 * x + state[0]
    state[0] = b1 * x - a1 * y + state[1]
    state[1] = b2 * x - a2 * y
    rate_error_rad_s[:] = y


@compiled
def _paper_acceleration(
    computer: Computer,
    memory: OnboardMemory,
    q_table_from_body_xyzw: Array,
    rate_error_rad_s: Array,
) -> Array:
    """Body acceleration, (3,), by the two published laws."""
    k1, k2, e = computer.k1_per_s, computer.k2_per_s2, q_table_from_body_xyzw
    sine = math.sqrt(e[0] ** 2 + e[1] ** 2 + e[2] ** 2)
    angle_rad = 2.0 * math.atan2(sine, e[3])
    brake_rad_s = math.sqrt(2.0 * computer.turn_acceleration_rad_s2 * angle_rad)
    limit_rad_s = min(brake_rad_s, computer.turn_rate_rad_s)
    near = angle_rad * k2 / k1 <= limit_rad_s
    speed_rad_s = min(limit_rad_s, computer.turn_acceleration_rad_s2 * memory.turn_s[0])
    acceleration_rad_s2: Array = -k1 * (rate_error_rad_s + speed_rad_s * e[:3] / sine)
    if near:
        acceleration_rad_s2 = -k2 * 2.0 * e[:3] - k1 * rate_error_rad_s
    return acceleration_rad_s2


@compiled
def decide(
    computer: Computer,
    memory: OnboardMemory,
    estimate: OnboardEstimate,
    reference: Reference,
    tick: int,
) -> None:
    """Gimbal rates for the next tick, into memory.wanted_rad_s[0].

    Fed forward is the difference of the momenta that the attitudes and rates `ahead` need,
    from the tick at which the command acts to the next.
    """
    q_body, omega = estimate.q_eci_from_body_xyzw, estimate.omega_body_rad_s
    q_table_from_body_xyzw, table_rad_s, total_n_m_s = np.empty(4), np.empty(3), np.empty(3)
    rotation_between(reference.q_eci_from_body_xyzw[tick], q_body, q_table_from_body_xyzw)
    unrotate(q_table_from_body_xyzw, reference.omega_body_rad_s[tick], table_rad_s)
    error_rad_s = omega - table_rad_s
    _low_pass(computer, memory, error_rad_s)
    unrotate(q_body, memory.momentum_eci_n_m_s, total_n_m_s)
    if computer.law == PAPER:
        acceleration_rad_s2 = _paper_acceleration(
            computer, memory, q_table_from_body_xyzw, error_rad_s
        )
        torque_n_m = -np.cross(omega, total_n_m_s)
    else:
        now = min(tick + computer.delay_ticks, len(reference.imaging) - 1)
        q_ahead = reference.ahead_q_eci_from_body_xyzw[now : now + 2]
        omega_ahead = reference.ahead_omega_body_rad_s[now : now + 2]
        now_n_m_s, later_n_m_s = np.empty(3), np.empty(3)
        unrotate(q_ahead[0], memory.momentum_eci_n_m_s, now_n_m_s)
        unrotate(q_ahead[1], memory.momentum_eci_n_m_s, later_n_m_s)
        acceleration_rad_s2 = (
            -computer.k2_per_s2 * 2.0 * q_table_from_body_xyzw[:3] - computer.k1_per_s * error_rad_s
        )
        faster_rad_s = omega_ahead[1] - omega_ahead[0]
        step_n_m_s = later_n_m_s - now_n_m_s - memory.inertia_kg_m2 @ faster_rad_s
        torque_n_m = step_n_m_s / COMMAND_STEP_S - np.cross(error_rad_s, total_n_m_s)
    torque_n_m -= memory.inertia_kg_m2 @ acceleration_rad_s2
    null_gain_rad_s = 0.0 if reference.imaging[tick] else computer.null_gain_rad_s
    middle_rad, rate_rad_s = estimate.gimbal_rad.copy(), memory.wanted_rad_s[0]
    for _ in range(2):
        steer(computer.gyros, middle_rad, torque_n_m, null_gain_rad_s, rate_rad_s)
        middle_rad = estimate.gimbal_rad + 0.5 * COMMAND_STEP_S * rate_rad_s


@lean
def send(computer: Computer, memory: OnboardMemory, gimbal_rad: Array) -> None:
    """Turn wanted into sent gimbal rates, memory.command_rad_s[0]: feedback on the gimbal angles.

    The angles are compared with where the wanted rates would have brought them, and the
    difference is made good: execution errors and the rate step then leave a bounded error of
    momentum instead of a growing one.  Call once a tick, after `decide`.
    """
    gyros, servo_states = computer.gyros, memory.servo_states
    t, b = computer.servo_tick.transition_matrix, computer.servo_tick.input_gain
    for i in range(4):
        lag_rad = servo_states[i, 0] - gimbal_rad[i]
        if computer.delay_ticks == 1:
            lag_rad -= (memory.command_rad_s[1, i] - memory.wanted_rad_s[1, i]) * COMMAND_STEP_S
        rate_rad_s = memory.wanted_rad_s[0, i] + computer.gimbal_gain * lag_rad / COMMAND_STEP_S
        rate_rad_s = min(max(rate_rad_s, -gyros.rate_max_rad_s), gyros.rate_max_rad_s)
        if computer.rate_step_rad_s > 0.0:
            rate_rad_s = computer.rate_step_rad_s * round(rate_rad_s / computer.rate_step_rad_s)
        memory.command_rad_s[0, i] = rate_rad_s
        wanted_rad_s = memory.wanted_rad_s[computer.delay_ticks, i]
        angle, rate, acceleration = servo_states[i]
        for k in range(3):
            servo_states[i, k] = t[k, 1] * rate + t[k, 2] * acceleration + b[k] * wanted_rad_s
        servo_states[i, 0] += angle
