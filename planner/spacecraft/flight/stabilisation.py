"""Steadiness of the spacecraft in each imaging interval of closed-loop runs."""

import math
from collections.abc import Sequence

import numpy as np

from planner.inflight.simulation.gyros.closed_loop import Log
from planner.inflight.simulation.gyros.steadiness import rate_errors, settled_after_s
from planner.spacecraft.flight.report import StabilisationReport, WindowSteadiness
from planner.spacecraft.table import TICK_S
from planner.spacecraft.vehicle.definition import AgileSpacecraft
from planner.spacecraft.verification import SpacecraftVerification, VerifiedWindow
from planner.world.platforms.gyro_craft import RATE_ERROR_MAX_RAD_S

ACROSS_AXES = [0, 2]  # of the body, across the optical axis
WORST_IF_GREAT = ("pointing_error_rad", "settled_s", "smear_px", "gimbal_rate_max_rad_s")
WORST_IF_SMALL = ("spare_s", "momentum_margin_n_m_s", "gimbal_margin")
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
    "control gains 2.0 1/s and 0.5 1/s^2, Butterworth 1.1 Hz on the rate error, feed-forward "
    "from the table; commands act at the tick they are measured at (see gains.delay_ticks)",
    "gravity gradient is the only external torque",
    "32 TDI lines set the exposure the smear is counted over",
    "light time and aberration (16 m on the ground, alike for all points) are left out",
)


def window_steadiness(
    spacecraft: AgileSpacecraft, verification: SpacecraftVerification, log: Log
) -> tuple[WindowSteadiness, ...]:
    """Every imaging interval of one closed-loop run."""
    verified = verification.windows
    before_rows = [0, *(one.last_row for one in verified)]
    return tuple(
        _window_steadiness(spacecraft, log, one, before_row)
        for one, before_row in zip(verified, before_rows, strict=False)
    )


def stabilisation(runs: Sequence[tuple[WindowSteadiness, ...]]) -> StabilisationReport:
    """Summarise closed-loop runs of one table."""
    windows = tuple(_worst_interval(same) for same in zip(*runs, strict=True))
    if not windows:
        return StabilisationReport(runs=len(runs), windows=(), share_steady=None, worst_rad_s=None)
    return StabilisationReport(
        runs=len(runs),
        windows=windows,
        share_steady=float(np.mean([[window.steady for window in run] for run in runs])),
        worst_rad_s=float(max(np.max(w.rate_error_rad_s) for w in windows)),
    )


def _worst_interval(same: Sequence[WindowSteadiness]) -> WindowSteadiness:
    """One interval over all runs."""
    return WindowSteadiness(
        request=same[0].request,
        look=same[0].look,
        rate_error_rad_s=np.max([one.rate_error_rad_s for one in same], axis=0),
        rate_error_rms_rad_s=math.sqrt(
            float(np.mean([one.rate_error_rms_rad_s**2 for one in same]))
        ),
        steady=all(one.steady for one in same),
        **{name: max(getattr(one, name) for one in same) for name in WORST_IF_GREAT},
        **{name: min(getattr(one, name) for one in same) for name in WORST_IF_SMALL},
    )


def _window_steadiness(
    spacecraft: AgileSpacecraft, log: Log, window: VerifiedWindow, before_row: int
) -> WindowSteadiness:
    camera = spacecraft.camera
    exposure_s = window.line_time_s * camera.tdi_lines
    since = slice(before_row, window.last_row)
    errors_rad_s = rate_errors(log, window.first_row, window.last_row)
    worst_rad_s = np.max(np.abs(errors_rad_s), axis=0)
    aside_rad = log.attitude_error_rad[window.first_row : window.last_row, ACROSS_AXES]
    settled_s = settled_after_s(log, before_row, window.last_row)
    across_rad_s = np.max(np.linalg.norm(errors_rad_s[:, ACROSS_AXES], axis=1))
    stored_n_m_s = np.max(np.linalg.norm(log.h_body_n_m_s[since], axis=1))
    return WindowSteadiness(
        request=window.request,
        look=window.look,
        rate_error_rad_s=worst_rad_s,
        rate_error_rms_rad_s=float(np.sqrt(np.mean(np.sum(errors_rad_s**2, axis=1)))),
        steady=bool(np.max(worst_rad_s) <= RATE_ERROR_MAX_RAD_S),
        pointing_error_rad=float(np.max(np.linalg.norm(aside_rad, axis=1))),
        settled_s=settled_s,
        spare_s=(window.first_row - before_row) * TICK_S - settled_s,
        smear_px=float(across_rad_s * exposure_s / camera.pixel_rad),
        momentum_margin_n_m_s=float(spacecraft.slew.momentum_sphere_n_m_s - stored_n_m_s),
        gimbal_margin=float(np.min(spacecraft.array.singularity_margin(log.gimbal_rad[since]))),
        gimbal_rate_max_rad_s=float(np.max(np.abs(log.gimbal_rate_rad_s[since]))),
    )
