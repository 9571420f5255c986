"""A constant attitude to the local vertical."""

from typing import Annotated, Literal

import numpy as np
from scipy.spatial.transform import Rotation

from planner.frames.local_orbital import q_lvlh_from_eci
from planner.frames.time_scales import Instants
from planner.orbits import OrbitStates
from planner.spec import Within, spec


@spec
class LvlhAttitude:
    """Constant yaw, pitch and roll to LVLH (+Z geocentric nadir, +Y against the orbit normal).

    The rotations carry LVLH onto the body in the order yaw (Z), pitch (Y), roll (X), each
    about the axis already turned: NASA's 3-2-1 sequence.
    """

    law: Literal["lvlh"] = "lvlh"
    yaw_deg: Annotated[float, Within(-360.0, 360.0)] = 0.0
    pitch_deg: Annotated[float, Within(-360.0, 360.0)] = 0.0
    roll_deg: Annotated[float, Within(-360.0, 360.0)] = 0.0

    def q_body_from_eci(self, instants: Instants, states: OrbitStates) -> Rotation:
        """Attitude at the n instants of `states`."""
        yaw_pitch_roll_rad = np.deg2rad([self.yaw_deg, self.pitch_deg, self.roll_deg])
        q_body_from_lvlh = Rotation.from_euler("ZYX", yaw_pitch_roll_rad).inv()
        return q_body_from_lvlh * q_lvlh_from_eci(states.r_sat_eci_m, states.v_sat_eci_m_s)

    def warnings_at(self, instants: Instants) -> tuple[str, ...]:
        """None: how far the carrier swings about it stands in the pointing budget."""
        return ()
