"""A line of the table of bench/truth.py."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

NEES_GOAL = (0.8, 1.3)
FEW_SIGMA = 2.0  # by which a value may miss its goal for its number of blocks alone


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


def blocked_nees_row(point: int, what: str, blocks: Sequence[np.ndarray], of: str) -> Row:
    """NEES of each of m axes, of (k, m) squares of errors over their told sigma, in blocks of what
    is alike: one satellite's elements, an hour of telemetry.
    """
    nees = np.mean(np.concatenate(blocks), axis=0)
    sigma = sigma_of_blocks(blocks)
    low, high = NEES_GOAL
    beyond = np.maximum(np.maximum(low - nees, nees - high), 0.0)
    seen = ", ".join(f"{value:.2f}+-{off:.2f}" for value, off in zip(nees, sigma, strict=True))
    is_met, why = verdict(beyond, sigma)
    return Row(point, what, f"NEES {low}-{high}", f"{seen} {of}{why}", is_met)


def sigma_of_blocks(blocks: Sequence[np.ndarray]) -> np.ndarray:
    """Of the mean of all, by how much the blocks' own means differ; not finite of a single one."""
    if len(blocks) < 2:
        return np.full(blocks[0].shape[1:], np.inf)
    means = [np.mean(block, axis=0) for block in blocks]
    return np.asarray(np.std(means, axis=0, ddof=1) / np.sqrt(len(blocks)))


def verdict(beyond: np.ndarray, sigma: np.ndarray) -> tuple[bool | None, str]:
    """Whether a goal is met, and why nothing can be told where its blocks are too few.

    beyond: by how much values miss it; sigma: how well they are known.
    """
    if not np.any(beyond > 0.0):
        return True, ""
    if np.all(beyond <= FEW_SIGMA * sigma):
        return None, "; too few to tell"
    return False, ""
