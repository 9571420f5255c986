"""The view's parts of each kind of platform."""

from collections.abc import Callable

from planner.base.arrays import Indices
from planner.output.view.platforms.body import body_parts
from planner.output.view.platforms.parts import KindParts
from planner.output.view.platforms.two_axis import two_axis_parts
from planner.output.view.scene import PlanScene

PARTS: dict[str, Callable[[PlanScene, Indices, int], KindParts]] = {
    "two_axis": two_axis_parts,
    "body": body_parts,
}


def parts_of(scene: PlanScene, row: Indices, every: int) -> KindParts:
    """Of the scene's platform; row: those shown, every: of how many one is."""
    return PARTS[scene.plan.scenario.platform.kind](scene, row, every)
