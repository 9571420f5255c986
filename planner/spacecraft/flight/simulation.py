"""Dispersed closed-loop runs of a command table.

Sees the table, the spacecraft and the orbit, never how the table was planned.
"""

import math
import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from planner.base.arrays import Array
from planner.spacecraft.flight.closed_loop import Log, Noise, fly
from planner.spacecraft.table import TICK_S, AttitudeTable
from planner.spacecraft.vehicle.definition import AgileSpacecraft
from planner.spacecraft.vehicle.dynamics import Plant, Ripple, servo_step
from planner.spacecraft.vehicle.onboard import TABLE, Computer, Reference
from planner.world.frames.geodesy import MU_EARTH_M3_S2
from planner.world.orbits.ephemeris import OrbitStates
from planner.world.platforms.cmg_array import CmgArray

STEP_S = 0.005
Kept = TypeVar("Kept")


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


def draw_dispersion(spacecraft: AgileSpacecraft, seed: int) -> Dispersion:
    """One draw: modes +-20 % in frequency, x0.5-1.5 in coupling, x0.5-2 in damping, inertia
    +-1 %, gimbal rates +-(1 % + 0.0069 deg/s), rotor drives 1 mN m at 0.3-3 Hz, gyro bias
    and scale."""
    random = np.random.default_rng(seed)
    m, array, sensors = len(spacecraft.modes), spacecraft.array, spacecraft.sensors
    return Dispersion(
        frequency_factor=random.uniform(0.8, 1.2, m),
        coupling_factor=random.uniform(0.5, 1.5, m),
        damping_factor=2.0 ** random.uniform(-1.0, 1.0, m),
        inertia_factor=random.uniform(0.99, 1.01, 3),
        gimbal_scale=1.0 + array.rate_error_share * random.uniform(-1.0, 1.0, 4),
        gimbal_offset_rad_s=array.rate_error_rad_s * random.uniform(-1.0, 1.0, 4),
        gimbal_jitter_rad_s=0.0,
        ripple=Ripple(
            np.full(4, 1e-3),
            2.0 * np.pi * random.uniform(0.3, 3.0, 4),
            random.uniform(0.0, 2.0 * np.pi, 4),
        ),
        gyro_bias_rad_s=sensors.gyro_bias_rad_s * random.standard_normal(3),
        gyro_scale=sensors.gyro_scale_error * random.standard_normal(3),
        noise=True,
        seed=seed,
    )


def plant(
    spacecraft: AgileSpacecraft, dispersion: Dispersion, radius_m: float, step_s: float = STEP_S
) -> Plant:
    """The body with its dispersion; radius_m: to the Earth's centre, inf for no gravity."""
    array = spacecraft.array
    inertia_kg_m2 = np.diag(np.array(spacecraft.inertia_kg_m2) * dispersion.inertia_factor)
    d = spacecraft.couplings_sqrt_kg_m() * dispersion.coupling_factor[:, None]
    omega_rad_s = 2.0 * np.pi * np.array([m.frequency_hz for m in spacecraft.modes])
    omega_rad_s = omega_rad_s * dispersion.frequency_factor
    damping = np.array([m.damping for m in spacecraft.modes]) * dispersion.damping_factor
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


def computer(spacecraft: AgileSpacecraft, law: int, noise: bool) -> Computer:
    """The on-board computer with the nominal numbers; without noise gimbals execute any rate."""
    # SciPy's signals take 0.2 s to import, which only a flight should pay.
    from scipy.signal import butter

    gains, array = spacecraft.gains, spacecraft.array
    b, a = butter(2, gains.cutoff_hz * 2.0 * TICK_S)
    return Computer(
        inertia_kg_m2=np.array(spacecraft.inertia_kg_m2),
        gyros=array.gyros(),
        rate_step_rad_s=array.rate_step_rad_s if noise else 0.0,
        k1_per_s=gains.k1_per_s,
        k2_per_s2=gains.k2_per_s2,
        butterworth_coefficients=np.array([b[0], b[1], b[2], a[1], a[2]]),
        null_gain_rad_s=gains.null_gain_rad_s,
        gyro_range_rad_s=spacecraft.sensors.gyro_range_rad_s,
        law=law,
        turn_acceleration_rad_s2=gains.acceleration_share
        * spacecraft.slew.torque_n_m
        / max(spacecraft.inertia_kg_m2),
        turn_rate_rad_s=spacecraft.slew.rate_axis_rad_s,
        servo_tick=servo_step(array.servo_rad_s, array.servo_damping, TICK_S),
        gimbal_gain=gains.gimbal_gain,
        delay_ticks=gains.delay_ticks,
    )


def reference(table: AttitudeTable, array: CmgArray, commanded: Sequence[int]) -> Reference:
    """The table made ready for the loop; commanded: ticks that give a new goal."""
    lag_s = 2.0 * array.servo_damping / array.servo_rad_s
    ahead, motion = table.attitude_at(np.minimum(table.t_s + lag_s, table.t_s[-1]))
    goals = np.zeros(len(table.t_s) - 1, dtype=bool)
    goals[list(commanded)] = True
    return Reference(
        q_eci_from_body_xyzw=np.ascontiguousarray(table.eci_from_body_xyzw),
        omega_body_rad_s=np.ascontiguousarray(table.omega_body_rad_s),
        alpha_body_rad_s2=np.ascontiguousarray(table.alpha_body_rad_s2),
        ahead_q_eci_from_body_xyzw=ahead.inv().as_quat(),
        ahead_omega_body_rad_s=motion.omega_body_rad_s,
        imaging=table.imaging(),
        commanded=goals,
    )


def _draw_noise(spacecraft: AgileSpacecraft, dispersion: Dispersion, ticks: int) -> Noise:
    sensors, random = spacecraft.sensors, np.random.default_rng(dispersion.seed)
    on = 1.0 if dispersion.noise else 0.0
    jitter_rad_s = dispersion.gimbal_jitter_rad_s * random.uniform(-1.0, 1.0, (ticks, 4))
    return Noise(
        gyro_rad_s=on * sensors.gyro_noise_rad_s * random.standard_normal((ticks, 3)),
        resolver_rad=on * sensors.resolver_noise_rad * random.standard_normal((ticks, 4)),
        gimbal_rate_rad_s=dispersion.gimbal_offset_rad_s + jitter_rad_s,
        tracker_rad=on * sensors.star_tracker_noise_rad * random.standard_normal((ticks, 3)),
        tracker_ticks=round(sensors.star_tracker_period_s / TICK_S),
        gyro_bias_rad_s=dispersion.gyro_bias_rad_s,
        gyro_scale=dispersion.gyro_scale,
    )


def fly_table(
    spacecraft: AgileSpacecraft,
    table: AttitudeTable,
    states: OrbitStates,
    dispersion: Dispersion,
    *,
    law: int = TABLE,
    commanded: Sequence[int] = (),
) -> Log:
    """One closed-loop run of the whole table; states: the orbit at the table's rows."""
    radii_m = np.linalg.norm(states.r_sat_eci_m, axis=1, keepdims=True)
    return fly(
        plant(spacecraft, dispersion, float(np.mean(radii_m))),
        computer(spacecraft, law, dispersion.noise),
        reference(table, spacecraft.array, commanded),
        _draw_noise(spacecraft, dispersion, len(table.t_s) - 1),
        np.ascontiguousarray(table.gimbal_rad[0]),
        np.ascontiguousarray(-states.r_sat_eci_m / radii_m),
    )


def fly_many(
    spacecraft: AgileSpacecraft,
    table: AttitudeTable,
    states: OrbitStates,
    seeds: Sequence[int],
    keep: Callable[[Log], Kept],
    tell: Callable[[int], None] = lambda _: None,
) -> list[Kept]:
    """Dispersed runs, one a seed, on as many threads as there are cores.

    keep: what is wanted of a run; its log (19 MB for an hour) is given up at once.
    tell: is called with how many are flown.
    """
    kept: list[Kept] = []
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        for one in pool.map(
            lambda seed: keep(
                fly_table(spacecraft, table, states, draw_dispersion(spacecraft, seed))
            ),
            seeds,
        ):
            kept.append(one)
            tell(len(kept))
    return kept
