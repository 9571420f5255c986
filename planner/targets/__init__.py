"""The target modes."""

from typing import TYPE_CHECKING, Annotated, Union, get_args

from pydantic import Field

from planner.targets.apparent import VisibleTarget
from planner.targets.bench_motion import AxisMotion, BenchMotionTarget
from planner.targets.body import BodyTarget
from planner.targets.earth_fixed import EarthFixedTarget
from planner.targets.ground import GroundTarget
from planner.targets.ground_moving import MovingGroundTarget
from planner.targets.ground_path import GroundPathTarget
from planner.targets.keep_out import KeepOut
from planner.targets.place import PlaceTarget
from planner.targets.session_target import SessionTarget
from planner.targets.sky import SkyTarget
from planner.targets.star import StarTarget

Target = Annotated[
    GroundTarget
    | PlaceTarget
    | MovingGroundTarget
    | GroundPathTarget
    | StarTarget
    | BodyTarget
    | BenchMotionTarget,
    Field(discriminator="mode"),
]
TARGETS = {mode.mode: mode for mode in get_args(get_args(Target)[0])}
if TYPE_CHECKING:
    WindowTarget = Target
else:
    # Those that can be seen at times of their own.
    _WITH_WINDOWS = tuple(mode for mode in TARGETS.values() if mode.has_windows)
    WindowTarget = Annotated[Union[_WITH_WINDOWS], Field(discriminator="mode")]  # noqa: UP007 (of a tuple)

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
    "PlaceTarget",
    "SessionTarget",
    "SkyTarget",
    "StarTarget",
    "Target",
    "VisibleTarget",
    "WindowTarget",
]
