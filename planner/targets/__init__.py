"""Which target modes are known?"""

from typing import get_args

from planner.targets.apparent import VisibleTarget
from planner.targets.earth_fixed import EarthFixedTarget
from planner.targets.ground import GroundTarget

Target = GroundTarget
TARGETS = {mode.mode: mode for mode in (get_args(Target) or (Target,))}

__all__ = ["TARGETS", "EarthFixedTarget", "GroundTarget", "Target", "VisibleTarget"]
