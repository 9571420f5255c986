"""Margins of each axis to its limits, anywhere between the first and the last row."""

import math
from collections.abc import Iterator
from datetime import datetime

import numpy as np

from planner.base.arrays import Array, Indices
from planner.base.commands import COMMAND_STEP_S, ROWS_PER_S, CommandTable
from planner.verification.hermite import AxisHermite, HermiteExtreme
from planner.verification.report import Finding, Limit, LimitMargin, SlowStretch
from planner.verification.structure import session_rows
from planner.world.frames.time_scales import shifted_utc
from planner.world.platforms import AxisLimits
from planner.world.scenario import Scenario

# A solver works to 1e-8 and a drive resolves 1e-4 of its range: neither is worth a rejection.
RELATIVE_TOLERANCE = 1e-6

# Greatest step of acceleration between two cells, in units of jerk limit x cell length, when the
# rows sample one smooth plan: with w the share of the cell still to come, its Hermite starts with
# an acceleration wrong by the integral of (3 w^2 - 2 w) jerk, at most 8/27, and ends likewise.
# More than that means angles and rates that don't belong to one plan within the jerk limit.
ACCELERATION_JUMP = 2.0 * 8.0 / 27.0


def limit_margins(table: CommandTable, scenario: Scenario) -> tuple[LimitMargin, ...]:
    """For every axis: both stops, rate, acceleration, jerk, steps of acceleration at rows."""
    return tuple(
        LimitMargin(
            axis=axis,
            kind=kind,
            limit=bound,
            extreme=extreme.value,
            margin=margin,
            t_s=extreme.t_s,
            at_utc=shifted_utc(table.epoch_utc, extreme.t_s),
        )
        for column, (axis, limits) in enumerate(
            zip(scenario.platform.axis_names, scenario.axis_limits, strict=True)
        )
        for kind, bound, extreme, margin in _extremes(
            axis_hermite(table, column), limits, float(scenario.initial_motion(axis)[2])
        )
    )


def limit_findings(margins: tuple[LimitMargin, ...], scenario: Scenario) -> Iterator[Finding]:
    """One error for each limit that is broken by more than rounding."""
    half_travel_rad = {
        axis: 0.5 * (limits.angle_max_rad - limits.angle_min_rad)
        for axis, limits in zip(scenario.platform.axis_names, scenario.axis_limits, strict=True)
    }
    for margin in margins:
        is_stop = margin.kind in ("angle_min", "angle_max")
        scale = half_travel_rad[margin.axis] if is_stop else margin.limit
        if margin.margin < -RELATIVE_TOLERANCE * scale:
            yield Finding(
                limit=margin.kind,
                axis=margin.axis,
                t_s=margin.t_s,
                at_utc=margin.at_utc,
                detail=(
                    f"{margin.axis} reaches {math.degrees(margin.extreme):.6g} {margin.unit}, "
                    f"{math.degrees(-margin.margin):.3g} {margin.unit} past its limit of "
                    f"{math.degrees(margin.limit):.6g} {margin.unit} ({margin.kind}), "
                    f"{margin.t_s:.3f} s after the table's epoch"
                ),
            )


def axis_hermite(table: CommandTable, column: int) -> AxisHermite:
    """One axis of the table as it is flown."""
    return AxisHermite(table.position[:, column], table.rate_rad_s[:, column])


def angles_at(table: CommandTable, cell: Indices, u_s: Array) -> Array:
    """Angles, shape (n, m), u_s after the rows that n cells begin with."""
    columns = range(len(table.dof_names))
    return np.stack([axis_hermite(table, k).angle_at(cell, u_s) for k in columns], axis=1)


def slow_stretches(
    axis: str, hermite: AxisHermite, rate_min_rad_s: float, rows: range, epoch_utc: datetime
) -> Iterator[SlowStretch]:
    """Where the rate stays below rate_min between the first and the last of `rows`, exactly."""
    hermite = hermite.over(rows)
    starts_s = np.arange(rows[0], rows[-1]) / ROWS_PER_S
    crossings_s = np.concatenate(
        [hermite.crossings_s(rate_min_rad_s), hermite.crossings_s(-rate_min_rad_s)]
    )
    with np.errstate(invalid="ignore"):
        in_cell = (crossings_s > 0.0) & (crossings_s < COMMAND_STEP_S)
    rows_s = np.arange(rows[0], rows[-1] + 1) / ROWS_PER_S
    edges_s = np.unique(np.concatenate([rows_s, (starts_s + crossings_s)[in_cell]]))
    edges_s = edges_s[(edges_s >= rows_s[0]) & (edges_s <= rows_s[-1])]
    middle_s = 0.5 * (edges_s[:-1] + edges_s[1:])
    cell = np.clip((middle_s * ROWS_PER_S).astype(np.intp) - rows[0], 0, rows[-1] - rows[0] - 1)
    slow = np.abs(hermite.rate_at(cell, middle_s - starts_s[cell])) < rate_min_rad_s
    changes = np.flatnonzero(np.diff(np.concatenate([[False], slow, [False]])))
    for first, last in zip(changes[::2], changes[1::2], strict=True):
        start_s, stop_s = float(edges_s[first]), float(edges_s[last])
        yield SlowStretch(
            axis=axis,
            start_s=start_s,
            stop_s=stop_s,
            start_utc=shifted_utc(epoch_utc, start_s),
            stop_utc=shifted_utc(epoch_utc, stop_s),
        )


def slow_outside_sessions(table: CommandTable, scenario: Scenario) -> Iterator[SlowStretch]:
    """The same wherever no session is held; an axis that stands still is not slow."""
    held = np.zeros(len(table.position) - 1, dtype=bool)
    for session in scenario.sessions:
        rows = session_rows(session, table.epoch_utc)
        held[max(rows[0], 0) : max(rows[-1], 0)] = True
    for column, (axis, limits) in enumerate(
        zip(scenario.platform.axis_names, scenario.axis_limits, strict=True)
    ):
        hermite = axis_hermite(table, column)
        moving = np.concatenate([[False], ~held & ~hermite.is_resting, [False]])
        changes = np.flatnonzero(np.diff(moving))
        for first, last in zip(changes[::2].tolist(), changes[1::2].tolist(), strict=True):
            yield from slow_stretches(
                axis, hermite, limits.rate_min_rad_s, range(first, last + 1), table.epoch_utc
            )


def _extremes(
    hermite: AxisHermite, limits: AxisLimits, initial_acceleration_rad_s2: float
) -> Iterator[tuple[Limit, float, HermiteExtreme, float]]:
    """The kinds of limit: bound, extreme, and what is left between them."""
    least, greatest = hermite.angle_extremes()
    yield "angle_min", limits.angle_min_rad, least, least.value - limits.angle_min_rad
    yield "angle_max", limits.angle_max_rad, greatest, limits.angle_max_rad - greatest.value
    jump_rad_s2 = ACCELERATION_JUMP * limits.jerk_max_rad_s3 * COMMAND_STEP_S
    magnitudes: tuple[tuple[Limit, float, HermiteExtreme], ...] = (
        ("rate", limits.rate_max_rad_s, hermite.rate_extreme()),
        ("acceleration", limits.acceleration_max_rad_s2, hermite.acceleration_extreme()),
        ("jerk", limits.jerk_max_rad_s3, hermite.jerk_extreme()),
        (
            "acceleration_jump",
            jump_rad_s2,
            hermite.acceleration_jump_extreme(initial_acceleration_rad_s2),
        ),
    )
    for limit, bound, extreme in magnitudes:
        yield limit, bound, extreme, bound - abs(extreme.value)
