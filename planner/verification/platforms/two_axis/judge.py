"""The judge of two axes: angles and rates, and the cubic Hermite between their rows."""

import math
from collections.abc import Iterator
from functools import cached_property

import numpy as np

from planner.base.arrays import Array, Indices, Mask
from planner.base.commands import COMMAND_STEP_S, ROWS_PER_S, CommandTable
from planner.verification.field_masks import mask_margins
from planner.verification.platforms.judge import FlownInstants, JudgedSession
from planner.verification.platforms.two_axis.axis_path import AxisPath
from planner.verification.platforms.two_axis.bench_motion import bench_session
from planner.verification.platforms.two_axis.carrier import (
    DERIVED_LAWS,
    boresight_platform,
    eci_from_platform,
)
from planner.verification.platforms.two_axis.hermite import AxisHermite
from planner.verification.platforms.two_axis.keep_out import keep_out_margins
from planner.verification.platforms.two_axis.limits import axis_margins, slow_stretches
from planner.verification.report import (
    ExclusionMargin,
    Finding,
    GyroMargin,
    KeepOutMargin,
    LimitMargin,
    MaskMargin,
    SlowStretch,
    table_fault,
)
from planner.verification.session import table_session
from planner.world.frames.time_scales import shifted_utc
from planner.world.orbits import OrbitStates
from planner.world.platforms import AxisLimits
from planner.world.rules.two_axis import axes_of, final_angle_rad, initial_motion, limits_of
from planner.world.scenario import Scenario
from planner.world.targets import BenchMotionTarget

ROWS_MIN = 2
CARRIER_RATE_RAD_S = math.radians(1.0)  # none turns faster
# A tenth of what pointing may err by; solvers meet their end conditions to about a thousandth.
END_ANGLE_TOLERANCE_RAD = math.radians(0.01 / 3600.0)
END_RATE_TOLERANCE_RAD_S = math.radians(0.01 / 3600.0)


class TwoAxisJudge:
    """Of axes on a carrier whose attitude the scenario gives."""

    def __init__(self, table: CommandTable, scenario: Scenario) -> None:
        self._table, self._scenario, self._platform = table, scenario, axes_of(scenario)

    @cached_property
    def _axes(self) -> tuple[tuple[str, AxisHermite, AxisLimits], ...]:
        columns = zip(self._table.position.T, self._table.rate_rad_s.T, strict=True)
        hermites = (AxisHermite(angle_rad, rate_rad_s) for angle_rad, rate_rad_s in columns)
        return tuple(
            zip(self._platform.axis_names, hermites, limits_of(self._scenario), strict=True)
        )

    def fault(self) -> Finding | None:
        """The axes' names, shapes and numbers."""
        table, names = self._table, self._platform.axis_names
        shape = table.position.shape
        if table.dof_names != names:
            return table_fault(
                f"the axes are {', '.join(table.dof_names)}, the platform's {', '.join(names)}"
            )
        if shape != table.rate_rad_s.shape or len(shape) != 2 or shape[1] != len(names):
            return table_fault(
                f"angles of shape {shape} and rates of shape {table.rate_rad_s.shape} are no table "
                f"of {len(names)} axes"
            )
        if shape[0] < ROWS_MIN:
            return table_fault(f"a table needs at least {ROWS_MIN} rows, not {shape[0]}")
        finite = np.isfinite(table.position) & np.isfinite(table.rate_rad_s)
        if not finite.all():
            row, column = (int(index) for index in np.argwhere(~finite)[0])
            return Finding(
                limit="table",
                axis=names[column],
                t_s=row / ROWS_PER_S,
                at_utc=shifted_utc(table.epoch_utc, row / ROWS_PER_S),
                detail=f"row {row} of {names[column]} holds no finite number",
            )
        return None

    def row_findings(self) -> Iterator[Finding]:
        """Whether every axis starts in its initial state, and ends at rest where it was asked."""
        yield from self._initial_state_findings()
        if self._scenario.final_state is not None:
            yield from self._final_state_findings()

    def _initial_state_findings(self) -> Iterator[Finding]:
        table, scenario = self._table, self._scenario
        for column, axis in enumerate(axes_of(scenario).axis_names):
            angle_rad, rate_rad_s, _ = initial_motion(scenario, axis)
            angle_off_rad = float(table.position[0, column] - angle_rad)
            rate_off_rad_s = float(table.rate_rad_s[0, column] - rate_rad_s)
            if (
                abs(angle_off_rad) > END_ANGLE_TOLERANCE_RAD
                or abs(rate_off_rad_s) > END_RATE_TOLERANCE_RAD_S
            ):
                yield Finding(
                    limit="initial_state",
                    axis=axis,
                    t_s=0.0,
                    at_utc=table.epoch_utc,
                    detail=(
                        f"row 0 of {axis} is {math.degrees(angle_off_rad):+.3g} deg and "
                        f"{math.degrees(rate_off_rad_s):+.3g} deg/s from the initial state"
                    ),
                )

    def _final_state_findings(self) -> Iterator[Finding]:
        """Whether every axis ends at rest, and where it was asked to."""
        table, scenario = self._table, self._scenario
        end_s = (len(table.position) - 1) / ROWS_PER_S
        for column, axis in enumerate(axes_of(scenario).axis_names):
            asked_rad = final_angle_rad(scenario)
            off_rad = (
                0.0 if asked_rad is None else float(table.position[-1, column]) - asked_rad[column]
            )
            rate_rad_s = float(table.rate_rad_s[-1, column])
            if abs(off_rad) > END_ANGLE_TOLERANCE_RAD or abs(rate_rad_s) > END_RATE_TOLERANCE_RAD_S:
                yield Finding(
                    limit="final_state",
                    axis=axis,
                    t_s=end_s,
                    at_utc=shifted_utc(table.epoch_utc, end_s),
                    detail=(
                        f"the last row of {axis} is {math.degrees(off_rad):+.3g} deg and "
                        f"{math.degrees(rate_rad_s):+.3g} deg/s from the final state, at rest"
                    ),
                )

    def margins(self) -> tuple[LimitMargin, ...]:
        """Of every axis: stops, rate, acceleration, jerk, steps of acceleration at rows."""
        return tuple(
            margin
            for axis, hermite, limits in self._axes
            for margin in axis_margins(
                axis,
                hermite,
                limits,
                float(initial_motion(self._scenario, axis)[2]),
                self._table.epoch_utc,
            )
        )

    def keep_out(self) -> tuple[KeepOutMargin, ...]:
        """Of the slews' cones."""
        return keep_out_margins(self._table, self._scenario, self)

    def masks(self) -> tuple[MaskMargin, ...]:
        """To the platform's masks."""
        masks = self._platform.masks
        if not masks:
            return ()
        path = AxisPath(self._platform, tuple(hermite for _, hermite, _ in self._axes))
        return mask_margins(masks, path, self._table.epoch_utc)

    def exclusions(self) -> tuple[ExclusionMargin, ...]:
        """None: what the carrier turns away from somebody else plans."""
        return ()

    def gyros(self) -> tuple[GyroMargin, ...]:
        """None: drives turn its axes."""
        return ()

    def slow_stretches(self, cells: Mask, *, standing: bool) -> Iterator[SlowStretch]:
        """By axis, then by time."""
        for axis, hermite, limits in self._axes:
            flown = cells if standing else cells & ~hermite.is_resting
            changes = np.flatnonzero(np.diff(np.concatenate([[False], flown, [False]])))
            for first, last in zip(changes[::2].tolist(), changes[1::2].tolist(), strict=True):
                rows = range(first, last + 1)
                yield from slow_stretches(
                    axis, hermite, limits.rate_min_rad_s, rows, self._table.epoch_utc
                )

    def boresight_eci(self, at: FlownInstants, states: OrbitStates) -> Array:
        """Of the payload, turned by the axes, on the platform, turned by the carrier."""
        boresight = boresight_platform(self._platform, self._angle_rad(at.cell, at.u_s))
        return self._eci_from_platform(boresight, at, states)

    def direction_eci(self, direction: Array, at: FlownInstants, states: OrbitStates) -> Array:
        """Of a direction in the platform's frame."""
        return self._eci_from_platform(np.tile(direction, (len(at.cell), 1)), at, states)

    def is_idle_at(self, rows: Indices) -> Mask:
        """Where all axes stand."""
        return np.asarray(
            np.abs(self._table.rate_rad_s[rows]).max(axis=1) <= END_RATE_TOLERANCE_RAD_S
        )

    def turn_most_rad(self) -> Array:
        """The axes' and the carrier's together."""
        rate_rad_s = np.abs(self._table.rate_rad_s).sum(axis=1)
        return np.asarray(
            (rate_rad_s + CARRIER_RATE_RAD_S) * COMMAND_STEP_S
            + sum(limits.acceleration_max_rad_s2 for _, _, limits in self._axes) * COMMAND_STEP_S**2
        )

    def session_findings(
        self, number: int, at: FlownInstants, states: OrbitStates
    ) -> Iterator[Finding]:
        """Nothing: axes that reach the target may look at it."""
        return iter(())

    def prescribed(self, number: int, rows: range, target: BenchMotionTarget) -> JudgedSession:
        """A bench session's, whose target gives the axes' angles."""
        flight = table_session(self._table, self._scenario, self, number, rows)
        return bench_session(flight, self._angle_rad(flight.at.cell, flight.at.u_s), target)

    @property
    def derives_attitude(self) -> bool:
        """How far measurements turn the carrier from its law is taken as given."""
        attitude = self._scenario.law
        return isinstance(attitude, DERIVED_LAWS) and not attitude.corrections

    def _angle_rad(self, cell: Indices, u_s: Array) -> Array:
        """Shape (n, m)."""
        return np.stack([hermite.angle_at(cell, u_s) for _, hermite, _ in self._axes], axis=1)

    def _eci_from_platform(
        self, vector_platform: Array, at: FlownInstants, states: OrbitStates
    ) -> Array:
        return eci_from_platform(
            vector_platform, self._platform, self._scenario.law, at.instants, states
        )
