"""Contributors to the errors of disturbed flights: Sobol's indices."""

from collections.abc import Sequence
from typing import Annotated

import numpy as np

from planner.base.answer_members import Member, answer
from planner.base.arrays import Array
from planner.inflight.flights.outcomes import RunOutcomes

_LEAST = 1e-12  # of a variance: below, nothing varies
_Size = Annotated[float, Member("", 0.0, decimals=6)]
_Rounded = Annotated[float, Member(decimals=6)]


@answer
class Contributor:
    """One cause's part in what varies from run to run: Sobol's indices.

    cause: the quantity that is uncertain, as in the pointing budget.
    share: of the variance of the target's place in the image, what the cause has a hand in, by
    itself or with others; all causes together make 1 or more.
    share_sigma: 1-sigma of that, from the finite number of runs.
    alone_share: share of the variance that would vanish if the cause were known; by chance it may
    lie a little below 0.
    alone_sigma: 1-sigma of that, from the finite number of runs.
    smear_share: `share`, of the smear.
    smear_share_sigma: 1-sigma of that, from the finite number of runs.
    smear_alone_share: `alone_share`, of the smear.
    smear_alone_sigma: 1-sigma of that, from the finite number of runs.
    """

    cause: str
    share: _Size
    share_sigma: _Size
    alone_share: _Rounded
    alone_sigma: _Size
    smear_share: _Size
    smear_share_sigma: _Size
    smear_alone_share: _Rounded
    smear_alone_sigma: _Size


def contributors(sessions: Sequence[RunOutcomes]) -> list[Contributor]:
    """By their part in the place, the largest first; none of fewer than two pairs of runs.

    Each pair of independent runs gives each cause's indices once, by runs that differ in one cause
    only; the indices of several instants are those of their sum, each weighted by its variance.
    Source: Jansen 1999, eq. 7 and 12; Gamboa et al. 2014 for results that are vectors.
    """
    variance_px2 = np.sum([runs.variance_px2 for runs in sessions], axis=0)
    total_px2 = np.sum([runs.total_px2 for runs in sessions], axis=0)
    first_px2 = np.sum([runs.first_px2 for runs in sessions], axis=0)
    if len(variance_px2) < 2:
        return []
    share, share_sigma = _ratio(total_px2, variance_px2)
    left, left_sigma = _ratio(first_px2, variance_px2)
    found = [
        Contributor(
            cause=cause,
            share=float(share[0, column]),
            share_sigma=float(share_sigma[0, column]),
            alone_share=float(1.0 - left[0, column]),
            alone_sigma=float(left_sigma[0, column]),
            smear_share=float(share[1, column]),
            smear_share_sigma=float(share_sigma[1, column]),
            smear_alone_share=float(1.0 - left[1, column]),
            smear_alone_sigma=float(left_sigma[1, column]),
        )
        for column, cause in enumerate(sessions[0].causes)
    ]
    return sorted(found, key=lambda one: -one.share)


def _ratio(parts_px2: Array, whole_px2: Array) -> tuple[Array, Array]:
    """Of means, and its 1-sigma error by the spread of (p, 2, causes) over (p, 2): (2, causes)."""
    mean = np.maximum(whole_px2.mean(axis=0), _LEAST)
    ratio = parts_px2.mean(axis=0) / mean[:, None]
    spread = np.std(parts_px2 - ratio * whole_px2[:, :, None], axis=0, ddof=1)
    return ratio, spread / (np.sqrt(len(parts_px2)) * mean[:, None])
