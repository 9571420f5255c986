"""The motion of a spacecraft that turns as a whole, from its idle attitude and back to it."""

import math
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from datetime import datetime
from typing import ClassVar, NamedTuple

import numpy as np

from planner.base import effort
from planner.base.arrays import Array, Indices, Mask
from planner.base.commands import COMMAND_STEP_S, ROWS_PER_S, CommandTable, Motion
from planner.base.errors import InfeasibleSlew, Refusal, figures
from planner.base.rotation import Rotation, of_like_sign
from planner.base.solvers import merged
from planner.base.table_motion import motion_at
from planner.motion.attitude.bounds import least_s, may
from planner.motion.attitude.idle import idle_attitude
from planner.motion.attitude.problem import (
    AvoidedCone,
    BodySlewProblem,
    Objective,
    depths_rad,
    require_ends,
    rows_of,
)
from planner.motion.attitude.slew import BodySlew, solve_attitude_slew
from planner.motion.attitude.track import (
    TargetSight,
    agility_limits,
    attitude_tracks,
    held_cells,
    roll_rule,
)
from planner.motion.pointing.line_of_sight import STENCIL, LineOfSight
from planner.planning.sessions.budget import PointingBudget
from planner.planning.sessions.plan import SlewRun, unproven_share
from planner.planning.sessions.platforms.body_budget import body_budget, body_covariance_rad2
from planner.planning.sessions.platforms.mover import Join, RowSpan, StartSearch, TrackBranch
from planner.planning.sessions.track_branches import (
    early_row,
    los_on_rows,
    require_visible,
    seen_from_s,
    session_rows,
)
from planner.world.exclusions import ExclusionMargin, Surroundings, exclusion_margins
from planner.world.frames.time_scales import Instants, shifted_utc, utc_text
from planner.world.orbits import Ephemeris, OrbitStates
from planner.world.platforms.body import BodyPlatform
from planner.world.platforms.steering import gimbal_rows, total_momentum_eci
from planner.world.scenario import BoundedLead, Scenario, Session
from planner.world.targets import VisibleTarget


@dataclass(frozen=True, kw_only=True)
class BodyMoverOptions:
    """How much time a body's slew is given."""

    recommended_times: float = 10.0  # the least time: as gentle as following a target, as of axes
    fewest_rows: int = 10  # of a slew: the OCP's spans begin and end on rows
    longest_s: float = 3600.0  # of the slew to the idle attitude in the end
    # Onto the idle attitude, of what is recommended: a body that turns fast may need more.
    most_times: int = 8
    track: int = 200  # of `effort`: to find how it lies on a target
    track_row: float = 1.0  # of `effort`: on a row, and again for each exclusion
    null_gain_rad_s: float = 0.02  # of the steering law, as docs/spacecraft.md takes it
    missed: float = 1e-3  # of a rotor's momentum: rates that are held over a row leave less
    inside_rad: float = 1e-6  # of an exclusion: 0.2 arcsec, more than the OCP leaves
    # rad, rad/s: ends of one slew on an orbit computed over another span differ by less
    alike: float = 1e-8
    stride: int = 10  # rows between looks where an exclusion is far: the Sun is up for 2 s or more
    sky_rad_s: float = math.radians(0.5)  # limb and glint turn by less than 0.2 deg/s from 200 km


OPTIONS = BodyMoverOptions()


@dataclass(frozen=True, kw_only=True, eq=False)
class MotionTrack:
    """Rows t_s (n,) of a motion on the table's clock; los: what is followed, None of idling."""

    t_s: Array
    motion: Motion
    los: LineOfSight | None = None

    def rows_at(self, first_row: int, last_row: int) -> Motion:
        """From one row of the table to another, both included."""
        begin = first_row - round(float(self.t_s[0]) * ROWS_PER_S)
        return rows_of(self.motion, slice(begin, begin + last_row - first_row + 1))


@dataclass(frozen=True, kw_only=True, eq=False)
class BodySlewParts:
    """A slew, and what comes before it: onto the idle attitude, if need be, and waiting on it."""

    slew: BodySlew
    wait: "_Wait | None" = None
    wall_s: float


class _Wait(NamedTuple):
    """Rows of the idle attitude, on this orbit, and the slew onto the first of them, if need be."""

    onto_idle: BodySlew | None
    rows: RowSpan
    ephemeris: Ephemeris


class _Solved(NamedTuple):
    """A slew, and the wait before it, if any."""

    slew: BodySlew
    wait: _Wait | None


class BodyMover:
    """As `Mover` says; a state is the `Motion` of one instant, the base is GCRF."""

    # Its least time is found, not known in closed form, and a slew that isn't found is dear.
    start_search: ClassVar = StartSearch(
        slews=9, growth=2, failures=2, work_rows=240_000, is_quick=True
    )

    def __init__(self, scenario: Scenario) -> None:
        platform = scenario.platform
        assert isinstance(platform, BodyPlatform)  # by the registry
        self.scenario, self.platform = scenario, platform
        self.limits = agility_limits(platform)
        self.settle_rows = math.ceil(platform.envelope.settle_s * ROWS_PER_S - 1e-6)
        self._is_trying = False
        self._known: dict[tuple[int, ...], list[tuple[Array, _Solved | InfeasibleSlew]]] = {}
        self._idled: dict[tuple[int, int], Motion] = {}

    def planning(self, scenario: Scenario) -> "BodyMover":
        mover = BodyMover(scenario)
        mover._known, mover._idled = self._known, self._idled
        return mover

    def trying(self, scenario: Scenario) -> "BodyMover":
        mover = self.planning(scenario)
        mover._is_trying = True
        return mover

    def initial(self, ephemeris: Ephemeris) -> Motion:
        state = self.scenario.initial_state.body_motion
        if state is None:
            return self._idle(ephemeris, 0, 0)
        rest = np.zeros((1, 3))
        try:
            require_ends(self._problem(state, Motion(state.position, rest, rest), 1))
        except InfeasibleSlew as refusal:
            refusal.field = "initial_state"
            raise
        return state

    def ways(
        self, ephemeris: Ephemeris, number: int, session: Session, from_row: int, state: Motion
    ) -> tuple[TrackBranch, ...]:
        scenario, target = self.scenario, session.target
        assert isinstance(target, VisibleTarget)  # a scenario refuses the others
        rows = session_rows(session, scenario.initial_state.epoch)
        settled = self.settle_rows
        if rows.start < settled:
            raise InfeasibleSlew(
                f"session {number + 1} begins {rows.start / ROWS_PER_S:g} s after the epoch, "
                "before which nothing is planned, and the body has to be on its target "
                f"{self.platform.envelope.settle_s:g} s earlier to settle (agility.settle_s); "
                "begin it later, or put the epoch earlier",
                limit="duration",
            )
        first_row = early_row(scenario, rows.start - settled, from_row)
        wide = RowSpan(start=first_row, stop=max(rows.stop, first_row + STENCIL - 1))
        los = los_on_rows(scenario, ephemeris, target, wide)
        require_visible(scenario, los, rows, target, number)
        sight = _sight(target, los)
        kept = 1 + len(self.platform.exclusions)
        effort.charge(OPTIONS.track + OPTIONS.track_row * kept * len(los.instants))
        try:
            tracks = attitude_tracks(
                self.platform,
                roll_rule(self.platform, target, session.roll),
                sight,
                (rows.start - settled) / ROWS_PER_S,
                rows.stop / ROWS_PER_S,
                Rotation.from_quat(state.position[0]),
            )
        except Refusal as refusal:
            if refusal.field == "roll":
                refusal.field = f"sessions.{number}.roll"
            raise
        seen_s = seen_from_s(los, rows.start / ROWS_PER_S)
        return tuple(
            TrackBranch(
                session=session,
                track=MotionTrack(t_s=track.t_s, motion=track.motion, los=los),
                rows=RowSpan(start=rows.start - settled, stop=rows.stop),
                seen_from_s=max(seen_s, float(track.t_s[0])),
                ephemeris=ephemeris,
                settle_rows=settled,
            )
            for track in tracks
        )

    def state_at(self, branch: TrackBranch, row: int) -> Motion:
        state: Motion = branch.track.rows_at(row, row)
        return state

    def may_slew(self, state: Motion, there: Motion, rows: int) -> bool:
        return rows > 0 and may(self._problem(state, there, rows))

    def least_s(self, state: Motion, there: Motion) -> float:
        return least_s(self._problem(state, there, 1).with_patience(ROWS_PER_S * 3600))

    def first_row_in_reach(
        self, branch: TrackBranch, from_row: int, state: Motion, last_row: int
    ) -> int | None:
        if self.scenario.slew.objective != "minimum_time" or last_row <= from_row:
            return None
        goal, first_row = self._early_goal(branch, from_row, last_row)
        problem = BodySlewProblem(
            start=state, goal=goal, first_arrival_row=first_row - from_row, limits=self.limits
        )
        needed_s = least_s(problem)
        return None if math.isinf(needed_s) else from_row + round(needed_s * ROWS_PER_S)

    def slew_onto(
        self,
        branch: TrackBranch,
        from_row: int,
        state: Motion,
        *,
        thorough: bool = True,
        early: bool = True,
        prove: bool = False,
    ) -> Join:
        """Exclusions are part of the programme: there is no detour to better or to prove.

        thorough: else it joins where the session begins, even if `early`.
        What was solved or refused once isn't solved again.
        """
        last_row = branch.rows.start
        if last_row <= from_row:
            settling = (
                f", in which the body has to settle for {self.platform.envelope.settle_s:g} s"
                if branch.settle_rows
                else ""
            )
            raise InfeasibleSlew(
                f"no time is left for a slew before the session{settling}", limit="duration"
            )
        began_s = time.perf_counter()
        if early and thorough and self.scenario.slew.objective == "minimum_time":
            goal, first_row = self._early_goal(branch, from_row, last_row)
        else:
            goal, first_row = branch.track.rows_at(last_row, last_row), last_row
        known = self._solved_once(branch, from_row, state, goal, first_row)
        if isinstance(known, InfeasibleSlew):
            raise known
        slew, wait = known
        slew_row = from_row if wait is None else wait.rows.stop
        return Join(
            slew=BodySlewParts(slew=slew, wait=wait, wall_s=time.perf_counter() - began_s),
            track=branch.track,
            slew_row=slew_row,
            join_row=slew_row + len(slew.motion.position) - 1,
            stop_row=branch.rows.stop,
            settle_rows=branch.settle_rows,
            brake_rows=0 if wait is None else wait.rows.start - from_row,
        )

    def _solved_once(
        self, branch: TrackBranch, from_row: int, state: Motion, goal: Motion, first_row: int
    ) -> _Solved | InfeasibleSlew:
        """As `_solve_to`, or what is known of ends that are alike."""
        there = rows_of(goal, slice(-1, None))
        ends = np.concatenate(
            [
                part.ravel()
                for end in (state, there)
                for part in (Rotation.from_quat(end.position).as_matrix(), end.rate_rad_s)
            ]
        )
        way = branch.rows.start, from_row
        for known_ends, known in self._known.get((first_row, *way), ()):
            if np.max(np.abs(known_ends - ends)) <= OPTIONS.alike:
                return known
        solved: _Solved | InfeasibleSlew
        tried_rows = {first_row}
        try:
            solved = self._solve_to(branch, from_row, state, goal, first_row)
        except InfeasibleSlew as refusal:
            solved = refusal
            if refusal.limit != "exclusion":  # which may depend on the other rows of the goal
                tried_rows.add(branch.rows.start)  # in the end, too
        for row in tried_rows:
            self._known.setdefault((row, *way), []).append((ends, solved))
        return solved

    def _solve_to(
        self, branch: TrackBranch, from_row: int, state: Motion, goal: Motion, first_row: int
    ) -> _Solved:
        """Onto a goal that ends where the session begins, its rows from first_row on."""
        slew_row, there = from_row, rows_of(goal, slice(-1, None))
        wait = self._wait(branch.ephemeris, from_row, state, branch.rows.start, there)
        if wait is not None:
            slew_row = wait.rows.stop
            state = self._idle(branch.ephemeris, slew_row, slew_row)
            goal, first_row = there, branch.rows.start
        return _Solved(self._solve(branch.ephemeris, slew_row, state, goal, first_row), wait)

    def with_final_slew(self, ephemeris: Ephemeris, joins: list[Join]) -> list[Join]:
        if self.scenario.final_state is None:
            return joins
        last = joins[-1]
        state = last.track.rows_at(last.stop_row, last.stop_row)
        epoch_utc, stop_s = self.scenario.initial_state.epoch, last.stop_row / ROWS_PER_S
        until_utc = shifted_utc(epoch_utc, stop_s + OPTIONS.longest_s + STENCIL / ROWS_PER_S)
        onward = self.scenario.orbit.ephemeris(shifted_utc(epoch_utc, stop_s), until_utc)
        most_rows = round(OPTIONS.longest_s * ROWS_PER_S)
        most_rows = int(min(most_rows, self.scenario.final_rows(last.stop_row)))
        if most_rows < OPTIONS.fewest_rows:
            raise InfeasibleSlew(
                f"after the last session {max(most_rows, 0) / ROWS_PER_S:g} s are left for the "
                "slew onto the idle attitude; end it earlier, or let final_by be later",
                field="final_by",
                limit="duration",
            )
        idle = self._idle(onward, last.stop_row, last.stop_row + most_rows)
        there = rows_of(idle, slice(1))
        rows = self._most_rows(state, there) or self._recommended_rows(state, there)
        goal_row = last.stop_row + min(rows, most_rows)
        track = MotionTrack(
            t_s=np.arange(last.stop_row, last.stop_row + most_rows + 1) / ROWS_PER_S, motion=idle
        )
        branch = TrackBranch(
            session=self.scenario.sessions[-1],
            track=track,
            rows=RowSpan(start=goal_row, stop=goal_row),
            seen_from_s=stop_s,
            ephemeris=onward,
        )
        try:
            final = self.slew_onto(branch, last.stop_row, state)
        except InfeasibleSlew as refusal:
            if self.scenario.final_by is not None:
                refusal.field = refusal.field or "final_by"
            raise
        return [*joins, Join(**(vars(final) | {"stop_row": final.join_row}))]

    def held(
        self, ephemeris: Ephemeris, session: Session, los: LineOfSight, state: Motion
    ) -> Iterator[Mask]:
        """By each sense of the session's roll rule; where it has been settled, too."""
        assert isinstance(session.target, VisibleTarget)  # a scenario refuses the others
        roll = roll_rule(self.platform, session.target, session.roll)
        sight = _sight(session.target, los)
        q_eci_from_body_before = Rotation.from_quat(state.position[0])
        return held_cells(self.platform, roll, sight, q_eci_from_body_before)

    def table(self, epoch_utc: datetime, joins: list[Join]) -> CommandTable:
        parts: list[Motion] = []
        for join in joins:
            wait: _Wait | None = join.slew.wait
            if wait is not None:
                if wait.onto_idle is not None:
                    parts.append(wait.onto_idle.motion)
                ends = wait.rows.start, wait.rows.stop
                if ends not in self._idled:
                    self._idled[ends] = self._idle(wait.ephemeris, *ends)
                parts.append(self._idled[ends])
            parts += [join.slew.slew.motion, join.track.rows_at(join.join_row, join.stop_row)]
        # A row that two share is the later one's.
        parts = [*(rows_of(part, slice(-1)) for part in parts[:-1]), parts[-1]]
        position = np.concatenate([part.position for part in parts])
        rate_rad_s = np.concatenate([part.rate_rad_s for part in parts])
        self._require_clear(epoch_utc, position, rate_rad_s)
        imaging = np.zeros(len(position) - 1, dtype=bool)
        for join in joins:
            imaging[join.join_row : join.stop_row] = True
        return CommandTable(
            epoch_utc=epoch_utc,
            channels=self.platform.channels,
            position=of_like_sign(position),
            rate_rad_s=rate_rad_s,
            acceleration_rad_s2=np.concatenate([part.acceleration_rad_s2 for part in parts]),
            extra_rad=self._gimbals(epoch_utc, position, rate_rad_s, imaging),
        )

    def run(self, number: int | None, join: Join) -> SlewRun:
        slew: BodySlew = join.slew.slew
        onto_idle = join.slew.wait.onto_idle if join.slew.wait is not None else None
        runs = [part.run for part in (onto_idle, slew) if part is not None]
        gap = unproven_share(slew.cost_rad2_s5, slew.bound_rad2_s5)
        return SlewRun(
            session=number,
            backend=self.scenario.slew.method,
            status="optimal" if slew.is_best == "jerk" else f"best found, gap {gap:.1%}",
            iterations=sum(run.iterations for run in runs),
            wall_s=join.slew.wall_s,
            duration_s=slew.duration_s,
            minimum_s=self.least_s(
                rows_of(slew.motion, slice(1)), rows_of(slew.motion, slice(-1, None))
            ),
            cost_rad2_s5=slew.cost_rad2_s5,
            lower_bound_rad2_s5=slew.bound_rad2_s5,
            gap=gap,
            comparison=None,
            solver=merged(runs),
        )

    def budget(
        self,
        ephemeris: Ephemeris,
        table: CommandTable,
        number: int,
        los: LineOfSight | None = None,
    ) -> PointingBudget | None:
        """los: over the session and more, where it is known already."""
        session = self.scenario.sessions[number]
        target = session.target
        assert isinstance(target, VisibleTarget)  # a scenario refuses the others
        rows = session_rows(session, self.scenario.initial_state.epoch)
        if los is None:
            los = los_on_rows(self.scenario, ephemeris, target, rows)
        return body_budget(
            los.cut_between(rows.start / ROWS_PER_S, rows.stop / ROWS_PER_S),
            ephemeris,
            target,
            self.platform,
            table.position[rows.start : rows.stop + 1],
            session=number,
        )

    def error_covariance_rad2(
        self, ephemeris: Ephemeris, table: CommandTable, number: int, los: LineOfSight
    ) -> Array:
        target = self.scenario.sessions[number].target
        assert isinstance(target, VisibleTarget)  # a scenario refuses the others
        position = motion_at(table, los.instants.t_s).position
        return body_covariance_rad2(los, ephemeris, target, self.platform, position)

    def idle_motion(self, instants: Instants, states: OrbitStates) -> Motion:
        return idle_attitude(self.platform.idle, instants, states)

    def warnings_along(self, table: CommandTable) -> tuple[str, ...]:
        """None: it steers itself."""
        return ()

    def _problem(self, state: Motion, there: Motion, rows: int) -> BodySlewProblem:
        return BodySlewProblem(start=state, goal=there, first_arrival_row=rows, limits=self.limits)

    def _early_goal(self, branch: TrackBranch, from_row: int, last_row: int) -> tuple[Motion, int]:
        """The track from the first row at which it may be joined."""
        seen_row = math.ceil(branch.seen_from_s * ROWS_PER_S - 1e-6)
        first_row = min(max(from_row + 1, seen_row), last_row)
        return branch.track.rows_at(first_row, last_row), first_row

    def _recommended_rows(self, state: Motion, there: Motion) -> int:
        least = self.least_s(state, there)
        return max(OPTIONS.fewest_rows, math.ceil(OPTIONS.recommended_times * least * ROWS_PER_S))

    def _most_rows(self, state: Motion, there: Motion) -> int | None:
        """The longest that a slew lasts; None: as long as there is time."""
        lead = self.scenario.slew.lead
        if not isinstance(lead, BoundedLead):
            return None
        if lead.max_duration_s is not None:
            return math.floor(lead.max_duration_s * ROWS_PER_S + 1e-6)
        return self._recommended_rows(state, there)

    def _wait(
        self,
        ephemeris: Ephemeris,
        from_row: int,
        state: Motion,
        last_row: int,
        there: Motion,
        times: int = 1,
    ) -> _Wait | None:
        """The slew onto the idle attitude, unless it is there, and the wait on it; None: none."""
        most_rows = self._most_rows(state, there)
        if most_rows is None or last_row - from_row <= most_rows:
            return None
        idle, idle_row, onto_idle = self._idle(ephemeris, from_row, from_row), from_row, None
        if not all(map(np.array_equal, vars(state).values(), vars(idle).values())):
            idle_row += times * min(self._recommended_rows(state, idle), most_rows)
            if idle_row >= last_row - OPTIONS.fewest_rows:
                return None
            idle = self._idle(ephemeris, idle_row, idle_row)
        slew_row = last_row - (self._most_rows(idle, there) or 0)
        if slew_row <= idle_row:
            return None
        if idle_row > from_row:
            try:
                onto_idle = self._solve(ephemeris, from_row, state, idle, idle_row, "smooth")
            except InfeasibleSlew:
                if times >= OPTIONS.most_times:
                    raise
                return self._wait(ephemeris, from_row, state, last_row, there, 2 * times)
        return _Wait(onto_idle, RowSpan(start=idle_row, stop=slew_row), ephemeris)

    def _solve(
        self,
        ephemeris: Ephemeris,
        from_row: int,
        state: Motion,
        goal: Motion,
        first_row: int,
        objective: Objective | None = None,
    ) -> BodySlew:
        """From a row onto a goal that begins at another; the objective is the scenario's."""
        last_row = first_row + len(goal.position) - 1
        problem = self._problem(state, goal, first_row - from_row)
        cones = self._cones(ephemeris, from_row, last_row, state, goal)
        objective = "any" if self._is_trying else objective or self.scenario.slew.objective
        return solve_attitude_slew(replace(problem, cones=cones, objective=objective))

    def _cones(
        self, ephemeris: Ephemeris, first_row: int, last_row: int, state: Motion, goal: Motion
    ) -> tuple[AvoidedCone, ...]:
        """What a slew keeps away from at every instant: of the exclusions that always count, those
        that some row sees, and that neither its start nor all of its goal lies in."""
        if not self.platform.always_excluded:
            return ()
        instants = self._instants(first_row, last_row)
        surroundings = Surroundings(instants, ephemeris.states(instants))
        cones = []
        for exclusion in self.platform.always_excluded:
            centre_eci, half_rad, counts_rad = surroundings.cone(exclusion.about)
            cone = AvoidedCone(
                name=exclusion.name,
                direction_body=self.platform.direction_of(exclusion),
                centre_eci=centre_eci,
                half_rad=math.radians(exclusion.kept_deg) + float(half_rad.max()),
            )
            start_rad = depths_rad(cone, state.position, cone.centre_eci[:1])
            arrivals = cone.centre_eci[-len(goal.position) :]
            goal_rad = depths_rad(cone, goal.position, arrivals)
            if np.any(counts_rad > 0.0) and max(start_rad[0], goal_rad.min()) <= 0.0:
                cones.append(cone)
        return tuple(cones)

    def _require_clear(
        self, epoch_utc: datetime, q_eci_from_body_xyzw: Array, rate_rad_s: Array
    ) -> None:
        """Raises InfeasibleSlew where the way, or idling, breaks an exclusion that always counts:
        the idle attitude may, and what comes out of the Earth's shadow on the way."""
        always = self.platform.always_excluded
        if not always:
            return
        platform = replace(self.platform, exclusions=always, star_trackers=None)
        count = len(q_eci_from_body_xyzw)
        end_utc = shifted_utc(epoch_utc, (count - 1) / ROWS_PER_S)
        ephemeris = self.scenario.orbit.ephemeris(epoch_utc, end_utc)

        def margins_on(rows: Indices) -> tuple[ExclusionMargin, ...]:
            instants = Instants(epoch_utc, rows / ROWS_PER_S)
            q_eci_from_body = Rotation.from_quat(q_eci_from_body_xyzw[rows])
            around = Surroundings(instants, ephemeris.states(instants))
            return exclusion_margins(platform, q_eci_from_body, around)

        rows = np.unique(np.append(np.arange(0, count, OPTIONS.stride), count - 1))
        turns_rad = COMMAND_STEP_S * (np.linalg.norm(rate_rad_s, axis=1) + OPTIONS.sky_rad_s)
        ways_rad = np.diff(np.append(0.0, np.cumsum(turns_rad))[rows])
        is_near = np.zeros(len(ways_rad), dtype=bool)
        for margin_rad in (one.margin_rad for one in margins_on(rows)):
            is_near |= margin_rad[1:] + margin_rad[:-1] < ways_rad
            is_near |= (margin_rad[1:] == math.pi) != (margin_rad[:-1] == math.pi)
        spans = zip(rows[:-1][is_near], rows[1:][is_near], strict=True)
        rows = np.unique(np.concatenate([rows[:1], *(np.arange(a, b + 1) for a, b in spans)]))
        for margin in margins_on(rows):
            worst = int(np.argmin(margin.margin_rad))
            inside_rad = -float(margin.margin_rad[worst])
            if inside_rad > OPTIONS.inside_rad:
                given = self.scenario.initial_state.body_only
                begins = given and margin.margin_rad[0] < -OPTIONS.inside_rad
                at_utc = shifted_utc(epoch_utc, float(rows[worst]) / ROWS_PER_S)
                raise InfeasibleSlew(
                    f"{margin.name}: at {utc_text(at_utc)} the body stands "
                    f"{math.degrees(inside_rad):.4g} deg {margin.side} {margin.title} than "
                    "allowed, on its way or idling; choose another time, attitude or exclusion",
                    limit="exclusion",
                    field=f"initial_state.{given[0]}" if begins else "platform.exclusions",
                )

    def _gimbals(
        self, epoch_utc: datetime, q_eci_from_body_xyzw: Array, rate_rad_s: Array, imaging: Mask
    ) -> Array | None:
        """Angles and rates of the gyros' gimbals, (n, 8); None: there are no gyros.

        Raises InfeasibleSlew where gravity gives body and gyros more momentum to hold than the
        envelope counts on, or the gimbals can't follow it."""
        gyros = self.platform.gyros
        if gyros is None:
            return None
        inertia_kg_m2 = np.array(self.platform.inertia_kg_m2)
        instants = self._instants(0, len(q_eci_from_body_xyzw) - 1)
        ephemeris = self.scenario.orbit.ephemeris(epoch_utc, instants.utc(-1))
        q_body_from_eci = Rotation.from_quat(q_eci_from_body_xyzw).inv()
        begun_body_n_m_s = inertia_kg_m2 @ rate_rad_s[0] + gyros.start_n_m_s
        total_eci_n_m_s = total_momentum_eci(
            q_body_from_eci,
            q_body_from_eci[0].inv().apply(begun_body_n_m_s),
            ephemeris.states(instants).r_sat_eci_m,
            inertia_kg_m2,
        )
        size_n_m_s = np.linalg.norm(total_eci_n_m_s, axis=1)
        most_n_m_s = gyros.envelope(inertia_kg_m2).total_n_m_s
        worst = int(np.argmax(size_n_m_s))
        if size_n_m_s[worst] > most_n_m_s:
            at_utc = instants.utc(worst)
            size = figures(float(size_n_m_s[worst]), most_n_m_s)
            raise InfeasibleSlew(
                f"gyros: at {utc_text(at_utc)} body and gyros hold {size} N m s together, by what "
                "they begin with and gravity's torque since, more than the "
                f"{most_n_m_s:.4g} that gyros.turns leaves beside turns at the largest rates; "
                "unload the gyros first, plan less at a time, or lower gyros.turns.rate_max_deg_s",
                limit="momentum",
                at_utc=at_utc,
                field="platform.gyros.start_n_m_s",
            )
        array = gyros.array.cmg_array
        held_n_m_s = q_body_from_eci.apply(total_eci_n_m_s) - rate_rad_s @ inertia_kg_m2
        told = gimbal_rows(array, held_n_m_s, imaging, OPTIONS.null_gain_rad_s)
        missed_n_m_s = np.linalg.norm(array.momentum(told[0]) - held_n_m_s, axis=1)
        worst = int(np.argmax(missed_n_m_s))
        if missed_n_m_s[worst] > OPTIONS.missed * array.momentum_n_m_s:
            at_utc = instants.utc(worst)
            raise InfeasibleSlew(
                f"gyros: at {utc_text(at_utc)} the gimbals, none faster than "
                f"{gyros.array.gimbal_rate_max_deg_s:g} deg/s, are {missed_n_m_s[worst]:.3g} N m s "
                "behind what turns the body; lower gyros.turns.torque_max_n_m or "
                "momentum_max_n_m_s",
                limit="torque",
                at_utc=at_utc,
                field="platform.gyros.turns.torque_max_n_m",
            )
        return np.hstack(told)

    def _instants(self, first_row: int, last_row: int) -> Instants:
        """Of the table's rows from one to another, both included."""
        t_s = np.arange(first_row, last_row + 1) / ROWS_PER_S
        return Instants(self.scenario.initial_state.epoch, t_s)

    def _idle(self, ephemeris: Ephemeris, first_row: int, last_row: int) -> Motion:
        """The idle attitude from one row to another, both included."""
        instants = self._instants(first_row, max(last_row, first_row + STENCIL - 1))
        idle = idle_attitude(self.platform.idle, instants, ephemeris.states(instants))
        return rows_of(idle, slice(last_row - first_row + 1))


def _sight(target: VisibleTarget, los: LineOfSight) -> TargetSight:
    """The base is GCRF."""
    return TargetSight(
        target=target, instants=los.instants, states=los.states, los_eci=los.los_base
    )
