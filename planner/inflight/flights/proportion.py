"""Probabilities from counts, with what chance leaves open."""

import math
from dataclasses import dataclass

SIGMAS_95 = 1.959964  # of Gauss's distribution, two-sided
SIGMAS_WARNED = 3.0  # one honest plan in 370 is warned of


@dataclass(frozen=True, kw_only=True)
class Proportion:
    """So many of so many runs."""

    count: int
    runs: int

    @property
    def value(self) -> float:
        return self.count / self.runs

    def interval(self, sigma: float = SIGMAS_95) -> tuple[float, float]:
        """Within which the probability lies, with the confidence of so many sigma.

        Source: Wilson 1927, Probable inference; Brown, Cai and DasGupta 2001, sec. 3.1.1.
        """
        n, z2 = self.runs, sigma**2
        middle = (self.count + 0.5 * z2) / (n + z2)
        p = self.value
        reach = sigma / (n + z2) * math.sqrt(n * p * (1.0 - p) + 0.25 * z2)
        return max(middle - reach, 0.0), min(middle + reach, 1.0)

    def differs_from(self, stated_probability: float) -> bool:
        """Whether chance hardly makes that of the probability told."""
        low, high = self.interval(SIGMAS_WARNED)
        return not low <= stated_probability <= high
