"""The pointing budget of a session: what contributes to the error, and what would help."""

from planner.base.answer_members import Count, Internal, NotNegative, Share, answer

LIKELY = 0.9  # of staying in the frame; below, a plan warns


@answer
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
    sigma_arcsec: NotNegative
    ground_m: NotNegative | None
    is_bias: bool
    basis: str
    better: str


@answer
class PointingBudget:
    """1-sigma pointing error of one session, per image axis at its worst instant.

    What the table can't know: the errors of orbit, attitude, Earth orientation, clock and drives.

    session: its number, from 0.
    sigma_arcsec: all contributions together.
    ground_m: the same across the line of sight at the target; null for a target in the sky.
    probability_in_frame: that the target stays inside the camera's frame over the whole session,
    from where the table holds it.
    contributions: cause by cause.
    """

    session: Count
    sigma_arcsec: NotNegative
    ground_m: NotNegative | None
    probability_in_frame: Share
    contributions: tuple[Contribution, ...]
    # Where that probability is low, the cause without which it would be highest.
    helps_most: Internal[str | None] = None

    def warning(self) -> str | None:
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
            f"session {self.session + 1}: the target stays in the frame with a probability of "
            f"{self.probability_in_frame:.3f} only; the pointing error is {error} (1 sigma); "
            f"against its part from {first.cause}, {first.better} would help most"
        )
