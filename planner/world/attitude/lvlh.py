"""A constant attitude to the local vertical."""

import math
from dataclasses import dataclass
from datetime import datetime
from typing import Annotated, Literal

import numpy as np

from planner.base.arrays import Array
from planner.base.errors import OutsideCoverage
from planner.base.rotation import Rotation
from planner.base.spec import Within, spec
from planner.world.attitude.correctable import CorrectableAttitude
from planner.world.attitude.errors import (
    KNOWLEDGE_RAD,
    MEAN_SIGMA_DEG,
    REST_MEMORY_S,
    REST_RAD,
    AttitudeErrors,
)
from planner.world.frames.local_orbital import q_lvlh_from_eci
from planner.world.frames.time_scales import Instants, elapsed_s, require_known, utc_text
from planner.world.orbits import OrbitStates

# Rms of the sinusoid at the orbital rate in which the ISS swings about its mean in torque
# equilibrium on 2018-10-12, about body x, y, z (bench/attitude_figures.py of commit 54f03d3).
SWING_RMS_BODY_RAD = np.deg2rad([0.234, 0.0126, 0.0065])


@dataclass(frozen=True, kw_only=True)
class SettlingFigures:
    """How the ISS wanders about its mean attitude after a manoeuvre, before torque equilibrium.

    The only one recorded, a half turn about yaw on 2018-10-12 that ended at 00:33, and 4.4 h after
    it (bench/truth.py).
    """

    # rms about body x, y, z as it ends, which falls as exp(-(time since / scale)^2)
    rms_body_rad: tuple[float, float, float] = (0.0, math.radians(0.9), math.radians(2.0))
    scale_s: tuple[float, float, float] = (3600.0, 10800.0, 2520.0)
    memory_s: float = 1500.0  # pitch changes by half its wander in so long
    settled_s: float = 8.0 * 3600.0  # beyond, less than 0.001 deg is left


SETTLING = SettlingFigures()


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
    manoeuvre_end: end of the carrier's last turn from another attitude, if it was less than some
    hours ago: until it is in torque equilibrium again it wanders about the mean. E.g.
    `"2015-02-27T15:30:00Z"`.
    """

    law: Literal["lvlh"] = "lvlh"
    yaw_deg: Annotated[float, Within(-360.0, 360.0)] = 0.0
    pitch_deg: Annotated[float, Within(-360.0, 360.0)] = 0.0
    roll_deg: Annotated[float, Within(-360.0, 360.0)] = 0.0
    manoeuvre_end: datetime | None = None

    def __post_init__(self) -> None:
        if self.manoeuvre_end is None:
            return
        try:
            require_known(self.manoeuvre_end)
        except ValueError as error:
            raise ValueError(f"manoeuvre_end {error}") from None
        for number, one in enumerate(self.corrections):
            if elapsed_s(one.epoch, self.manoeuvre_end) < 0.0:
                raise ValueError(
                    f"corrections.{number}.epoch {utc_text(one.epoch, 0)} lies before the "
                    f"manoeuvre_end {utc_text(self.manoeuvre_end, 0)}: what was measured before a "
                    "manoeuvre says nothing of the attitude after it; leave it out"
                )

    @property
    def is_level(self) -> bool:
        """Whether it is the local orbital frame itself, as no station flies."""
        return self.yaw_deg == self.pitch_deg == self.roll_deg == 0.0

    def q_law_body_from_eci(self, instants: Instants, states: OrbitStates) -> Rotation:
        """Attitude at the n instants of `states`; OutsideCoverage before the manoeuvre's end."""
        self._since_manoeuvre_s(instants)
        yaw_pitch_roll_rad = np.deg2rad([self.yaw_deg, self.pitch_deg, self.roll_deg])
        q_body_from_lvlh = Rotation.from_euler("ZYX", yaw_pitch_roll_rad).inv()
        return q_body_from_lvlh * q_lvlh_from_eci(states.r_sat_eci_m, states.v_sat_eci_m_s)

    def law_warnings_at(self, instants: Instants) -> tuple[str, ...]:
        """That the carrier is not yet in torque equilibrium."""
        since_s = self._since_manoeuvre_s(instants)
        wander_deg = float(np.rad2deg(np.max(_wander_rms_body_rad(since_s))))
        if not wander_deg > MEAN_SIGMA_DEG:
            return ()
        return (
            f"the carrier's manoeuvre ended {np.min(since_s) / 3600.0:.1f} h before: the ISS "
            "is not yet in torque equilibrium then and wanders about its mean attitude by "
            f"{wander_deg:.2g} deg (1 sigma; in pitch by 0.1 deg still after 4.4 h)",
        )

    def law_errors(self, instants: Instants) -> AttitudeErrors:
        """Errors of the mean, the swing about it, and what else the carrier does."""
        mean_rad = np.hypot(KNOWLEDGE_RAD, np.deg2rad(MEAN_SIGMA_DEG))
        since_s = self._since_manoeuvre_s(instants)
        forgotten_rad = np.hypot(REST_RAD, _wander_rms_body_rad(since_s))
        unsettled = bool(np.min(since_s) < SETTLING.settled_s)
        return AttitudeErrors(
            np.hypot(mean_rad, forgotten_rad),
            SWING_RMS_BODY_RAD,
            "measured: the ISS's swing about its mean attitude in torque equilibrium, of unknown "
            f"phase{', and its wander after a manoeuvre' if unsettled else ''}; the mean itself is "
            f"assumed right to {MEAN_SIGMA_DEG:g} deg an axis",
            "the carrier's attitude telemetry (law harmonic)",
            forgotten_rad,
            SETTLING.memory_s if unsettled else REST_MEMORY_S,
        )

    def _since_manoeuvre_s(self, instants: Instants) -> Array:
        """Shape (n,), infinite where there was none; OutsideCoverage before its end."""
        if self.manoeuvre_end is None:
            return np.full(len(instants), np.inf)
        since_s = instants.since_s(self.manoeuvre_end)
        early = int(np.argmin(since_s))
        if since_s[early] < 0.0:
            raise OutsideCoverage(
                f"the attitude is needed from {utc_text(instants.utc(early), 0)}, before the "
                f"manoeuvre's end {utc_text(self.manoeuvre_end, 0)}; begin after it, or give the "
                "manoeuvre's attitudes (law aem)",
                field="attitude.manoeuvre_end",
                at_utc=instants.utc(early),
            )
        return np.asarray(since_s)


def _wander_rms_body_rad(since_s: Array) -> Array:
    """Shape (n, 3)."""
    share = np.exp(-((since_s[:, None] / SETTLING.scale_s) ** 2))
    return np.asarray(SETTLING.rms_body_rad * share)


def level_warnings(
    attitude: object, platform: str, usual_deg: tuple[float, float, float] | None
) -> tuple[str, ...]:
    """That 0/0/0 is not how a platform's carrier flies, where its usual attitude is known."""
    if usual_deg is None or not (isinstance(attitude, LvlhAttitude) and attitude.is_level):
        return ()
    off_deg = math.degrees(Rotation.from_euler("ZYX", usual_deg, degrees=True).magnitude())
    return (
        f"the carrier of {platform} usually flies at yaw/pitch/roll "
        f"{'/'.join(f'{angle:g}' for angle in usual_deg)} deg, {off_deg:.1f} deg from the 0/0/0 of "
        "attitude (7 km on the ground for each, from 400 km): state its mean attitude in yaw_deg, "
        "pitch_deg and roll_deg",
    )
