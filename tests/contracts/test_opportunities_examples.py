"""The gallery of opportunities holds what its paper shows."""

from pathlib import Path

import numpy as np
import pytest

from app.work.searches import read_opportunity_request
from planner.planning.opportunities import find_opportunities
from planner.world.frames.time_scales import Instants

GALLERY = Path(__file__).parents[2] / "examples" / "opportunities_gallery.json"


def test_las_vegas_is_in_sight_when_it_was_photographed():
    """Sumarokov 2016, Fig. 3: 27 Feb 2015; the pass of 17:35-17:39 UTC, 84 deg at most."""
    request = read_opportunity_request(GALLERY.read_bytes())
    windows = find_opportunities(request).windows
    [first] = np.flatnonzero((windows.target == 0) & (windows.rise_s < 86400.0))[:1]
    edges = Instants(request.start, np.array([windows.rise_s[first], windows.set_s[first]]))
    rise, fall = edges.utc_text(0)
    assert "2015-02-27T17:35:00Z" < rise < fall < "2015-02-27T17:39:00Z"
    # half the last digit of the figure's 84 deg, and as much again for another TLE
    assert np.rad2deg(windows.highest_rad[first]) == pytest.approx(84.0, abs=1.0)
