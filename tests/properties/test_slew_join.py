"""The earliest join is the earliest, and the slew meets a moving track there."""

import dataclasses
import math

import numpy as np
import pytest
from slew_cases import LIMITS, NAMES, deg_state

from planner.motion.pointing.track import AxisTrack
from planner.motion.slew.feasibility import verdict
from planner.planning.sessions.platforms.two_axis.earliest_join import Approach, track_states
from planner.world.scenario import SlewOptions

OPTIONS = SlewOptions()


def swinging_track(start_deg, swing_deg, angular_rate_rad_s):
    """A track with exact derivatives, fastest in the middle as a pass is."""
    t_s = np.arange(0, 1201) / 5.0
    phase = angular_rate_rad_s * (t_s - 120.0)[:, None]
    swing = np.radians(swing_deg)
    return AxisTrack(
        axis_names=NAMES,
        t_s=t_s,
        axis_states=np.stack(
            [
                np.radians(start_deg) + swing * np.sin(phase),
                swing * angular_rate_rad_s * np.cos(phase),
                -swing * angular_rate_rad_s**2 * np.sin(phase),
            ]
        ),
    )


def feasible(track, start, start_s, t_s):
    return all(
        verdict(here, there, LIMITS, t_s - start_s).profile is not None
        for here, there in zip(start, track_states(track, t_s), strict=True)
    )


@pytest.mark.parametrize(
    ("track", "start"),
    [
        (swinging_track([20, -5], [60, 20], 0.012), (deg_state(0), deg_state(0))),
        (swinging_track([-40, 30], [50, -30], 0.014), (deg_state(150, 1.0), deg_state(-60))),
        (swinging_track([60, 10], [-70, 10], 0.01), (deg_state(-160, -1.0, 0.2), deg_state(9))),
        (swinging_track([0, 0], [3, 3], 0.1), (deg_state(0.1), deg_state(-2.0, 0.1))),
    ],
)
@pytest.mark.parametrize("start_s", [0.0, 31.4])
def test_no_earlier_row_can_be_joined(track, start, start_s):
    approach = Approach(track=track, limits=(LIMITS, LIMITS), start=start, start_s=start_s)
    join = approach.earliest_join(OPTIONS)
    row = round(join.t_s * 5)
    assert join.t_s == row / 5.0
    first = math.ceil(start_s * 5 + 1)
    earlier = [k / 5.0 for k in range(first, row) if feasible(track, start, start_s, k / 5.0)]
    # A continuous slew may exist a row or two before one that rows can carry.
    assert len(earlier) <= 2
    end = join.timed.slew.motion(np.array([join.t_s - start_s]))
    for order, wanted in enumerate(track.motion(np.array([join.t_s]))):
        np.testing.assert_allclose(end[order], wanted, rtol=0, atol=1e-8)
    assert join.timed.slew.violations == ()


def test_track_out_of_reach_in_time_has_no_join():
    track = swinging_track([120, 0], [0, 0], 0.01)
    short = dataclasses.replace(track, t_s=track.t_s[:51], axis_states=track.axis_states[:, :51])
    start = (deg_state(-120), deg_state(0))
    approach = Approach(track=short, limits=(LIMITS, LIMITS), start=start, start_s=0.0)
    assert approach.earliest_join(OPTIONS) is None
