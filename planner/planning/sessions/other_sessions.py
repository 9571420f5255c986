"""The cost of moving one session to the others of its request."""

from dataclasses import replace

from planner.base import effort
from planner.base.effort import at_most
from planner.base.errors import Refusal
from planner.planning.sessions.assembly import assemble_table, sessions_after_conflicts, table_work
from planner.planning.sessions.final import with_final_slew
from planner.planning.sessions.sequence import RefusedSession, SessionRefused, sequence_sessions
from planner.planning.sessions.track_branches import ephemeris_over, session_rows
from planner.verification import verify
from planner.world.frames.time_scales import elapsed_s, utc_text
from planner.world.scenario import Scenario, Session

SHARE = 0.6  # of the work that is left, for planning the whole request once more


class Others:
    """The other sessions of a refused one's request, asked about it moved.

    dearer: the first start tried that costs other sessions, and which.  undecided: in words, a
    start of which it wasn't found out.
    """

    def __init__(self, refused: RefusedSession) -> None:
        self._refused = refused
        self.dearer: tuple[Session, tuple[int, ...]] | None = None
        self.undecided = ""

    def stay_as_asked(self, moved: Session) -> bool:
        """Whether the whole request, with that session moved, was planned and judged good."""
        costs = None
        with at_most(SHARE * effort.remaining()) as search:
            costs = self._costs(moved)
        if search.is_exhausted:
            self.undecided = (
                f"at {utc_text(moved.start, 1)} this session by itself can be, but whether the "
                "others then can was not found out before the search ended"
            )
        if costs and (self.dearer is None or len(costs) < len(self.dearer[1])):
            self.dearer = moved, costs
        return costs == ()

    def _costs(self, moved: Session) -> tuple[int, ...] | None:
        """Sessions without which the others are planned; None: the moved one isn't."""
        scenario, number = self._refused.scenario, self._refused.number
        kept = [
            other
            for other, session in enumerate(scenario.sessions)
            if other <= number or elapsed_s(session.start, moved.stop) >= 0.0
        ]
        while True:
            sessions = [moved if one == number else scenario.sessions[one] for one in kept]
            try:
                planned = _is_planned(replace(scenario, sessions=tuple(sessions)))
            except SessionRefused as failed:
                lost = kept[failed.session.number]
                if lost == number:
                    return None
                kept.remove(lost)
                continue
            except Refusal:
                return None
            count = len(scenario.sessions)
            return tuple(sorted({*range(count)} - {*kept})) if planned else None


def _is_planned(scenario: Scenario) -> bool:
    """As the pipeline plans it; raises SessionRefused and refusals of the whole."""
    epoch_utc = scenario.initial_state.epoch
    rows = [session_rows(session, epoch_utc) for session in scenario.sessions]
    ephemeris = ephemeris_over(scenario, rows)
    joins = sequence_sessions(scenario, ephemeris, prove=False)
    whole = with_final_slew(scenario, ephemeris, joins)
    if not scenario.slew.keeps_limits:
        return True
    effort.charge(table_work(scenario, whole[-1].stop_row))
    final, _ = sessions_after_conflicts(scenario, joins)
    return verify(assemble_table(epoch_utc, scenario.platform.axis_names, whole), final).passed
