"""An attitude that turns with a constant body rate."""

import math
from datetime import datetime
from typing import Annotated, Literal

import numpy as np

from planner.base.arrays import Array
from planner.base.errors import OutsideCoverage
from planner.base.rotation import Rotation
from planner.base.spec import UnitPart, Within, spec
from planner.world.attitude.correctable import CorrectableAttitude
from planner.world.attitude.errors import KNOWLEDGE_RAD, AttitudeErrors, soon_forgotten
from planner.world.frames.time_scales import Instants, elapsed_s, utc_text
from planner.world.orbits import OrbitStates

QUATERNION_NORM_TOLERANCE = 1e-4  # four printed decimals
# Rms sizes (deg) about body x, y, z of the shapes over time that the error of a constant body rate
# is made of, fitted to ISS telemetry in torque equilibrium (bench/attitude_figures.py of commit
# 54f03d3):
# the swing and the rate's own error, which a turning frame brings back each orbit, the orbital
# plane's drift, an eccentric orbit's uneven pace, and the pitch rate's error, which adds up.
_SIZES_BODY_DEG = (
    (0.32, 0.043, 0.255),  # 1 - cos u, u the orbit's angle since the epoch
    (0.056, 0.0, 0.097),  # sin u
    (0.033, 0.0, 0.029),  # u cos u - sin u
    (0.030, 0.0, 0.028),  # u sin u
    (0.0, 0.038, 0.0),  # u - sin u
    (0.0, 0.241, 0.0),  # u
)
# No camera sees anything from a carrier that spins faster.
_RateDegS = Annotated[float, Within(-180.0, 180.0)]
WARN_AGE_S = 600.0  # 0.2 deg: the HRC's frame is 0.6 deg high
REFUSE_AGE_S = 7200.0  # 2 deg, and as far as it was measured


@spec
class InertialAttitude(CorrectableAttitude):
    """Attitude and body rate known at an epoch, the rate constant in body axes.

    The closed form of q' = q/2 o omega; the paper's 0.1 s recursion with norm correction approaches
    it with an error of (omega tau)^3/24 per step. It is refused 2 h and more from the
    epoch: the rate of no carrier stays that long. Source: Sumarokov 2016, eq. 1-2.

    epoch: time at which this is the attitude; UTC.
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
        """Measured up to two hours from the epoch."""
        parts_rad = self._error_parts_body_rad(instants.since_s(self.epoch))
        known_rad = np.full_like(parts_rad[:1], KNOWLEDGE_RAD)
        parts_rad = np.concatenate([parts_rad, known_rad])
        sigma_rad = np.linalg.norm(parts_rad, axis=0)
        return AttitudeErrors(
            sigma_rad,
            np.zeros(3),
            "measured: the constant body rate on ISS telemetry in torque equilibrium "
            "(bench/truth.py)",
            "attitude and rate nearer to the session, or a longer history (law harmonic)",
            soon_forgotten(sigma_rad),
            parts_body_rad=parts_rad,
        )

    def _error_parts_body_rad(self, age_s: Array) -> Array:
        """Shape (6, n, 3)."""
        u = 2.0 * np.pi / self.orbital_period_s * age_s
        c, s = np.cos(u), np.sin(u)
        shapes = np.stack([1.0 - c, s, u * c - s, u * s, u - s, u])
        return np.asarray(shapes[:, :, None] * np.deg2rad(_SIZES_BODY_DEG)[:, None, :])

    def _age_warning(self, age_s: float) -> str:
        parts_rad = self._error_parts_body_rad(np.array([age_s]))
        error_deg = float(np.rad2deg(np.linalg.norm(parts_rad)))
        error = f"be off by some {error_deg:.2g} deg" if error_deg < 90.0 else "point anywhere"
        return (
            f"the attitude's epoch {utc_text(self.epoch, 0)} is {age_s / 60.0:.1f} min from the "
            f"plan's farthest end: with a constant body rate the ISS would {error}"
        )
