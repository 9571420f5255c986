"""SciPy's `Rotation`, loaded when the first one is made.

Its package takes 0.15 s, for which who only reads a request needn't wait.
"""

from typing import TYPE_CHECKING, Any

import numpy as np

from planner.base.arrays import Array

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation as Rotation
else:

    class _OnFirstUse(type):
        def __getattr__(cls, name: str) -> Any:  # noqa: ANN401 (as Python calls it)
            from scipy.spatial import transform

            return getattr(transform.Rotation, name)

    class Rotation(metaclass=_OnFirstUse):
        """Makes SciPy's by each of its class methods, and names them in annotations."""


def like_signs(q_xyzw: Array) -> Array:
    """Signs (n,) by which each of n quaternions (n, 4) lies nearest to the one before; +1 first."""
    likeness = np.sum(q_xyzw[1:] * q_xyzw[:-1], axis=1)
    return np.concatenate([[1.0], np.cumprod(np.where(likeness < 0.0, -1.0, 1.0))])


def continuous(q: "Rotation") -> Array:
    """Components of n rotations, shape (n, 4), scalar last, neighbours of like sign."""
    q_xyzw = q.as_quat()
    return np.asarray(q_xyzw * like_signs(q_xyzw)[:, None])


def of_like_sign(q_xyzw: Array) -> Array:
    """The same rotations (n, 4): the first w not negative, each nearest to the one before it."""
    begin = -1.0 if q_xyzw[0, 3] < 0.0 else 1.0
    return np.asarray(q_xyzw * (begin * like_signs(q_xyzw))[:, None])
