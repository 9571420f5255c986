"""A body with control moment gyros as a simulation of its control loop takes it.

Numbers of Platonov, Sumarokov 2019 where the paper gives them; every other default is assumed, as
docs/spacecraft.md lists them.
"""

import math
from dataclasses import dataclass, field, replace
from typing import Annotated

import numpy as np

from planner.base.arrays import Array
from planner.base.spec import Within, spec
from planner.world.platforms.body import BodyPlatform
from planner.world.platforms.cmg_array import CmgArray, Positive

Vector3 = tuple[float, float, float]
RATE_ERROR_MAX_RAD_S = math.radians(0.001)  # while imaging; Platonov, Sumarokov 2019


@spec
class FlexibleMode:
    """One cantilever mode of the structure.

    inertia_share: the part of the body's inertia that swings with it; the coupling vector is
    sqrt(share) sqrt(J) o axis_body, so that a share of 1 would leave no rigid body.
    """

    frequency_hz: Annotated[float, Within(1e-3, 20.0)]
    damping: Annotated[float, Within(1e-6, 0.999)] = 0.005
    inertia_share: Annotated[float, Within(0.0, 0.3)]
    axis_body: Vector3

    def __post_init__(self) -> None:
        if not math.isclose(math.hypot(*self.axis_body), 1.0, abs_tol=1e-3):
            raise ValueError(f"axis_body must be a unit vector, not {self.axis_body}")


def _unit_vector(x: float, y: float, z: float) -> Vector3:
    length = math.hypot(x, y, z)
    return (x / length, y / length, z / length)


# Assumed: the paper names solar-array modes "about 2 Hz" on X and Z and modes up to 10 Hz.
ASSUMED_MODES = (
    FlexibleMode(frequency_hz=2.0, inertia_share=0.05, axis_body=_unit_vector(1.0, 0.1, 0.2)),
    FlexibleMode(frequency_hz=2.1, inertia_share=0.05, axis_body=_unit_vector(0.2, 0.1, 1.0)),
    FlexibleMode(frequency_hz=3.4, inertia_share=0.03, axis_body=_unit_vector(0.1, 1.0, 0.1)),
    FlexibleMode(frequency_hz=5.5, inertia_share=0.01, axis_body=_unit_vector(0.7, 0.1, 0.7)),
    FlexibleMode(frequency_hz=9.5, inertia_share=0.005, axis_body=_unit_vector(0.5, 0.5, 0.7)),
)


@spec
class Sensors:
    """Rate gyro (four channels: X, Y, Z and their diagonal) and star trackers; noise assumed.

    gyro_noise_rad_s: per sample of 0.2 s.  gyro_scale_error: of the angle turned.
    star_tracker_noise_rad: per axis and fix of two trackers together.
    resolver_noise_rad: of a gimbal angle, per sample.
    """

    gyro_range_rad_s: Positive = math.radians(1.6)
    gyro_noise_rad_s: float = math.radians(5e-5)
    gyro_bias_rad_s: float = math.radians(1e-5)
    gyro_scale_error: float = 2e-5
    star_tracker_noise_rad: float = math.radians(5.0 / 3600.0)
    star_tracker_period_s: Annotated[float, Within(0.2, 1e6)] = 1.0  # no less than a control cycle
    resolver_noise_rad: float = 5e-6


@spec
class ControlGains:
    """The on-board laws: body acceleration = -k2 (2 n) - k1 (rate error), plus feed-forward.

    cutoff_hz: second-order Butterworth low-pass on the rate error; from 1.2 Hz on the loop drives
    the arrays' modes where they are slowest and couple most.  delay_ticks: whole 0.2 s cycles
    between measurement and command.  null_gain_rad_s: rho of the steering law, zero while
    imaging.  acceleration_share: a1/a of the paper's laws.  gimbal_gain: share of a gimbal's
    angle error made good in a tick.
    """

    k1_per_s: Positive = 2.0
    k2_per_s2: Positive = 0.5
    cutoff_hz: Positive = 1.1
    delay_ticks: Annotated[int, Within(0, 1)] = 0
    null_gain_rad_s: float = 0.02
    acceleration_share: float = 0.75
    gimbal_gain: float = 0.9


@dataclass(frozen=True, kw_only=True, eq=False)
class GyroCraft:
    """A body as designed, its gyros, structure, sensors and on-board laws.

    inertia_kg_m2: (3, 3), the swinging parts included.  turn_acceleration_rad_s2, turn_rate_rad_s:
    a1 and the rate of the paper's turns.
    """

    inertia_kg_m2: Array
    array: CmgArray
    modes: tuple[FlexibleMode, ...] = ASSUMED_MODES
    sensors: Sensors = field(default_factory=Sensors)
    gains: ControlGains = field(default_factory=ControlGains)
    turn_acceleration_rad_s2: float
    turn_rate_rad_s: float

    @property
    def couplings_sqrt_kg_m(self) -> Array:
        """Modal coupling vectors d, shape (m, 3): J - sum d d^T is the rigid body's inertia."""
        moments, axes = np.linalg.eigh(self.inertia_kg_m2)
        root_j = (axes * np.sqrt(moments)) @ axes.T
        rows = [math.sqrt(m.inertia_share) * root_j @ np.array(m.axis_body) for m in self.modes]
        return np.array(rows).reshape(-1, 3)


def gyro_craft(platform: BodyPlatform) -> GyroCraft:
    """The body with the paper's structure, sensors and gains, by share of its own inertia.

    Its rate gyros read a little more than turns may ask, the paper's 1.6 deg/s at least.
    """
    gyros = platform.gyros
    assert gyros is not None
    assert platform.inertia_kg_m2 is not None  # with gyros
    rate_rad_s = math.radians(gyros.turns.rate_max_deg_s)
    inertia_kg_m2 = np.array(platform.inertia_kg_m2)
    sensors, gains = Sensors(), ControlGains()
    torque_n_m = gains.acceleration_share * gyros.turns.torque_max_n_m
    return GyroCraft(
        inertia_kg_m2=inertia_kg_m2,
        array=gyros.array.cmg_array,
        sensors=replace(sensors, gyro_range_rad_s=max(sensors.gyro_range_rad_s, 1.01 * rate_rad_s)),
        turn_acceleration_rad_s2=torque_n_m / float(np.diag(inertia_kg_m2).max()),
        turn_rate_rad_s=rate_rad_s,
    )
