"""The spacecraft itself: gyros, unloading coils and trackers of Platonov, Sumarokov 2019."""

import math
from datetime import timedelta
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
from imaging_cases import EPOCH, sun_synchronous
from matplotlib.figure import Figure
from spacecraft_flight import orbit_states

from planner.spacecraft.imaging.ground_arc import orbital_q_body_from_eci
from planner.spacecraft.table import TICK_S
from planner.spacecraft.vehicle.definition import AGILE_CMG
from planner.spacecraft.vehicle.steering import total_momentum_eci
from planner.world.frames.time_scales import Instants
from reproduction.platonov_array import (
    gyro_reach_deg_s,
    least_torque_n_m,
    needed,
    node_drift_deg_day,
    quickest_s,
    reach_n_m_s,
    spin_up_s,
    turned,
)
from reproduction.platonov_sessions import planned
from reproduction.platonov_trackers import seen, sigma_arcsec
from reproduction.platonov_unloading import COIL_A_M2, STEP_S, Unloading, field_eci_t, unload
from reproduction.statements import Numbers

HEIGHT_KM = 650.0
START_N_M_S = np.array([20.0, -15.0, math.sqrt(30.0**2 - 25.0**2)])
SOLAR_AND_AIR_N_M = np.array([1e-4, 0.0, 1e-4])  # assumed, always the same way: the worst kind
ORBITS = 3.0
NAMES = ("strip_and_stereo", "eight_areas")
COILS_A_M2 = (50.0, COIL_A_M2, 300.0)


class Gathered(NamedTuple):
    """Momentum that the gravity gradient adds over the long session, N m s, and coils' runs."""

    session_n_m_s: float
    runs: tuple[Unloading, ...]
    field_t: tuple[float, float]


@lru_cache(maxsize=1)
def _gathered() -> Gathered:
    plan = planned("eight_areas")
    total = total_momentum_eci(
        plan.table.q_body_from_eci,
        np.zeros(3),
        orbit_states(plan).r_sat_eci_m,
        np.array(AGILE_CMG.inertia_kg_m2),
    )
    period_s = 2.0 * math.pi * math.sqrt((6378.137e3 + 1e3 * HEIGHT_KM) ** 3 / 3.986004418e14)
    t_s = np.arange(0.0, ORBITS * period_s, STEP_S)
    instants = Instants(EPOCH, t_s)
    ephemeris = sun_synchronous(HEIGHT_KM).ephemeris(
        EPOCH - timedelta(seconds=10.0), EPOCH + timedelta(seconds=float(t_s[-1]) + 10.0)
    )
    states = ephemeris.states(instants)
    # In orbital orientation the principal axes see no gravity gradient.
    axes = orbital_q_body_from_eci(ephemeris, instants).as_matrix()
    disturbance = np.tile(SOLAR_AND_AIR_N_M, (len(t_s), 1))
    runs = tuple(
        unload(states, instants, axes, START_N_M_S, disturbance, coil) for coil in COILS_A_M2
    )
    strength = np.linalg.norm(field_eci_t(states.r_sat_eci_m, instants), axis=1)
    return Gathered(
        float(np.linalg.norm(total, axis=1).max()),
        runs,
        (float(strength.min()), float(strength.max())),
    )


class Trackers(NamedTuple):
    """Of a session: rows' times, trackers usable (n, 3), and which rows image (n,)."""

    t_s: np.ndarray
    usable: np.ndarray
    imaging: np.ndarray


@lru_cache(maxsize=2)
def _trackers_of(name: str) -> Trackers:
    plan = planned(name)
    table = plan.table
    found = seen(table, orbit_states(plan), Instants(table.epoch_utc, table.t_s))
    return Trackers(table.t_s, found.usable, np.append(table.imaging(), False))


def numbers() -> Numbers:
    return {**_gyros(), **_rates(), **_craft(), **_coils(), **_trackers()}


def _gyros() -> Numbers:
    array, inertia = AGILE_CMG.array, np.array(AGILE_CMG.inertia_kg_m2)
    short, long = (needed(planned(name).table.gimbal_rad, TICK_S) for name in NAMES)
    most = max(short.gyro_n_m_s, long.gyro_n_m_s)
    held = max(short.held_n_m_s, long.held_n_m_s)
    least_n_m = array.momentum_n_m_s * array.rate_step_rad_s
    x, y, z = (math.degrees(least_n_m / j) for j in inertia)
    envelope = {
        f"envelope along {axis}": reach_n_m_s(np.eye(3)[k])
        for k, axis in enumerate(("OX", "OY", "OZ"))
    }
    return {
        **envelope,
        "four times what is needed": 60.0 / most,
        "torque in the sphere": least_torque_n_m(60.0),
        "momentum at 3.5 deg/s": float(inertia.max() * math.radians(3.5)),
        "least torque": least_n_m,
        "least acceleration": z,
        "most": most,
        "held": held,
        "in_pitch": float(long.by_axis_n_m_s[2]),
        "long_torque": long.torque_n_m,
        "times_held": 60.0 / held,
        "empty_torque": least_torque_n_m(0.0, 1),
        "about_y": y,
        "in_a_cycle": 0.2 * x,
    }


def _rates() -> Numbers:
    usual, fast = turned(1.58, 15.4), turned(3.3, 13.0)
    return {
        "spin-up": spin_up_s(3.5, 30.0),
        "20 deg by table": usual.settled_s,
        "3.5 deg/s against 1.6": gyro_reach_deg_s(),
        "spin_up_1_58": spin_up_s(1.58, 30.0),
        "spin_up_15_n_m": spin_up_s(3.5, 15.0),
        "spin_up_1_58_15_n_m": spin_up_s(1.58, 15.0),
        "turn_s": usual.turn_s,
        "quickest_s": quickest_s(20.0),
        "fast_s": fast.turn_s,
        "fast_settled_s": fast.settled_s,
    }


def _craft() -> Numbers:
    low_m, middle_m, high_m = (AGILE_CMG.camera.pixel_rad * km * 1e3 for km in (600, 650, 700))
    return {
        "Sun-synchronous": node_drift_deg_day(HEIGHT_KM),
        "resolution": middle_m,
        "low_m": low_m,
        "high_m": high_m,
    }


def _coils() -> Numbers:
    found = _gathered()
    usual = found.runs[COILS_A_M2.index(COIL_A_M2)]
    h = np.linalg.norm(usual.h_eci_n_m_s, axis=1)
    left = ", ".join(
        f"{np.linalg.norm(run.h_eci_n_m_s[-1]):.2g} with {coil:.0f}"
        for coil, run in zip(COILS_A_M2, found.runs, strict=True)
    )
    return {
        "unloading coils": float(usual.t_s[np.argmax(h < 0.1 * h[0])]) / 60.0,
        "what a session gathers": found.session_n_m_s,
        "least_ut": 1e6 * found.field_t[0],
        "most_ut": 1e6 * found.field_t[1],
        "left": left,
        "kept_n_m_s": float(h[-(len(h) // 3) :].max()),
        "coil_mn_m": 1e3 * float(usual.torque_n_m.max()),
    }


def _trackers() -> Numbers:
    shares = []
    for one in map(_trackers_of, NAMES):
        two = one.usable.sum(axis=1) >= 2
        shares.append((100.0 * two[one.imaging].mean(), 100.0 * two[~one.imaging].mean()))
    single, pair, three = (float(sigma_arcsec(k)[-1]) for k in ((0,), (0, 1), (0, 1, 2)))
    return {
        "two of three trackers": float(shares[1][0]),
        "why two trackers": pair,
        "strip_percent": float(shares[0][0]),
        "turning_percent": float(shares[1][1]),
        "single": single,
        "three": three,
        "assumed": math.degrees(AGILE_CMG.sensors.star_tracker_noise_rad) * 3600.0,
    }


def pictures(folder: Path) -> None:
    figure = Figure(figsize=(10.0, 3.8), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(1.0, 1.2))
    for coil, run in zip(COILS_A_M2, _gathered().runs, strict=True):
        h = np.linalg.norm(run.h_eci_n_m_s, axis=1)
        left.semilogy(run.t_s / 3600.0, h, label=f"{coil:.0f} A m²")
    left.set(xlabel="time, h", ylabel="momentum in the gyros, N m s", title="three coils")
    left.legend(fontsize="small")
    one = _trackers_of("eight_areas")
    for k in range(3):
        right.fill_between(
            one.t_s + 400.0, k + 0.1, k + 0.9, where=one.usable[:, k], color=f"C{k}", lw=0.0
        )
    right.fill_between(
        one.t_s + 400.0, 3.1, 3.4, where=one.imaging, color="0.4", lw=0.0, label="imaging"
    )
    right.set(
        xlabel="time on the paper's clock, s",
        yticks=[0.5, 1.5, 2.5, 3.25],
        yticklabels=["tracker 1", "tracker 2", "tracker 3", "imaging"],
        title="when each tracker sees stars, eight areas",
    )
    figure.savefig(folder / "reproduction_spacecraft_coils_and_trackers.png", dpi=90)
