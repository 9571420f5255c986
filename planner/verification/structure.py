"""The check that the table is whole: epoch and columns right, long enough for its sessions."""

from collections.abc import Iterator
from datetime import datetime

from planner.base.commands import ROWS_PER_S, CommandTable
from planner.verification.clock import elapsed_us
from planner.verification.platforms.judge import Judge
from planner.verification.report import Finding, table_fault
from planner.world.frames.time_scales import shifted_utc, utc_text
from planner.world.scenario import Scenario, Session

STEP_US = 1_000_000 // ROWS_PER_S
TIME_RESOLUTION_US = 1  # of a datetime: a session a microsecond past a row belongs to that row


def unflyable(table: CommandTable, judge: Judge) -> Finding | None:
    """What leaves nothing to judge, else None."""
    if table.epoch_utc.utcoffset() is None:
        return table_fault("the epoch has no UTC offset")
    return judge.fault()


def structure_findings(table: CommandTable, scenario: Scenario, judge: Judge) -> Iterator[Finding]:
    """Faults that still leave limits and pointing to judge."""
    epoch_utc = table.epoch_utc
    if epoch_utc.microsecond % STEP_US:
        yield table_fault(
            f"the epoch {utc_text(epoch_utc, 6)} is no multiple of 0.2 s after its second"
        )
    late_us = elapsed_us(epoch_utc, scenario.initial_state.epoch)
    if late_us:
        yield table_fault(
            f"the epoch {utc_text(epoch_utc, 6)} is {late_us / 1e6:+g} s from the initial state's"
        )
    yield from judge.row_findings()
    if scenario.final_by is not None:
        last_us = (len(table.t_s) - 1) * STEP_US
        over_us = last_us - elapsed_us(scenario.final_by, epoch_utc)
        if over_us > TIME_RESOLUTION_US:
            yield Finding(
                limit="final_state",
                t_s=last_us / 1e6,
                at_utc=shifted_utc(epoch_utc, last_us / 1e6),
                detail=f"the table ends {over_us / 1e6:g} s after {utc_text(scenario.final_by)}, "
                "by when its last state was asked for",
            )
    for number, session in enumerate(scenario.sessions):
        rows = session_rows(session, epoch_utc)
        if not covers(table, rows):
            yield Finding(
                limit="coverage",
                detail=(
                    f"session {number + 1} needs rows {rows[0]}..{rows[-1]}, "
                    f"the table has 0..{len(table.t_s) - 1}"
                ),
            )


def session_rows(session: Session, epoch_utc: datetime) -> range:
    """From the row at or before the start to the row at or after the stop, both included."""
    first = (elapsed_us(session.start, epoch_utc) + TIME_RESOLUTION_US) // STEP_US
    last = -((TIME_RESOLUTION_US - elapsed_us(session.stop, epoch_utc)) // STEP_US)
    return range(first, last + 1)


def covers(table: CommandTable, rows: range) -> bool:
    """Whether the table holds all these rows."""
    return rows[0] >= 0 and rows[-1] < len(table.t_s)
