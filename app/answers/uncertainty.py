"""The pointing budget, as answered."""

from dataclasses import dataclass

from planner.sessions.uncertainty import Contribution, PointingBudget


@dataclass(frozen=True, kw_only=True)
class UncertaintyOut:
    """1-sigma pointing error of one session, per image axis at its worst instant.

    What the table can't know: the errors of orbit, attitude, Earth orientation, clock and
    drives.  probability_in_frame: that the target stays inside the camera's frame over the
    whole session, from where the table holds it.
    """

    session: int
    sigma_arcsec: float
    ground_m: float | None
    probability_in_frame: float
    contributions: list[Contribution]


def uncertainty_out(session: int, budget: PointingBudget) -> UncertaintyOut:
    """The budget of the session with this number."""
    return UncertaintyOut(
        session=session,
        sigma_arcsec=budget.sigma_arcsec,
        ground_m=budget.ground_m,
        probability_in_frame=budget.probability_in_frame,
        contributions=list(budget.contributions),
    )
