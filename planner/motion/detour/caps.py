"""The caps that stand for cones and masks at each instant of a programme.

A cone is one.  A mask's region is cut into convex parts, and between two instants the path stays
out of the smallest cap that holds a part and touches it where the path comes nearest: both
instants must be outside.  As caps hold their parts, what keeps out of them keeps out of the mask,
as far as the path is straight between instants; as they touch where the path was, the path itself
is one way to keep out, so that caps may be taken from it again and again, each time for less.
"""

from typing import NamedTuple

import numpy as np

from planner.base import effort
from planner.base.arrays import Array
from planner.motion.detour.convex_parts import convex_parts
from planner.motion.detour.ocp import Caps
from planner.motion.pointing.keep_out import KeepOutView
from planner.world.platforms.spherical_polygon import SphericalPolygon

PARTS_AT_ONCE = 3  # of masks, nearest to the path, kept out of at an instant
LOOKS = 4  # at the path between two instants
LOOK = 0.07  # of `effort`, for each part


class MaskPart(NamedTuple):
    """polygon: convex.  region: the mask's number in `KeepOutView.regions`."""

    polygon: SphericalPolygon
    region: int
    margin_rad: float


def mask_parts(view: KeepOutView) -> tuple[MaskPart, ...]:
    """Convex parts of all masks."""
    return tuple(
        MaskPart(polygon, number, mask.margin_rad)
        for number, mask in enumerate(view.masks, start=len(view.cones))
        for polygon in convex_parts(mask.polygon)
    )


def cap_count(view: KeepOutView, parts: tuple[MaskPart, ...]) -> int:
    """How many caps are kept out of at an instant: between it and the ones before and after."""
    return len(view.cones) + 2 * min(len(parts), PARTS_AT_ONCE)


def cone_caps(view: KeepOutView, t_s: Array, margins_rad: Array) -> Caps:
    """Of the cones at t_s; margins_rad: (cones, n), kept beside each half angle."""
    axes, counts = [], []
    for cone in view.cones:
        axis, is_counting = cone.at(t_s)
        axes.append(axis)
        counts.append(is_counting)
    half_angle = np.array([[cone.half_angle_rad] for cone in view.cones])
    return Caps(np.stack(axes), half_angle + margins_rad, np.stack(counts))


def look_tau(tau: Array) -> Array:
    """When the path is looked at, (n + 1, looks): within each pair of instants and both ends."""
    edges = np.concatenate([[0.0], tau, [1.0]])
    return edges[:-1, None] + np.diff(edges)[:, None] * np.linspace(0.0, 1.0, LOOKS + 1)


def mask_caps(parts: tuple[MaskPart, ...], boresight_platform: Array, margins_rad: Array) -> Caps:
    """Of the masks at n instants.

    boresight_platform: of the path so far, unit vectors (n + 1, looks, 3) at `look_tau`.
    margins_rad: (regions, n), kept beside each mask's own margin.
    """
    between, looks, _ = boresight_platform.shape
    effort.charge(LOOK * between * looks * len(parts))
    flat = boresight_platform.reshape(-1, 3)
    depth = np.stack([part.polygon.depth_rad(flat) + part.margin_rad for part in parts])
    depth = depth.reshape(len(parts), between, looks)
    deepest_look = np.argmax(depth, axis=2)
    nearest = np.argsort(-depth.max(axis=2), axis=0, kind="stable")[:PARTS_AT_ONCE]
    axis, half_angle = np.empty((*nearest.shape, 3)), np.empty(nearest.shape)
    for number, part in enumerate(parts):
        cap, interval = np.nonzero(nearest == number)
        near = boresight_platform[interval, deepest_look[number, interval]]
        axis[cap, interval], touching_rad = _touching_cap(part.polygon, near)
        half_angle[cap, interval] = touching_rad + part.margin_rad
    region = np.array([part.region for part in parts])[nearest]
    instant = np.arange(between - 1)
    return Caps(
        np.concatenate([axis[:, :-1], axis[:, 1:]]),
        np.concatenate(
            [
                half_angle[:, :-1] + margins_rad[region[:, :-1], instant],
                half_angle[:, 1:] + margins_rad[region[:, 1:], instant],
            ]
        ),
        np.ones((2 * len(nearest), between - 1), dtype=bool),
    )


def _touching_cap(polygon: SphericalPolygon, directions: Array) -> tuple[Array, Array]:
    """Axis (n, 3) and half angle (n,) of the smallest cap that holds a convex polygon and touches
    it where each of n unit vectors is nearest to it.

    A cap of half angle r that touches at p, where it is left along t, has the axis
    p cos r - t sin r, and holds a corner v where tan r >= (1 - p v) / (-t v).
    """
    boundary = polygon.nearest_boundary(directions)
    rise = np.maximum(1.0 - boundary.point_directions @ polygon.corner_directions.T, 0.0)
    behind = np.maximum(-boundary.outward_directions @ polygon.corner_directions.T, 0.0)
    half_angle = np.arctan2(rise, behind).max(axis=1)
    cosine, sine = np.cos(half_angle)[:, None], np.sin(half_angle)[:, None]
    return cosine * boundary.point_directions - sine * boundary.outward_directions, half_angle
