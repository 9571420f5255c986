"""The end of a command table, in the members of an initial state that begins there."""

from datetime import datetime
from typing import Any

import numpy as np

from planner.base.arrays import Array
from planner.base.commands import COMMAND_STEP_S, CommandTable
from planner.base.rotation import Rotation
from planner.world.frames.time_scales import elapsed_s, shifted_utc
from planner.world.platforms import BodyPlatform
from planner.world.rules.body import BodyRules
from planner.world.rules.two_axis import TwoAxisRules
from planner.world.scenario import Scenario


def end_of_table(table: CommandTable) -> tuple[datetime, dict[str, Any], dict[str, Any]]:
    """When it ends, where the platform is then, and how it moves; empty where it rests.

    The acceleration of axes is that of the cubic flown between the last two rows.
    """
    end_utc, rate_rad_s = shifted_utc(table.epoch_utc, float(table.t_s[-1])), table.rate_rad_s[-1]
    if table.acceleration_rad_s2 is None:
        before_rad, angle_rad = table.position[-2:]
        acceleration_rad_s2 = (
            6.0 * (before_rad - angle_rad) / COMMAND_STEP_S
            + 2.0 * table.rate_rad_s[-2]
            + 4.0 * rate_rad_s
        ) / COMMAND_STEP_S
        names = TwoAxisRules.state_members
        told: list[Any] = [
            dict(zip(table.dof_names, _degrees(column), strict=True))
            for column in (angle_rad, rate_rad_s, acceleration_rad_s2)
        ]
    else:
        names = BodyRules.state_members
        q_body_from_eci = Rotation.from_quat(table.position[-1]).inv()
        told = [
            np.round(q_body_from_eci.as_quat(), 13).tolist(),
            _degrees(rate_rad_s),
            _degrees(table.acceleration_rad_s2[-1]),
        ]
    members = dict(zip(names, told, strict=True))
    position = {names[0]: members.pop(names[0])}
    # In a day such a rate would turn it by 0.00001 deg.
    rests = np.abs(np.rad2deg(rate_rad_s)).max() <= 1e-10
    return end_utc, position, {} if rests else members


def waits_from(before: Scenario, end_utc: datetime, later: Scenario) -> bool:
    """Whether `later` begins when the plan of `before` has ended, with what waits meanwhile.

    later: beginning on its idle attitude, which then must be the law that the earlier plan ended
    on, or with a position that rests.
    """
    ended, platform, start = before.platform, later.platform, later.initial_state
    is_over = elapsed_s(start.epoch, end_utc) >= 0.0
    if isinstance(ended, BodyPlatform) and start.q_body_from_eci_xyzw is None:
        return is_over and isinstance(platform, BodyPlatform) and ended.idle == platform.idle
    return is_over


def _degrees(column_rad: Array) -> list[float]:
    degrees: list[float] = np.round(np.rad2deg(column_rad), 12).tolist()
    return degrees
