"""The choice is the best for its slew times, and the bound holds: against all orders of a few."""

import itertools
import math
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest
from ruckig import InputParameter, Ruckig, Trajectory
from scipy.spatial.transform import Rotation
from spacecraft_cases import line, session

from planner.spacecraft.imaging.candidates import ScanStarts, candidates
from planner.spacecraft.imaging.choice import choose, options_of
from planner.spacecraft.imaging.session import GroundArc, Slews, make_session
from planner.spacecraft.requests import StripRequest
from planner.spacecraft.vehicle import AgileSpacecraft
from planner.world.targets.ground_path import GroundPathTarget, PathPoint

BODY = AgileSpacecraft().platform()
SLEWS = Slews(platform=BODY)
SIX_SECONDS = GroundPathTarget(
    points=tuple(PathPoint(latitude_deg=at_deg, longitude_deg=0.0) for at_deg in (5.0, 5.27)),
    line="plane",
    speed_m_s=4977.0,  # 30 rows
)


def state(turn_rad, rate_rad_s=0.0):
    """Of `Slews`, turning about Z."""
    rate = [0.0, 0.0, rate_rad_s]
    return np.array([*Rotation.from_rotvec(turn_rad).as_quat(), *rate, *[0.0] * 4])


def scan_starts(request, look, starts_s, rolls_rad):
    states = np.array([state([0.0, 0.0, roll_rad]) for roll_rad in rolls_rad]).reshape(-1, 11)
    arc = GroundArc(path=SIX_SECONDS, request=request, look=look)
    return ScanStarts(arc, np.array(starts_s), states, states, np.zeros(len(states)))


def imaged_with(priorities):
    """A session with requests of these priorities."""
    request = SimpleNamespace(requests=priorities)
    return SimpleNamespace(priorities=priorities, slews=SLEWS, request=request, duration_s=200.0)


def random_session(seed, stereo):
    random = np.random.default_rng(seed)
    options = []
    for request in range(6):
        middle, roll = random.uniform(20.0, 120.0), random.uniform(-0.4, 0.4)
        for look in range(2 if stereo and request < 2 else 1):
            starts = np.round((middle + 45.0 * look + np.array([0.0, 10.0])) * 5.0) / 5.0
            options.append(scan_starts(request, look, starts, [roll, roll + 0.05]))
    return options, list(random.integers(1, 10, 6).astype(float))


@cache
def follows(a, b):
    ends = (state([0.0, 0.0, roll_rad])[None] for _, roll_rad in (a, b))
    return SLEWS.ticks(*ends)[0] <= round((b[0].start_s - a[0].stop_s) / 0.2)


def quickest_s(angle_rad, rates_rad_s=(0.0, 0.0)):
    """About Z, by Ruckig."""
    rate, acceleration, jerk = BODY.envelope.by_order_rad[:, 2].tolist()
    asked = InputParameter(1)
    asked.current_position, asked.target_position = [0.0], [angle_rad]
    asked.current_velocity, asked.target_velocity = [rates_rad_s[0]], [rates_rad_s[1]]
    asked.max_velocity = [rate]
    asked.max_acceleration = [acceleration]
    asked.max_jerk = [jerk]
    least = Trajectory(1)
    Ruckig(1).calculate(asked, least)
    return least.duration


@cache
def follows_at_best(a, b):
    slew_s = quickest_s(abs(b[1] - a[1])) + BODY.envelope.settle_s
    return b[0].start_s - a[0].stop_s >= slew_s


def rolled(options):
    """Every scan that may be begun, with its roll."""
    for one in options:
        rolls_rad = Rotation.from_quat(one.entry_states[:, :4]).as_rotvec()[:, 2].tolist()
        for k, roll_rad in enumerate(rolls_rad):
            yield one.begun(k), roll_rad


def brute_force(options, priorities, follows=follows):
    groups, looks = {}, {}
    for scan, roll_rad in rolled(options):
        groups.setdefault((scan.request, scan.look), []).append((scan, roll_rad))
        looks.setdefault(scan.request, set()).add(scan.look)
    best = 0.0
    for picks in itertools.product(*[[None, *group] for group in groups.values()]):
        path = sorted((p for p in picks if p is not None), key=lambda p: p[0].start_s)
        if all(follows(a, b) for a, b in itertools.pairwise(path)):
            taken = {(scan.request, scan.look) for scan, _ in path}
            whole = {r for r, own in looks.items() if {(r, look) for look in own} <= taken}
            best = max(best, sum(priorities[r] for r in whole))
    return best


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("stereo", [False, True])
def test_choice_is_the_best_of_all(seed, stereo):
    options, priorities = random_session(seed, stereo)
    choice = choose(options, imaged_with(priorities))
    assert choice.value == pytest.approx(brute_force(options, priorities))
    assert choice.greedy_value <= choice.value
    rolls_rad = dict(rolled(options))
    chosen = [(scan, rolls_rad[scan]) for scan in choice.chosen]
    assert all(follows(a, b) for a, b in itertools.pairwise(chosen))
    bound = choice.bound(priorities)
    assert brute_force(options, priorities, follows_at_best) <= bound + 1e-9
    assert bound <= sum(priorities)


def test_a_bound_is_less_than_everything_where_no_slew_is_quick_enough():
    options = [scan_starts(0, 0, [10.0], [-0.4]), scan_starts(1, 0, [17.0], [0.4])]
    choice = choose(options, imaged_with([1.0, 3.0]))
    assert (choice.value, choice.bound([1.0, 3.0])) == (3.0, 3.0)


def test_what_is_never_whole_is_passed_over():
    """One request has no scan, another the first look of a pair only."""
    options = [
        scan_starts(0, 0, [40.0], [0.0]),
        scan_starts(2, 0, [10.0], [0.0]),
        scan_starts(2, 1, [], []),
    ]
    choice = choose(options, imaged_with([1.0, 3.0, 9.0]))
    assert (choice.value, choice.greedy_value, choice.requests) == (1.0, 1.0, {0})


def test_a_dense_session_is_worth_what_was_flown():
    """Fourteen strips in 260 s drawn by chance; one of 35.65 was flown."""
    random = np.random.default_rng(1)
    drawn = [
        StripRequest(
            name=str(k),
            priority=random.uniform(1.0, 5.0),
            geometry=line(random.uniform(60.0, 200.0), 20.0, random.uniform(-250.0, 250.0)),
        )
        for k in range(14)
    ]
    made = make_session(session(drawn, 260.0))
    assert choose(options_of(made)[0], made).value >= 36.59


@pytest.mark.parametrize(("count", "apart_s"), [(25, 1.0), (30, 2.0)])
def test_more_requests_than_can_be_paired_finely_are_tried_further_apart(count, apart_s):
    strips = [StripRequest(name=str(k), geometry=line(130.0)) for k in range(count)]
    made = make_session(session(strips, 260.0))
    [tried] = candidates(strips[0], 0, made)
    np.testing.assert_allclose(np.diff(tried.starts_s), apart_s)


@pytest.mark.parametrize("rates_deg_s", [(0.0, 0.0), (-0.9, -0.9), (0.5, -0.4), (0.7, 0.3)])
@pytest.mark.parametrize("angle_deg", [4.0, 20.0, 45.0])
def test_turn_times_that_suffice_are_a_little_above_the_least_ones(angle_deg, rates_deg_s):
    """About one axis Ruckig's jerk-limited time is the least; what blends two motions, or stops
    first, takes up to 4 s more."""
    rates_rad_s = np.deg2rad(rates_deg_s).tolist()
    start, end = (
        state([0.0, 0.0, 0.0], rates_rad_s[0]),
        state([0.0, 0.0, math.radians(angle_deg)], rates_rad_s[1]),
    )
    least = quickest_s(math.radians(angle_deg), rates_rad_s)
    enough_s = SLEWS.ticks(start[None], end[None])[0] * 0.2 - BODY.envelope.settle_s
    assert least <= enough_s <= least + 4.0


def test_full_gyros_turn_slowly():
    """45 of 60 N m s leave 11 for the lengths of J w about all three axes, 4 put aside."""
    full = AgileSpacecraft().platform((0.0, 0.0, 45.0))
    rate_rad_s = 11.0 / math.hypot(800.0, 500.0, 800.0)
    np.testing.assert_allclose(full.envelope.by_order_rad[0], rate_rad_s)
    start, end = state([0.0, 0.0, 0.0]), state([0.0, 0.0, 0.8])
    least_s = 0.8 / rate_rad_s
    assert least_s < 0.2 * Slews(platform=full).ticks(start[None], end[None])[0] < 1.2 * least_s
