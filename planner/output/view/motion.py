"""Motion of the axes: as flown between rows, and as the paper's spline would move them."""

from collections.abc import Iterator

import numpy as np

from planner.base.arrays import Array, Indices
from planner.base.commands import COMMAND_STEP_S, ROWS_PER_S, CommandTable
from planner.base.table_motion import accelerations_rad_s2
from planner.motion.baseline import paper_profiles
from planner.motion.slew import AxisState
from planner.output.view.columns import AxisMotion, BaselineSlew
from planner.world.frames.time_scales import elapsed_s
from planner.world.plan import FlightPlan


def motion_at_rows(table: CommandTable, row: Indices) -> dict[str, AxisMotion]:
    """By axis, at rows by their numbers, (n,); at the last of the cell that ends there."""
    cell = np.minimum(row, len(table.t_s) - 2)
    begin, end = np.moveaxis(accelerations_rad_s2(table, cell), 1, 0)
    rate = table.rate_rad_s[row]
    angle = np.full_like(rate, np.nan)
    if table.acceleration_rad_s2 is None:
        angle = table.position[row]
    acceleration = np.where((row > cell)[:, None], end, begin)
    jerk = (end - begin) / COMMAND_STEP_S
    return _by_axis(table.dof_names, angle, rate, acceleration, jerk)


def _by_axis(axis_names: tuple[str, ...], *motion: Array) -> dict[str, AxisMotion]:
    """motion: angles, rates, accelerations and jerks, (n, m) each."""
    angle, rate, acceleration, jerk = motion
    return {
        name: AxisMotion(
            angle_rad=angle[:, axis],
            rate_rad_s=rate[:, axis],
            acceleration_rad_s2=acceleration[:, axis],
            jerk_rad_s3=jerk[:, axis],
        )
        for axis, name in enumerate(axis_names)
    }


def baseline_slews(plan: FlightPlan, every: int) -> Iterator[BaselineSlew]:
    """Of each slew, at every so many rows and its end; none of a spline's plan, nor of a body's."""
    table = plan.table
    if not plan.scenario.slew.keeps_limits or table.acceleration_rad_s2 is not None:
        return
    for segment in plan.segments:
        if segment.kind != "slew":
            continue
        first, last = (
            round(elapsed_s(moment, table.epoch_utc) * ROWS_PER_S)
            for moment in (segment.start_utc, segment.stop_utc)
        )
        profiles = paper_profiles(
            _states(table, first, 0.0 * table.rate_rad_s[first]),
            _states(table, last, _acceleration_after(table, last)),
            (last - first) / ROWS_PER_S,
            plan.scenario.slew,
        )
        row = np.unique([*range(first, last, every), last])
        parts = [profile.evaluate((row - first) / ROWS_PER_S) for profile in profiles]
        motion = (np.stack([part[order] for part in parts], axis=1) for order in range(4))
        yield BaselineSlew(
            session=segment.session,
            t_s=row / ROWS_PER_S,
            axes=_by_axis(table.dof_names, *motion),
        )


def _states(table: CommandTable, row: int, acceleration_rad_s2: Array) -> tuple[AxisState, ...]:
    return tuple(
        AxisState(angle_rad=float(q), rate_rad_s=float(v), acceleration_rad_s2=float(a))
        for q, v, a in zip(
            table.position[row], table.rate_rad_s[row], acceleration_rad_s2, strict=True
        )
    )


def _acceleration_after(table: CommandTable, row: int) -> Array:
    """Of the track that begins there, (m,), by its rates on three rows; 0 where the table ends.

    The spline needs it only to aim ahead by its filter's lag: an error of 1 % is 0.01 arcsec.
    """
    rate = table.rate_rad_s[row : row + 3]
    if len(rate) < 3:
        return np.zeros(rate.shape[1])
    return np.asarray((-3.0 * rate[0] + 4.0 * rate[1] - rate[2]) / (2.0 * COMMAND_STEP_S))
