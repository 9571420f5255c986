"""The resolution of a column: the noise of a row by itself, and the sensor's step."""

import math
from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Array


@dataclass(frozen=True, kw_only=True)
class LatticeOptions:
    """When a column's values lie on the steps of a sensor."""

    lattice_min: float = 0.9  # of the gaps between values, to be whole multiples of the least
    whole: float = 0.02  # of a step, off the lattice: digits printed round it
    values_min: int = 20  # fewer may lie so by chance,
    repeated: float = 0.25  # unless each comes again and again: values over rows


OPTIONS = LatticeOptions()


def row_noise(error: Array) -> float:
    """1 sigma of white noise in (n,): third differences keep little of what is smooth."""
    if len(error) < 4:
        return 0.0
    return 1.4826 * float(np.median(np.abs(np.diff(error, 3)))) / math.sqrt(20.0)


def sensor_step(value: Array) -> float:
    """The step of an encoder or of the digits sent, of (n,); 0 where values are of no lattice."""
    finite = value[np.isfinite(value)]
    if not len(finite):
        return 0.0
    gaps = np.diff(np.sort(finite))
    gaps = gaps[gaps > 1e-12 * max(float(np.abs(finite).max()), 1e-3)]
    if not len(gaps) or (
        len(gaps) > OPTIONS.repeated * len(finite) and len(gaps) < OPTIONS.values_min
    ):
        return 0.0
    counts = gaps / gaps.min()
    is_whole = np.abs(counts - np.round(counts)) < OPTIONS.whole
    return float(gaps.min()) if is_whole.mean() > OPTIONS.lattice_min else 0.0
