"""The mover: everything that planning asks of a platform's motion, whatever its kind."""

from collections.abc import Iterator
from dataclasses import dataclass
from datetime import datetime
from typing import Any, ClassVar, Protocol

from planner.base.arrays import Array, Mask
from planner.base.commands import CommandTable, Motion
from planner.motion.pointing.line_of_sight import LineOfSight
from planner.planning.sessions.budget import PointingBudget
from planner.planning.sessions.plan import SlewRun
from planner.world.frames.time_scales import Instants
from planner.world.orbits import Ephemeris, OrbitStates
from planner.world.scenario import Scenario, Session

State = Any  # how a platform moves at one instant: only its own mover looks into it


class Track(Protocol):
    """A motion that follows a target: rows t_s (n,) on the table's clock.

    los: what is followed; None where the motion itself is asked for.
    """

    @property
    def t_s(self) -> Array: ...
    @property
    def los(self) -> LineOfSight | None: ...


@dataclass(frozen=True, kw_only=True)
class RowSpan:
    """The rows of the table that enclose a session; `stop` is the last one, included."""

    start: int
    stop: int


@dataclass(frozen=True, kw_only=True, eq=False)
class TrackBranch:
    """One way to hold a session's target: a track over `rows` and what lies before.

    seen_from_s: since when, up to the session, the target can be seen, and looked at out of
    all cones and masks, without a break.  ephemeris: the orbit it was found on.  settle_rows: of
    the track, from where it is joined, in which the session can't have begun.
    """

    session: Session
    track: Any  # a Track, of the mover's own kind
    rows: RowSpan
    seen_from_s: float
    ephemeris: Ephemeris
    settle_rows: int = 0


@dataclass(frozen=True, kw_only=True)
class Join:
    """A slew from `slew_row` to `join_row`, and its track followed to `stop_row`.

    slew, brake: of the mover's own kind.  brake: what brings the platform to its idle motion in
    the brake_rows at the end of what was before, None where it slews at once or is idle already;
    it then waits until slew_row.  settle_rows: as of the branch.
    search_truncated: whether the bound of work ended the search for an earlier join or a smoother
    slew.
    """

    slew: Any
    brake: Any = None
    track: Any  # a Track, of the mover's own kind
    slew_row: int
    join_row: int
    stop_row: int
    brake_rows: int = 0
    settle_rows: int = 0
    search_truncated: bool = False


@dataclass(frozen=True, kw_only=True)
class StartSearch:
    """How hard another start is sought for a refused session.

    slews: solved, from the first row on that closed forms leave open.  growth: of the rows from
    one to the next.  failures: candidates that closed forms leave open, until the search ends with
    none found.  work_rows: of `effort`, for all ways of moving it.  is_quick: whether the whole
    request is tried with smooth slews, which are taken where no quicker ones are found, and
    without a judge.
    """

    slews: int
    growth: int
    failures: int
    work_rows: float
    is_quick: bool


class Mover(Protocol):
    """The motion of one scenario's platform.

    settle_rows: on a target, before its session can begin.
    """

    start_search: ClassVar[StartSearch]

    @property
    def settle_rows(self) -> int: ...

    def planning(self, scenario: Scenario) -> "Mover":
        """Of a scenario with other sessions, to plan it: it knows the slews that this one has
        solved."""
        ...

    def trying(self, scenario: Scenario) -> "Mover":
        """Of a scenario with other sessions, or another objective, to find out whether it can be
        flown: it knows the slews that this one has solved or refused."""
        ...

    def initial(self, ephemeris: Ephemeris) -> State:
        """How it moves at row 0; raises InfeasibleSlew where no table can begin so."""
        ...

    def ways(
        self, ephemeris: Ephemeris, number: int, session: Session, from_row: int, state: State
    ) -> tuple[TrackBranch, ...]:
        """Every way to hold the target over the session, the shortest slew first.

        number: the session's index, for refusals.  session: that session, or the same with other
        times.  from_row: the target is of no use before.  state: where the platform comes from.
        Raises NotVisible, Unreachable, TrackBreaksLimit; InfeasibleSlew where it begins too soon.
        """
        ...

    def state_at(self, branch: TrackBranch, row: int) -> State:
        """What a slew must arrive with to follow the branch's track from a row on."""
        ...

    def may_slew(self, state: State, there: State, rows: int) -> bool:
        """Whether a slew may lead from state to state in exactly so many rows."""
        ...

    def least_s(self, state: State, there: State) -> float:
        """No motion between them is quicker."""
        ...

    def first_row_in_reach(
        self, branch: TrackBranch, from_row: int, state: State, last_row: int
    ) -> int | None:
        """The first row, up to that one, on which nothing known forbids that a slew joins early."""
        ...

    def slew_onto(
        self,
        branch: TrackBranch,
        from_row: int,
        state: State,
        *,
        thorough: bool = True,
        early: bool = True,
        prove: bool = False,
    ) -> Join:
        """Slew from `state` at row `from_row` onto a branch's track; raises InfeasibleSlew.

        early: whether the objective "minimum_time" joins the track before the session's first row.
        thorough: whether the best detour around cones is sought, not only some detour.  prove:
        where there is none, show it before searching long.
        """
        ...

    def with_final_slew(self, ephemeris: Ephemeris, joins: list[Join]) -> list[Join]:
        """The joins, and a slew to the final state where one is asked for and not reached."""
        ...

    def held(
        self, ephemeris: Ephemeris, session: Session, los: LineOfSight, state: State
    ) -> Iterator[Mask]:
        """Of every way to point at a target, between which of its rows it is held, (n - 1,).

        state: where the platform comes from.
        """
        ...

    def table(self, epoch_utc: datetime, joins: list[Join]) -> CommandTable:
        """Slews and tracks put together."""
        ...

    def run(self, number: int | None, join: Join) -> SlewRun:
        """The figures of one slew.  number: of the session it leads to."""
        ...

    def budget(
        self,
        ephemeris: Ephemeris,
        table: CommandTable,
        number: int,
        los: LineOfSight | None = None,
    ) -> PointingBudget | None:
        """The pointing budget of a session; None where no target is looked at."""
        ...

    def error_covariance_rad2(
        self, ephemeris: Ephemeris, table: CommandTable, number: int, los: LineOfSight
    ) -> Array:
        """Of a session's target in the image at the instants of `los`, by the budget's causes.

        (n, 2, 2), in the order of the frame's sides.
        """
        ...

    def idle_motion(self, instants: Instants, states: OrbitStates) -> Motion:
        """Of a body on its idle attitude, of axes at zero, at 7 or more even instants."""
        ...

    def warnings_along(self, table: CommandTable) -> tuple[str, ...]:
        """What the user should know about the base that it moves against."""
        ...
