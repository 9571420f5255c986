"""The third paper's sessions are planned at its moments and flown steadily."""

import json
from pathlib import Path

import numpy as np
import pytest

from app.requests.spacecraft import read_spacecraft_request
from planner.spacecraft.plan import plan_imaging
from planner.world.frames.time_scales import elapsed_s

EXAMPLES = Path(__file__).parents[2] / "examples"
LONG_START_S = 400.0  # the paper's clock at row 0 of the long session
# Slews onto the first strip and the 31 that follow, below Fig. 7.
COMMANDED_S = (
    600, 725, 756, 789, 821, 882, 914, 946, 979, 1040, 1071, 1104, 1136, 1197, 1229, 1261, 1294,
    1355, 1386, 1419, 1451, 1512, 1544, 1576, 1609, 1670, 1701, 1734, 1766, 1827, 1859, 1891,
)  # fmt: skip


def fly(name):
    document = json.loads((EXAMPLES / name).read_text(encoding="utf-8"))
    plan = plan_imaging(read_spacecraft_request(json.dumps(document).encode()))
    assert plan.left_out == ()
    assert plan.verification.passed
    assert (
        plan.stabilisation.share_steady == 1.0
    )  # 0.001 deg/s on every axis: Platonov, Sumarokov 2019, Figs. 4, 6, 8, 9
    return plan, [(w.first_row / 5.0, w.last_row / 5.0) for w in plan.windows]


def begins_s(plan, slew):
    return elapsed_s(slew.start_utc, plan.table.epoch_utc)


@pytest.fixture(scope="module")
def strip_and_stereo():
    return fly("spacecraft_strip_and_stereo.json")


def test_strip_and_stereo_pair_are_imaged_when_the_paper_images_them(strip_and_stereo):
    plan, windows_s = strip_and_stereo
    # Figs. 4 and 6; a scan lasts whole cycles of 0.2 s.
    np.testing.assert_allclose(windows_s, [(128, 144), (338, 354), (448, 464)], atol=0.2)
    leaving_s = {slew.onto: begins_s(plan, slew) for slew in plan.slews}
    # The paper commands its slews there: ours need no more time.
    for window, commanded_s in enumerate((72.0, 252.0, 354.0)):
        assert leaving_s[window] >= commanded_s


def test_the_long_session_has_the_papers_moments():
    """Of Figs. 7 to 9: the latter show the second area's first and the fifth's third strip."""
    plan, windows_s = fly("spacecraft_eight_areas.json")
    assert len(windows_s) == 32
    clock_s = np.array(windows_s) + LONG_START_S
    for number, shown in ((4, (866.0, 881.0)), (18, (1405.0, 1419.0))):
        np.testing.assert_allclose(clock_s[number], shown, atol=0.3)  # a cycle is 0.2 s
    np.testing.assert_allclose(np.diff(clock_s), [[15.0], *[[14.0]] * 3] * 8, atol=0.3)
    # Each scan ends where the next slew is commanded, by 1 s at the end of an area's first strip.
    left_s = np.array(COMMANDED_S[1:]) - clock_s[:-1, 1]
    assert np.all((left_s > 0.0) & (left_s < 1.1))
    into_orbital, onto_the_first, *_ = plan.slews
    assert begins_s(plan, into_orbital) == 0.0
    assert begins_s(plan, onto_the_first) + LONG_START_S >= COMMANDED_S[0]
