"""Margins of a body's exclusions and star trackers at the rows of a view."""

from collections.abc import Iterator

from planner.base.arrays import Indices
from planner.base.rotation import Rotation
from planner.output.view.columns import ExclusionTrace
from planner.output.view.platforms.parts import KindParts
from planner.output.view.scene import PlanScene
from planner.world.exclusions import Surroundings, exclusion_margins
from planner.world.platforms import BodyPlatform


def body_parts(scene: PlanScene, row: Indices, every: int) -> KindParts:
    """Exclusions in the platform's order, the star trackers last."""
    return KindParts(exclusions=tuple(_exclusion_traces(scene)))


def _exclusion_traces(scene: PlanScene) -> Iterator[ExclusionTrace]:
    platform = scene.plan.scenario.platform
    assert isinstance(platform, BodyPlatform)  # as the registry says
    q_eci_from_body = Rotation.from_quat(scene.rows.q_body_from_eci_xyzw).inv()
    surroundings = Surroundings(scene.instants, scene.states)
    for margin in exclusion_margins(platform, q_eci_from_body, surroundings):
        yield ExclusionTrace(
            name=margin.name,
            away_from=margin.title,
            imaging_only=margin.imaging_only,
            margin_rad=margin.margin_rad,
        )
