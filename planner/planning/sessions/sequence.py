"""The branch on which each session is held, and the rows at which it is joined and left."""

from dataclasses import dataclass
from datetime import datetime
from itertools import pairwise

from planner.base import effort
from planner.base.commands import COMMAND_STEP_S, ROWS_PER_S
from planner.base.effort import at_most
from planner.base.errors import (
    CadenceBroken,
    InfeasibleSlew,
    NotVisible,
    Refusal,
    Relaxation,
    SearchEnded,
    SolverFailed,
    TrackBreaksLimit,
    Unreachable,
)
from planner.planning.sessions.cadence import Cadence
from planner.planning.sessions.chain import (
    CONFLICTS,
    Chain,
    SlewStart,
    Steps,
)
from planner.planning.sessions.platforms.mover import Join, Mover, RowSpan, State, TrackBranch
from planner.planning.sessions.track_branches import ephemeris_over, session_rows
from planner.world.frames.time_scales import shifted_utc
from planner.world.orbits import Ephemeris
from planner.world.scenario import Scenario, Session


@dataclass(frozen=True, kw_only=True)
class SequenceOptions:
    """Shares of the work that is left, for each part of sequencing."""

    find_share: float = 0.7  # for finding a plan
    conflict_share: float = 0.8  # where there is none, for saying why
    proof_share: float = 0.7  # of that, for a proof around cones
    offers_share: float = 0.5  # of that, for what would help


OPTIONS = SequenceOptions()


@dataclass(frozen=True, kw_only=True)
class RefusedSession:
    """A session that can't be flown as asked.

    number: its index.  mover: of the scenario, which knows what was tried.  state: of the platform
    at from_row, from which its slew begins.  cadence: of the scenario's sessions.
    hopeless: sessions that no slew reaches in time from the one before, as both are asked.
    """

    scenario: Scenario
    mover: Mover
    number: int
    from_row: int
    state: State
    cadence: Cadence
    hopeless: tuple[int, ...] = ()

    @property
    def session(self) -> Session:
        return self.scenario.sessions[self.number]

    @property
    def epoch_utc(self) -> datetime:
        return self.scenario.initial_state.epoch

    @property
    def wanted(self) -> RowSpan:
        return session_rows(self.session, self.epoch_utc)

    def utc(self, row: int) -> datetime:
        return shifted_utc(self.epoch_utc, row / ROWS_PER_S)


class SessionRefused(Exception):
    """Which session can't be flown, and why."""

    def __init__(
        self, session: RefusedSession, refusal: Refusal, chain: Chain | None = None
    ) -> None:
        super().__init__(refusal.detail)
        self.session, self.refusal = session, refusal
        self._chain = chain

    def offers(self) -> tuple[Relaxation, ...]:
        """What sessions would lose under each `on_conflict` by which all of them can be flown."""
        found: list[Relaxation] = []
        if self._chain is not None:
            if self.session.mover.start_search.is_quick:
                self._chain.accept_first()  # to join a track early loses nothing more or less
                self._chain.mover = self.session.mover.trying(self.session.scenario)
            with at_most(OPTIONS.offers_share * effort.remaining()):
                for mode in CONFLICTS:
                    instead = self._chain.solve(mode)
                    found += _relaxations_of(mode, instead[0]) if instead is not None else []
        return tuple(found)


def sequence_sessions(
    scenario: Scenario, ephemeris: Ephemeris, mover: Mover, *, prove: bool = True
) -> list[Join]:
    """A slew and a track for every session, in order.

    Of all choices of branch and whole turns the one with the least time slewing is taken,
    after the least time lost to sessions where `on_conflict` allows some to be lost.  Its tracks
    are then joined as early, and its cones passed as smoothly, as is found by the work that may
    be done.
    prove: whether to show, where a slew has no detour around cones, that there is none.
    Raises SessionRefused; InfeasibleSlew where it is the initial state's fault; SearchEnded.
    """
    state = mover.initial(ephemeris)
    cadence = Cadence(scenario, ephemeris)
    branches = _branches_by_session(scenario, ephemeris, mover, state, cadence)
    chain = Chain(scenario, mover, state, branches)
    found = None
    with at_most(OPTIONS.find_share * effort.remaining()) as search:
        found = chain.solve(scenario.on_conflict)
    if search.is_exhausted and found is None:
        chain.accept_first()
        with at_most(OPTIONS.find_share * effort.remaining()) as search:
            found = chain.solve(scenario.on_conflict)
    if found is not None:
        return chain.improve_joins(*found)
    if not search.is_exhausted:
        with at_most(OPTIONS.conflict_share * effort.remaining()):
            raise _find_conflict(chain, cadence, prove=prove)
    raise SearchEnded(
        f"no plan of these {len(scenario.sessions)} sessions was found, nor shown to be "
        "impossible, by the work that one request may make; ask for fewer sessions, cones or "
        'modes at a time, or for the objective "smooth"',
        field="sessions",
    )


def sequence_whole(scenario: Scenario, mover: Mover) -> list[Join]:
    """The same on an orbit of its own and without proofs, and the slew to the final state."""
    epoch_utc = scenario.initial_state.epoch
    rows = [session_rows(session, epoch_utc) for session in scenario.sessions]
    ephemeris = ephemeris_over(scenario, rows)
    return mover.with_final_slew(
        ephemeris, sequence_sessions(scenario, ephemeris, mover, prove=False)
    )


def _branches_by_session(
    scenario: Scenario, ephemeris: Ephemeris, mover: Mover, state: State, cadence: Cadence
) -> list[tuple[TrackBranch, ...]]:
    from_row = 0
    sessions: list[tuple[TrackBranch, ...]] = []
    for number, session in enumerate(scenario.sessions):
        try:
            cadence.require(number)
            branches = mover.ways(ephemeris, number, session, from_row, state)
        except (
            CadenceBroken, NotVisible, Unreachable, TrackBreaksLimit, InfeasibleSlew
        ) as refusal:  # fmt: skip
            refused = RefusedSession(
                scenario=scenario,
                mover=mover,
                number=number,
                from_row=from_row,
                state=state,
                cadence=cadence,
            )
            raise SessionRefused(refused, refusal) from None
        sessions.append(branches)
        from_row = branches[0].rows.stop
        state = mover.state_at(branches[0], from_row)
    return sessions


def _find_conflict(chain: Chain, cadence: Cadence, *, prove: bool) -> SessionRefused:
    """The first session that is known not to be joined in time, and why; nothing new is solved."""
    scenario = chain.scenario
    steps: Steps = ()
    for number in range(len(chain.sessions)):
        longer = chain.cheapest_steps(CONFLICTS[scenario.on_conflict], number + 1)
        if longer is None:
            break
        steps = longer
    slew_start = chain.slew_start(steps)
    state = chain.state_at(slew_start.branch, slew_start.last_row)
    refusal = None
    if prove:
        with at_most(OPTIONS.proof_share * effort.remaining()):
            refusal = _refusal(chain, number, slew_start, prove=True)
    refusal = refusal or _refusal(chain, number, slew_start, prove=False)
    refused = RefusedSession(
        scenario=scenario,
        mover=chain.mover,
        number=number,
        from_row=slew_start.last_row,
        state=state,
        cadence=cadence,
        hopeless=chain.hopeless_sessions() if scenario.on_conflict == "refuse" else (),
    )
    return SessionRefused(refused, refusal, chain)


def _refusal(chain: Chain, number: int, slew_start: SlewStart, *, prove: bool) -> InfeasibleSlew:
    state = chain.state_at(slew_start.branch, slew_start.last_row)
    for branch in chain.sessions[number]:
        try:
            chain.mover.slew_onto(
                branch,
                slew_start.last_row,
                state,
                thorough=False,
                early=not chain.scenario.keeps_out,
                prove=prove,
            )
        except InfeasibleSlew as refusal:
            return _with_mode(refusal, chain.scenario.on_conflict) if slew_start.branch else refusal
    raise SolverFailed(
        f"the slew to session {number + 1} was found impossible and then possible",
        field=f"sessions.{number}.start",
    )


def _with_mode(refusal: InfeasibleSlew, mode: str) -> InfeasibleSlew:
    """The refusal, saying that giving something up as asked doesn't help."""
    if mode == "refuse":
        return refusal
    return InfeasibleSlew(
        f'{refusal.detail}; "on_conflict": "{mode}" finds no slew that leaves '
        f"{COMMAND_STEP_S} s of each session",
        axis=refusal.axis,
        limit=refusal.limit,
    )


def _relaxations_of(mode: str, steps: Steps) -> list[Relaxation]:
    """What each session loses; a session's start is its own step's, its stop the next one's."""
    later_s = [(step.join_row - step.branch.rows.start) / ROWS_PER_S for step in steps]
    earlier_s = [
        (before.branch.rows.stop - step.leave_row) / ROWS_PER_S for before, step in pairwise(steps)
    ] + [0.0]
    return [
        Relaxation(on_conflict=mode, session=session, start_later_s=later, stop_earlier_s=earlier)
        for session, (later, earlier) in enumerate(zip(later_s, earlier_s, strict=False))
        if later or earlier
    ]
