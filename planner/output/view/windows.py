"""Windows of each session's target around the session."""

from datetime import datetime

from planner.base.errors import OutsideCoverage
from planner.planning.opportunities import (
    Opportunities,
    OpportunityRequest,
    OpportunityTarget,
    find_opportunities,
)
from planner.world.frames.time_scales import shifted_utc
from planner.world.plan import FlightPlan
from planner.world.scenario import Scenario, Session

AROUND_S = 1800.0  # before and after: the whole pass of a low orbit, and no other
SAMPLES = 5


def session_windows(plan: FlightPlan, pixel_arcsec: float) -> tuple[Opportunities | None, ...]:
    """Of every session; None for a target without windows, or where too little is known.

    From `AROUND_S` before each session to as long after, within what the orbit is known for,
    else from the table's first row to its last.
    """
    table_span = (plan.table.epoch_utc, shifted_utc(plan.table.epoch_utc, plan.table.t_s[-1]))
    found: list[Opportunities | None] = []
    for number, session in enumerate(plan.scenario.sessions):
        around = shifted_utc(session.start, -AROUND_S), shifted_utc(session.stop, AROUND_S)
        spans = (around, table_span) if session.target.has_windows else ()
        in_spans = (
            _windows(plan.scenario, session, str(number), span, pixel_arcsec) for span in spans
        )
        found.append(next((windows for windows in in_spans if windows is not None), None))
    return tuple(found)


def _windows(
    scenario: Scenario,
    session: Session,
    name: str,
    span: tuple[datetime, datetime],
    pixel_arcsec: float,
) -> Opportunities | None:
    """None where orbit or attitude aren't known over the span, or it is too short to be asked."""
    try:
        request = OpportunityRequest(
            platform=scenario.platform,
            orbit=scenario.orbit,
            attitude=scenario.attitude,
            targets=(OpportunityTarget(id=name, target=session.target),),
            start=span[0],
            stop=span[1],
            samples=SAMPLES,
            pixel_arcsec=pixel_arcsec,
        )
    except ValueError:  # what the request says of itself
        return None
    try:
        return find_opportunities(request)
    except OutsideCoverage:
        return None
