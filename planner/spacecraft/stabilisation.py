"""How steady was the spacecraft while imaging?  From closed-loop runs, per interval."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from planner.spacecraft.definition import AgileSpacecraft
from planner.spacecraft.flight import Log
from planner.spacecraft.table import TICK_S, AttitudeTable, ImagingWindow
from planner.spacecraft.verification import SpacecraftVerification

Array = NDArray[np.float64]
RATE_ERROR_MAX_RAD_S = math.radians(0.001)  # Platonov, Sumarokov 2019
ASSUMPTIONS = (
    "gimbal servo 50 rad/s, damping 0.7 (the paper gives the form, no numbers)",
    "flexible modes 2.0, 2.1, 3.4, 5.5, 9.5 Hz with 5, 5, 3, 1, 0.5 % of the inertia, damping "
    "0.005 (the paper: about 2 Hz for the solar arrays, modes up to 10 Hz)",
    "dispersions: frequency +-20 %, coupling x0.5-1.5, damping x0.5-2, inertia +-1 %",
    "gimbal execution error +-(1 % + 0.0069 deg/s), both constant in a run, uniformly drawn",
    "gimbal angles read to 1 arcsec and fed back to the gimbal rates",
    "rotor drives disturb with 1 mN m at 0.3-3 Hz",
    "gyro noise 5e-5 deg/s a sample, bias 1e-5 deg/s, scale 2e-5; star trackers 5 arcsec, "
    "once a second, used between imaging intervals only",
    "control gains 2.0 1/s and 0.5 1/s^2, Butterworth 1.5 Hz on the rate error, feed-forward "
    "from the table; commands act at the tick they are measured at (see gains.delay_ticks)",
    "gravity gradient is the only external torque",
    "32 TDI lines set the exposure the smear is counted over",
    "light time and aberration (16 m on the ground, alike for all points) are left out",
)


@dataclass(frozen=True, kw_only=True)
class FlownWindow:
    """One imaging interval over all runs.

    rate_error_rad_s: (3,), largest magnitude per body axis at 5 ms steps; rms_rad_s: root mean
    square of the vector.  steady: within 0.001 deg/s on every axis, in every run.
    pointing_error_rad: largest angle between flown and commanded optical axis, what the
    computer can't know included.  settled_s: from the end of the interval before (the
    session's start) until the rate error is within 0.001 deg/s for good; spare_s: from then
    to the interval's start, negative when it began too early.
    smear_px: largest rate error across the optical axis times the exposure.
    momentum_margin_n_m_s, gimbal_margin: least distance to the momentum sphere and to
    singularity (smallest singular value of D) since the interval before.
    gimbal_rate_rad_s: fastest gimbal.
    """

    window: ImagingWindow
    rate_error_rad_s: Array
    rms_rad_s: float
    steady: bool
    pointing_error_rad: float
    settled_s: float
    spare_s: float
    smear_px: float
    momentum_margin_n_m_s: float
    gimbal_margin: float
    gimbal_rate_rad_s: float


@dataclass(frozen=True, kw_only=True)
class StabilisationReport:
    """All intervals; share_steady: of intervals x runs within 0.001 deg/s (None: no runs)."""

    runs: int
    windows: tuple[FlownWindow, ...]
    share_steady: float | None
    worst_rad_s: float | None


def stabilisation(
    spacecraft: AgileSpacecraft,
    table: AttitudeTable,
    verification: SpacecraftVerification,
    logs: Sequence[Log],
) -> StabilisationReport:
    """Summarise closed-loop runs of a table."""
    if not logs or not table.windows:
        return StabilisationReport(runs=len(logs), windows=(), share_steady=None, worst_rad_s=None)
    windows, within = [], []
    before = 0
    for number, window in enumerate(table.windows):
        exposure_s = verification.windows[number].line_time_s * spacecraft.camera.tdi_lines
        windows.append(_flown(spacecraft, logs, window, before, exposure_s))
        within += [_within(log, window) for log in logs]
        before = window.last_row
    return StabilisationReport(
        runs=len(logs),
        windows=tuple(windows),
        share_steady=float(np.mean(within)),
        worst_rad_s=float(max(np.max(w.rate_error_rad_s) for w in windows)),
    )


def rate_errors(log: Log, first_row: int, last_row: int) -> Array:
    """Rate error at every simulation step between two rows, (m, 3), rad/s."""
    per_tick = len(log.rate_error) // len(log.rate)
    return np.asarray(log.rate_error[first_row * per_tick : last_row * per_tick])


def _within(log: Log, window: ImagingWindow) -> bool:
    errors = rate_errors(log, window.first_row, window.last_row)
    return bool(np.max(np.abs(errors)) <= RATE_ERROR_MAX_RAD_S)


def settled_after_s(log: Log, first_row: int, last_row: int) -> float:
    """Seconds from first_row until the rate error stays within 0.001 deg/s up to last_row."""
    over = np.any(np.abs(rate_errors(log, first_row, last_row)) > RATE_ERROR_MAX_RAD_S, axis=1)
    if not over.any():
        return 0.0
    per_tick = len(log.rate_error) // len(log.rate)
    return float((np.flatnonzero(over)[-1] + 1) * TICK_S / per_tick)


def _flown(
    spacecraft: AgileSpacecraft,
    logs: Sequence[Log],
    window: ImagingWindow,
    before_row: int,
    exposure_s: float,
) -> FlownWindow:
    inside = slice(window.first_row, window.last_row)
    since = slice(before_row, window.last_row)
    errors = np.concatenate([rate_errors(log, window.first_row, window.last_row) for log in logs])
    off_axis = [np.linalg.norm(log.attitude_error[inside][:, [0, 2]], axis=1).max() for log in logs]
    settled_s = max(settled_after_s(log, before_row, window.last_row) for log in logs)
    across = np.linalg.norm(errors[:, [0, 2]], axis=1).max()
    stored = max(np.linalg.norm(log.momentum[since], axis=1).max() for log in logs)
    margin = min(spacecraft.array.singularity_margin(log.gimbal[since]).min() for log in logs)
    return FlownWindow(
        window=window,
        rate_error_rad_s=np.max(np.abs(errors), axis=0),
        rms_rad_s=float(np.sqrt(np.mean(np.sum(errors**2, axis=1)))),
        steady=all(_within(log, window) for log in logs),
        pointing_error_rad=float(max(off_axis)),
        settled_s=settled_s,
        spare_s=(window.first_row - before_row) * TICK_S - settled_s,
        smear_px=float(across * exposure_s / spacecraft.camera.pixel_rad),
        momentum_margin_n_m_s=float(spacecraft.slew.momentum_sphere_n_m_s - stored),
        gimbal_margin=float(margin),
        gimbal_rate_rad_s=float(max(np.abs(log.gimbal_rate[since]).max() for log in logs)),
    )
