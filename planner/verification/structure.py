"""The check that the table is whole: epoch, axes and start right, finite, long enough."""

import math
from collections.abc import Iterator
from datetime import datetime

import numpy as np

from planner.base.commands import ROWS_PER_S, CommandTable
from planner.verification.clock import elapsed_us
from planner.verification.report import Finding
from planner.world.frames.time_scales import shifted_utc, utc_text
from planner.world.scenario import Scenario, Session

STEP_US = 1_000_000 // ROWS_PER_S
TIME_RESOLUTION_US = 1  # of a datetime: a session a microsecond past a row belongs to that row
ROWS_MIN = 2
# A tenth of what pointing may err by; solvers meet their end conditions to about a thousandth.
END_ANGLE_TOLERANCE_RAD = math.radians(0.01 / 3600.0)
END_RATE_TOLERANCE_RAD_S = math.radians(0.01 / 3600.0)


def unflyable(table: CommandTable, scenario: Scenario) -> Finding | None:
    """What leaves nothing to judge, else None."""
    names = scenario.platform.axis_names
    shape = table.position.shape
    if table.epoch_utc.utcoffset() is None:
        return _fault("the epoch has no UTC offset")
    if table.dof_names != names:
        return _fault(
            f"the axes are {', '.join(table.dof_names)}, the platform's {', '.join(names)}"
        )
    if shape != table.rate_rad_s.shape or len(shape) != 2 or shape[1] != len(names):
        return _fault(
            f"angles of shape {shape} and rates of shape {table.rate_rad_s.shape} are no table "
            f"of {len(names)} axes"
        )
    if shape[0] < ROWS_MIN:
        return _fault(f"a table needs at least {ROWS_MIN} rows, not {shape[0]}")
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


def structure_findings(table: CommandTable, scenario: Scenario) -> Iterator[Finding]:
    """Faults that still leave limits and pointing to judge."""
    epoch_utc = table.epoch_utc
    if epoch_utc.microsecond % STEP_US:
        yield _fault(f"the epoch {utc_text(epoch_utc, 6)} is no multiple of 0.2 s after its second")
    late_us = elapsed_us(epoch_utc, scenario.initial_state.epoch)
    if late_us:
        yield _fault(
            f"the epoch {utc_text(epoch_utc, 6)} is {late_us / 1e6:+g} s from the initial state's"
        )
    yield from _initial_state_findings(table, scenario)
    if scenario.final_state is not None:
        yield from _final_state_findings(table, scenario)
    for number, session in enumerate(scenario.sessions):
        rows = session_rows(session, epoch_utc)
        if not covers(table, rows):
            yield Finding(
                limit="coverage",
                detail=(
                    f"session {number + 1} needs rows {rows[0]}..{rows[-1]}, "
                    f"the table has 0..{len(table.position) - 1}"
                ),
            )


def session_rows(session: Session, epoch_utc: datetime) -> range:
    """From the row at or before the start to the row at or after the stop, both included."""
    first = (elapsed_us(session.start, epoch_utc) + TIME_RESOLUTION_US) // STEP_US
    last = -((TIME_RESOLUTION_US - elapsed_us(session.stop, epoch_utc)) // STEP_US)
    return range(first, last + 1)


def covers(table: CommandTable, rows: range) -> bool:
    """Whether the table holds all these rows."""
    return rows[0] >= 0 and rows[-1] < len(table.position)


def _initial_state_findings(table: CommandTable, scenario: Scenario) -> Iterator[Finding]:
    for column, axis in enumerate(scenario.platform.axis_names):
        angle_rad, rate_rad_s, _ = scenario.initial_motion(axis)
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


def _final_state_findings(table: CommandTable, scenario: Scenario) -> Iterator[Finding]:
    """Whether every axis ends at rest, and where it was asked to."""
    end_s = (len(table.position) - 1) / ROWS_PER_S
    for column, axis in enumerate(scenario.platform.axis_names):
        asked_rad = scenario.final_angle_rad
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


def _fault(detail: str) -> Finding:
    return Finding(limit="table", detail=detail)
