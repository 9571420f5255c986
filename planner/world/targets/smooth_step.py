"""A step from one level to another with continuous jerk.

With x from 0 to 1: w = 35 x^4 - 84 x^5 + 70 x^6 - 20 x^7, whose first three derivatives
vanish at both ends.  Source: Ebert et al. 2003, Texturing and Modeling (smoothstep family).
"""

import numpy as np
from numpy.typing import ArrayLike

from planner.base.arrays import Array

_W = np.polynomial.Polynomial([0.0, 0.0, 0.0, 0.0, 35.0, -84.0, 70.0, -20.0])
_SLOPE = _W.deriv()
_CURVATURE = _W.deriv(2)
_AREA = _W.integ()


def step(x: ArrayLike) -> Array:
    """w, its slope and its curvature, shape (3, ...); 0 before and level after."""
    inside = np.clip(x, 0.0, 1.0)
    return np.stack([_W(inside), _SLOPE(inside), _CURVATURE(inside)])


def ramp(t_s: ArrayLike, blend_s: float) -> Array:
    """0 long before t = 0 and t long after, shape of `t_s`; blended over `blend_s` around 0."""
    t = np.asarray(t_s)
    x = t / blend_s + 0.5
    return np.where(x < 1.0, blend_s * _AREA(np.clip(x, 0.0, 1.0)), t)
