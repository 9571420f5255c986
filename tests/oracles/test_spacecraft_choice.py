"""Is the choice optimal?  Against every subset and order, on small random sessions."""

import itertools

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from planner.spacecraft.candidates import Candidate
from planner.spacecraft.choose import choose
from planner.spacecraft.definition import AGILE_CMG
from planner.spacecraft.ground_arc import GroundArc
from planner.spacecraft.turn_time import turn_time

TIME = turn_time(AGILE_CMG)


def candidate(request, part, start_s, pitch_rad):
    arc = GroundArc(
        latitude_rad=(0.1, 0.11),
        longitude_rad=(0.0, 0.0),
        height_m=0.0,
        start_s=start_s,
        duration_s=6.0,
    )
    tilted = Rotation.from_rotvec([0.0, 0.0, pitch_rad])
    return Candidate(request=request, part=part, arcs=(arc,), entry=tilted, exit=tilted)


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
    angle = np.array([(a.exit.inv() * b.entry).magnitude()])
    return b.start_s - a.stop_s >= TIME.ticks(angle)[0] * 0.2 - 1e-6


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
    assert choice.proven_optimal
    assert choice.value == pytest.approx(brute_force(options, priorities))
    assert choice.greedy_value <= choice.value
    path = [options[k] for k in choice.chosen]
    assert all(follows(a, b) for a, b in itertools.pairwise(path))


def test_a_pair_that_needs_more_time_gets_it():
    options = [candidate(0, 0, 10.0, 0.0), candidate(1, 0, 30.0, 0.1)]
    assert choose(options, [1.0, 1.0], TIME, {}).value == 2.0
    assert choose(options, [1.0, 1.0], TIME, {(0, 1): 100}).value == 1.0
