"""An attitude that turns with a constant body rate."""

import math
from datetime import datetime
from typing import Annotated, Literal

import numpy as np
from scipy.spatial.transform import Rotation

from planner.arrays import Array
from planner.errors import OutsideCoverage
from planner.frames.time_scales import Instants, elapsed_s, require_offset, utc_text
from planner.orbits import OrbitStates
from planner.spec import UnitPart, Within, spec

QUATERNION_NORM_TOLERANCE = 1e-4  # four printed decimals
# Rms error of the constant body rate on ISS telemetry of 2018-10-12 (bench/attitude.py).
CONSTANT_RATE_LEADS_S = (0.0, 60.0, 120.0, 300.0, 600.0, 900.0, 1200.0, 1800.0)
CONSTANT_RATE_RMS_DEG = (0.0, 0.020, 0.037, 0.096, 0.207, 0.338, 0.464, 0.781)
# No camera sees anything from a carrier that spins faster.
_RateDegS = Annotated[float, Within(-180.0, 180.0)]
WARN_AGE_S = 600.0  # 0.2 deg: the HRC's frame is 0.6 deg high
REFUSE_AGE_S = 7200.0  # 12 deg


@spec
class InertialAttitude:
    """Attitude and body rate known at an epoch, the rate constant in body axes.

    q_body_from_eci_xyzw: scalar last, `Rotation.from_quat(q).apply(v_eci)` gives `v_body`.
    omega_body_deg_s: body relative to ECI, in body axes.
    The closed form of q' = q/2 o omega; the paper's 0.1 s recursion with norm correction
    approaches it with an error of (omega tau)^3/24 per step.
    Raises OutsideCoverage 2 h and more from the epoch: the rate of no carrier stays that long.
    Source: Sumarokov 2016, eq. 1-2.
    """

    law: Literal["inertial"] = "inertial"
    epoch: datetime
    q_body_from_eci_xyzw: tuple[UnitPart, UnitPart, UnitPart, UnitPart]
    omega_body_deg_s: tuple[_RateDegS, _RateDegS, _RateDegS] = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        require_offset("epoch", self.epoch)
        norm = math.hypot(*self.q_body_from_eci_xyzw)
        if not abs(norm - 1.0) <= QUATERNION_NORM_TOLERANCE:
            raise ValueError(
                f"q_body_from_eci_xyzw must have unit length, not {norm:.6g}; divide it by its norm"
            )

    def q_body_from_eci(self, instants: Instants, states: OrbitStates) -> Rotation:
        """Attitude at the n instants; the orbit plays no part."""
        since_epoch_s = self._since_epoch_s(instants)
        age_s = float(np.max(np.abs(since_epoch_s)))
        if age_s >= REFUSE_AGE_S:
            raise OutsideCoverage(
                f"{self._age_warning(age_s)}; at {REFUSE_AGE_S / 3600.0:.0f} h a constant body "
                "rate says nothing; give attitude and rate nearer to the sessions, or another law",
                field="attitude.epoch",
            )
        turn_rad = np.outer(since_epoch_s, np.deg2rad(self.omega_body_deg_s))
        return Rotation.from_rotvec(-turn_rad) * Rotation.from_quat(self.q_body_from_eci_xyzw)

    def warnings_at(self, instants: Instants) -> tuple[str, ...]:
        """That the epoch is far from the instants."""
        age_s = float(np.max(np.abs(self._since_epoch_s(instants))))
        return (self._age_warning(age_s),) if age_s > WARN_AGE_S else ()

    def error_rms_rad(self, instants: Instants) -> Array:
        """Of the rotation, shape (n,): measured up to 1800 s, beyond that growing as time^2."""
        return _error_rms_rad(np.abs(self._since_epoch_s(instants)))

    def _since_epoch_s(self, instants: Instants) -> Array:
        return np.asarray(instants.t_s + elapsed_s(instants.epoch_utc, self.epoch))

    def _age_warning(self, age_s: float) -> str:
        error_deg = float(np.rad2deg(_error_rms_rad(np.array([age_s]))[0]))
        error = f"be off by some {error_deg:.2g} deg" if error_deg < 90.0 else "point anywhere"
        return (
            f"the attitude's epoch {utc_text(self.epoch, 0)} is {age_s / 60.0:.1f} min from the "
            f"plan's farthest end: with a constant body rate the ISS would {error}"
        )


def _error_rms_rad(age_s: Array) -> Array:
    rms_deg = np.interp(age_s, CONSTANT_RATE_LEADS_S, CONSTANT_RATE_RMS_DEG)
    beyond = np.maximum(1.0, age_s / CONSTANT_RATE_LEADS_S[-1])
    return np.asarray(np.deg2rad(rms_deg * beyond**2))
