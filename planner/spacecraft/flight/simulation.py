"""How well does a table hold when flown?  Dispersed closed-loop runs of a command table.

Sees the table, the spacecraft and the orbit, never how the table was planned.
"""

import math
import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from scipy.signal import butter

from planner.arrays import Array
from planner.frames.geodesy import MU_EARTH_M3_S2
from planner.orbits.ephemeris import OrbitStates
from planner.spacecraft.flight.closed_loop import Log, Noise, Reference, fly
from planner.spacecraft.table import TICK_S, AttitudeTable
from planner.spacecraft.vehicle.cmg_array import CmgArray
from planner.spacecraft.vehicle.definition import AgileSpacecraft
from planner.spacecraft.vehicle.dynamics import Plant, servo_transition
from planner.spacecraft.vehicle.onboard import TABLE, Computer

STEP_S = 0.005
Kept = TypeVar("Kept")


@dataclass(frozen=True, kw_only=True)
class Dispersion:
    """How one flown spacecraft differs from the nominal one.

    frequency, coupling, damping: factors per mode (m,).  inertia: factors per axis (3,).
    gimbal_scale, gimbal_offset_rad_s: executed = scale x commanded + offset, (4,) each;
    gimbal_jitter_rad_s: a further error drawn anew every tick, uniform +-.  ripple: (4, 3),
    torque N m, rad/s and phase of the rotor drives' disturbance (0 N m: none).  gyro_bias_rad_s,
    gyro_scale: (3,).  modes_start: (2 m,), swinging at the start.  noise: whether sensors
    and gimbals make random errors; seed: of those.
    """

    frequency: Array
    coupling: Array
    damping: Array
    inertia: Array
    gimbal_scale: Array
    gimbal_offset_rad_s: Array
    gimbal_jitter_rad_s: float
    ripple: Array
    gyro_bias_rad_s: Array
    gyro_scale: Array
    modes_start: Array
    noise: bool
    seed: int


def nominal(spacecraft: AgileSpacecraft) -> Dispersion:
    """The spacecraft as designed, without noise."""
    m = len(spacecraft.modes)
    return Dispersion(
        frequency=np.ones(m),
        coupling=np.ones(m),
        damping=np.ones(m),
        inertia=np.ones(3),
        gimbal_scale=np.ones(4),
        gimbal_offset_rad_s=np.zeros(4),
        gimbal_jitter_rad_s=0.0,
        ripple=np.tile([0.0, 1.0, 0.0], (4, 1)),
        gyro_bias_rad_s=np.zeros(3),
        gyro_scale=np.zeros(3),
        modes_start=np.zeros(2 * m),
        noise=False,
        seed=0,
    )


def dispersed(spacecraft: AgileSpacecraft, seed: int) -> Dispersion:
    """One draw: modes +-20 % in frequency, x0.5-1.5 in coupling, x0.5-2 in damping, inertia
    +-1 %, gimbal rates +-(1 % + 0.0069 deg/s), rotor drives 1 mN m at 0.3-3 Hz, gyro bias
    and scale."""
    random = np.random.default_rng(seed)
    m, array, sensors = len(spacecraft.modes), spacecraft.array, spacecraft.sensors
    return Dispersion(
        frequency=random.uniform(0.8, 1.2, m),
        coupling=random.uniform(0.5, 1.5, m),
        damping=2.0 ** random.uniform(-1.0, 1.0, m),
        inertia=random.uniform(0.99, 1.01, 3),
        gimbal_scale=1.0 + array.rate_error_share * random.uniform(-1.0, 1.0, 4),
        gimbal_offset_rad_s=array.rate_error_rad_s * random.uniform(-1.0, 1.0, 4),
        gimbal_jitter_rad_s=0.0,
        ripple=np.stack(
            [
                np.full(4, 1e-3),
                2.0 * np.pi * random.uniform(0.3, 3.0, 4),
                random.uniform(0.0, 2.0 * np.pi, 4),
            ],
            axis=1,
        ),
        gyro_bias_rad_s=sensors.gyro_bias_rad_s * random.standard_normal(3),
        gyro_scale=sensors.gyro_scale_error * random.standard_normal(3),
        modes_start=np.zeros(2 * m),
        noise=True,
        seed=seed,
    )


def plant(
    spacecraft: AgileSpacecraft, dispersion: Dispersion, radius_m: float, step_s: float = STEP_S
) -> Plant:
    """The body as flown; radius_m: distance to the Earth's centre, inf for no gravity."""
    array = spacecraft.array
    scale = dispersion.inertia
    inertia = spacecraft.inertia * scale
    couplings = spacecraft.couplings() * dispersion.coupling[:, None]
    omega = 2.0 * np.pi * np.array([m.frequency_hz for m in spacecraft.modes])
    omega = omega * dispersion.frequency
    damping = np.array([m.damping for m in spacecraft.modes]) * dispersion.damping
    half, drive = servo_transition(array.servo_rad_s, array.servo_damping, step_s / 2.0)
    return Plant(
        inertia=inertia,
        rigid_inverse=np.asarray(np.linalg.inv(inertia - couplings.T @ couplings)),
        couplings=couplings,
        stiffness=omega**2,
        damping=2.0 * damping * omega,
        rotor=np.ascontiguousarray(array.rotor_axes),
        torque=np.ascontiguousarray(array.torque_axes),
        gimbal_axes=np.ascontiguousarray(array.gimbal_axes),
        momentum_n_m_s=array.momentum_n_m_s,
        gimbal_inertia_kg_m2=array.gimbal_inertia_kg_m2,
        servo_half=half,
        servo_input=drive,
        step_s=step_s,
        rate_scale=dispersion.gimbal_scale,
        ripple=dispersion.ripple,
        gravity_per_s2=0.0 if math.isinf(radius_m) else 3.0 * MU_EARTH_M3_S2 / radius_m**3,
    )


def _ideal(array: CmgArray, noise: bool) -> float:
    """Gimbal rate quantum: a run without noise executes any rate."""
    return array.rate_step_rad_s if noise else 0.0


def computer(spacecraft: AgileSpacecraft, law: int = TABLE, noise: bool = True) -> Computer:
    """The on-board computer with the nominal numbers."""
    gains, array = spacecraft.gains, spacecraft.array
    servo, drive = servo_transition(array.servo_rad_s, array.servo_damping, TICK_S)
    b, a = butter(2, gains.cutoff_hz * 2.0 * TICK_S)
    return Computer(
        inertia=np.array(spacecraft.inertia_kg_m2),
        rotor=np.ascontiguousarray(array.rotor_axes),
        torque=np.ascontiguousarray(array.torque_axes),
        momentum_n_m_s=array.momentum_n_m_s,
        rate_max_rad_s=array.rate_max_rad_s,
        rate_step=_ideal(array, noise),
        k1_per_s=gains.k1_per_s,
        k2_per_s2=gains.k2_per_s2,
        butterworth=np.array([b[0], b[1], b[2], a[1], a[2]]),
        null_gain=gains.null_gain_rad_s,
        gyro_range_rad_s=spacecraft.sensors.gyro_range_rad_s,
        law=law,
        turn_acceleration_rad_s2=gains.acceleration_share
        * spacecraft.slew.torque_n_m
        / max(spacecraft.inertia_kg_m2),
        turn_rate_rad_s=spacecraft.slew.rate_axis_rad_s,
        tick_s=TICK_S,
        servo_tick=servo,
        servo_input=drive,
        gimbal_gain=gains.gimbal_gain,
    )


def reference(
    table: AttitudeTable, array: CmgArray, states: OrbitStates, commanded: Sequence[int] = ()
) -> Reference:
    """The table made ready for the loop; states: the orbit at its rows."""
    lag_s = 2.0 * array.servo_damping / array.servo_rad_s
    rows = len(table.t_s)
    ahead, motion = table.attitude_at(np.minimum(table.t_s + lag_s, table.t_s[-1]))
    goals = np.zeros(rows - 1, dtype=bool)
    goals[list(commanded)] = True
    nadir = -states.r_sat_eci_m / np.linalg.norm(states.r_sat_eci_m, axis=1, keepdims=True)
    return Reference(
        q=np.ascontiguousarray(table.eci_from_body_xyzw),
        rate=np.ascontiguousarray(table.omega_body_rad_s),
        acceleration=np.ascontiguousarray(table.alpha_body_rad_s2),
        ahead=np.hstack([ahead.inv().as_quat(), motion.omega_body_rad_s]),
        imaging=table.imaging(),
        commanded=goals,
        nadir=np.ascontiguousarray(nadir),
    )


def _noise(spacecraft: AgileSpacecraft, dispersion: Dispersion, ticks: int) -> Noise:
    sensors, random = spacecraft.sensors, np.random.default_rng(dispersion.seed)
    on = 1.0 if dispersion.noise else 0.0
    jitter = dispersion.gimbal_jitter_rad_s * random.uniform(-1.0, 1.0, (ticks, 4))
    return Noise(
        gyro=on * sensors.gyro_noise_rad_s * random.standard_normal((ticks, 3)),
        resolver=on * sensors.resolver_noise_rad * random.standard_normal((ticks, 4)),
        gimbal_rate=dispersion.gimbal_offset_rad_s + jitter,
        tracker=on * sensors.star_tracker_noise_rad * random.standard_normal((ticks, 3)),
        tracker_ticks=round(sensors.star_tracker_period_s / TICK_S),
        gyro_bias=dispersion.gyro_bias_rad_s,
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
    step_s: float = STEP_S,
) -> Log:
    """One closed-loop run of the whole table; states: the orbit at the table's rows."""
    radius_m = float(np.mean(np.linalg.norm(states.r_sat_eci_m, axis=1)))
    return fly(
        plant(spacecraft, dispersion, radius_m, step_s),
        computer(spacecraft, law, dispersion.noise),
        reference(table, spacecraft.array, states, commanded),
        _noise(spacecraft, dispersion, len(table.t_s) - 1),
        np.ascontiguousarray(table.gimbal_rad[0]),
        dispersion.modes_start,
        spacecraft.gains.delay_ticks,
    )


def fly_many(
    spacecraft: AgileSpacecraft,
    table: AttitudeTable,
    states: OrbitStates,
    seeds: Sequence[int],
    keep: Callable[[Log], Kept],
) -> list[Kept]:
    """Dispersed runs, one a seed, on as many threads as there are cores.

    keep: what is wanted of a run; its log (23 MB for an hour) is given up at once.
    """
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        return list(
            pool.map(
                lambda seed: keep(
                    fly_table(spacecraft, table, states, dispersed(spacecraft, seed))
                ),
                seeds,
            )
        )
