"""The caps that stand for cones and masks at each instant of a programme.

A cone is one.  A mask's region is cut into convex parts, and between two instants the path stays
out of the smallest cap that holds a part and touches it where the path comes nearest: both
instants must be outside.  As caps hold their parts, what keeps out of them keeps out of the mask,
as far as the path is straight between instants; as they touch where the path was, the path itself
is one way to keep out, so that caps may be taken from it again and again, each time for less.
"""

from collections.abc import Iterator
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from planner.base import effort
from planner.base.arrays import Array
from planner.motion.detour.ocp import Caps
from planner.motion.pointing.keep_out import KeepOutView
from planner.world.platforms.spherical_polygon import (
    OPTIONS as POLYGON_OPTIONS,
)
from planner.world.platforms.spherical_polygon import (
    SphericalPolygon,
    polygon_to_the_left,
    seen_on_plane,
)

# A polygon on the sphere cut into convex ones.

Ring = tuple[int, ...]  # corners by number, counter-clockwise; p: where they are on a plane


@lru_cache(maxsize=64)
def convex_parts(polygon: SphericalPolygon) -> tuple[SphericalPolygon, ...]:
    """Convex polygons that make it up and don't overlap; itself where it is convex.

    Every cut is a diagonal from a reflex corner, where there is one such that leaves the corner
    convex on both sides, and the shortest of these.
    """
    if not polygon.is_reflex.any():
        return (polygon,)
    p = seen_on_plane(polygon.corner_directions, polygon.middle_direction)
    rings = _cut_convex(p, tuple(range(len(p))))
    return tuple(polygon_to_the_left(polygon.corner_directions[list(ring)]) for ring in rings)


def _cut_convex(p: Array, ring: Ring) -> list[Ring]:
    reflex = [
        k for k in range(len(ring)) if _turn(p, *_around(ring, k)) < -POLYGON_OPTIONS.straight
    ]
    if not reflex:
        return [ring]
    begin = reflex[0]
    turned = ring[begin:] + ring[:begin]
    before, corner, after = turned[-1], turned[0], turned[1]

    def cut_price(k: int) -> tuple[bool, float]:
        leaves_reflex = (
            _turn(p, turned[k], corner, after) < 0.0 or _turn(p, before, corner, turned[k]) < 0.0
        )
        return leaves_reflex, float(np.linalg.norm(p[turned[k]] - p[corner]))

    k = min(_find_diagonals(p, turned), key=cut_price)
    return _cut_convex(p, turned[: k + 1]) + _cut_convex(p, (corner, *turned[k:]))


def _find_diagonals(p: Array, ring: Ring) -> Iterator[int]:
    """Places of corners that the first one, a reflex one, sees across the inside."""
    before, corner, after = ring[-1], ring[0], ring[1]
    for k in range(2, len(ring) - 1):
        to = ring[k]
        leads_out = _turn(p, corner, to, after) >= 0.0 and _turn(p, to, corner, before) >= 0.0
        sides = zip(ring, ring[1:] + ring[:1], strict=True)
        if not leads_out and not any(
            _meet(p, corner, to, *side) for side in sides if corner not in side and to not in side
        ):
            yield k


def _around(ring: Ring, k: int) -> tuple[int, int, int]:
    return ring[k - 1], ring[k], ring[(k + 1) % len(ring)]


def _turn(p: Array, a: int, b: int, c: int) -> float:
    """Sine of the turn to the left at b, on the way from a to c."""
    first, second = p[b] - p[a], p[c] - p[b]
    across = first[0] * second[1] - first[1] * second[0]
    return float(across / np.hypot(*first) / np.hypot(*second))


def _meet(p: Array, a: int, b: int, c: int, d: int) -> bool:
    """Whether the line from a to b meets that from c to d, its ends included."""
    parted = _turn(p, a, b, c) * _turn(p, a, b, d) <= 0.0
    return parted and _turn(p, c, d, a) * _turn(p, c, d, b) <= 0.0


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
    """Caps of the cones at t_s; margins_rad: (cones, n), kept beside each half angle."""
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
    """Caps of the masks at n instants.

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
