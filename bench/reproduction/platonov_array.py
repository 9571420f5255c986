"""The paper's four gyros by the product's array: envelope, torque, spin-up."""

import dataclasses
import math
from datetime import timedelta
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from imaging_cases import EPOCH, sun_synchronous
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation
from spacecraft_flight import settle_table

from planner.base.arrays import Array
from planner.spacecraft.flight.simulation import computer, draw_dispersion, fly_table
from planner.spacecraft.flight.stabilisation import settled_after_s
from planner.spacecraft.slews.eigenaxis import eigenaxis_slew
from planner.spacecraft.slews.slew_choice import quickest_slew
from planner.spacecraft.slews.slew_problem import AttitudeSlewProblem, EndState
from planner.spacecraft.vehicle.cmg_array import CmgArray
from planner.spacecraft.vehicle.definition import AGILE_CMG, SlewLimits
from planner.spacecraft.vehicle.onboard import TABLE, Estimate, estimate_rate, memory_at
from planner.spacecraft.vehicle.steering import steer
from planner.world.frames.time_scales import Instants

ARRAY = AGILE_CMG.array
SETTLE_SEEDS = range(6)


def reach_n_m_s(direction: Array) -> float:
    """Momentum at which the array's envelope ends, by bisection."""

    def beyond(length: float) -> float:
        return -1.0 if ARRAY.in_envelope(length * direction) else 1.0

    return float(brentq(beyond, 1.0, 300.0, xtol=1e-6))


def least_torque_n_m(momentum_n_m_s: float, places: int = 1500) -> float:
    """Least torque the steering law gives in any way, gyros holding so much in any direction.

    A way is worst for the gimbal whose row of D's pseudo-inverse lies along it.
    """
    random, gyros = np.random.default_rng(1), ARRAY.gyros()
    directions = random.standard_normal((places, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    rates, least = np.empty(4), math.inf
    for held in (*directions, *np.eye(3)):
        gimbal_rad = ARRAY.gimbal_angles(momentum_n_m_s * held)
        d = ARRAY.jacobian(gimbal_rad)
        rows = np.linalg.pinv(d)
        row = rows[np.argmax(np.linalg.norm(rows, axis=1))]
        way = row / np.linalg.norm(row)
        steer(gyros, gimbal_rad, 1e3 * way, 0.0, rates)  # more than there is: all it can
        least = min(least, float(ARRAY.momentum_n_m_s * (d @ rates) @ way))
    return least


class Needed(NamedTuple):
    """Of a flown session: most momentum held and its greatest part along each axis, N m s, most
    torque, N m, and the size of each of four gyros whose envelope would just do, N m s."""

    held_n_m_s: float
    by_axis_n_m_s: Array
    torque_n_m: float
    gyro_n_m_s: float


def needed(gimbal_rad: Array, tick_s: float) -> Needed:
    """From the rows (n, 4) of a table, or of a run."""
    h = ARRAY.momentum(gimbal_rad)

    def fits(size: float) -> bool:
        return bool(np.all(CmgArray(momentum_n_m_s=size).in_envelope(h)))

    low, high = 0.1, 60.0
    while high - low > 0.01:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if fits(middle) else (middle, high)
    return Needed(
        float(np.linalg.norm(h, axis=1).max()),
        np.abs(h).max(axis=0),
        float(np.linalg.norm(np.diff(h, axis=0), axis=1).max() / tick_s),
        high,
    )


def _pitch_turn(angle_deg: float, limits: SlewLimits) -> AttitudeSlewProblem:
    return AttitudeSlewProblem(
        start=EndState.at_rest(Rotation.identity()),
        end=EndState.at_rest(Rotation.from_euler("z", angle_deg, degrees=True)),
        momentum_eci_n_m_s=np.zeros(3),
        inertia_kg_m2=np.array(AGILE_CMG.inertia_kg_m2),
        limits=limits,
    )


def spin_up_s(rate_deg_s: float, torque_n_m: float) -> float:
    """Until a turn about the Euler axis has its full rate, its torque rising by 40 N m/s."""
    limits = SlewLimits(rate_axis_rad_s=math.radians(rate_deg_s), torque_n_m=torque_n_m)
    turn = eigenaxis_slew(_pitch_turn(60.0, limits))
    t_s = np.linspace(0.0, turn.duration_s, 4001)
    _, motion = turn.attitude_at(t_s)
    speed = np.linalg.norm(motion.omega_body_rad_s, axis=1)
    return float(t_s[np.argmax(speed >= 0.999 * speed.max())])


def quickest_s(angle_deg: float) -> float:
    """Least time of a turn in pitch from rest to rest within the product's limits."""
    return float(quickest_slew(_pitch_turn(angle_deg, AGILE_CMG.slew)).duration_s)


class Turned(NamedTuple):
    """A turn flown in dispersed runs: its time and the median from command to settled, s."""

    turn_s: float
    settled_s: float


@lru_cache(maxsize=4)
def turned(rate_deg_s: float, seconds: float, angle_deg: float = 20.0) -> Turned:
    """A smooth turn in so many seconds up to a rate, followed by the product's law."""
    limits = SlewLimits(rate_axis_rad_s=math.radians(rate_deg_s), torque_n_m=15.0)
    spacecraft = dataclasses.replace(AGILE_CMG, slew=limits)
    table, duration_s = settle_table(spacecraft, "ocp", angle_deg, seconds)
    ephemeris = sun_synchronous(600.0).ephemeris(EPOCH, EPOCH + timedelta(seconds=60))
    states = ephemeris.states(Instants(EPOCH, table.t_s))
    settled = [
        settled_after_s(
            fly_table(spacecraft, table, states, draw_dispersion(spacecraft, seed)), 50, 300
        )
        for seed in SETTLE_SEEDS
    ]
    return Turned(duration_s, float(np.median(settled)))


def gyro_reach_deg_s() -> float:
    """Rate about one body axis up to which the four channels still give the rate."""
    onboard = computer(AGILE_CMG, TABLE, noise=False)
    memory = memory_at(onboard, np.zeros(3), np.zeros((4, 3)))
    estimate = Estimate(np.array([0.0, 0.0, 0.0, 1.0]), np.empty(3), np.zeros(4))

    def beyond(rate_deg_s: float) -> float:
        z = math.radians(rate_deg_s)
        channels = np.array([0.0, 0.0, z, z / math.sqrt(3.0)])
        return -1.0 if estimate_rate(onboard, memory, estimate, channels) else 1.0

    return float(brentq(beyond, 0.5, 10.0, xtol=1e-6))


def node_drift_deg_day(height_km: float, revolutions: int = 15) -> float:
    """How fast the plane of the bench's Sun-synchronous orbit turns, in the product's orbit."""
    orbit = sun_synchronous(height_km)
    period_s = 2.0 * math.pi * math.sqrt((6378.137e3 + 1e3 * height_km) ** 3 / 3.986004418e14)
    ephemeris = orbit.ephemeris(EPOCH, EPOCH + timedelta(seconds=(revolutions + 1) * period_s))
    t_s = np.arange(0.0, (revolutions + 0.9) * period_s, 20.0)
    states = ephemeris.states(Instants(EPOCH, t_s))
    normal = np.cross(states.r_sat_eci_m, states.v_sat_eci_m_s)
    node = np.unwrap(np.arctan2(normal[:, 0], -normal[:, 1]))
    z = states.r_sat_eci_m[:, 2]
    up = np.flatnonzero((z[:-1] < 0.0) & (z[1:] >= 0.0))
    share = -z[up] / (z[up + 1] - z[up])
    at_node = node[up] + share * (node[up + 1] - node[up])
    at_s = t_s[up] + share * 20.0
    drift = (at_node[-1] - at_node[0]) / (at_s[-1] - at_s[0])
    return float(np.rad2deg(drift) * 86400.0)
