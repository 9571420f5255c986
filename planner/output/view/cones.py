"""Margins of the boresight to each keep-out cone, and each cone's outline on the axes."""

import math
from collections.abc import Iterator

import numpy as np

from planner.base.arrays import Array, Indices, angle_rad, cross
from planner.base.rotation import Rotation
from planner.motion.pointing.angles import axis_angles, boresight_platform, within_stops
from planner.output.view.columns import ConeTrace
from planner.output.view.scene import PlanScene
from planner.world.targets import KeepOut

OUTLINES_MAX = 31  # instants; a page draws the one next to its cursor
OUTLINE_POINTS = 37  # every 10 deg around, the first again at the end


def cone_traces(scene: PlanScene) -> Iterator[ConeTrace]:
    """Of each cone of the scenario."""
    if not scene.plan.scenario.slew.keep_out:  # of axes alone
        return
    count = len(scene.rows.instants)
    outlined = np.unique(np.linspace(0, count - 1, min(count, OUTLINES_MAX)).round().astype(int))
    boresight = boresight_platform(
        scene.plan.scenario.two_axis, scene.plan.table.position[scene.rows.row]
    )
    axis_names = scene.plan.scenario.two_axis.axis_names
    for number, cone in enumerate(scene.plan.scenario.slew.keep_out):
        axis_platform, counts_rad = _axis(scene, cone)
        half_angle_rad = math.radians(cone.half_angle_deg)
        yield ConeTrace(
            number=number,
            about=cone.about,
            half_angle_rad=half_angle_rad,
            separation_rad=angle_rad(boresight, axis_platform),
            counts=tuple((counts_rad > 0.0).tolist()),
            outline_t_s=scene.rows.instants.t_s[outlined],
            outline_rad=dict(
                zip(
                    axis_names,
                    _outlines_rad(scene, axis_platform, half_angle_rad, outlined),
                    strict=True,
                )
            ),
        )


def _axis(scene: PlanScene, cone: KeepOut) -> tuple[Array, Array]:
    rows = scene.rows
    q_platform_from_eci = scene.plan.scenario.two_axis.q_platform_from_body * Rotation.from_quat(
        rows.q_body_from_eci_xyzw
    )
    return cone.axis_platform(rows.instants, rows.states, q_platform_from_eci)


def _outlines_rad(
    scene: PlanScene, axis_platform: Array, half_angle_rad: float, outlined: Indices
) -> Array:
    """Shape (2, k, 2, OUTLINE_POINTS): axes, instants, ways of pointing there, points around."""
    platform = scene.plan.scenario.two_axis
    axis = axis_platform[outlined]
    spare = np.eye(3)[np.abs(axis).argmin(axis=1)]
    first = cross(axis, spare)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    second = cross(axis, first)
    around = np.linspace(0.0, 2.0 * np.pi, OUTLINE_POINTS)[None, :, None]
    side = math.cos(half_angle_rad) * axis[:, None] + math.sin(half_angle_rad) * (
        np.cos(around) * first[:, None] + np.sin(around) * second[:, None]
    )
    both_rad = within_stops(platform, axis_angles(platform, side.reshape(-1, 3)).angle_rad)
    shaped = both_rad.reshape(2, len(outlined), OUTLINE_POINTS, 2)
    return np.asarray(shaped.transpose(3, 1, 0, 2))
