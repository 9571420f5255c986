"""Numbers that telemetry tells with their errors, as answers hold them."""

from dataclasses import replace
from typing import Annotated, Self

from planner.base.answer_members import Member, NotNegative, Signed, answer


@answer
class Estimate:
    """An estimate, in the unit that the name of its member says.

    value: the most likely.
    sigma: its 1-sigma error, of the errors' own size and of how they go together in time.
    """

    value: Signed
    sigma: NotNegative

    def turned(self, sign: int) -> Self:
        """Of what is measured the other way round, where the sign is -1."""
        return replace(self, value=sign * self.value)

    def scaled(self, factor: float, decimals: int) -> Self:
        """In another unit, rounded."""
        value = round(factor * self.value, decimals) + 0.0  # no -0.0
        return replace(self, value=value, sigma=round(factor * self.sigma, decimals))

    def if_so(self, assumes: str) -> "ClockEstimate":
        """As an estimate of the clock under this condition."""
        return ClockEstimate(value=self.value, sigma=self.sigma, assumes=assumes)


@answer
class ClockEstimate(Estimate):
    """An estimate of the clock, in the unit that the name of its member says.

    assumes: the condition on the axes under which it holds.
    """

    assumes: str


@answer
class Inseparable:
    """Two estimates that the samples hardly tell apart: one's error is made up for by the other's.

    names: both, as they stand in this answer. E.g. `["clock_drift", "axes.alpha.gain"]`.
    correlation: of their errors, from -1 to 1. E.g. `-0.994`.
    """

    names: Annotated[tuple[str, ...], Member(called="members")]
    correlation: Annotated[float, Member(decimals=4)]
