"""Depth of directions in a polygon on the sphere, compiled.

side_parameters: rows of 13, a side each: the corner it begins with, its normal, the planes through
both its ends, and whether that corner is reflex; as `SphericalPolygon.side_parameters`.
"""

import math

import numpy as np

from planner.base.arrays import Array, Indices, Mask
from planner.base.compiled import compiled, lean
from planner.base.vectors import Vector, dot, norm, plus, vector_of


@lean
def nearest_side(
    side_parameters: Array, first: int, last: int, direction: Vector
) -> tuple[float, int, bool]:
    """Depth in the polygon of rows first to last, without that one, negative outside; the nearest
    side or, where the third says so, the corner it begins with.

    A direction whose nearest point is a corner lies inside where the corner is reflex; none inside
    is a quarter turn away.
    """
    sides = side_parameters
    away, is_inside, cosine, side, corner = math.inf, False, -2.0, first, first
    for row in range(first, last):
        sine = dot(direction, vector_of(sides, row, 3))
        after_first = dot(direction, vector_of(sides, row, 6)) >= 0.0
        if after_first and dot(direction, vector_of(sides, row, 9)) >= 0.0:
            apart = math.asin(min(abs(sine), 1.0))
            if apart < away:
                away, is_inside, side = apart, sine > 0.0, row
        along = dot(direction, vector_of(sides, row, 0))
        if along > cosine:
            cosine, corner = along, row
    chord = norm(plus(direction, -1.0, vector_of(sides, corner, 0)))
    apart = 2.0 * math.asin(min(0.5 * chord, 1.0))
    is_corner = apart < away
    if is_corner:
        away, is_inside, side = apart, sides[corner, 12] > 0.0, corner
    return away if is_inside and away < 0.5 * math.pi else -away, side, is_corner


@compiled
def nearest_sides(side_parameters: Array, directions: Array) -> tuple[Array, Indices, Mask]:
    """The same of unit vectors (n, 3) in one polygon."""
    count = len(directions)
    depth, side = np.empty(count), np.empty(count, np.intp)
    is_corner = np.empty(count, np.bool_)
    for k in range(count):
        depth[k], side[k], is_corner[k] = nearest_side(
            side_parameters, 0, len(side_parameters), vector_of(directions, k, 0)
        )
    return depth, side, is_corner
