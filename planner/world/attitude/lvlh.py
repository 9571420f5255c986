"""A constant attitude to the local vertical."""

from typing import Annotated, Literal

import numpy as np

from planner.base.rotation import Rotation
from planner.base.spec import Within, spec
from planner.world.attitude.correctable import CorrectableAttitude
from planner.world.attitude.errors import (
    KNOWLEDGE_RAD,
    MEAN_SIGMA_DEG,
    REST_RAD,
    AttitudeErrors,
)
from planner.world.frames.local_orbital import q_lvlh_from_eci
from planner.world.frames.time_scales import Instants
from planner.world.orbits import OrbitStates

# Rms of the sinusoid at the orbital rate in which the ISS swings about its mean in torque
# equilibrium on 2018-10-12, about body x, y, z (bench/attitude_figures.py of commit 54f03d3).
SWING_RMS_BODY_RAD = np.deg2rad([0.234, 0.0126, 0.0065])


@spec
class LvlhAttitude(CorrectableAttitude):
    """Constant yaw, pitch and roll to LVLH (+Z geocentric nadir, +Y against the orbit normal).

    The rotations carry LVLH onto the body in the order yaw (Z), pitch (Y), roll (X), each about the
    axis already turned: NASA's 3-2-1 sequence.  They are the mean attitude, about which the carrier
    swings; on the ISS in torque equilibrium not 0/0/0 but -4/-2/1 deg or so, 177 for -4 when it
    flies backwards.  Each tenth of a degree by which it is wrong costs 0.7 km at 400 km.

    yaw_deg: first turn, about +Z.
    pitch_deg: second turn, about +Y as the first left it.
    roll_deg: third turn, about +X as the others left it.
    """

    law: Literal["lvlh"] = "lvlh"
    yaw_deg: Annotated[float, Within(-360.0, 360.0)] = 0.0
    pitch_deg: Annotated[float, Within(-360.0, 360.0)] = 0.0
    roll_deg: Annotated[float, Within(-360.0, 360.0)] = 0.0

    def q_law_body_from_eci(self, instants: Instants, states: OrbitStates) -> Rotation:
        """Attitude at the n instants of `states`."""
        yaw_pitch_roll_rad = np.deg2rad([self.yaw_deg, self.pitch_deg, self.roll_deg])
        q_body_from_lvlh = Rotation.from_euler("ZYX", yaw_pitch_roll_rad).inv()
        return q_body_from_lvlh * q_lvlh_from_eci(states.r_sat_eci_m, states.v_sat_eci_m_s)

    def law_warnings_at(self, instants: Instants) -> tuple[str, ...]:
        """None: how far the carrier swings about it stands in the pointing budget."""
        return ()

    def law_errors(self, instants: Instants) -> AttitudeErrors:
        """Of the mean, the swing about it, and what else the carrier does."""
        mean_rad = np.hypot(KNOWLEDGE_RAD, np.deg2rad(MEAN_SIGMA_DEG))
        return AttitudeErrors(
            np.hypot(mean_rad, REST_RAD),
            SWING_RMS_BODY_RAD,
            "measured: the ISS's swing about its mean attitude in torque equilibrium, of unknown "
            f"phase; the mean itself is assumed right to {MEAN_SIGMA_DEG:g} deg an axis",
            "the carrier's attitude telemetry (law harmonic)",
            REST_RAD,
        )
