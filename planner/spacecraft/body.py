"""The imaging spacecraft as a platform of kind body, within the settings of a session."""

import math
from dataclasses import dataclass, replace

import numpy as np

from planner.base.errors import InfeasibleSlew
from planner.spacecraft.vehicle.definition import AgileSpacecraft
from planner.world.platforms import BodyPlatform
from planner.world.platforms.agile_cmg import AGILE_CMG
from planner.world.platforms.gyros import GyroSet, GyroTurns, ScissoredPairs


@dataclass(frozen=True, kw_only=True)
class BodyOptions:
    """What the gyros keep for other things than turns."""

    # what the body holds on its idle attitude, and gravity's torque gives in an hour
    other_n_m_s: float = 4.0
    rate_least_deg_s: float = 0.1  # the idle attitude turns at 0.06


OPTIONS = BodyOptions()


def body_of(
    spacecraft: AgileSpacecraft, stored_n_m_s: tuple[float, float, float] = (0.0, 0.0, 0.0)
) -> BodyPlatform:
    """Its gyros, its turns and its camera.

    stored_n_m_s: in the gyros at the start, body axes; it lowers the rate of turns, about any
    axis, to what there is room for.  Raises InfeasibleSlew where no rate is left.
    """
    stored = math.hypot(*stored_n_m_s)
    slew, camera = spacecraft.slew, spacecraft.camera
    room_n_m_s = slew.momentum_sphere_n_m_s - stored - OPTIONS.other_n_m_s
    rate_deg_s = math.degrees(
        min(
            slew.rate_axis_rad_s,
            slew.rate_rad_s / math.sqrt(3.0),
            room_n_m_s / math.hypot(*spacecraft.inertia_kg_m2),
        )
    )
    if rate_deg_s < OPTIONS.rate_least_deg_s:
        raise InfeasibleSlew(
            f"the gyros store {stored:.1f} N m s at the start, which leaves no room "
            f"to turn in the {slew.momentum_sphere_n_m_s:.0f} N m s sphere they are steered in; "
            "unload momentum first",
            field="settings.momentum_n_m_s",
            limit="momentum",
        )
    along, across = np.tan(np.deg2rad([camera.along_max_deg, camera.across_max_deg]))
    array = spacecraft.array
    x, y, z = spacecraft.inertia_kg_m2
    line = AGILE_CMG.camera
    assert line.type == "pushbroom"  # as of the file
    return replace(
        AGILE_CMG,
        name=spacecraft.name,
        inertia_kg_m2=((x, 0.0, 0.0), (0.0, y, 0.0), (0.0, 0.0, z)),
        off_nadir_max_deg=min(math.degrees(math.atan(math.hypot(along, across))) + 0.5, 90.0),
        camera=replace(line, both_ways=camera.reversible, tdi_lines=camera.tdi_lines),
        gyros=GyroSet(
            array=ScissoredPairs(
                rotor_n_m_s=array.momentum_n_m_s,
                gimbal_rate_max_deg_s=math.degrees(array.rate_max_rad_s),
            ),
            turns=GyroTurns(
                rate_max_deg_s=rate_deg_s,
                torque_max_n_m=slew.torque_n_m,
                torque_rate_max_n_m_s=slew.torque_rate_n_m_s,
                momentum_max_n_m_s=slew.momentum_sphere_n_m_s,
                settle_s=slew.settle_s,
            ),
            start_n_m_s=stored_n_m_s,
        ),
    )
