"""The check of a bench session's motion, on the rows and between them."""

import math
from collections.abc import Iterator

import numpy as np

from planner.base.arrays import Array
from planner.base.errors import InvalidInput
from planner.verification.clock import elapsed_us
from planner.verification.platforms.judge import JudgedSession
from planner.verification.report import Finding
from planner.verification.session import TableSession
from planner.world.targets import BenchMotionTarget, PrescribedMotion

BETWEEN_ROWS_MAX_RAD = math.radians(0.1 / 3600.0)  # what the 0.2 s table promises of its cubics
# Rows are the motion's own values; the first is where the slew ends, met to a thousandth.
AT_ROWS_MAX_RAD = math.radians(0.01 / 3600.0)
AT_ROWS_MAX_RAD_S = math.radians(0.01 / 3600.0)


def bench_session(
    flight: TableSession, angle_rad: Array, target: BenchMotionTarget
) -> JudgedSession:
    """Its error is the larger one of the axes' angles, (n, m).

    Where the motion stands at each instant is taken from the target.
    """
    table, number = flight.table, flight.number
    start_utc = target.start if target.start is not None else flight.scenario.sessions[number].start
    since_s = flight.t_s - elapsed_us(start_utc, table.epoch_utc) / 1e6
    try:
        motion = target.axis_motion(table.dof_names, since_s)
    except InvalidInput as refusal:
        detail = f"session {number + 1}: {refusal.detail}"
        return None, (Finding(limit="motion", detail=detail),)
    error_rad = np.abs(angle_rad - motion.angle_rad).max(axis=1)
    report = flight.report(error_rad, allowed_rad=BETWEEN_ROWS_MAX_RAD)
    return report, tuple(_findings(flight, angle_rad, motion))


def _findings(
    flight: TableSession, angle_rad: Array, motion: PrescribedMotion
) -> Iterator[Finding]:
    table, is_row, rows = flight.table, flight.is_row, slice(flight.rows[0], flight.rows[-1] + 1)
    angle_off_rad = angle_rad - motion.angle_rad
    rate_off_rad_s = np.zeros_like(angle_off_rad)
    rate_off_rad_s[is_row] = table.rate_rad_s[rows] - motion.rate_rad_s[is_row]
    allowed_rad = np.where(is_row, AT_ROWS_MAX_RAD, BETWEEN_ROWS_MAX_RAD)[:, None]
    excess = np.maximum(
        np.abs(angle_off_rad) / allowed_rad, np.abs(rate_off_rad_s) / AT_ROWS_MAX_RAD_S
    )
    for column, axis in enumerate(table.dof_names):
        worst = int(np.argmax(excess[:, column]))
        if not excess[worst, column] <= 1.0:
            angle, rate = (off[worst, column] for off in (angle_off_rad, rate_off_rad_s))
            yield flight.error(
                "motion",
                worst,
                f"{axis} is {math.degrees(angle) * 3600.0:+.3f} arcsec and "
                f"{math.degrees(rate) * 3600.0:+.3f} arcsec/s off the motion asked for"
                f"{'' if is_row[worst] else ', between rows'}",
                axis,
            )
