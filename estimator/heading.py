"""Which way does the craft face about the vertical, by how the limb's brightness runs?

Clear air scatters sunlight forwards and backwards more than sideways (Rayleigh), and the limb
lies above most dust and cloud; so along each camera's arc the limb's brightness follows the
angle to the Sun.  Each camera's exposure is free.  A weak hint, for when no attitude was
predicted: it decides between headings that fit the limb's shape alike.
"""

import numpy as np
from numpy.typing import NDArray

from estimator.limb import LimbPoints
from estimator.limb_geometry import Limb
from estimator.nadir import Fit, columns_per_patch

Floats = NDArray[np.float64]

_SCATTER = 0.15  # of brightness from one 5 deg of limb to the next, dust and lens shading


def brightness_cost(points: list[LimbPoints], limb: Limb, fit: Fit, sun_itrf: Floats) -> float:
    """Minus twice the log likelihood of the limb's brightness under a fit's heading."""
    total = 0.0
    for p in points:
        good = p.found & ~p.clipped & (p.slope > 0.0)
        if np.sum(good) < 16:
            continue
        direction = p.ray_body[good] @ fit.c_body_from_itrf
        elevation = limb.sun_elevation_rad(direction, fit.height_m, sun_itrf)
        cosine = direction @ sun_itrf
        expected = np.log(1.0 + cosine**2) - 0.04 / np.maximum(np.sin(elevation), 0.02)
        share = 1.0 / columns_per_patch(p)[good]
        off = np.log(p.slope[good]) - expected
        off -= np.sum(share * off) / np.sum(share)
        total += float(np.sum(share * np.minimum((off / _SCATTER) ** 2, 9.0)))
    return total
