"""Margins of the boresight to each mask, and each mask's outline on the axes."""

import math
from collections.abc import Iterator

import numpy as np

from planner.base.arrays import Array, Indices, angle_rad
from planner.motion.pointing.angles import axis_angles, boresight_platform, within_stops
from planner.output.view.columns import MaskTrace
from planner.world.plan import FlightPlan
from planner.world.platforms import FieldMask

_STEP_RAD = math.radians(2.0)  # a great circle bends on the axes


def mask_traces(plan: FlightPlan, row: Indices) -> Iterator[MaskTrace]:
    """Of each mask, at these rows of the table."""
    if not plan.scenario.platform.masks:  # of axes alone
        return
    platform = plan.scenario.two_axis
    boresight = boresight_platform(platform, plan.table.position[row])
    for number, mask in enumerate(platform.masks):
        outline_platform = _outline_platform(mask)
        outline_rad = within_stops(platform, axis_angles(platform, outline_platform).angle_rad)
        yield MaskTrace(
            number=number,
            name=mask.name,
            asked_rad=mask.margin_rad,
            away_rad=-mask.polygon.depth_rad(boresight),
            outline_platform=outline_platform,
            outline_rad={
                name: outline_rad[..., axis] for axis, name in enumerate(platform.axis_names)
            },
        )


def _outline_platform(mask: FieldMask) -> Array:
    """Along its sides in steps of at most _STEP_RAD, (m, 3)."""
    corners = mask.polygon.corner_directions
    nexts = np.roll(corners, -1, axis=0)
    points = [corners[:1]]
    for first, second, side_rad in zip(corners, nexts, angle_rad(corners, nexts), strict=True):
        steps = math.ceil(side_rad / _STEP_RAD)
        along_rad = np.linspace(0.0, side_rad, steps + 1)[1:, None]
        points.append(
            (np.sin(side_rad - along_rad) * first + np.sin(along_rad) * second) / np.sin(side_rad)
        )
    return np.concatenate(points)
