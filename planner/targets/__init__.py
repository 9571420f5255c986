"""Which target modes are known?"""

from typing import Annotated, get_args

from pydantic import Field

from planner.targets.apparent import VisibleTarget
from planner.targets.body import BodyTarget
from planner.targets.earth_fixed import EarthFixedTarget
from planner.targets.ground import GroundTarget
from planner.targets.ground_moving import MovingGroundTarget
from planner.targets.ground_path import GroundPathTarget
from planner.targets.keep_out import KeepOut
from planner.targets.sky import SkyTarget
from planner.targets.star import StarTarget
from planner.targets.test_motion import AxisMotion, BenchMotionTarget

Target = Annotated[
    GroundTarget
    | MovingGroundTarget
    | GroundPathTarget
    | StarTarget
    | BodyTarget
    | BenchMotionTarget,
    Field(discriminator="mode"),
]
TimedTarget = GroundPathTarget | BenchMotionTarget  # t = 0 is the session's start unless given
TARGETS = {mode.mode: mode for mode in get_args(get_args(Target)[0])}

__all__ = [
    "TARGETS",
    "AxisMotion",
    "BenchMotionTarget",
    "BodyTarget",
    "EarthFixedTarget",
    "GroundPathTarget",
    "GroundTarget",
    "KeepOut",
    "MovingGroundTarget",
    "SkyTarget",
    "StarTarget",
    "Target",
    "TimedTarget",
    "VisibleTarget",
]
