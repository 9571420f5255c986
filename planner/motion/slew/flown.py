"""The motion flown from rows every 0.2 s: the cubic Hermite between them."""

import numpy as np

from planner.base.arrays import Indices
from planner.base.commands import COMMAND_STEP_S
from planner.motion.pointing.hermite import cubic_range
from planner.motion.slew.problem import LIMIT_TOLERANCE
from planner.motion.slew.solution import AxisProfile
from planner.world.platforms import AxisLimits

REPRODUCTION_RAD = np.deg2rad(0.1 / 3600.0)  # how far the flown Hermite may leave the plan
SAMPLES_PER_ROW = 8  # the deviation is a quartic bump in a cell: its peak is met within 4 %


def rows_in(duration_s: float) -> int:
    """How many command steps a slew of duration_s takes; ValueError if it isn't a whole number."""
    rows = round(duration_s / COMMAND_STEP_S)
    if rows < 1 or abs(rows * COMMAND_STEP_S - duration_s) > 1e-6 * COMMAND_STEP_S:
        raise ValueError(
            f"duration_s must be a multiple of the command step, 0.2 s, not {duration_s}"
        )
    return rows


def reproduces(profile: AxisProfile, rows: int, limits: AxisLimits) -> bool:
    """Whether the Hermite of the sampled profile keeps the limits and the plan to 0.1 arcsec.

    The jerk of the Hermite is a weighted mean of the plan's, so it needs no test.
    """
    return (
        not cells_that_break(profile, rows, limits).size
        and not cells_that_leave(profile, rows).size
    )


def cells_that_break(profile: AxisProfile, rows: int, limits: AxisLimits) -> Indices:
    """Cells between two rows in which the Hermite passes a limit of angle, rate, acceleration."""
    angle, rate = profile.lowest(np.linspace(0.0, profile.duration_s, rows + 1), 2)
    ranges = cubic_range(profile.duration_s / rows, angle[:, None], rate[:, None])
    broken = np.zeros(rows, dtype=bool)
    for (least, greatest), (low, high) in zip(ranges[:3], limits.bounds[:3], strict=True):
        slack = LIMIT_TOLERANCE * (high - low)
        broken |= (greatest[:, 0] > high + slack) | (least[:, 0] < low - slack)
    return np.flatnonzero(broken)


def cells_that_leave(profile: AxisProfile, rows: int) -> Indices:
    """Cells in which the Hermite is more than 0.1 arcsec from the profile."""
    step_s = profile.duration_s / rows
    cells = _cells_in_doubt(profile, rows)
    s = np.arange(1, SAMPLES_PER_ROW) / SAMPLES_PER_ROW
    starts_s = cells.astype(float) * step_s
    angle0, rate0 = profile.lowest(starts_s, 2)
    angle1, rate1 = profile.lowest(starts_s + step_s, 2)
    between = (starts_s[:, None] + s * step_s).ravel()
    planned = profile.lowest(between, 1)[0].reshape(len(cells), len(s))
    h00, h01 = (1.0 + 2.0 * s) * (1.0 - s) ** 2, s**2 * (3.0 - 2.0 * s)
    h10, h11 = s * (1.0 - s) ** 2 * step_s, s**2 * (s - 1.0) * step_s
    hermite = (
        np.outer(angle0, h00) + np.outer(angle1, h01) + np.outer(rate0, h10) + np.outer(rate1, h11)
    )
    return np.asarray(cells[(np.abs(hermite - planned) > REPRODUCTION_RAD).any(axis=1)])


def _cells_in_doubt(profile: AxisProfile, rows: int) -> Indices:
    """Cells with a breakpoint inside, and those where the fourth derivative is large.

    Elsewhere the Hermite's error is at most step^4 / 384 of that derivative (de Boor 2001, ch. V).
    """
    step_s = profile.duration_s / rows
    at_row = profile.breakpoints_s / step_s
    begins, ends = np.floor(at_row[:-1] + 1e-9), np.ceil(at_row[1:] - 1e-9)
    inside = np.flatnonzero(np.abs(at_row - np.round(at_row)) > 1e-9)
    powers = np.arange(4, profile.coefficients.shape[1])
    width = np.diff(profile.breakpoints_s)[:, None]
    scale = powers * (powers - 1) * (powers - 2) * (powers - 3)
    fourth = np.abs(profile.coefficients[:, 4:] * scale * width ** (powers - 4)).sum(axis=1)
    doubtful = np.flatnonzero(fourth * step_s**4 / 384.0 > REPRODUCTION_RAD)
    cells = [np.floor(at_row[inside])]
    cells += [np.arange(begins[piece], ends[piece]) for piece in doubtful]
    return np.unique(np.clip(np.concatenate(cells), 0, rows - 1)).astype(np.intp)
