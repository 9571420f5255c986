"""Stretches over which something holds."""

from collections.abc import Iterable

import numpy as np

from planner.base.arrays import Mask


def runs(flags: Mask) -> Iterable[tuple[int, int]]:
    """First and last index of every stretch of at least two true flags."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(int)))
    for first, after in edges.reshape(-1, 2).tolist():
        if after - first > 1:
            yield first, after - 1
