"""The instants at which a session is judged, and what is reported of them."""

from dataclasses import dataclass
from datetime import datetime

import numpy as np

from planner.base.arrays import Array, Mask
from planner.base.commands import COMMAND_STEP_S, ROWS_PER_S, CommandTable
from planner.verification.platforms.judge import FlownInstants, Judge
from planner.verification.report import Finding, Limit, OffTarget, SessionReport
from planner.world.frames.time_scales import Instants, shifted_utc
from planner.world.scenario import Scenario

POINTS_PER_CELL = 4  # the row, and three: a Hermite errs like u^2 (1-u)^2, most in the middle


@dataclass(frozen=True, eq=False)
class TableSession:
    """What the table flies over one session, at n instants, every `POINTS_PER_CELL`th one a row.

    number: the session's.
    """

    table: CommandTable
    scenario: Scenario
    judge: Judge
    number: int
    rows: range
    at: FlownInstants

    @property
    def t_s(self) -> Array:
        """Since the table's epoch, shape (n,)."""
        return self.at.instants.t_s

    @property
    def is_row(self) -> Mask:
        return np.asarray(np.arange(len(self.t_s)) % POINTS_PER_CELL == 0)

    def utc(self, index: int) -> datetime:
        """The instant of that index."""
        return shifted_utc(self.table.epoch_utc, float(self.t_s[index]))

    def error(self, limit: Limit, index: int, what: str, axis: str | None = None) -> Finding:
        """What is wrong at the instant of that index."""
        return Finding(
            limit=limit,
            axis=axis,
            t_s=float(self.t_s[index]),
            at_utc=self.utc(index),
            detail=f"session {self.number + 1}: {what}",
        )

    def report(
        self,
        error_rad: Array,
        *,
        allowed_rad: float,
        off_target: tuple[OffTarget, ...] = (),
    ) -> SessionReport:
        """error_rad: of each instant, shape (n,)."""
        rows, epoch_utc = self.rows, self.table.epoch_utc
        worst = int(np.argmax(error_rad))
        cells = np.zeros(len(self.table.t_s) - 1, dtype=bool)
        cells[rows[0] : rows[-1]] = True
        return SessionReport(
            session=self.number,
            start_utc=shifted_utc(epoch_utc, rows[0] / ROWS_PER_S),
            stop_utc=shifted_utc(epoch_utc, rows[-1] / ROWS_PER_S),
            max_rad=float(error_rad[worst]),
            max_t_s=float(self.t_s[worst]),
            max_at_utc=self.utc(worst),
            rms_rad=float(np.sqrt(np.mean(error_rad**2))),
            rows_max_rad=float(error_rad[self.is_row].max()),
            between_rows_max_rad=float(error_rad[~self.is_row].max()),
            allowed_rad=allowed_rad,
            off_target=off_target,
            slow_stretches=tuple(self.judge.slow_stretches(cells, standing=True)),
        )


def table_session(
    table: CommandTable, scenario: Scenario, judge: Judge, number: int, rows: range
) -> TableSession:
    """What is flown over rows that the table has."""
    cells = len(rows) - 1
    points = np.arange(POINTS_PER_CELL * cells + 1)
    cell = np.minimum(points // POINTS_PER_CELL, cells - 1)
    u_s = (points - POINTS_PER_CELL * cell) * (COMMAND_STEP_S / POINTS_PER_CELL)
    t_s = (POINTS_PER_CELL * rows[0] + points) / (ROWS_PER_S * POINTS_PER_CELL)
    return TableSession(
        table=table,
        scenario=scenario,
        judge=judge,
        number=number,
        rows=rows,
        at=FlownInstants(rows[0] + cell, u_s, Instants(table.epoch_utc, t_s)),
    )
