"""The agile spacecraft: its inertia, modes, sensors, limits and control gains.

Numbers of Platonov, Sumarokov 2019 where the paper gives them; every other default is an
assumption, named as such here and repeated in `ASSUMPTIONS` of the stabilisation report.
"""

import math
from typing import Annotated, Literal

import numpy as np

from planner.base.arrays import Array
from planner.base.spec import Within, spec
from planner.world.platforms.cmg_array import CmgArray, Positive

SlewObjective = Literal["smooth", "minimum_time"]
Vector3 = tuple[float, float, float]
SETTLE_S = (0.0, 60.0)
SWATH_M = (100.0, 500e3)
OFF_NADIR_DEG = (0.1, 60.0)
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


@spec
class SlewLimits:
    """What a planned turn may ask for; of the gyros no more than `CmgArray` has everywhere.

    rate_rad_s: vector magnitude; rate_axis_rad_s: each body axis, 1.58 deg/s by default so that
    the gyro (1.6) always reads.  torque, torque_rate: magnitude of the control torque and of
    its derivative (assumed: they spare the modes).  settle_s: between the end of a turn and
    imaging, on the profile already.
    """

    rate_rad_s: Positive = math.radians(3.5)
    rate_axis_rad_s: Positive = math.radians(1.58)
    torque_n_m: Positive = 15.0
    torque_rate_n_m_s: Positive = 40.0
    momentum_sphere_n_m_s: Positive = 60.0
    settle_s: Annotated[float, Within(*SETTLE_S)] = 2.6


@spec
class PushbroomCamera:
    """The pushbroom camera, optical axis -Y, detector columns along X.

    pixel_rad: 1 m at nadir from 650 km.  tdi_lines: lines added up, which sets the exposure;
    swath_m: ground width imaged at nadir.  reversible: whether the detector also scans
    backwards (TDI in both directions).  The paper gives 1 m and 12 km; TDI is assumed.
    """

    pixel_rad: Annotated[float, Within(1e-9, 1e-3)] = 1.0 / 650e3
    tdi_lines: Annotated[int, Within(1, 1024)] = 32
    swath_m: Annotated[float, Within(*SWATH_M)] = 12e3
    reversible: bool = False
    across_max_deg: Annotated[float, Within(*OFF_NADIR_DEG)] = 45.0
    along_max_deg: Annotated[float, Within(*OFF_NADIR_DEG)] = 30.0


@spec
class AgileSpacecraft:
    """An Earth-imaging spacecraft turned by control moment gyros.

    Body axes: X along flight, Y up (the optical axis is -Y), Z = X x Y (pitch).
    inertia_kg_m2: principal moments, the swinging parts included.
    """

    name: str = "agile-cmg"
    inertia_kg_m2: Vector3 = (800.0, 500.0, 800.0)
    array: CmgArray = CmgArray()
    modes: tuple[FlexibleMode, ...] = ASSUMED_MODES
    sensors: Sensors = Sensors()
    gains: ControlGains = ControlGains()
    slew: SlewLimits = SlewLimits()
    camera: PushbroomCamera = PushbroomCamera()

    def __post_init__(self) -> None:
        a, b, c = sorted(self.inertia_kg_m2)
        if not (a > 0.0 and a + b >= c):
            raise ValueError(
                f"inertia_kg_m2 {self.inertia_kg_m2}: no body has these moments (each must be "
                "positive and at most the sum of the others)"
            )
        for name, value, most in (
            ("momentum_sphere_n_m_s", self.slew.momentum_sphere_n_m_s, self.array.sphere_n_m_s),
            ("torque_n_m", self.slew.torque_n_m, self.array.torque_n_m),
        ):
            if value > most:
                raise ValueError(
                    f"slew.{name} ({value:g}) is more than the {most:g} that the gyros of "
                    f"{self.name!r} have in every direction; ask for less of them"
                )
        d = self.couplings_sqrt_kg_m()
        if np.linalg.eigvalsh(np.diag(self.inertia_kg_m2) - d.T @ d)[0] <= 0.0:
            raise ValueError("the modes' inertia shares leave no rigid body; make them smaller")

    def couplings_sqrt_kg_m(self) -> Array:
        """Modal coupling vectors d, shape (m, 3): J - sum d d^T is the rigid body's inertia."""
        root_j = np.sqrt(np.array(self.inertia_kg_m2))
        rows = [math.sqrt(m.inertia_share) * root_j * np.array(m.axis_body) for m in self.modes]
        return np.array(rows).reshape(-1, 3)


AGILE_CMG = AgileSpacecraft()
SPACECRAFT = {AGILE_CMG.name: AGILE_CMG}
