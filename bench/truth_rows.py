"""A line of the table of bench/truth.py."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2, norm

NEES_GOAL = (0.8, 1.3)
# A goal missed by less than this may be missed for the number of sets alone.
FEW_SIGMA = 2.0
GAUSS, USUAL = 2.0, 4.4  # variance of the square of an error of variance 1


class Row(NamedTuple):
    """What a row of the table asks for and what was seen.

    is_met: None where nothing is asked, or where the goal is missed but a law that tells the truth
    may well be seen so by as few independent sets.
    """

    what: str
    goal: str
    seen: str
    is_met: bool | None


def nees_row(what: str, sets: Sequence[np.ndarray], of: str, spread: float = GAUSS) -> Row:
    """NEES of each of m axes, of (k, m) squares of errors over their told sigma, in sets that are
    independent: one satellite's elements, a stretch of telemetry.

    The sampling error is that of a law that tells the truth, one error a set.
    """
    nees = np.mean(np.concatenate(sets), axis=0)
    low, high = NEES_GOAL
    by_number = np.sqrt(spread / len(sets))
    freedom = len(sets) * GAUSS / spread
    power = chi2.cdf(high * freedom, freedom) - chi2.cdf(low * freedom, freedom)
    beyond = bool(np.any((nees < low) | (nees > high)))
    doubtful = bool(np.all(np.abs(nees - 1.0) <= FEW_SIGMA * by_number))
    values = ", ".join(f"{value:.2f}" for value in nees)
    seen = f"{values} +-{by_number:.2f} {of}; {_sets(len(sets), power)}"
    return Row(what, f"NEES {low}-{high}", seen, _verdict(beyond, doubtful))


def share_row(
    what: str, told: float, kept: NDArray[np.floating], of_set: NDArray[np.integer], goal: float
) -> Row:
    """A told probability beside the share that was kept, of cases, (n,), and the set of each.

    Cases of a set are one; uneven sets are as many as Kish's effective size says (Survey Sampling,
    1965, section 11.7).
    """
    _, cases = np.unique(of_set, return_counts=True)
    sets = cases.sum() ** 2 / np.sum(cases**2)
    by_number = np.sqrt(told * (1.0 - told) / sets)
    power = 1.0 - 2.0 * norm.sf(goal / by_number)
    off = abs(kept.mean() - told)
    seen = f"told {told:.3f}, kept {kept.mean():.3f} +-{by_number:.3f}; {_sets(sets, power)}"
    is_met = _verdict(bool(off > goal), bool(off <= FEW_SIGMA * by_number))
    return Row(what, f"within {goal}", seen, is_met)


def _verdict(beyond: bool, doubtful: bool) -> bool | None:
    if not beyond:
        return True
    return None if doubtful else False


def _sets(count: float, power: float) -> str:
    return f"{count:.0f} independent, which show the truth so in {power:.0%}"
