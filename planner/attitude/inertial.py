"""An attitude that turns with a constant body rate."""

import math
from datetime import datetime
from typing import Annotated, Literal

import numpy as np
from scipy.spatial.transform import Rotation

from planner.arrays import Array
from planner.attitude.correctable import CorrectableAttitude
from planner.attitude.errors import AttitudeErrors, known_errors
from planner.errors import OutsideCoverage
from planner.frames.time_scales import Instants, elapsed_s, utc_text
from planner.orbits import OrbitStates
from planner.spec import UnitPart, Within, spec

QUATERNION_NORM_TOLERANCE = 1e-4  # four printed decimals
# Rms error of the constant body rate about body x, y, z on ISS telemetry of 2018-10-12 in torque
# equilibrium (bench/truth.py).
CONSTANT_RATE_LEADS_S = (0.0, 60.0, 120.0, 300.0, 600.0, 900.0, 1200.0, 1800.0)
CONSTANT_RATE_RMS_BODY_DEG = (
    (0.0, 0.004, 0.009, 0.027, 0.077, 0.154, 0.248, 0.446),
    (0.0, 0.018, 0.036, 0.089, 0.178, 0.269, 0.355, 0.528),
    (0.0, 0.008, 0.016, 0.040, 0.088, 0.148, 0.215, 0.364),
)
# No camera sees anything from a carrier that spins faster.
_RateDegS = Annotated[float, Within(-180.0, 180.0)]
WARN_AGE_S = 600.0  # 0.2 deg: the HRC's frame is 0.6 deg high
REFUSE_AGE_S = 7200.0  # 12 deg


@spec
class InertialAttitude(CorrectableAttitude):
    """Attitude and body rate known at an epoch, the rate constant in body axes.

    The closed form of q' = q/2 o omega; the paper's 0.1 s recursion with norm correction approaches
    it with an error of (omega tau)^3/24 per step. It is refused 2 h and more from the
    epoch: the rate of no carrier stays that long. Source: Sumarokov 2016, eq. 1-2.

    epoch: when the attitude was so; UTC.
    q_body_from_eci_xyzw: scalar last, `Rotation.from_quat(q).apply(v_eci)` gives `v_body`.
    omega_body_deg_s: body relative to ECI, in body axes.
    """

    law: Literal["inertial"] = "inertial"
    epoch: datetime
    q_body_from_eci_xyzw: tuple[UnitPart, UnitPart, UnitPart, UnitPart]
    omega_body_deg_s: tuple[_RateDegS, _RateDegS, _RateDegS] = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        norm = math.hypot(*self.q_body_from_eci_xyzw)
        if not abs(norm - 1.0) <= QUATERNION_NORM_TOLERANCE:
            raise ValueError(
                f"q_body_from_eci_xyzw must have unit length, not {norm:.6g}; divide it by its norm"
            )
        for number, one in enumerate(self.corrections):
            age_s = abs(elapsed_s(one.epoch, self.epoch))
            if age_s >= REFUSE_AGE_S:
                raise ValueError(
                    f"corrections.{number}.epoch is {age_s / 3600.0:.1f} h from the attitude's "
                    f"epoch; at {REFUSE_AGE_S / 3600.0:.0f} h a constant body rate says nothing "
                    "to be corrected: leave it out, or give attitude and rate nearer to it"
                )

    def q_law_body_from_eci(self, instants: Instants, states: OrbitStates) -> Rotation:
        """Attitude at the n instants; the orbit plays no part."""
        since_epoch_s = instants.since_s(self.epoch)
        age_s = float(np.max(np.abs(since_epoch_s)))
        if age_s >= REFUSE_AGE_S:
            raise OutsideCoverage(
                f"{self._age_warning(age_s)}; at {REFUSE_AGE_S / 3600.0:.0f} h a constant body "
                "rate says nothing; give attitude and rate nearer to the sessions, or another law",
                field="attitude.epoch",
            )
        turn_rad = np.outer(since_epoch_s, np.deg2rad(self.omega_body_deg_s))
        return Rotation.from_rotvec(-turn_rad) * Rotation.from_quat(self.q_body_from_eci_xyzw)

    def law_warnings_at(self, instants: Instants) -> tuple[str, ...]:
        """That the epoch is far from the instants."""
        age_s = float(np.max(np.abs(instants.since_s(self.epoch))))
        return (self._age_warning(age_s),) if age_s > WARN_AGE_S else ()

    def law_errors(self, instants: Instants) -> AttitudeErrors:
        """Measured up to 1800 s from the epoch, beyond that growing as time^2."""
        return known_errors(
            _error_rms_body_rad(np.abs(instants.since_s(self.epoch))),
            "measured: the constant body rate on ISS telemetry in torque equilibrium "
            "(bench/truth.py)",
            "attitude and rate nearer to the session, or a longer history (law harmonic)",
        )

    def _age_warning(self, age_s: float) -> str:
        error_deg = float(np.linalg.norm(np.rad2deg(_error_rms_body_rad(np.array([age_s])))))
        error = f"be off by some {error_deg:.2g} deg" if error_deg < 90.0 else "point anywhere"
        return (
            f"the attitude's epoch {utc_text(self.epoch, 0)} is {age_s / 60.0:.1f} min from the "
            f"plan's farthest end: with a constant body rate the ISS would {error}"
        )


def _error_rms_body_rad(age_s: Array) -> Array:
    """Shape (n, 3)."""
    rms_deg = [np.interp(age_s, CONSTANT_RATE_LEADS_S, one) for one in CONSTANT_RATE_RMS_BODY_DEG]
    beyond = np.maximum(1.0, age_s / CONSTANT_RATE_LEADS_S[-1])
    return np.asarray(np.deg2rad(rms_deg).T * beyond[:, None] ** 2)
