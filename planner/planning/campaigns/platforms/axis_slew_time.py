"""The least time of a slew of axes from one track to another, computed millions of times over.

`planner.motion.slew.closed_forms` answers for any state; here the accelerations at both ends, small
beside the limit on a track, are taken away by ramps of their own, and what they cost is added
(a time that surely suffices) or taken off (a time no motion can beat).
"""

import math

from planner.base.arrays import Array
from planner.base.compiled import compiled, lean

HALVINGS = 40  # of the span of peak rates: its rounding is 1e-12 of the rate limit
BOUNDLESS = 1e12  # rad/s3: a jerk that takes no time


@compiled
def slew_time_s(start_axes: Array, end_axes: Array, limits: Array, sign: float) -> float:
    """Seconds for all axes; sign 1: surely enough, -1: no motion is quicker.

    start_axes, end_axes: (3, m), angle, rate, acceleration.  limits: (m, 3).  Hard stops are left
    out, and so are gaps: of the durations above the least one, some may be impossible, where an
    axis can't slow down enough on the way (`axes_fit` tells).
    """
    needed_s = 0.0
    for axis in range(start_axes.shape[1]):
        axis_s = _axis_time_s(start_axes[:, axis], end_axes[:, axis], limits[axis], sign, math.nan)
        needed_s = max(needed_s, axis_s)
    return needed_s


@compiled
def axes_fit(
    start_axes: Array, end_axes: Array, limits: Array, sign: float, available_s: float
) -> bool:
    """Whether `slew_time_s` is at most available_s, told as soon as it is certain; with sign 1
    also whether each axis surely can take just so long, no gap in the way."""
    for axis in range(start_axes.shape[1]):
        start, end = start_axes[:, axis], end_axes[:, axis]
        if _axis_time_s(start, end, limits[axis], sign, available_s) > available_s:
            return False
        if sign > 0.0 and not _can_last(start, end, limits[axis], available_s):
            return False
    return True


@lean
def _axis_time_s(
    start_state: Array, end_state: Array, axis_limits: Array, sign: float, available_s: float
) -> float:
    """One axis; only as exactly as tells on which side of available_s it is, unless that is NaN."""
    v, a, j = axis_limits
    delta_rad, v0, v1, ramps_s = _without_ramps(start_state, end_state, axis_limits, sign)
    if sign < 0.0 and not _is_plain(delta_rad, v0, v1, a, j):
        j = BOUNDLESS
    return float(by_peak_s(delta_rad, v0, v1, v, a, j, available_s - ramps_s) + ramps_s)


@lean
def _can_last(start_state: Array, end_state: Array, axis_limits: Array, lasts_s: float) -> bool:
    """Of one axis that can be there in less, whether it surely can take just so long.

    Motions of one duration are a convex set, so that they cover all ways from the shortest to the
    longest: it can if a motion is known that gets no further.
    """
    v, a, j = axis_limits
    delta_rad, v0, v1, ramps_s = _without_ramps(start_state, end_state, axis_limits, 1.0)
    left_s, stop0_s, stop1_s = lasts_s - ramps_s, change_s(v0, a, j), change_s(v1, a, j)
    if left_s >= stop0_s + stop1_s and 0.5 * (v0 * stop0_s + v1 * stop1_s) <= delta_rad:
        return True  # at rest in between
    # Seen the other way round, up to a peak and down again, which takes just so long.
    low, high = max(-v0, -v1), v
    most_s = change_s(high + v0, a, j) + change_s(high + v1, a, j)
    if left_s >= most_s:
        return bool(-_way_rad(high, -v0, -v1, a, j) - high * (left_s - most_s) <= delta_rad)
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        if change_s(middle + v0, a, j) + change_s(middle + v1, a, j) <= left_s:
            low = middle
        else:
            high = middle
    return bool(-_way_rad(low, -v0, -v1, a, j) <= delta_rad)


@lean
def _without_ramps(
    start_state: Array, end_state: Array, axis_limits: Array, sign: float
) -> tuple[float, float, float, float]:
    """Way, rates at its ends and the ramps' time, where these take the ends' accelerations away;
    seen from the side from which no less lies ahead than a direct change of rate covers."""
    v, a, j = axis_limits
    a0, a1 = start_state[2], end_state[2]
    ramp0_s, ramp1_s = abs(a0) / j, abs(a1) / j
    # A ramp to no acceleration after the start (sign 1), or from none before it (-1).
    v0 = start_state[1] + sign * a0 * ramp0_s / 2.0
    v1 = end_state[1] - sign * a1 * ramp1_s / 2.0
    moved0 = ramp0_s * (start_state[1] + sign * a0 * ramp0_s / 3.0)
    moved1 = ramp1_s * (end_state[1] - sign * a1 * ramp1_s / 3.0)
    delta_rad = end_state[0] - start_state[0] - sign * (moved0 + moved1)
    v0, v1 = min(max(v0, -v), v), min(max(v1, -v), v)
    ramps_s = sign * (ramp0_s + ramp1_s)
    if delta_rad < 0.5 * (v0 + v1) * change_s(v1 - v0, a, j):
        return -delta_rad, -v0, -v1, ramps_s
    return delta_rad, v0, v1, ramps_s


@lean
def needed_axis_s(
    rates_rad_s: tuple[float, float],
    accelerations_rad_s2: tuple[float, float],
    delta_rad: float,
    slack_rad: float,
    limits: tuple[float, float, float],
    available_s: float,
) -> float:
    """No motion between two rates and accelerations by so much, or up to slack_rad more or less, is
    quicker; only as exactly as tells on which side of available_s it is."""
    v, a, j = limits
    # Ramps from no acceleration before the start, and to none after the end.
    (w0, w1), (a0, a1) = rates_rad_s, accelerations_rad_s2
    ramp0_s, ramp1_s = abs(a0) / j, abs(a1) / j
    v0, v1 = w0 - 0.5 * a0 * ramp0_s, w1 + 0.5 * a1 * ramp1_s
    delta_rad += ramp0_s * (w0 - a0 * ramp0_s / 3.0) + ramp1_s * (w1 + a1 * ramp1_s / 3.0)
    v = max(v, abs(v0), abs(v1))
    direct_rad = 0.5 * (v0 + v1) * change_s(v1 - v0, a, j)
    if delta_rad < direct_rad:
        delta_rad, direct_rad, v0, v1 = -delta_rad, -direct_rad, -v0, -v1
    delta_rad = max(delta_rad - slack_rad, direct_rad)
    if not _is_plain(delta_rad, v0, v1, a, j):
        j = BOUNDLESS
    ramps_s = ramp0_s + ramp1_s
    return float(by_peak_s(delta_rad, v0, v1, v, a, j, available_s + ramps_s) - ramps_s)


@lean
def _is_plain(delta_rad: float, v0: float, v1: float, a: float, j: float) -> bool:
    """Whether one rise to a peak and one fall is the quickest way, with bounded jerk too.

    So it is well beyond what is covered while either rate is brought to rest and back.
    """
    fastest = max(abs(v0), abs(v1))
    return delta_rad >= 2.0 * fastest * change_s(fastest, a, j)


@lean
def by_peak_s(
    delta_rad: float,
    v0_rad_s: float,
    v1_rad_s: float,
    v_rad_s: float,
    a_rad_s2: float,
    j_rad_s3: float,
    available_s: float,
) -> float:
    """From rate v0 over `delta_rad` by a peak rate, held if it is the limit v, to rate v1; s.

    delta_rad: not less than the direct change of rate covers.  available_s: the search for the
    peak ends once it is certain whether that is enough.
    Source: Biagiotti, Melchiorri 2008, "Trajectory Planning for Automatic Machines", 3.4.
    """
    v0, v1, v, a, j = v0_rad_s, v1_rad_s, v_rad_s, a_rad_s2, j_rad_s3
    beyond = delta_rad - _way_rad(v, v0, v1, a, j)
    if beyond >= 0.0:
        return change_s(v - v0, a, j) + change_s(v1 - v, a, j) + beyond / v
    low, high = max(v0, v1), v
    high_s = change_s(high - v0, a, j) + change_s(v1 - high, a, j)
    for _ in range(HALVINGS):
        if high_s <= available_s:
            break
        middle = 0.5 * (low + high)
        middle_s = change_s(middle - v0, a, j) + change_s(v1 - middle, a, j)
        if _way_rad(middle, v0, v1, a, j) < delta_rad:
            if middle_s > available_s:
                return middle_s
            low = middle
        else:
            high, high_s = middle, middle_s
    return high_s


@lean
def _way_rad(v_peak_rad_s: float, v0: float, v1: float, a: float, j: float) -> float:
    """What is covered from v0 by way of a peak rate to v1."""
    return 0.5 * (
        (v0 + v_peak_rad_s) * change_s(v_peak_rad_s - v0, a, j)
        + (v_peak_rad_s + v1) * change_s(v1 - v_peak_rad_s, a, j)
    )


@compiled
def change_s(rate_rad_s: float, acceleration_rad_s2: float, jerk_rad_s3: float) -> float:
    """Least time to change the rate by so much, from and to no acceleration."""
    change, a, j = abs(rate_rad_s), acceleration_rad_s2, jerk_rad_s3
    if change >= a * a / j:
        return change / a + a / j
    return 2.0 * math.sqrt(change / j)
