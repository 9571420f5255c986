"""The arrays of nearly every quantity, row number and answer of yes or no; vector products."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
Mask = NDArray[np.bool_]


def angle_rad(direction: Array, other_direction: Array) -> Array:
    """Between vectors (n, 3) of any length, accurate near 0 and pi too."""
    across = np.linalg.norm(np.cross(direction, other_direction), axis=1)
    return np.asarray(np.arctan2(across, np.einsum("nj,nj->n", direction, other_direction)))


def cross(left_value: Array, right_value: Array) -> Array:
    """Vector products left x right of shapes (..., 3) that broadcast, in both units' product.

    NumPy's own, bit for bit, without its search for the axes, which takes longer than a few
    hundred products.
    """
    product = np.empty(np.broadcast_shapes(left_value.shape, right_value.shape))
    ax, ay, az = (left_value[..., k] for k in range(3))
    bx, by, bz = (right_value[..., k] for k in range(3))
    product[..., 0] = ay * bz - az * by
    product[..., 1] = az * bx - ax * bz
    product[..., 2] = ax * by - ay * bx
    return product


def rank_among(kind: Indices, value: Array) -> Indices:
    """How many of its kind are greater than each value, (n,), or as great and before it."""
    order = np.lexsort((-value, kind))
    kinds, rank = kind[order], np.empty(len(order), np.intp)
    rank[order] = np.arange(len(order)) - np.searchsorted(kinds, kinds)
    return rank


def told_deg(values_rad: Array) -> list[float]:
    """Angles (n,) or rates in degrees, to the decimals in which a request can say them again."""
    degrees: list[float] = np.round(np.rad2deg(values_rad), 12).tolist()
    return degrees
