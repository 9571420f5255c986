"""The steadiness of the camera while it images, of closed-loop runs."""

import numpy as np

from planner.base.arrays import Array
from planner.base.commands import COMMAND_STEP_S
from planner.inflight.simulation.gyros.closed_loop import Log
from planner.inflight.simulation.gyros.dispersed import STEP_S
from planner.world.platforms.cmg_array import CmgArray
from planner.world.platforms.gyro_craft import RATE_ERROR_MAX_RAD_S


def rate_errors(log: Log, first_row: int, last_row: int) -> Array:
    """Rate error at every simulation step between two rows, (m, 3), rad/s."""
    return log.rate_error_rad_s[first_row:last_row].reshape(-1, 3)


def settled_after_s(log: Log, first_row: int, last_row: int) -> float:
    """Seconds from first_row until the rate error stays within 0.001 deg/s up to last_row."""
    errors_rad_s = rate_errors(log, first_row, last_row)
    over = np.flatnonzero(np.any(np.abs(errors_rad_s) > RATE_ERROR_MAX_RAD_S, axis=1))
    steps_per_tick = log.rate_error_rad_s.shape[1]
    return float((over[-1] + 1) * COMMAND_STEP_S / steps_per_tick) if len(over) else 0.0


def steadiness_figures(
    log: Log,
    array: CmgArray,
    omega_body_rad_s: Array,
    first_row: int,
    last_row: int,
    since_row: int = 0,
) -> Array:
    """Of one run while the camera images from one row to another, (11,), as `worst_of` reads them.

    omega_body_rad_s: as commanded at the beginning of each tick, (n, 3).  since_row: from which on
    the body settles, and the gyros' extremes are told.
    """
    inside = rate_errors(log, first_row, last_row)
    worst_rad_s = np.abs(inside).max(axis=0)
    flown = slice(since_row, last_row)
    held_n_m_s = log.h_body_n_m_s[flown]
    given_n_m = np.diff(held_n_m_s, axis=0) / COMMAND_STEP_S
    given_n_m += np.cross(omega_body_rad_s[since_row : last_row - 1], held_n_m_s[:-1])
    return np.array(
        [
            float(worst_rad_s.max() <= RATE_ERROR_MAX_RAD_S),
            *worst_rad_s,
            np.sqrt(np.mean(np.sum(inside**2, axis=1))),
            np.linalg.norm(log.attitude_error_rad[first_row:last_row], axis=1).max(),
            (first_row - since_row) * COMMAND_STEP_S - settled_after_s(log, since_row, last_row),
            np.linalg.norm(given_n_m, axis=1).max(),
            np.linalg.norm(held_n_m_s, axis=1).max(),
            array.singularity_margin(log.gimbal_rad[flown]).min(),
            np.abs(log.gimbal_rate_rad_s[flown]).max(),
        ]
    )


def errors_over_time(log: Log) -> tuple[Array, Array, Array]:
    """Times (k,), attitude errors and rate errors in body axes, (k, 3), after every step.

    Between ticks, at which attitudes are compared, the error grows by the rate's; what is left of
    it is the turn of the axes meanwhile, spread evenly.
    """
    ticks, steps, _ = log.rate_error_rad_s.shape
    rate = np.vstack([np.zeros((1, 3)), log.rate_error_rad_s.reshape(-1, 3)])
    grown = np.cumsum(0.5 * STEP_S * (rate[1:] + rate[:-1]), axis=0).reshape(ticks, steps, 3)
    grown -= np.vstack([np.zeros((1, 3)), grown[:-1, -1]])[:, None]
    begun = log.attitude_error_rad
    left = np.vstack([begun[1:] - begun[:-1] - grown[:-1, -1], np.zeros((1, 3))])
    share = np.arange(1, steps + 1)[:, None] / steps
    error = np.vstack([begun[:1], (begun[:, None] + grown + share * left[:, None]).reshape(-1, 3)])
    return STEP_S * np.arange(ticks * steps + 1), error, rate
