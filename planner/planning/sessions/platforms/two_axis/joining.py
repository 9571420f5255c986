"""The slew from the platform's state onto one session's track."""

from planner.base import effort
from planner.base.commands import ROWS_PER_S
from planner.base.effort import at_most
from planner.base.errors import InfeasibleSlew
from planner.motion.baseline import in_paper_time, paper_slew
from planner.motion.detour.detour import avoid_cones
from planner.motion.pointing.keep_out import KeepOutView, keep_out_view
from planner.motion.slew import AxisState, SlewProblem, SlewSolution, broken_limit, optimal_slew
from planner.planning.sessions.platforms.mover import Join, TrackBranch
from planner.planning.sessions.platforms.two_axis.earliest_join import Approach, track_states
from planner.planning.sessions.platforms.two_axis.slew_timing import (
    TimedSlew,
    may_slew_within_lead,
    slew_within_lead,
)
from planner.world.rules.two_axis import axes_of, limits_of
from planner.world.scenario import Scenario


def slew_onto(
    scenario: Scenario,
    branch: TrackBranch,
    from_row: int,
    state: tuple[AxisState, ...],
    *,
    thorough: bool = True,
    early: bool = True,
    prove: bool = False,
) -> Join:
    """Slew from `state` at row `from_row` onto one branch's track.

    With the objective "minimum_time" the track is joined as early as the slew can and the
    target is seen, else at the first row of the session, as without `early`.  thorough: whether
    the best detour around cones is sought, not only some detour.  prove: where there is none, show
    it before searching long.  Raises InfeasibleSlew.
    """
    start_row = branch.rows.start
    if start_row <= from_row:
        raise InfeasibleSlew("no time is left for a slew before the session", limit="duration")
    for states, does in (
        (state, "begins"),
        (track_states(branch.track, start_row / ROWS_PER_S), "ends"),
    ):
        _require_within_limits(scenario, states, does)
    keep_out = keep_out_view(
        scenario, branch.ephemeris, from_row / ROWS_PER_S, start_row / ROWS_PER_S
    )
    met, search_truncated = None, False
    if early and _joins_early(scenario):
        # What is left must do for a slew to the session's first row.
        with at_most(effort.remaining() / 2.0) as search:
            met = _approach_of(scenario, branch, from_row, state).earliest_join(
                scenario.slew,
                after_s=branch.seen_from_s,
                until_s=start_row / ROWS_PER_S,
                keep_out=keep_out,
            )
        search_truncated = search.is_exhausted
    if met is None:
        timed = _slew(scenario, branch, from_row, state, keep_out, thorough=thorough, prove=prove)
        join_row = start_row
    else:
        timed, join_row = met.timed, round(met.t_s * ROWS_PER_S)
        search_truncated = search_truncated or met.search_truncated
    slew = timed.slew
    return Join(
        slew=slew,
        brake=timed.brake,
        brake_rows=round(timed.brake.duration_s * ROWS_PER_S) if timed.brake else 0,
        track=branch.track,
        slew_row=join_row - round(slew.duration_s * ROWS_PER_S),
        join_row=join_row,
        stop_row=branch.rows.stop,
        search_truncated=search_truncated or slew.search_truncated,
    )


def may_slew_between(
    scenario: Scenario, state: tuple[AxisState, ...], there: tuple[AxisState, ...], rows: int
) -> bool:
    """Whether a slew may lead from state to state in exactly so many rows."""
    if rows <= 0:
        return False
    if not scenario.slew.keeps_limits:
        return True
    return may_slew_within_lead(state, there, limits_of(scenario), scenario.slew, rows)


def first_row_in_reach(
    scenario: Scenario,
    branch: TrackBranch,
    from_row: int,
    state: tuple[AxisState, ...],
    last_row: int,
) -> int | None:
    """The first row, up to that one, on which closed forms leave open that a slew joins early."""
    if not _joins_early(scenario):
        return None
    approach = _approach_of(scenario, branch, from_row, state)
    return next(approach.rows_within_reach(branch.seen_from_s, last_row / ROWS_PER_S), None)


def _approach_of(
    scenario: Scenario, branch: TrackBranch, from_row: int, state: tuple[AxisState, ...]
) -> Approach:
    return Approach(
        track=branch.track, limits=limits_of(scenario), start=state, start_s=from_row / ROWS_PER_S
    )


def _joins_early(scenario: Scenario) -> bool:
    return scenario.slew.keeps_limits and scenario.slew.objective == "minimum_time"


def _slew(
    scenario: Scenario,
    branch: TrackBranch,
    from_row: int,
    state: tuple[AxisState, ...],
    keep_out: KeepOutView | None,
    *,
    thorough: bool,
    prove: bool,
) -> TimedSlew:
    """To the first row of the session."""
    problem = SlewProblem(
        axis_names=branch.track.axis_names,
        limits=limits_of(scenario),
        start=state,
        end=track_states(branch.track, branch.rows.start / ROWS_PER_S),
        duration_s=(branch.rows.start - from_row) / ROWS_PER_S,
        avoid_modes=scenario.slew.avoid_modes,
        keep_out=keep_out,
    )

    def solve_slew(part: SlewProblem) -> SlewSolution:
        if scenario.slew.keeps_limits:
            return avoid_cones(optimal_slew(part, on_rows=True), thorough=thorough, prove=prove)
        if scenario.slew.objective == "minimum_time":
            part = in_paper_time(part)
        return paper_slew(part, scenario.slew)

    return slew_within_lead(problem, scenario.slew, solve_slew)


def _require_within_limits(scenario: Scenario, state: tuple[AxisState, ...], does: str) -> None:
    """A track keeps its limits on its own rows; between rows that are finer it may not."""
    for name, axis, limits in zip(
        axes_of(scenario).axis_names, state, limits_of(scenario), strict=True
    ):
        limit = broken_limit(axis, limits)
        if limit is not None:
            raise InfeasibleSlew(
                f"the slew {does} on a track that needs more {limit} of {name} there than it has; "
                "choose other times",
                axis=name,
                limit=limit,
            )
