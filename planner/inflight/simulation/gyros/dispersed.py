"""Dispersed closed-loop runs of a command table.

Sees the table, the spacecraft and the orbit, never how the table was planned.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Array, Mask
from planner.base.commands import COMMAND_STEP_S, CommandTable
from planner.base.table_motion import motion_at
from planner.inflight.simulation.gyros.closed_loop import Log, Noise, fly
from planner.inflight.simulation.gyros.dynamics import Plant, Ripple, servo_step
from planner.inflight.simulation.gyros.onboard import TABLE, Computer, Reference
from planner.world.frames.geodesy import MU_EARTH_M3_S2
from planner.world.orbits.ephemeris import OrbitStates
from planner.world.platforms.cmg_array import CmgArray
from planner.world.platforms.gyro_craft import GyroCraft

STEP_S = 0.005


@dataclass(frozen=True, kw_only=True)
class Dispersion:
    """How one spacecraft differs from the nominal one.

    Factors on frequency, coupling and damping of each mode (m,) and on the inertia of each axis
    (3,).  gimbal_scale, gimbal_offset_rad_s: executed = scale x commanded + offset, (4,) each;
    gimbal_jitter_rad_s: a further error drawn anew every tick, uniform +-.  gyro_bias_rad_s,
    gyro_scale: (3,).  noise: whether sensors and gimbals make random errors; seed: of those.
    """

    frequency_factor: Array
    coupling_factor: Array
    damping_factor: Array
    inertia_factor: Array
    gimbal_scale: Array
    gimbal_offset_rad_s: Array
    gimbal_jitter_rad_s: float
    ripple: Ripple
    gyro_bias_rad_s: Array
    gyro_scale: Array
    noise: bool
    seed: int


def as_designed(craft: GyroCraft, seed: int) -> Dispersion:
    """Nothing differs; sensors and gimbals have their noise."""
    modes = np.ones(len(craft.modes))
    return Dispersion(
        frequency_factor=modes,
        coupling_factor=modes,
        damping_factor=modes,
        inertia_factor=np.ones(3),
        gimbal_scale=np.ones(4),
        gimbal_offset_rad_s=np.zeros(4),
        gimbal_jitter_rad_s=0.0,
        ripple=Ripple(np.zeros(4), np.ones(4), np.zeros(4)),
        gyro_bias_rad_s=np.zeros(3),
        gyro_scale=np.zeros(3),
        noise=True,
        seed=seed,
    )


def draw_dispersion(craft: GyroCraft, seed: int) -> Dispersion:
    """One draw: modes +-20 % in frequency, x0.5-1.5 in coupling, x0.5-2 in damping, inertia
    +-1 %, gimbal rates +-(1 % + 0.0069 deg/s), rotor drives 1 mN m at 0.3-3 Hz (for
    60 N m s, as much of others), gyro bias and scale."""
    random = np.random.default_rng(seed)
    m, array, sensors = len(craft.modes), craft.array, craft.sensors
    return Dispersion(
        frequency_factor=random.uniform(0.8, 1.2, m),
        coupling_factor=random.uniform(0.5, 1.5, m),
        damping_factor=2.0 ** random.uniform(-1.0, 1.0, m),
        inertia_factor=random.uniform(0.99, 1.01, 3),
        gimbal_scale=1.0 + array.rate_error_share * random.uniform(-1.0, 1.0, 4),
        gimbal_offset_rad_s=array.rate_error_rad_s * random.uniform(-1.0, 1.0, 4),
        gimbal_jitter_rad_s=0.0,
        ripple=Ripple(
            np.full(4, 1e-3 / 60.0 * array.momentum_n_m_s),
            2.0 * np.pi * random.uniform(0.3, 3.0, 4),
            random.uniform(0.0, 2.0 * np.pi, 4),
        ),
        gyro_bias_rad_s=sensors.gyro_bias_rad_s * random.standard_normal(3),
        gyro_scale=sensors.gyro_scale_error * random.standard_normal(3),
        noise=True,
        seed=seed,
    )


def plant(
    craft: GyroCraft, dispersion: Dispersion, radius_m: float, step_s: float = STEP_S
) -> Plant:
    """The body with its dispersion; radius_m: to the Earth's centre, inf for no gravity."""
    array = craft.array
    scale = np.sqrt(dispersion.inertia_factor)
    inertia_kg_m2 = craft.inertia_kg_m2 * np.outer(scale, scale)
    d = craft.couplings_sqrt_kg_m * dispersion.coupling_factor[:, None]
    omega_rad_s = 2.0 * np.pi * np.array([m.frequency_hz for m in craft.modes])
    omega_rad_s = omega_rad_s * dispersion.frequency_factor
    damping = np.array([m.damping for m in craft.modes]) * dispersion.damping_factor
    return Plant(
        inertia_kg_m2=inertia_kg_m2,
        rigid_inverse_per_kg_m2=np.asarray(np.linalg.inv(inertia_kg_m2 - d.T @ d)),
        couplings_sqrt_kg_m=d,
        stiffness_per_s2=omega_rad_s**2,
        damping_per_s=2.0 * damping * omega_rad_s,
        gyros=array.gyros(),
        gimbal_axes_body=array.gimbal_axes_body,
        gimbal_inertia_kg_m2=array.gimbal_inertia_kg_m2,
        servo_half_step=servo_step(array.servo_rad_s, array.servo_damping, step_s / 2.0),
        step_s=step_s,
        rate_scale=dispersion.gimbal_scale,
        ripple=dispersion.ripple,
        gravity_per_s2=0.0 if math.isinf(radius_m) else 3.0 * MU_EARTH_M3_S2 / radius_m**3,
    )


def computer(craft: GyroCraft, law: int, noise: bool) -> Computer:
    """The on-board computer with the nominal numbers; without noise gimbals execute any rate."""
    # SciPy's signals take 0.2 s to import, which only a flight should pay.
    from scipy.signal import butter

    gains, array = craft.gains, craft.array
    b, a = butter(2, gains.cutoff_hz * 2.0 * COMMAND_STEP_S)
    return Computer(
        inertia_kg_m2=craft.inertia_kg_m2,
        gyros=array.gyros(),
        rate_step_rad_s=array.rate_step_rad_s if noise else 0.0,
        k1_per_s=gains.k1_per_s,
        k2_per_s2=gains.k2_per_s2,
        butterworth_coefficients=np.array([b[0], b[1], b[2], a[1], a[2]]),
        null_gain_rad_s=gains.null_gain_rad_s,
        gyro_range_rad_s=craft.sensors.gyro_range_rad_s,
        law=law,
        turn_acceleration_rad_s2=craft.turn_acceleration_rad_s2,
        turn_rate_rad_s=craft.turn_rate_rad_s,
        servo_tick=servo_step(array.servo_rad_s, array.servo_damping, COMMAND_STEP_S),
        gimbal_gain=gains.gimbal_gain,
        delay_ticks=gains.delay_ticks,
    )


def reference(
    table: CommandTable, imaging: Mask, array: CmgArray, commanded: Sequence[int]
) -> Reference:
    """The table made ready for the loop.

    imaging: whether the camera runs from row k to k + 1, (n - 1,).  commanded: ticks that give a
    new goal.
    """
    lag_s = 2.0 * array.servo_damping / array.servo_rad_s
    ahead = motion_at(table, np.minimum(table.t_s + lag_s, table.t_s[-1]))
    goals = np.zeros(len(table.t_s) - 1, dtype=bool)
    goals[list(commanded)] = True
    assert table.acceleration_rad_s2 is not None  # a body's table has it
    return Reference(
        q_eci_from_body_xyzw=np.ascontiguousarray(table.position),
        omega_body_rad_s=np.ascontiguousarray(table.rate_rad_s),
        alpha_body_rad_s2=np.ascontiguousarray(table.acceleration_rad_s2),
        ahead_q_eci_from_body_xyzw=ahead.position,
        ahead_omega_body_rad_s=ahead.rate_rad_s,
        imaging=imaging,
        commanded=goals,
    )


def camera_on(spans: Iterable[tuple[int, int]], rows: int) -> Mask:
    """Whether the camera runs from row k to k + 1, (rows - 1,); spans: first and last rows."""
    on = np.zeros(rows - 1, dtype=bool)
    for first_row, last_row in spans:
        on[max(first_row, 0) : max(last_row, 0)] = True
    return on


def _draw_noise(craft: GyroCraft, dispersion: Dispersion, ticks: int) -> Noise:
    sensors, random = craft.sensors, np.random.default_rng(dispersion.seed)
    on = 1.0 if dispersion.noise else 0.0
    jitter_rad_s = dispersion.gimbal_jitter_rad_s * random.uniform(-1.0, 1.0, (ticks, 4))
    return Noise(
        gyro_rad_s=on * sensors.gyro_noise_rad_s * random.standard_normal((ticks, 3)),
        resolver_rad=on * sensors.resolver_noise_rad * random.standard_normal((ticks, 4)),
        gimbal_rate_rad_s=dispersion.gimbal_offset_rad_s + jitter_rad_s,
        tracker_rad=on * sensors.star_tracker_noise_rad * random.standard_normal((ticks, 3)),
        tracker_ticks=round(sensors.star_tracker_period_s / COMMAND_STEP_S),
        gyro_bias_rad_s=dispersion.gyro_bias_rad_s,
        gyro_scale=dispersion.gyro_scale,
    )


def fly_table(
    craft: GyroCraft,
    table: CommandTable,
    imaging: Mask,
    states: OrbitStates,
    dispersion: Dispersion,
    *,
    law: int = TABLE,
    commanded: Sequence[int] = (),
) -> Log:
    """One closed-loop run of the whole table, from where its gimbals stand on its first row.

    states: the orbit at the table's rows.
    """
    assert table.extra_rad is not None  # of gyros
    radii_m = np.linalg.norm(states.r_sat_eci_m, axis=1, keepdims=True)
    return fly(
        plant(craft, dispersion, float(np.mean(radii_m))),
        computer(craft, law, dispersion.noise),
        reference(table, imaging, craft.array, commanded),
        _draw_noise(craft, dispersion, len(table.t_s) - 1),
        np.ascontiguousarray(table.extra_rad[0, :4]),
        np.ascontiguousarray(-states.r_sat_eci_m / radii_m),
    )
