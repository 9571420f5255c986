"""The examples of requests for opportunities say what they mean."""

from pathlib import Path

import numpy as np
import pytest

from app.requests.opportunities import read_opportunity_request
from planner.planning.opportunities import find_opportunities
from planner.world.frames.time_scales import Instants

EXAMPLES = sorted((Path(__file__).parents[2] / "examples").glob("opportunities_*.json"))


def read(path):
    return read_opportunity_request(path.read_bytes())


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_every_target_has_a_window(path):
    request = read(path)
    windows = find_opportunities(request).windows
    assert set(windows.target.tolist()) == set(range(len(request.targets)))
    assert request.platform.kind == "body" or np.all(windows.branches.any(axis=1))


def test_las_vegas_is_in_sight_when_it_was_photographed():
    """Sumarokov 2016, Fig. 3: 27 Feb 2015; the pass of 17:35-17:39 UTC, 84 deg at most."""
    request = read(next(path for path in EXAMPLES if path.stem == "opportunities_gallery"))
    windows = find_opportunities(request).windows
    [first] = np.flatnonzero((windows.target == 0) & (windows.rise_s < 86400.0))[:1]
    edges = Instants(request.start, np.array([windows.rise_s[first], windows.set_s[first]]))
    rise, fall = edges.utc_text(0)
    assert "2015-02-27T17:35:00Z" < rise < fall < "2015-02-27T17:39:00Z"
    # half the last digit of the figure's 84 deg, and as much again for another TLE
    assert np.rad2deg(windows.highest_rad[first]) == pytest.approx(84.0, abs=1.0)
