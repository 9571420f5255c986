"""The times that sessions are chosen by enclose the least time of Ruckig."""

import numpy as np

from planner.motion.slew import AxisState
from planner.motion.slew.closed_forms import quickest_profile
from planner.planning.campaigns.platforms.axis_slew_time import axes_fit, slew_time_s
from planner.world.platforms import PLATFORMS

LIMITS = PLATFORMS["iss-hrc"].axis_limits[:1]
TABLE = np.array(
    [[LIMITS[0].rate_max_rad_s, LIMITS[0].acceleration_max_rad_s2, LIMITS[0].jerk_max_rad_s3]]
)
CASES = 2000
ROUNDING_S = 1e-6  # Ruckig's own tolerance on the end state, 1e-8 of the acceleration limit


def test_no_motion_is_quicker_and_some_motion_is_as_quick():
    rng = np.random.default_rng(20150227)
    compared = 0
    for number in range(CASES):
        # Half of the states as on tracks, half up to the limits.
        wide = 1.0 if number % 2 else 0.2
        start, end = wide * rng.uniform(-1.0, 1.0, (2, 3, 1)) * [[1.0], [0.05], [0.012]]
        exact = quickest_profile(_state(start), _state(end), LIMITS[0])
        if exact is None or abs(start[1, 0]) > 0.048 or abs(end[1, 0]) > 0.048:
            continue  # its ramp alone may pass the rate limit
        least_s, enough_s = (slew_time_s(start, end, TABLE, sign) for sign in (-1.0, 1.0))
        assert least_s - ROUNDING_S <= exact.duration_s <= enough_s + ROUNDING_S
        compared += 1
    assert compared > CASES * 0.9


def test_some_motion_takes_just_the_time_that_is_told_to_suffice():
    """Between scans on the ISS an axis at 1.5 deg/s can't slow down enough in 4 s: a gap."""
    rng = np.random.default_rng(1)
    found = {False: 0, True: 0}
    for _ in range(CASES):
        start, end = rng.uniform(-1.0, 1.0, (2, 3, 1)) * [[0.1], [0.045], [0.0005]]
        available_s = float(rng.uniform(0.2, 12.0))
        exact = quickest_profile(_state(start), _state(end), LIMITS[0], available_s)
        lasts = exact.duration_s < available_s + ROUNDING_S
        if axes_fit(start, end, TABLE, 1.0, available_s):
            assert lasts
            found[True] += 1
        elif lasts:  # a bit more time for the ramps, and it fits
            found[False] += 1
    assert found[True] > 300
    assert found[False] < 0.02 * CASES


def test_slews_between_passing_targets_are_met_closely():
    """On tracks of a 400 km pass, accelerations of 0.02 deg/s2: ramps of 0.02 s at either end."""
    rng = np.random.default_rng(1)
    for _ in range(500):
        start, end = rng.uniform(-1.0, 1.0, (2, 3, 1)) * [[1.0], [0.01], [0.0003]]
        exact = quickest_profile(_state(start), _state(end), LIMITS[0])
        # Two ramps of 0.02 s, and the detour of rates they make.
        assert slew_time_s(start, end, TABLE, 1.0) - exact.duration_s < 0.2


def _state(values):
    angle_rad, rate_rad_s, acceleration_rad_s2 = values[:, 0].tolist()
    return AxisState(
        angle_rad=angle_rad, rate_rad_s=rate_rad_s, acceleration_rad_s2=acceleration_rad_s2
    )
