"""Polygons on the sphere, and by plain formulae whether and how far a direction is outside."""

import math

import numpy as np


def star(rng, middle, size_rad, count):
    """Corners around a middle, by no more than two thirds of a half turn from one to the next."""
    shares = rng.dirichlet(np.full(count, 4.0))
    while shares.max() > 1.0 / 3.0:
        shares = rng.dirichlet(np.full(count, 4.0))
    clock = 2.0 * np.pi * np.cumsum(shares)
    away = size_rad * rng.uniform(0.3, 1.0, count)
    first = np.cross(middle, rng.normal(size=3))
    first /= np.linalg.norm(first)
    second = np.cross(middle, first)
    return (
        np.cos(away)[:, None] * middle
        + (np.sin(away) * np.cos(clock))[:, None] * first
        + (np.sin(away) * np.sin(clock))[:, None] * second
    )


def boom(rng, middle, half_length_rad, half_width_rad):
    """A thin quadrilateral."""
    along = np.cross(middle, rng.normal(size=3))
    along /= np.linalg.norm(along)
    across = np.cross(middle, along)
    u, v = math.tan(half_length_rad), math.tan(half_width_rad)
    corners = [
        middle + a * u * along + b * v * across for a, b in ((1, 1), (-1, 1), (-1, -1), (1, -1))
    ]
    return np.array([corner / np.linalg.norm(corner) for corner in corners])


def inside(corners, directions):
    """Whether unit vectors (n, 3) are: the corners wind around them.

    The sum of the angles at which each side is seen; a polygon seen from behind winds too.
    """
    total = np.zeros(len(directions))
    for first, second in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        a, b = np.cross(directions, first), np.cross(directions, second)
        total += np.arctan2(directions @ np.cross(first, second), np.sum(a * b, axis=1))
    return (np.abs(total) > np.pi) & (directions @ corners.sum(axis=0) > 0.0)


def sampled_away_rad(corners, directions, count=400):
    """Distance of unit vectors (n, 3) from points along the sides, and half of how far apart any
    two neighbours are."""
    share = np.linspace(0.0, 1.0, count + 1)[:, None]
    sides = zip(corners, np.roll(corners, -1, axis=0), strict=True)
    points = np.concatenate([(1.0 - share) * a + share * b for a, b in sides])
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    chord = np.array([np.linalg.norm(points - one, axis=1).min() for one in directions])
    step = np.linalg.norm(np.diff(points, axis=0), axis=1).max()
    return 2.0 * np.arcsin(chord / 2.0), np.arcsin(step / 2.0)


def mask_corners(mask):
    corners = np.array(mask.corners_platform)
    return corners / np.linalg.norm(corners, axis=1, keepdims=True)
