"""What kinds of air make of the limb's light along the horizon, for estimator/search/sunlight.py.

Linear fits to the limbs of SASKTRAN2 (the twelve chosen airs of bench/limb_tables.py and sixty
drawn as its `drawn` draws, seeds 101 to 160; drawn_1 to drawn_6 are not among them) and of 40 airs
of our own renderer, with the Sun 25 to 85 deg high.  Each limb is fitted to 0.02.
"""

from dataclasses import dataclass

import numpy as np

from planner.arrays import Array


@dataclass(frozen=True)
class AirLight:
    """How often a kind of air is met, and the mean (8,) and covariance (8, 8) of its light.

    Of blue brightness: contrast left of single scattering, dust's light against the air's if it
    scattered evenly, and sunlight's loss by its path's length against that straight down.  Of the
    logarithm of red over blue: its slope and bend by the cosine of the angle to the Sun.  Of grey
    brightness: the first three again.
    """

    share: float
    mean: Array
    covariance: Array


def _kind(share: float, mean: str, covariance: str, widened: float = 1.0) -> AirLight:
    """covariance: its lower triangle by rows, in 1e-5."""
    lower = np.zeros((8, 8))
    lower[np.tril_indices(8)] = 1e-5 * np.array(covariance.split(), dtype=float)
    full = lower + np.tril(lower, -1).T
    return AirLight(share, np.array(mean.split(), dtype=float), widened**2 * full)


_SCATTERED_OFTEN = (
    "0.491 0.299 0.014 0.107 0.059 0.494 0.362 0.017",
    """
    1452
    -1703 3256
    -35 104 14
    -145 515 11 726
    240 -179 -4 111 99
    1547 -1875 -36 -273 272 1911
    -1729 3269 94 1034 -85 -2020 3993
    -46 121 13 27 -5 -53 115 20
    """,
)
_SCATTERED_ONCE = (
    "0.867 0.1 0.018 0.082 0.009 0.843 0.143 0.026",
    """
    676
    -521 629
    8 -5 3
    -399 403 -3 523
    25 -18 0 57 47
    725 -648 9 -503 33 994
    -684 657 -9 676 47 -864 1152
    -50 58 0 44 -5 -66 63 12
    """,
)
AIRS = (
    _kind(0.5, *_SCATTERED_OFTEN),
    # As our renderer has it, where little is scattered more than once.
    _kind(0.35, *_SCATTERED_ONCE),
    # Laden with dust, or with the haze of an eruption.
    _kind(0.15, *_SCATTERED_OFTEN, widened=2.5),
)
