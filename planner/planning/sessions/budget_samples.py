"""Sample rows of a session for its pointing budget."""

import math
from itertools import pairwise

import numpy as np

from planner.base.arrays import Array, Indices

_FRAME_TURN_RAD = 0.1  # a keyhole turns the frame in seconds: one more row each


def spread_rows(image_platform: Array, samples: int) -> Indices:
    """Of the rows that many, evenly, and more where the frame turns in the platform.

    image_platform: (n, 2, 3), the directions of the frame's sides.
    """
    rows = np.arange(len(image_platform))
    turn_rad = np.linalg.norm(np.diff(image_platform, axis=0), axis=(1, 2))
    along = np.linspace(0.0, samples - 1.0, len(rows))
    along[1:] += np.cumsum(turn_rad) / _FRAME_TURN_RAD
    even = np.linspace(0.0, along[-1], math.ceil(along[-1]) + 1)
    return np.unique(np.interp(even, along, rows).round().astype(np.intp))


def farthest_rows(shares: Array, rows: Indices) -> Indices:
    """Of the instants nearest to each of `rows` the one with the largest share of the frame."""
    ends = np.concatenate([[0], (rows[1:] + rows[:-1]) // 2 + 1, [len(shares)]])
    return np.array([first + np.argmax(shares[first:last]) for first, last in pairwise(ends)])
