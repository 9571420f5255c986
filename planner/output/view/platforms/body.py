"""Margins of a body's exclusions and star trackers, and its gyros, at the rows of a view."""

from collections.abc import Iterator

import numpy as np

from planner.base.arrays import Indices
from planner.base.rotation import Rotation
from planner.output.view.columns import ExclusionTrace, GyroTrace
from planner.output.view.platforms.parts import KindParts
from planner.output.view.scene import PlanScene
from planner.world.exclusions import Surroundings, exclusion_margins
from planner.world.plan import FlightPlan
from planner.world.platforms import BodyPlatform


def body_parts(scene: PlanScene, row: Indices, every: int) -> KindParts:
    """Exclusions in the platform's order, the star trackers last."""
    return KindParts(exclusions=tuple(_exclusion_traces(scene)), gyros=_gyro_trace(scene.plan, row))


def _body_of(plan: FlightPlan) -> BodyPlatform:
    platform = plan.scenario.platform
    assert isinstance(platform, BodyPlatform)  # as the registry says
    return platform


def _gyro_trace(plan: FlightPlan, row: Indices) -> GyroTrace | None:
    gyros, columns_rad = _body_of(plan).gyros, plan.table.extra_rad
    if gyros is None or columns_rad is None:
        return None
    gimbal_rad, gimbal_rate_rad_s = np.hsplit(columns_rad[row], 2)
    array = gyros.array.cmg_array
    return GyroTrace(
        gimbal_rad=gimbal_rad,
        gimbal_rate_rad_s=gimbal_rate_rad_s,
        momentum_n_m_s=array.momentum(gimbal_rad),
        gimbal_rate_max_rad_s=array.rate_max_rad_s,
        momentum_max_n_m_s=gyros.turns.momentum_max_n_m_s,
    )


def _exclusion_traces(scene: PlanScene) -> Iterator[ExclusionTrace]:
    platform = _body_of(scene.plan)
    q_eci_from_body = Rotation.from_quat(scene.rows.q_body_from_eci_xyzw).inv()
    surroundings = Surroundings(scene.instants, scene.states)
    for margin in exclusion_margins(platform, q_eci_from_body, surroundings):
        yield ExclusionTrace(
            name=margin.name,
            away_from=margin.title,
            imaging_only=margin.imaging_only,
            margin_rad=margin.margin_rad,
        )
