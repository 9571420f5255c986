"""An axis's drive: loop, friction, cable and sensors, in the units a person writes.

What turns an axis is given over its inertia (deg/s2), as its acceleration limit is: the motion
needs no inertia.  The HRC's papers publish none of these numbers but the least rate that its
platform follows smoothly (1 arcmin/s, Sumarokov 2016, p. 86) and that friction and cables make
it oscillate below; the defaults are assumed, and such that they do.
"""

import math
from typing import Annotated

import numpy as np

from planner.base.arrays import Array
from planner.base.spec import Within, spec

CONTROL_STEP_S = 0.02  # of every loop: fifty a second, ten per row; assumed
DERIVATIVE_SHARE = 10.0  # the error's derivative is filtered at this many bandwidths

_ARCSEC = math.radians(1.0 / 3600.0)
_Share = Annotated[float, Within(0.0, 1.0)]
FRICTION_MAX_DEG_S2 = CABLE_TENSION_MAX_DEG_S2 = VISCOUS_MAX_PER_S = 100.0
CABLE_STIFFNESS_MAX_PER_S2 = 10.0
_FrictionDegS2 = Annotated[float, Within(0.0, FRICTION_MAX_DEG_S2)]
_TensionDegS2 = Annotated[float, Within(-CABLE_TENSION_MAX_DEG_S2, CABLE_TENSION_MAX_DEG_S2)]
_NoiseArcsec = Annotated[float, Within(0.0, 3600.0)]
_RateNoiseArcsecS = Annotated[float, Within(0.0, 3600.0)]


@spec
class AxisDrive:
    """Delays, friction and sensors between a commanded angle and the axis's true one; assumed
    unless a source is given.

    bandwidth_hz: undamped frequency of the position loop.
    damping: the loop's, share of critical damping.
    integral: pole of the loop's integrator as a share of the bandwidth; 0 for none.
    command_latency_s: delay of the drive behind its table. 0: the paper adds its delays to the
    time of prediction.
    lag_s: time constant with which the torque follows its command, within the loop.
    torque_reserve: largest torque, in units of the axis's greatest acceleration.
    coulomb_deg_s2: friction while sliding.
    breakaway_deg_s2: friction that must be overcome to slide from rest.
    stribeck_arcmin_s: rate over which friction falls from breakaway to Coulomb.
    viscous_per_s: friction that grows with rate.
    presliding_arcsec: elastic motion before Coulomb friction is reached.
    presliding_damping: of that motion, share of critical damping.
    cable_tension_deg_s2: pull of the cables at zero angle, towards smaller angles.
    cable_stiffness_per_s2: growth of the cables' pull with the angle: acceleration over angle.
    backlash_arcsec: play between the encoder's side of the gear and the shaft.
    encoder_step_arcsec: one count of the encoder.
    encoder_noise_arcsec: 1-sigma, of each reading.
    gyro_step_arcsec_s: one count of the rate gyro.
    gyro_noise_arcsec_s: 1-sigma, of each reading.
    gyro_bias_arcsec_s: 1-sigma, constant in one flight.
    inertia_kg_m2: of what the axis turns, about it; only the carrier's structure feels it.
    """

    bandwidth_hz: Annotated[float, Within(0.05, 5.0)] = 0.3
    damping: Annotated[float, Within(0.2, 2.0)] = 0.7
    integral: _Share = 0.2
    command_latency_s: Annotated[float, Within(0.0, 5.0)] = 0.0
    lag_s: Annotated[float, Within(0.0, 5.0)] = 0.01
    torque_reserve: Annotated[float, Within(1.0, 1e3)] = 1.5
    coulomb_deg_s2: _FrictionDegS2 = 0.1
    breakaway_deg_s2: _FrictionDegS2 = 0.2
    stribeck_arcmin_s: Annotated[float, Within(1e-3, 600.0)] = 0.6
    viscous_per_s: Annotated[float, Within(0.0, VISCOUS_MAX_PER_S)] = 0.05
    presliding_arcsec: Annotated[float, Within(0.01, 3600.0)] = 1.0
    presliding_damping: Annotated[float, Within(0.0, 10.0)] = 0.5
    cable_tension_deg_s2: _TensionDegS2 = 0.01
    cable_stiffness_per_s2: Annotated[float, Within(0.0, CABLE_STIFFNESS_MAX_PER_S2)] = 0.001
    backlash_arcsec: Annotated[float, Within(0.0, 3600.0)] = 0.0
    encoder_step_arcsec: _NoiseArcsec = 0.3
    encoder_noise_arcsec: _NoiseArcsec = 0.1
    gyro_step_arcsec_s: _RateNoiseArcsecS = 0.1
    gyro_noise_arcsec_s: _RateNoiseArcsecS = 0.5
    gyro_bias_arcsec_s: _RateNoiseArcsecS = 0.5
    inertia_kg_m2: Annotated[float, Within(1e-3, 1e5)] = 60.0

    def __post_init__(self) -> None:
        if not self.breakaway_deg_s2 >= self.coulomb_deg_s2:
            raise ValueError(
                f"breakaway_deg_s2 must be at least coulomb_deg_s2 ({self.coulomb_deg_s2:g}), "
                f"not {self.breakaway_deg_s2:g}"
            )
        if self.coulomb_deg_s2 == 0.0 < self.breakaway_deg_s2:
            raise ValueError(
                f"breakaway_deg_s2 ({self.breakaway_deg_s2:g}) needs coulomb_deg_s2 above 0; for "
                "no friction set both to 0"
            )
        if not _is_stable(self):
            raise ValueError(
                f"lag_s ({self.lag_s:g}) is too long for a loop of {self.bandwidth_hz:g} Hz, "
                "which would swing up by itself; lower lag_s or bandwidth_hz"
            )

    @property
    def omega_rad_s(self) -> float:
        """The loop's undamped frequency."""
        return 2.0 * math.pi * self.bandwidth_hz

    @property
    def gains_per_s(self) -> tuple[float, float, float]:
        """Gains of the error's integral (1/s3), the error (1/s2) and its derivative (1/s).

        They put the poles of a lossless axis at the roots of (s^2 + 2 d w s + w^2)(s + i w).
        """
        omega, pole = self.omega_rad_s, self.integral * self.omega_rad_s
        damping = 2.0 * self.damping * omega
        return (pole * omega**2, omega**2 + damping * pole, damping + pole)

    @property
    def derivative_share(self) -> float:
        """Share of the last filtered derivative in the next."""
        return math.exp(-DERIVATIVE_SHARE * self.omega_rad_s * CONTROL_STEP_S)

    @property
    def bristle_per_s2(self) -> float:
        """The friction's stiffness before sliding, sigma_0 over the inertia; 0 without friction."""
        return math.radians(self.coulomb_deg_s2) / (self.presliding_arcsec * _ARCSEC)

    @property
    def bristle_per_s(self) -> float:
        """The friction's damping before sliding, sigma_1 over the inertia."""
        return 2.0 * self.presliding_damping * math.sqrt(self.bristle_per_s2)


def _is_stable(drive: AxisDrive) -> bool:
    """Whether the sampled loop about an axis without friction settles."""
    integral, proportional, derivative = drive.gains_per_s
    keep, step = drive.derivative_share, CONTROL_STEP_S
    plant, torque = _sampled_plant(drive.lag_s)
    # States: angle, rate, torque; then the last angle, its filtered derivative and its integral.
    law = np.zeros(6)
    law[0] = -proportional - derivative * (1.0 - keep) / step
    law[3:] = (derivative * (1.0 - keep) / step, -derivative * keep, -integral)
    loop = np.zeros((6, 6))
    loop[:3, :3] = plant
    loop[:3] += np.outer(torque, law)
    loop[3, 0] = 1.0
    loop[4, [0, 3, 4]] = ((1.0 - keep) / step, -(1.0 - keep) / step, keep)
    loop[5, [0, 5]] = (step, 1.0)
    if drive.integral == 0.0:
        loop = loop[:5, :5]
    return bool(np.max(np.abs(np.linalg.eigvals(loop))) < 1.0)


def _sampled_plant(lag_s: float) -> tuple[Array, Array]:
    """Over one step: of angle, rate and torque, from themselves (3, 3) and the command (3,)."""
    step = CONTROL_STEP_S
    kept = math.exp(-step / lag_s) if lag_s else 0.0
    rate = lag_s * (1.0 - kept)
    angle = lag_s * (step - rate)
    plant = np.array([[1.0, step, angle], [0.0, 1.0, rate], [0.0, 0.0, kept]])
    return plant, np.array([step**2 / 2.0 - angle, step - rate, 1.0 - kept])


# An axis that follows its table: no friction, cable, lag or play, and sensors that tell the truth.
IDEAL_DRIVE = AxisDrive(
    lag_s=0.0,
    coulomb_deg_s2=0.0,
    breakaway_deg_s2=0.0,
    viscous_per_s=0.0,
    cable_tension_deg_s2=0.0,
    cable_stiffness_per_s2=0.0,
    encoder_step_arcsec=0.0,
    encoder_noise_arcsec=0.0,
    gyro_step_arcsec_s=0.0,
    gyro_noise_arcsec_s=0.0,
    gyro_bias_arcsec_s=0.0,
)
