"""The axes between two rows: the cubic Hermite of the commands, the quintic of the plan."""

from typing import NamedTuple

import numpy as np

from planner.base.arrays import Array, Mask
from planner.base.interpolation import cubic_coefficients, quintic_coefficients
from planner.world.platforms import AxisLimits


class HermiteRange(NamedTuple):
    """Extremes of a motion between its rows.

    Each of angle_rad, rate_rad_s, acceleration_rad_s2, jerk_rad_s3 has shape (2, cells, m):
    least and greatest over the cell, its ends included.
    """

    angle_rad: Array
    rate_rad_s: Array
    acceleration_rad_s2: Array
    jerk_rad_s3: Array


def cubic_range(step_s: float, angle_rad: Array, rate_rad_s: Array) -> HermiteRange:
    """Exact extremes, cell by cell, of the cubic Hermite through rows `step_s` apart.

    angle_rad, rate_rad_s: shape (n, m).  The rate is a parabola over a cell, so its extreme
    and the angle's are roots in closed form; the acceleration is a straight line, the jerk level.
    """
    q0, v0, c2, c3 = cubic_coefficients(
        step_s, angle_rad[:-1], angle_rad[1:], rate_rad_s[:-1], rate_rad_s[1:]
    )

    def angle_at(s: Array) -> Array:
        return q0 + s * (v0 + s * (c2 + s * c3))

    def rate_at(s: Array) -> Array:
        return v0 + s * (2.0 * c2 + 3.0 * s * c3)

    with np.errstate(divide="ignore", invalid="ignore"):
        s_rate = -c2 / (3.0 * c3)
        q = -(c2 + np.copysign(np.sqrt(c2 * c2 - 3.0 * c3 * v0), c2))
        s_angle = [q / (3.0 * c3), v0 / q]  # the stable pair of roots of v0 + 2 c2 s + 3 c3 s^2
    rates = np.stack([v0, rate_rad_s[1:] * step_s, rate_at(_keep_inside(s_rate))])
    angles = np.stack([q0, angle_rad[1:], *(angle_at(_keep_inside(s)) for s in s_angle)])
    accelerations = np.stack([2.0 * c2, 2.0 * c2 + 6.0 * c3])
    return HermiteRange(
        _least_and_greatest(angles),
        _least_and_greatest(rates) / step_s,
        _least_and_greatest(accelerations) / step_s**2,
        np.stack([6.0 * c3, 6.0 * c3]) / step_s**3,
    )


def cubic_and_row_range(
    step_s: float, angle_rad: Array, rate_rad_s: Array, acceleration_rad_s2: Array
) -> HermiteRange:
    """As flown, and on rows, where a slew must meet the motion itself, its own acceleration, too.

    The Hermite's differs from it by the jerk's change over a cell.
    """
    ranges = cubic_range(step_s, angle_rad, rate_rad_s)
    before, after = acceleration_rad_s2[:-1], acceleration_rad_s2[1:]
    return ranges._replace(
        acceleration_rad_s2=_least_and_greatest(
            np.stack([*ranges.acceleration_rad_s2, before, after])
        )
    )


def beyond_limits(
    ranges: HermiteRange, limits: tuple[AxisLimits, ...], tolerance_share: float
) -> Mask:
    """Where limits break, or the motion is not a number: order of derivative, cell, axis.

    Shape (4, cells, m).  tolerance_share: of the range from limit to limit, by which it may be
    passed.
    """
    low, high = np.array([axis.bounds for axis in limits]).T[:, :, None]
    slack = tolerance_share * (high - low)
    least, greatest = np.stack(ranges, axis=1)
    return np.asarray(~((least >= low - slack) & (greatest <= high + slack)))


def quintic_motion(
    t_s: Array, rows_s: Array, angle_rad: Array, rate_rad_s: Array, acceleration_rad_s2: Array
) -> tuple[Array, Array, Array]:
    """Angle, rate and acceleration at t_s (k,) of the quintic Hermite through the rows.

    rows_s: (n,) increasing; the motion there (n, m).  Returns three arrays (k, m).  Its error
    is step^6/46080 of the sixth derivative: 1e-9 arcsec on a pass at 0.2 s.  Outside the
    rows the first or last piece is continued.
    """
    cell = np.clip(np.searchsorted(rows_s, t_s, side="right") - 1, 0, len(rows_s) - 2)
    h = (rows_s[cell + 1] - rows_s[cell])[:, None]
    s = (t_s - rows_s[cell])[:, None] / h
    c0, c1, c2, c3, c4, c5 = quintic_coefficients(
        h,
        (angle_rad[cell], rate_rad_s[cell], acceleration_rad_s2[cell]),
        (angle_rad[cell + 1], rate_rad_s[cell + 1], acceleration_rad_s2[cell + 1]),
    )
    angle = c0 + s * (c1 + s * (c2 + s * (c3 + s * (c4 + s * c5))))
    rate = (c1 + s * (2.0 * c2 + s * (3.0 * c3 + s * (4.0 * c4 + s * 5.0 * c5)))) / h
    acceleration = (2.0 * c2 + s * (6.0 * c3 + s * (12.0 * c4 + s * 20.0 * c5))) / h**2
    return angle, rate, acceleration


def _keep_inside(s: Array) -> Array:
    return np.where((s > 0.0) & (s < 1.0), s, 0.0)


def _least_and_greatest(extreme_candidates: Array) -> Array:
    return np.stack([extreme_candidates.min(axis=0), extreme_candidates.max(axis=0)])
