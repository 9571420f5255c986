"""Are the third paper's sessions planned at its moments and flown steadily?"""

import json
from pathlib import Path

import numpy as np
import pytest

from app.requests.spacecraft import read_spacecraft_request
from planner.spacecraft.plan import plan_imaging

EXAMPLES = Path(__file__).parents[2] / "examples"
LONG_START_S = 400.0  # the paper's clock at row 0 of the long session


def fly(name):
    document = json.loads((EXAMPLES / name).read_text(encoding="utf-8"))
    plan = plan_imaging(read_spacecraft_request(json.dumps(document).encode()))
    assert plan.left_out == ()
    assert plan.verification.passed
    assert (
        plan.stabilisation.share_steady == 1.0
    )  # 0.001 deg/s on every axis: Platonov, Sumarokov 2019, Figs. 4, 6, 8, 9
    return plan, [(w.first_row / 5.0, w.last_row / 5.0) for w in plan.table.windows]


@pytest.fixture(scope="module")
def strip_and_stereo():
    return fly("spacecraft_strip_and_stereo.json")


def test_strip_and_stereo_pair_are_imaged_when_the_paper_images_them(strip_and_stereo):
    plan, windows_s = strip_and_stereo
    # Figs. 4 and 6; a scan lasts whole cycles of 0.2 s.
    np.testing.assert_allclose(windows_s, [(128, 144), (338, 354), (448, 464)], atol=0.2)
    turns_s = [turn.first_row / 5.0 for turn in plan.turns]
    assert turns_s[0] >= 72.0  # the paper's turn begins there: ours needs no more time


def test_the_long_session_has_the_papers_intervals():
    """Intervals of Figs. 8 and 9: second area, first strip, and fifth area, third strip."""
    _, windows_s = fly("spacecraft_eight_areas.json")
    assert len(windows_s) == 32
    on_the_papers_clock = np.array(windows_s) + LONG_START_S
    for shown in ((866.0, 881.0), (1405.0, 1419.0)):
        assert np.abs(on_the_papers_clock - shown).max(axis=1).min() < 0.3  # a cycle is 0.2 s
