"""The choice is the best for estimated slew times: against every subset and order of a few."""

import itertools
import math

import numpy as np
import pytest
from ruckig import InputParameter, Ruckig, Trajectory
from scipy.spatial.transform import Rotation

from planner.spacecraft.body import body_of
from planner.spacecraft.imaging.candidates import Candidate
from planner.spacecraft.imaging.choose import choose
from planner.spacecraft.imaging.ground_arc import GroundArc
from planner.spacecraft.imaging.slew_time import MovingEnds, slew_time
from planner.spacecraft.vehicle.definition import AGILE_CMG

BODY = body_of(AGILE_CMG)
TIME = slew_time(BODY)


def candidate(request, part, start_s, pitch_rad, rate_rad_s=0.0):
    arc = GroundArc(
        latitude_rad=(0.1, 0.11),
        longitude_rad=(0.0, 0.0),
        height_m=0.0,
        start_s=start_s,
        duration_s=6.0,
    )
    tilted = MovingEnds(
        q_body_from_eci_xyzw=Rotation.from_rotvec([[0.0, 0.0, -pitch_rad]]).as_quat(),
        rate_eci_rad_s=np.array([[0.0, 0.0, rate_rad_s]]),
    )
    return Candidate(
        request=request, part=part, arcs=(arc,), entry=tilted, exit=tilted, tilt_rad=0.0
    )


def random_session(seed, stereo):
    random = np.random.default_rng(seed)
    options = []
    for request in range(6):
        middle, roll = random.uniform(20.0, 120.0), random.uniform(-0.4, 0.4)
        parts = (1, 2) if stereo and request < 2 else (0,)
        for part in parts:
            for k in range(2):
                start = round((middle + 10.0 * k + 45.0 * (part == 2)) * 5) / 5
                options.append(candidate(request, part, start, roll + 0.05 * k))
    return options, list(random.integers(1, 10, 6).astype(float))


def follows(a, b):
    return b.start_s - a.stop_s >= TIME.ticks(a.exit, b.entry)[0] * 0.2 - 1e-6


def brute_force(options, priorities):
    groups = {}
    for option in options:
        groups.setdefault((option.request, option.part), []).append(option)
    best = 0.0
    for picks in itertools.product(*[[None, *group] for group in groups.values()]):
        path = sorted((p for p in picks if p is not None), key=lambda p: p.start_s)
        if all(follows(a, b) for a, b in itertools.pairwise(path)):
            parts = {(p.request, p.part) for p in path}
            whole = {r for r, part in parts if part == 0 or {(r, 1), (r, 2)} <= parts}
            best = max(best, sum(priorities[r] for r in whole))
    return best


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("stereo", [False, True])
def test_choice_is_the_best_of_all(seed, stereo):
    options, priorities = random_session(seed, stereo)
    choice = choose(options, priorities, TIME, {})
    assert choice.value == pytest.approx(brute_force(options, priorities))
    assert choice.greedy_value <= choice.value
    path = [options[k] for k in choice.chosen]
    assert all(follows(a, b) for a, b in itertools.pairwise(path))


def test_a_pair_that_needs_more_time_gets_it():
    options = [candidate(0, 0, 10.0, 0.0), candidate(1, 0, 30.0, 0.1)]
    assert choose(options, [1.0, 1.0], TIME, {}).value == 2.0
    assert choose(options, [1.0, 1.0], TIME, {(0, 1): 100}).value == 1.0


@pytest.mark.parametrize("rates_deg_s", [(0.0, 0.0), (-0.9, -0.9), (0.5, -0.4), (0.7, 0.3)])
@pytest.mark.parametrize("angle_deg", [4.0, 20.0, 45.0])
def test_estimated_turn_times_are_a_little_above_the_least_ones(angle_deg, rates_deg_s):
    """About one axis Ruckig's jerk-limited time is the least; 0.8 s are allowed for rates aside,
    3 % for slews without corners, and one tick is lost by rounding."""
    rates = [np.array([0.0, 0.0, math.radians(rate)]) for rate in rates_deg_s]
    ends = [Rotation.identity(), Rotation.from_rotvec([0.0, 0.0, math.radians(angle_deg)])]
    moving = [
        MovingEnds(q_body_from_eci_xyzw=e.inv().as_quat()[None], rate_eci_rad_s=r[None])
        for e, r in zip(ends, rates, strict=True)
    ]
    rate, acceleration, jerk = BODY.envelope.by_order_rad[:, 2].tolist()
    asked = InputParameter(1)
    asked.current_position, asked.target_position = [0.0], [math.radians(angle_deg)]
    asked.current_velocity, asked.target_velocity = [rates[0][2]], [rates[1][2]]
    asked.max_velocity = [rate]
    asked.max_acceleration = [acceleration]
    asked.max_jerk = [jerk]
    least = Trajectory(1)
    Ruckig(1).calculate(asked, least)
    estimated_s = TIME.ticks(*moving)[0] * 0.2 - BODY.envelope.settle_s
    assert least.duration <= estimated_s <= 1.03 * least.duration + 0.8 + 0.2 + 0.5


def test_full_gyros_turn_slowly():
    """45 of 60 N m s leave 11 for the lengths of J w about all three axes, 4 put aside."""
    full = body_of(AGILE_CMG, (0.0, 0.0, 45.0))
    rate_rad_s = 11.0 / math.hypot(800.0, 500.0, 800.0)
    np.testing.assert_allclose(full.envelope.by_order_rad[0], rate_rad_s)
    start, end = (
        MovingEnds(
            q_body_from_eci_xyzw=Rotation.from_rotvec([[0.0, 0.0, angle_rad]]).inv().as_quat(),
            rate_eci_rad_s=np.zeros((1, 3)),
        )
        for angle_rad in (0.0, 0.8)
    )
    least_s = 0.8 / rate_rad_s
    assert least_s < 0.2 * slew_time(full).ticks(start, end)[0] < 1.2 * least_s
