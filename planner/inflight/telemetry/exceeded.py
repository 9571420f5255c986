"""Limits of the platform that the measured motion went beyond, by more than its noise."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from planner.base.arrays import Array
from planner.inflight.telemetry.following import Followed
from planner.inflight.telemetry.noise import row_noise, sensor_step
from planner.world.platforms import AxisLimits

Limit = Literal["angle_min", "angle_max", "rate", "acceleration"]


@dataclass(frozen=True, kw_only=True)
class ExceededOptions:
    """When a limit is told to have been exceeded."""

    sigma: float = 5.0  # of the noise, by which a limit must be passed
    rows_min: int = 7  # of a stretch, so that a cubic through it leaves some to tell the noise by
    apart_s: float = 1.0  # what is beyond again sooner is the same stretch
    noise_max: float = 0.2  # of a limit: with more, nothing is told of it


OPTIONS = ExceededOptions()

_SLOPE_S: dict[Limit, float] = {
    "rate": 0.4,
    "acceleration": 1.0,
}  # of which the motion is a parabola, and a cubic


@dataclass(frozen=True, kw_only=True)
class Exceeded:
    """value: the farthest, in the limit's own unit of radians; start_s, stop_s: after the table's
    epoch."""

    limit: Limit
    start_s: float
    stop_s: float
    value: float
    bound: float


def limits_exceeded(followed: Followed, limits: AxisLimits) -> tuple[list[Exceeded], list[Limit]]:
    """Stretches beyond, and the limits that the samples could tell of."""
    found: list[Exceeded] = []
    checked: list[Limit] = []
    t_s = followed.t_s
    angle_rad = followed.motion.angle_rad(t_s) + followed.error_rad
    if followed.basis == "angles":
        checked += ["angle_min", "angle_max"]
        margin = OPTIONS.sigma * max(row_noise(angle_rad), 0.5 * sensor_step(angle_rad))
        low, high = limits.angle_min_rad, limits.angle_max_rad
        found += _beyond("angle_min", t_s, -angle_rad, -low, margin, -1.0)
        found += _beyond("angle_max", t_s, angle_rad, high, margin, 1.0)
    motions: tuple[tuple[Limit, int, float], ...] = (
        ("rate", 1, limits.rate_max_rad_s),
        ("acceleration", 2, limits.acceleration_max_rad_s2),
    )
    step = sensor_step(angle_rad if followed.rate_rad_s is None else followed.rate_rad_s)
    for limit, order, bound in motions:
        told = False
        for run in followed.runs:
            value, noise = _motion(followed, run, order, _SLOPE_S[limit], step)
            if value is not None and noise < OPTIONS.noise_max * bound:
                told = True
                found += _either_way(limit, t_s[run], value, bound, OPTIONS.sigma * noise)
        if told:
            checked.append(limit)
    return sorted(found, key=lambda one: one.start_s), checked


def _motion(
    followed: Followed, run: slice, order: int, span_s: float, step: float
) -> tuple[Array | None, float]:
    """The derivative of this order over a run, and its noise: the plan's own and the error's, as
    only the error is small enough to be drawn through uneven or missing rows.

    step: of the sensor, by half of which a row may be off.
    """
    t_s, error, motion = followed.t_s[run], followed.error_rad[run], followed.motion
    if len(t_s) < OPTIONS.rows_min:
        return None, 0.0
    planned = motion.rate_rad_s(t_s) if order == 1 else motion.acceleration_rad_s2(t_s)
    if followed.rate_rad_s is not None:
        error, order = followed.rate_rad_s[run] - motion.rate_rad_s(t_s), order - 1
        if not np.isfinite(error).all():
            return None, 0.0
    noise = max(row_noise(error), 0.5 * step)
    if order == 0:
        return planned + error, noise
    step_s = (t_s[-1] - t_s[0]) / (len(t_s) - 1)
    rows = max(OPTIONS.rows_min, 2 * round(0.5 * span_s / step_s) + 1)
    if rows > len(t_s):
        return None, 0.0
    # SciPy's signals take 0.2 s to import, which only a comparison should pay.
    from scipy.signal import savgol_filter

    even_s = np.linspace(t_s[0], t_s[-1], len(t_s))
    even = np.interp(even_s, t_s, error)
    slope = savgol_filter(even, rows, order + 1, deriv=order, delta=step_s)
    kernel = savgol_filter(
        np.eye(1, 2 * rows + 1, rows)[0], rows, order + 1, deriv=order, delta=step_s
    )
    return planned + np.interp(t_s, even_s, slope), noise * float(np.linalg.norm(kernel))


def _either_way(
    limit: Limit, t_s: Array, value: Array, bound: float, margin: float
) -> list[Exceeded]:
    return [
        *_beyond(limit, t_s, value, bound, margin, 1.0),
        *_beyond(limit, t_s, -value, bound, margin, -1.0),
    ]


def _beyond(
    limit: Limit, t_s: Array, value: Array, bound: float, margin: float, sign: float
) -> list[Exceeded]:
    beyond = np.flatnonzero(value > bound + margin)
    found = []
    for rows in np.split(beyond, np.flatnonzero(np.diff(t_s[beyond]) > OPTIONS.apart_s) + 1):
        if not len(rows):
            continue
        first, last = rows[0], rows[-1] + 1
        found.append(
            Exceeded(
                limit=limit,
                start_s=float(t_s[first]),
                stop_s=float(t_s[last - 1]),
                value=sign * float(value[first:last].max()),
                bound=sign * bound,
            )
        )
    return found
