"""A region of directions whose sides are great-circle arcs: how deep in it a direction lies."""

import math
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations

import numpy as np

from planner.base.arrays import Array, Indices, Mask, cross


@dataclass(frozen=True, kw_only=True)
class PolygonOptions:
    """Which polygons on the sphere can be told inside from outside."""

    # of a polygon from its middle: clearly less than a hemisphere
    reach_max_rad: float = math.radians(85.0)
    width_min_rad: float = math.radians(0.01)  # from a corner to any side that it is no end of
    straight: float = 1e-9  # sine of the turn at a corner that is none


OPTIONS = PolygonOptions()


@dataclass(frozen=True, eq=False)
class NearestBoundary:
    """The boundary's point nearest to each of n directions.

    depth_rad: (n,), distance from it, positive inside.  point_directions: itself,
    (n, 3).  outward_directions: unit tangents there, (n, 3), along which the region is left.
    """

    depth_rad: Array
    point_directions: Array
    outward_directions: Array


@dataclass(frozen=True, eq=False)
class SphericalPolygon:
    """A simple polygon, smaller than a hemisphere.

    corner_directions: unit vectors (m, 3); the inside lies on the left of each side, seen from
    outside the sphere.  normals: (m, 3), of the side from each corner to the next, pointing
    inside.  is_reflex: (m,), where the inside takes more than half a turn.  middle_direction,
    reach_rad: the smallest cap that holds all of it.
    """

    corner_directions: Array
    normals: Array
    is_reflex: Mask
    middle_direction: Array
    reach_rad: float

    def depth_rad(self, directions: Array) -> Array:
        """How far inside unit vectors (n, 3) are, along the sphere; negative outside.

        Exact but for rounding.
        """
        return self._nearest_side(directions)[0]

    def nearest_boundary(self, directions: Array) -> NearestBoundary:
        """The boundary nearest to unit vectors (n, 3)."""
        depth, place, is_corner = self._nearest_side(directions)
        normal = self.normals[place]
        foot = unit(directions - np.sum(directions * normal, axis=1, keepdims=True) * normal)
        at = np.where(is_corner[:, None], self.corner_directions[place], foot)
        along = directions - np.sum(directions * at, axis=1, keepdims=True) * at
        along *= -np.sign(depth)[:, None]
        on_corner = np.linalg.norm(along, axis=1, keepdims=True) < OPTIONS.straight
        along = np.where(on_corner, -(normal + self.normals[place - 1]), along)
        outward = np.where(is_corner[:, None], along, -normal)
        return NearestBoundary(depth, at, unit(outward))

    @cached_property
    def side_parameters(self) -> Array:
        """As compiled code takes them, (m, 13)."""
        corner, following = self.corner_directions, np.roll(self.corner_directions, -1, axis=0)
        planes = cross(self.normals, corner), cross(following, self.normals)
        columns = (corner, self.normals, *planes, self.is_reflex[:, None])
        return np.concatenate(columns, axis=1, dtype=np.float64)

    def _nearest_side(self, directions: Array) -> tuple[Array, Indices, Mask]:
        # Numba takes 0.2 s to import, which only work should pay.
        from planner.world.platforms.polygon_kernel import nearest_sides

        return nearest_sides(self.side_parameters, np.array(directions, np.float64, order="C"))


def spherical_polygon(corner_directions: Array) -> SphericalPolygon:
    """Build it from unit vectors (m, 3) in either order, m >= 3; its inside is the smaller side.

    Raises ValueError where it is no simple polygon, is anywhere narrower than 0.01 deg, or
    reaches 85 deg from its middle.
    """
    middle, reach_rad = _smallest_cap(corner_directions)
    if not reach_rad < OPTIONS.reach_max_rad:
        raise ValueError(
            f"must stay within {math.degrees(OPTIONS.reach_max_rad):g} deg of their middle, so "
            f"that it is clear which side is inside, not reach {math.degrees(reach_rad):.1f} deg; "
            "split the region into polygons that overlap"
        )
    _require_simple(corner_directions)
    x, y = seen_on_plane(corner_directions, middle).T
    if np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)) < 0.0:
        corner_directions = corner_directions[::-1]
    return polygon_to_the_left(corner_directions)


def polygon_to_the_left(corner_directions: Array) -> SphericalPolygon:
    """Build a simple polygon from its corners, its inside on the left of its sides."""
    middle, reach_rad = _smallest_cap(corner_directions)
    normals = _side_normals(corner_directions)
    bends = np.sum(np.roll(normals, 1, axis=0) * np.roll(corner_directions, -1, axis=0), axis=1)
    return SphericalPolygon(
        corner_directions=corner_directions,
        normals=normals,
        is_reflex=bends < -OPTIONS.straight,
        middle_direction=middle,
        reach_rad=reach_rad,
    )


def unit(directions: Array) -> Array:
    """Vectors (n, 3) of any length, divided by it."""
    return np.asarray(directions / np.linalg.norm(directions, axis=1, keepdims=True))


def seen_on_plane(corner_directions: Array, middle_direction: Array) -> Array:
    """Project from the sphere's centre on a plane across the middle, (m, 2): arcs become straight.

    Counter-clockwise is what is so seen from outside the sphere.
    """
    middle = middle_direction
    first = np.cross(middle, np.eye(3)[np.argmin(np.abs(middle))])
    axes = np.stack([first, np.cross(middle, first)], axis=1) / np.linalg.norm(first)
    return np.asarray(corner_directions @ axes / (corner_directions @ middle)[:, None])


def _smallest_cap(corner_directions: Array) -> tuple[Array, float]:
    """Middle and radius of the smallest cap that holds the corners: two or three lie on its edge.

    A radius of a quarter turn or more is given as half a turn.
    """
    places = range(len(corner_directions))
    first, second = corner_directions[np.array(list(combinations(places, 2))).T]
    a, b, c = corner_directions[np.array(list(combinations(places, 3))).T]
    around = cross(b - a, c - a)
    middles = np.concatenate([first + second, around, -around])
    length = np.linalg.norm(middles, axis=1)
    middles = unit(middles[length > OPTIONS.straight])
    cosine = (middles @ corner_directions.T).min(axis=1) if len(middles) else np.zeros(1)
    best = int(np.argmax(cosine))
    if not cosine[best] > 0.0:
        return np.zeros(3), math.pi
    return middles[best], float(_apart_rad(corner_directions, middles[best]).max())


def _require_simple(corner_directions: Array) -> None:
    """Raises ValueError naming corners by their places in what was given."""
    count = len(corner_directions)
    following = np.roll(corner_directions, -1, axis=0)
    least_deg = math.degrees(OPTIONS.width_min_rad)
    for k, apart_rad in enumerate(np.linalg.norm(following - corner_directions, axis=1)):
        if apart_rad < OPTIONS.width_min_rad:
            raise ValueError(
                f"must lie {least_deg:g} deg or more apart, but {k} and {(k + 1) % count} are "
                f"{math.degrees(apart_rad):.2g} deg apart; leave one of them out"
            )
    normals = _side_normals(corner_directions)
    for k, other in combinations(range(count), 2):
        if other - k in (1, count - 1):
            continue
        parted = (normals[k] @ corner_directions[other]) * (normals[k] @ following[other]) < 0.0
        if (
            parted
            and (normals[other] @ corner_directions[k]) * (normals[other] @ following[k]) < 0.0
        ):
            raise ValueError(
                f"must make sides that don't cross, but the side from {k} crosses the side from "
                f"{other}; give them in their order around the region"
            )
    away = np.minimum(_from_sides(corner_directions, normals, corner_directions)[1], math.pi)
    ends = _apart_rad(corner_directions[:, None], corner_directions)
    away = np.minimum(away, np.minimum(ends, np.roll(ends, -1, axis=1)))
    own = np.arange(count)
    away[own, own] = away[own, own - 1] = math.inf
    corner, side = (int(place) for place in np.unravel_index(np.argmin(away), away.shape))
    if away[corner, side] < OPTIONS.width_min_rad:
        raise ValueError(
            f"must enclose a region {least_deg:g} deg wide or more everywhere, but {corner} lies "
            f"{math.degrees(away[corner, side]):.2g} deg from the side from {side} to "
            f"{(side + 1) % count}"
        )


def _side_normals(corner_directions: Array) -> Array:
    return unit(cross(corner_directions, np.roll(corner_directions, -1, axis=0)))


def _from_sides(corner_directions: Array, normals: Array, directions: Array) -> tuple[Array, Array]:
    """Of each direction from each side, (n, m): the sine to its left, and how far off it is.

    Infinitely where none of the side's inner points is the nearest one.
    """
    sine = directions @ normals.T
    after_first = directions @ cross(normals, corner_directions).T >= 0.0
    before_last = directions @ cross(np.roll(corner_directions, -1, axis=0), normals).T >= 0.0
    away = np.arcsin(np.minimum(np.abs(sine), 1.0))
    return sine, np.where(after_first & before_last, away, math.inf)


def _apart_rad(direction: Array, other_direction: Array) -> Array:
    """Between unit vectors (..., 3), by their chord: accurate where they are close."""
    chord = np.linalg.norm(direction - other_direction, axis=-1)
    return np.asarray(2.0 * np.arcsin(np.minimum(chord / 2.0, 1.0)))
