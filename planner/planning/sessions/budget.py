"""The pointing budget of a session: what contributes to the error, and what would help."""

from dataclasses import dataclass
from typing import Annotated

from pydantic import Field

LIKELY = 0.9  # of staying in the frame; below, a plan warns


@dataclass(frozen=True, kw_only=True)
class Contribution:
    """One cause: 1-sigma per image axis at the session's worst instant.

    cause: the quantity that is uncertain.
    sigma_arcsec: its 1-sigma.
    ground_m: across the line of sight at the target, null for a target in the sky.
    is_bias: constant over the session, or a swing as slow as the orbit.
    basis: source of the sigma: measured or assumed, and from what.
    better: a way to make it smaller.
    """

    cause: str
    sigma_arcsec: Annotated[float, Field(ge=0.0)]
    ground_m: Annotated[float, Field(ge=0.0)] | None
    is_bias: bool
    basis: str
    better: str


@dataclass(frozen=True, kw_only=True)
class PointingBudget:
    """1-sigma pointing error of one session, per image axis at the worst instant.

    probability_in_frame: that the target is inside the frame at every instant of the session.
    helps_most: where that is unlikely, the cause without which it would be likeliest.
    """

    contributions: tuple[Contribution, ...]
    sigma_arcsec: float
    ground_m: float | None
    probability_in_frame: float
    helps_most: str | None = None

    def warning(self, session: int) -> str | None:
        """That the target may well be missed, and what would help most."""
        if self.helps_most is None:
            return None
        first = next(part for part in self.contributions if part.cause == self.helps_most)
        error = (
            f"{self.sigma_arcsec / 3600.0:.2f} deg"
            if self.ground_m is None
            else f"{self.ground_m / 1e3:.1f} km"
        )
        return (
            f"session {session + 1}: the target stays in the frame with a probability of "
            f"{self.probability_in_frame:.3f} only; the pointing error is {error} (1 sigma); "
            f"against its part from {first.cause}, {first.better} would help most"
        )
