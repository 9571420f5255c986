"""How does a carrier point that keeps a constant attitude to the local vertical?"""

from typing import Literal

import numpy as np
from scipy.spatial.transform import Rotation

from planner.frames.local_orbital import q_lvlh_from_eci
from planner.frames.time_scales import Instants
from planner.orbits import OrbitStates
from planner.spec import require_within, spec

ANGLE_MAX_DEG = 360.0


@spec
class LvlhAttitude:
    """Constant yaw, pitch and roll to LVLH (+Z geocentric nadir, +Y against the orbit normal).

    The rotations carry LVLH onto the body in the order yaw (Z), pitch (Y), roll (X), each
    about the axis already turned: NASA's 3-2-1 sequence.
    """

    law: Literal["lvlh"] = "lvlh"
    yaw_deg: float = 0.0
    pitch_deg: float = 0.0
    roll_deg: float = 0.0

    def __post_init__(self) -> None:
        angles = ("yaw_deg", "pitch_deg", "roll_deg")
        require_within(self, *((name, -ANGLE_MAX_DEG, ANGLE_MAX_DEG) for name in angles))

    def q_body_from_eci(self, instants: Instants, states: OrbitStates) -> Rotation:
        """Attitude at the n instants of `states`."""
        yaw_pitch_roll_rad = np.deg2rad([self.yaw_deg, self.pitch_deg, self.roll_deg])
        q_body_from_lvlh = Rotation.from_euler("ZYX", yaw_pitch_roll_rad).inv()
        return q_body_from_lvlh * q_lvlh_from_eci(states.r_sat_eci_m, states.v_sat_eci_m_s)

    def warnings_at(self, instants: Instants) -> tuple[str, ...]:
        """None: how far the carrier swings about it stands in the pointing budget."""
        return ()
