"""Margins of each axis to its limits, anywhere between the first and the last row."""

from collections.abc import Iterator
from datetime import datetime

import numpy as np

from planner.base.commands import COMMAND_STEP_S, ROWS_PER_S
from planner.verification.limits import RELATIVE_TOLERANCE
from planner.verification.platforms.two_axis.hermite import AxisHermite, HermiteExtreme
from planner.verification.report import Limit, LimitMargin, SlowStretch
from planner.world.frames.time_scales import shifted_utc
from planner.world.platforms import AxisLimits

# Greatest step of acceleration between two cells, in units of jerk limit x cell length, when the
# rows sample one smooth plan: with w the share of the cell still to come, its Hermite starts with
# an acceleration wrong by the integral of (3 w^2 - 2 w) jerk, at most 8/27, and ends likewise.
# More than that means angles and rates that don't belong to one plan within the jerk limit.
ACCELERATION_JUMP = 2.0 * 8.0 / 27.0


def axis_margins(
    axis: str,
    hermite: AxisHermite,
    limits: AxisLimits,
    initial_acceleration_rad_s2: float,
    epoch_utc: datetime,
) -> Iterator[LimitMargin]:
    """Of one axis: both stops, rate, acceleration, jerk, steps of acceleration at rows."""
    half_travel_rad = 0.5 * (limits.angle_max_rad - limits.angle_min_rad)
    for kind, bound, extreme, margin in _extremes(hermite, limits, initial_acceleration_rad_s2):
        is_stop = kind in ("angle_min", "angle_max")
        yield LimitMargin(
            axis=axis,
            kind=kind,
            limit=bound,
            extreme=extreme.value,
            margin=margin,
            tolerance=RELATIVE_TOLERANCE * (half_travel_rad if is_stop else bound),
            t_s=extreme.t_s,
            at_utc=shifted_utc(epoch_utc, extreme.t_s),
        )


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
