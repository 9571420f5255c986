"""A covariance is the scatter of fits to errors of known kinds."""

import numpy as np
import pytest

from planner.inflight.simulation.identification import covariance

SAMPLES, FLIGHTS = 1500, 100
OPEN = np.array([1e6, 1e6])  # no prior to speak of


def errors(chance, memory):
    """Of one sigma, each `memory` of the last and the rest new."""
    found = chance.standard_normal(SAMPLES)
    for k in range(1, SAMPLES):
        found[k] = memory * found[k - 1] + np.sqrt(1.0 - memory**2) * found[k]
    return found


def one_step(k):
    """All is told within 300 samples, as of an axis that lets go once."""
    return np.stack([k > 600.0, (k > 600.0) & (k < 900.0)], axis=1).astype(float)


def throughout(k):
    return np.stack([np.sin(k / 40.0), np.cos(k / 70.0)], axis=1)


@pytest.mark.parametrize("slope_of", [one_step, throughout])
@pytest.mark.parametrize(("memory", "size"), [(0.0, 1.0), (0.0, 3.0), (0.7, 1.0)])
def test_told_and_kept_errors_agree(slope_of, memory, size):
    """Squares of errors over their sigmas: 1 on average, to 10 % at one sigma of 100 flights,
    and a window of 30 samples sees most of errors that are forgotten in 3."""
    slope, chance = slope_of(np.arange(float(SAMPLES))), np.random.default_rng(3)
    squares = []
    for _ in range(FLIGHTS):
        data = size * errors(chance, memory)
        fitted, *_ = np.linalg.lstsq(slope, data, rcond=None)
        missed = data - slope @ fitted
        told = covariance(slope[None], missed[None], np.ones((1, SAMPLES)), OPEN)
        squares.append(fitted @ np.linalg.solve(told, fitted) / 2.0)
    assert 0.7 < np.mean(squares) < 1.5


def test_a_prior_holds_what_nothing_shows():
    told = covariance(np.zeros((1, 50, 1)), np.ones((1, 50)), np.ones((1, 50)), np.array([2.3]))
    assert told[0, 0] == pytest.approx(2.3**2)
