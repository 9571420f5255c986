"""How does a carrier point that turns with a constant body rate?"""

import math
from datetime import datetime
from typing import ClassVar, Literal

import numpy as np
from scipy.spatial.transform import Rotation

from planner.frames.time_scales import Instants, elapsed_s, require_offset
from planner.orbits import OrbitStates
from planner.spec import spec

QUATERNION_NORM_TOLERANCE = 1e-4  # four printed decimals


@spec
class InertialAttitude:
    """Attitude and body rate known at an epoch, the rate constant in body axes.

    q_body_from_eci_xyzw: scalar last, `Rotation.from_quat(q).apply(v_eci)` gives `v_body`.
    omega_body_deg_s: body relative to ECI, in body axes.
    The closed form of q' = q/2 o omega; the paper's 0.1 s recursion with norm correction
    approaches it with an error of (omega tau)^3/24 per step.
    Source: Sumarokov 2016, eq. 1-2.
    """

    law: Literal["inertial"] = "inertial"
    epoch: datetime
    q_body_from_eci_xyzw: tuple[float, float, float, float]
    omega_body_deg_s: tuple[float, float, float] = (0.0, 0.0, 0.0)
    warnings: ClassVar[tuple[str, ...]] = ()

    def __post_init__(self) -> None:
        require_offset("epoch", self.epoch)
        norm = math.hypot(*self.q_body_from_eci_xyzw)
        if not abs(norm - 1.0) <= QUATERNION_NORM_TOLERANCE:
            raise ValueError(
                f"q_body_from_eci_xyzw must have unit length, not {norm:.6g}; divide it by its norm"
            )

    def q_body_from_eci(self, instants: Instants, states: OrbitStates) -> Rotation:
        """Attitude at the n instants; the orbit plays no part."""
        since_epoch_s = instants.t_s + elapsed_s(instants.epoch_utc, self.epoch)
        turned_rad = np.outer(since_epoch_s, np.deg2rad(self.omega_body_deg_s))
        return Rotation.from_rotvec(-turned_rad) * Rotation.from_quat(self.q_body_from_eci_xyzw)
