"""The motion of two axes on a carrier that somebody else steers."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import datetime
from typing import ClassVar

import numpy as np

from planner.base import effort
from planner.base.arrays import Array, Mask
from planner.base.commands import COMMAND_STEP_S, ROWS_PER_S, CommandTable, Motion
from planner.base.errors import InfeasibleSlew
from planner.base.solvers import merged
from planner.base.table_motion import motion_at
from planner.motion.baseline import compare_with_spline
from planner.motion.pointing.keep_out import keep_out_view
from planner.motion.pointing.line_of_sight import LineOfSight
from planner.motion.pointing.track import held_cells
from planner.motion.slew import AxisState, require_brakable
from planner.planning.sessions.budget import PointingBudget
from planner.planning.sessions.plan import SlewRun, unproven_share
from planner.planning.sessions.platforms.mover import Join, StartSearch, TrackBranch
from planner.planning.sessions.platforms.two_axis import joining
from planner.planning.sessions.platforms.two_axis.budget import (
    error_covariance_rad2,
    pointing_budget,
)
from planner.planning.sessions.platforms.two_axis.earliest_join import track_states
from planner.planning.sessions.platforms.two_axis.final import with_final_slew
from planner.planning.sessions.platforms.two_axis.slew_timing import least_slew_s
from planner.planning.sessions.platforms.two_axis.tracks import track_branches
from planner.planning.sessions.track_branches import (
    OPTIONS as TRACK_BRANCH_OPTIONS,
)
from planner.planning.sessions.track_branches import los_on_rows, session_rows
from planner.world.attitude.lvlh import level_warnings
from planner.world.frames.time_scales import Instants
from planner.world.orbits import Ephemeris, OrbitStates
from planner.world.rules.two_axis import axes_of, initial_motion, limits_of
from planner.world.scenario import Scenario, Session
from planner.world.targets import BenchMotionTarget, VisibleTarget

States = tuple[AxisState, ...]
AWAY_ROWS = ROWS_PER_S  # from a cone or mask, out of which no slew comes at once


@dataclass(frozen=True)
class TwoAxisMover:
    """As `Mover` says; a state is that of each axis, its base turns by an attitude law."""

    # The solver needs a row or two more than closed forms say.
    start_search: ClassVar = StartSearch(
        slews=3, growth=1, failures=1, work_rows=math.inf, is_quick=False
    )

    settle_rows: ClassVar = 0

    scenario: Scenario

    def planning(self, scenario: Scenario) -> "TwoAxisMover":
        return TwoAxisMover(scenario)

    def trying(self, scenario: Scenario) -> "TwoAxisMover":
        return TwoAxisMover(scenario)

    def initial(self, ephemeris: Ephemeris) -> States:
        scenario = self.scenario
        names = axes_of(scenario).axis_names
        motions = (initial_motion(scenario, axis).tolist() for axis in names)
        state = tuple(
            AxisState(angle_rad=q, rate_rad_s=v, acceleration_rad_s2=a) for q, v, a in motions
        )
        if scenario.slew.keeps_limits:
            require_brakable(names, state, limits_of(scenario))
        self._require_outside(ephemeris, state)
        return state

    def ways(
        self, ephemeris: Ephemeris, number: int, session: Session, from_row: int, state: States
    ) -> tuple[TrackBranch, ...]:
        angle_rad = np.array([axis.angle_rad for axis in state])
        return track_branches(self.scenario, ephemeris, number, session, from_row, angle_rad)

    def state_at(self, branch: TrackBranch, row: int) -> States:
        return track_states(branch.track, row / ROWS_PER_S)

    def may_slew(self, state: States, there: States, rows: int) -> bool:
        return joining.may_slew_between(self.scenario, state, there, rows)

    def least_s(self, state: States, there: States) -> float:
        return least_slew_s(state, there, limits_of(self.scenario))

    def first_row_in_reach(
        self, branch: TrackBranch, from_row: int, state: States, last_row: int
    ) -> int | None:
        return joining.first_row_in_reach(self.scenario, branch, from_row, state, last_row)

    def slew_onto(
        self,
        branch: TrackBranch,
        from_row: int,
        state: States,
        *,
        thorough: bool = True,
        early: bool = True,
        prove: bool = False,
    ) -> Join:
        return joining.slew_onto(
            self.scenario, branch, from_row, state, thorough=thorough, early=early, prove=prove
        )

    def with_final_slew(self, ephemeris: Ephemeris, joins: list[Join]) -> list[Join]:
        return with_final_slew(self.scenario, ephemeris, joins)

    def held(
        self, ephemeris: Ephemeris, session: Session, los: LineOfSight, state: States
    ) -> Iterator[Mask]:
        scenario, t_s = self.scenario, los.instants.t_s
        view = keep_out_view(scenario, ephemeris, float(t_s[0]), float(t_s[-1]))
        platform = axes_of(scenario).with_limits(limits_of(scenario))
        for angle_rad, held in held_cells(platform, los):
            if view is not None:
                effort.charge(TRACK_BRANCH_OPTIONS.cone_row * len(t_s) * len(view.regions))
                inside = view.depths_rad(t_s - t_s[0], angle_rad).max(axis=0) > 0.0
                near = np.convolve(inside, np.ones(2 * AWAY_ROWS + 1), "same") > 0.0
                held &= ~(near[1:] | near[:-1])
            yield held

    def table(self, epoch_utc: datetime, joins: list[Join]) -> CommandTable:
        """Row by row: braked to rest, at rest until each slew begins, the slew, the track.

        A row shared by two of them is the later one's.  What a slew leaves as end error is
        flown as it dies away.
        """
        last = joins[-1].track.axis_states
        angle_rad, rate_rad_s = np.empty((2, joins[-1].stop_row + 1, last.shape[-1]))
        from_row = 0
        for join in joins:
            slew_t_s = np.arange(join.join_row - join.slew_row + 1) / ROWS_PER_S
            slew = slice(join.slew_row, join.join_row + 1)
            angle_rad[slew], rate_rad_s[slew], _, _ = join.slew.motion(slew_t_s)
            at_rest = slice(from_row + join.brake_rows, join.slew_row)
            angle_rad[at_rest], rate_rad_s[at_rest] = angle_rad[join.slew_row], 0.0
            if join.brake:
                brake = slice(from_row, from_row + join.brake_rows)
                brake_t_s = np.arange(join.brake_rows) / ROWS_PER_S
                angle_rad[brake], rate_rad_s[brake], _, _ = join.brake.motion(brake_t_s)
            track = slice(join.join_row, join.stop_row + 1)
            track_t_s = np.arange(join.join_row, join.stop_row + 1) / ROWS_PER_S
            angle_rad[track], rate_rad_s[track], _ = join.track.motion(track_t_s)
            if join.slew.settling_s:
                since_join_s = track_t_s[:, None] - track_t_s[0]
                left_rad = np.exp(-since_join_s / join.slew.settling_s) * join.slew.end_error_rad
                angle_rad[track] += left_rad
                rate_rad_s[track] -= left_rad / join.slew.settling_s
            from_row = join.stop_row
        return CommandTable(
            epoch_utc=epoch_utc,
            channels=self.scenario.platform.channels,
            position=angle_rad,
            rate_rad_s=rate_rad_s,
        )

    def run(self, number: int | None, join: Join) -> SlewRun:
        slew, options = join.slew, self.scenario.slew
        optimised = options.keeps_limits
        cost_rad2_s5, bound_rad2_s5 = slew.jerk_squared_integral, sum(slew.lower_bounds_rad2_s5)
        parts = [part for part in (join.brake, slew) if part]
        return SlewRun(
            session=number,
            backend=options.method,
            status="; ".join(dict.fromkeys(slew.status)),
            iterations=sum(part.iterations for part in parts),
            wall_s=sum(part.wall_s for part in parts),
            duration_s=slew.duration_s,
            minimum_s=least_slew_s(slew.problem.start, slew.problem.end, slew.problem.limits),
            cost_rad2_s5=cost_rad2_s5 if optimised else None,
            lower_bound_rad2_s5=bound_rad2_s5 if optimised else None,
            gap=unproven_share(cost_rad2_s5, bound_rad2_s5) if optimised else None,
            comparison=compare_with_spline(slew, options, number) if optimised else None,
            solver=merged(run for part in parts for run in part.runs),
        )

    def budget(
        self, ephemeris: Ephemeris, table: CommandTable, number: int, los: LineOfSight | None = None
    ) -> PointingBudget | None:
        """los: over the session and more, where it is known already."""
        scenario = self.scenario
        session = scenario.sessions[number]
        if isinstance(session.target, BenchMotionTarget):
            return None
        rows = session_rows(session, scenario.initial_state.epoch)
        if los is None:
            los = los_on_rows(scenario, ephemeris, session.target, rows)
        los = los.cut_between(rows.start / ROWS_PER_S, rows.stop / ROWS_PER_S)
        return pointing_budget(
            los,
            ephemeris,
            scenario.law,
            session.target,
            axes_of(scenario),
            motion_at(table, los.instants.t_s).position,
            session=number,
        )

    def error_covariance_rad2(
        self, ephemeris: Ephemeris, table: CommandTable, number: int, los: LineOfSight
    ) -> Array:
        """The axes are linear between rows."""
        angle_rad = [np.interp(los.instants.t_s, table.t_s, angle) for angle in table.position.T]
        target = self.scenario.sessions[number].target
        assert isinstance(target, VisibleTarget)  # a test motion looks at nothing
        return error_covariance_rad2(
            los,
            ephemeris,
            self.scenario.law,
            target,
            axes_of(self.scenario),
            np.stack(angle_rad, axis=1),
        )

    def idle_motion(self, instants: Instants, states: OrbitStates) -> Motion:
        return Motion(*(np.zeros((len(instants), 2)) for _ in range(3)))

    def warnings_along(self, table: CommandTable) -> tuple[str, ...]:
        attitude, platform = self.scenario.law, axes_of(self.scenario)
        return (
            *level_warnings(attitude, platform.name, platform.usual_yaw_pitch_roll_deg),
            *attitude.warnings_at(Instants(table.epoch_utc, table.t_s)),
        )

    def _require_outside(self, ephemeris: Ephemeris, state: States) -> None:
        view = keep_out_view(self.scenario, ephemeris, 0.0, COMMAND_STEP_S)
        if view is None:
            return
        angle_rad = np.array([[axis.angle_rad for axis in state]])
        depth_rad: Array = view.depths_rad(np.zeros(1), angle_rad)[:, 0]
        worst = int(np.argmax(depth_rad))
        if depth_rad[worst] > 0.0:
            raise InfeasibleSlew(
                f"the platform begins {math.degrees(depth_rad[worst]):.2f} deg inside "
                f"{view.regions[worst].title}; begin with other angles, or leave that out",
                field="initial_state.angles_deg",
                limit="keep_out",
                at_utc=self.scenario.initial_state.epoch,
            )
