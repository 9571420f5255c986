"""A line of the table of bench/truth.py."""

from typing import NamedTuple

import numpy as np

NEES_GOAL = (0.8, 1.3)
BLOCKS = 10  # of telemetry, an hour each: longer than what is alike
FEW = "; too few to tell"
FEW_SIGMA = 2.0  # by which a value may miss its goal for the number of blocks alone


class Row(NamedTuple):
    """What a point of the table asks for and what was seen.

    is_met: None where nothing is asked, or where the data are too few to tell.
    """

    point: int
    what: str
    goal: str
    seen: str
    is_met: bool | None


def nees_row(point: int, what: str, nees: float, of: str) -> Row:
    """Mean squared error over the told variance, 1 where that is right."""
    low, high = NEES_GOAL
    is_met = bool(low <= nees <= high)
    return Row(point, what, f"NEES {low}-{high}", f"{nees:.2f} {of}", is_met)


def blocked_nees_row(point: int, what: str, squares: np.ndarray, of: str) -> Row:
    """NEES of each of m axes, of (n, m) errors over their told sigma, squared, in order of time.

    Neighbours are alike; how far the mean may be off for so few, its blocks say.  Where that is
    why it misses the goal, nothing can be told.
    """
    nees = np.mean(squares, axis=0)
    means = [np.mean(block, axis=0) for block in np.array_split(squares, BLOCKS)]
    sigma = np.std(means, axis=0, ddof=1) / np.sqrt(BLOCKS)
    low, high = NEES_GOAL
    beyond = np.maximum(np.maximum(low - nees, nees - high), 0.0)
    few = bool(beyond.any() and (beyond <= FEW_SIGMA * sigma).all())
    seen = ", ".join(f"{value:.2f}+-{off:.2f}" for value, off in zip(nees, sigma, strict=True))
    is_met = None if few else not beyond.any()
    return Row(point, what, f"NEES {low}-{high}", f"{seen} {of}{FEW * few}", is_met)
