"""The target modes."""

from typing import TYPE_CHECKING, Annotated, Union, get_args

from pydantic import Field

from planner.world.targets.apparent import VisibleTarget
from planner.world.targets.bench_motion import BenchMotionTarget, PrescribedMotion
from planner.world.targets.body import BodyTarget
from planner.world.targets.earth_fixed import EarthFixedTarget
from planner.world.targets.ground import GroundTarget
from planner.world.targets.ground_moving import MovingGroundTarget
from planner.world.targets.ground_path import GroundPathTarget
from planner.world.targets.imaging import IMAGING_MODES, ImagingMode, ScanWindow
from planner.world.targets.place import PlaceTarget
from planner.world.targets.session_target import SessionTarget
from planner.world.targets.sky import SkyTarget
from planner.world.targets.star import StarTarget
from planner.world.targets.station import StationTarget

Target = Annotated[
    GroundTarget
    | PlaceTarget
    | MovingGroundTarget
    | GroundPathTarget
    | StationTarget
    | StarTarget
    | BodyTarget
    | BenchMotionTarget,
    Field(discriminator="mode"),
]
TARGETS = {mode.mode: mode for mode in get_args(get_args(Target)[0])}
if TYPE_CHECKING:
    AskedTarget = Target
    ChosenTarget = Target | ImagingMode
else:
    # What a request may name: imaging modes become paths.
    AskedTarget = Annotated[
        Union[(*TARGETS.values(), *IMAGING_MODES.values())],
        Field(discriminator="mode"),
    ]
    # Those that can be seen at times of their own.
    _WITH_WINDOWS = tuple(mode for mode in TARGETS.values() if mode.has_windows)
    # What a campaign chooses among, and windows are searched for.
    ChosenTarget = Annotated[
        Union[(*_WITH_WINDOWS, *IMAGING_MODES.values())], Field(discriminator="mode")
    ]

__all__ = [
    "IMAGING_MODES",
    "TARGETS",
    "AskedTarget",
    "BenchMotionTarget",
    "BodyTarget",
    "ChosenTarget",
    "EarthFixedTarget",
    "GroundPathTarget",
    "GroundTarget",
    "ImagingMode",
    "MovingGroundTarget",
    "PlaceTarget",
    "PrescribedMotion",
    "ScanWindow",
    "SessionTarget",
    "SkyTarget",
    "StarTarget",
    "StationTarget",
    "Target",
    "VisibleTarget",
]
