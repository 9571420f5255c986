"""A polygon on the sphere cut into convex ones."""

from collections.abc import Iterator
from functools import lru_cache

import numpy as np

from planner.base.arrays import Array
from planner.world.platforms.spherical_polygon import (
    OPTIONS as POLYGON_OPTIONS,
)
from planner.world.platforms.spherical_polygon import (
    SphericalPolygon,
    polygon_to_the_left,
    seen_on_plane,
)

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
    rings = _cut(p, tuple(range(len(p))))
    return tuple(polygon_to_the_left(polygon.corner_directions[list(ring)]) for ring in rings)


def _cut(p: Array, ring: Ring) -> list[Ring]:
    reflex = [
        k for k in range(len(ring)) if _turn(p, *_around(ring, k)) < -POLYGON_OPTIONS.straight
    ]
    if not reflex:
        return [ring]
    begin = reflex[0]
    turned = ring[begin:] + ring[:begin]
    before, corner, after = turned[-1], turned[0], turned[1]

    def price(k: int) -> tuple[bool, float]:
        leaves_reflex = (
            _turn(p, turned[k], corner, after) < 0.0 or _turn(p, before, corner, turned[k]) < 0.0
        )
        return leaves_reflex, float(np.linalg.norm(p[turned[k]] - p[corner]))

    k = min(_diagonals(p, turned), key=price)
    return _cut(p, turned[: k + 1]) + _cut(p, (corner, *turned[k:]))


def _diagonals(p: Array, ring: Ring) -> Iterator[int]:
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
