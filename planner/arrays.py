"""The arrays of nearly every quantity, row number and answer of yes or no; vector products."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
Mask = NDArray[np.bool_]


def cross(a: Array, b: Array) -> Array:
    """Vector products a x b of (..., 3), shapes broadcast.

    NumPy's own, bit for bit, without its search for the axes, which takes longer than a few
    hundred products.
    """
    product = np.empty(np.broadcast_shapes(a.shape, b.shape))
    ax, ay, az = (a[..., k] for k in range(3))
    bx, by, bz = (b[..., k] for k in range(3))
    product[..., 0] = ay * bz - az * by
    product[..., 1] = az * bx - ax * bz
    product[..., 2] = ax * by - ay * bx
    return product
