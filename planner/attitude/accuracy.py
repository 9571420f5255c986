"""The error of a predicted attitude, by its law and age."""

from dataclasses import dataclass

import numpy as np

from planner.arrays import Array
from planner.attitude.aem import AemAttitude
from planner.attitude.harmonic import HarmonicAttitude
from planner.attitude.inertial import InertialAttitude
from planner.frames.time_scales import Instants

# The vehicle's two attitude solutions in the telemetry of 2018-10-12 are 138 arcsec apart.
KNOWLEDGE_RAD = np.deg2rad(138.0 / 3600.0) / np.sqrt(6.0)
# Rms about its mean of the ISS in torque equilibrium that day: 0.236, 0.021, 0.008 deg.
SWING_RAD = np.deg2rad(0.237) / np.sqrt(3.0)


@dataclass(frozen=True, eq=False)
class AttitudeSigma:
    """per_axis_rad: 1-sigma about each body axis, shape (n,).  basis: on what evidence."""

    per_axis_rad: Array
    basis: str


def attitude_sigma(attitude: object, instants: Instants) -> AttitudeSigma:
    """Errors of a law at n instants, the vehicle's knowledge of its attitude included."""
    if isinstance(attitude, HarmonicAttitude):
        return AttitudeSigma(
            np.hypot(KNOWLEDGE_RAD, attitude.sigma_rad(instants)),
            "measured on the history's own tail, held out of the fit",
        )
    if isinstance(attitude, AemAttitude):
        size_rad = np.hypot(KNOWLEDGE_RAD, attitude.residual_rad)
        return AttitudeSigma(
            np.full(len(instants), size_rad),
            "the message is assumed true to 56 arcsec an axis, the measured difference of the "
            "ISS's two attitude solutions; its noise is measured",
        )
    if isinstance(attitude, InertialAttitude):
        return AttitudeSigma(
            np.hypot(KNOWLEDGE_RAD, attitude.error_rms_rad(instants) / np.sqrt(3.0)),
            "measured: the constant body rate on ISS telemetry in torque equilibrium "
            "(bench/attitude.py)",
        )
    return AttitudeSigma(
        np.full(len(instants), np.hypot(KNOWLEDGE_RAD, SWING_RAD)),
        "measured: the ISS's swing about its mean attitude in torque equilibrium; the mean "
        "itself is taken as right (bench/attitude.py)",
    )
