"""Times are ordered as they passed, through the second that a clock repeats.

2016 ended with 23:59:60 UTC (IERS Bulletin C 52).
"""

import json

import pytest

from app.requests.examples import LAS_VEGAS
from app.requests.plan import read_plan_request
from planner.base.errors import InvalidRequest
from planner.world.frames.time_scales import elapsed_s

BEFORE, WITHIN, AFTER = (
    f"{at}Z" for at in ("2016-12-31T23:59:59.8", "2016-12-31T23:59:60.6", "2017-01-01T00:00:00.4")
)


def scenario(epoch: str, *spans: tuple[str, str]):
    target = LAS_VEGAS["sessions"][0]["target"]
    sessions = [{"target": target, "start": start, "stop": stop} for start, stop in spans]
    state = {**LAS_VEGAS["initial_state"], "epoch": epoch}
    document = {**LAS_VEGAS, "initial_state": state, "sessions": sessions}
    return read_plan_request(json.dumps(document).encode())


def test_a_session_may_begin_within_the_leap_second():
    read = scenario(BEFORE, (WITHIN, AFTER))
    assert elapsed_s(read.sessions[0].start, read.initial_state.epoch) == pytest.approx(0.8)
    read = scenario("2016-12-31T23:59:50Z", ("2016-12-31T23:59:55Z", BEFORE), (WITHIN, AFTER))
    assert len(read.sessions) == 2


def test_the_second_before_the_leap_second_is_earlier():
    with pytest.raises(InvalidRequest) as refusal:
        scenario(WITHIN, (BEFORE, AFTER))
    assert refusal.value.field == "sessions.0.start"
    with pytest.raises(InvalidRequest) as refusal:
        scenario("2016-12-31T23:59:50Z", ("2016-12-31T23:59:55Z", WITHIN), (BEFORE, AFTER))
    assert refusal.value.field == "sessions.1.start"
