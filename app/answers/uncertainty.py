"""The pointing budget, as answered."""

from dataclasses import dataclass

from planner.sessions.uncertainty import PointingBudget


@dataclass(frozen=True, kw_only=True)
class ContributionOut:
    """One cause, 1-sigma per image axis at the session's worst instant.

    basis: whether measured or assumed, and on what.  better: what would make it smaller.
    is_bias: constant over the session.
    ground_m: across the line of sight at the target, null for a target in the sky.
    """

    cause: str
    sigma_arcsec: float
    ground_m: float | None
    is_bias: bool
    basis: str
    better: str


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
    contributions: list[ContributionOut]


def uncertainty_out(session: int, budget: PointingBudget) -> UncertaintyOut:
    """The budget of the session with this number."""
    return UncertaintyOut(
        session=session,
        sigma_arcsec=budget.sigma_arcsec,
        ground_m=budget.ground_m,
        probability_in_frame=budget.probability_in_frame,
        contributions=[
            ContributionOut(
                cause=part.cause,
                sigma_arcsec=part.sigma_arcsec,
                ground_m=part.ground_m,
                is_bias=part.is_bias,
                basis=part.basis,
                better=part.better,
            )
            for part in budget.contributions
        ],
    )
