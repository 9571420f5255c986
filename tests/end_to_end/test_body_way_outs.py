"""A refused session of a body is told the nearest way out, which plans when it is sent."""

import other_body
import pytest
from planner_values import plan_of

from planner.base.commands import COMMAND_STEP_S
from planner.base.errors import InfeasibleSlew, Refusal
from planner.world.frames.time_scales import elapsed_s, shifted_utc, utc_from_text, utc_text

# A steep limit of the angle off nadir, at either end of a pass; a rate too slow for its middle.
SLOW = {"rate_max_deg_s": [1.43, 0.9, 0.9], "acceleration_max_deg_s2": [0.43, 0.32, 0.3]}
BODIES = [
    {"off_nadir_max_deg": 48.0},
    {"off_nadir_max_deg": 45.0, "roll": {"rule": "lines_across_track"}},
    {"agility": SLOW | {"limits": "axis", "jerk_max_deg_s3": [0.6, 0.4, 0.35], "settle_s": 5.0}},
]


def request_of(changes, number):
    request = other_body.body_request(sessions=3)
    session = request["sessions"][number]
    platform = other_body.PLATFORM | changes
    return request | {"platform": platform, "sessions": [session]}


def planned(request, start_utc, stop_utc):
    """With these times of its session."""
    times = {"start": utc_text(start_utc, 1), "stop": utc_text(stop_utc, 1)}
    sessions = [request["sessions"][0] | times]
    return plan_of(request | {"sessions": sessions})


def way_out(request, start_utc, stop_utc):
    """The times told where it is refused, None where it is planned."""
    try:
        planned(request, start_utc, stop_utc)
    except Refusal as refusal:
        return refusal.earliest_feasible_start_utc, refusal.feasible_stop_utc
    return None, None


@pytest.mark.parametrize(
    ("changes", "objective"),
    [(BODIES[0], "smooth"), (BODIES[1], "minimum_time"), (BODIES[2], "smooth")],
)
def test_a_way_out_is_flown_and_no_nearer_start_is(changes, objective):
    refused = 0
    for number in range(3):
        request = request_of(changes, number) | {"slew": {"objective": objective}}
        asked = request["sessions"][0]
        start_utc, stop_utc = (utc_from_text(asked[side]) for side in ("start", "stop"))
        told_start_utc, told_stop_utc = way_out(request, start_utc, stop_utc)
        if told_start_utc is None:
            continue
        refused += 1
        assert planned(request, told_start_utc, told_stop_utc).verification.passed
        later_s = elapsed_s(told_start_utc, start_utc)
        if later_s > COMMAND_STEP_S:
            nearer_utc = shifted_utc(told_start_utc, -COMMAND_STEP_S)
            with pytest.raises(Refusal):
                planned(request, nearer_utc, told_stop_utc)
    assert refused >= 1


@pytest.mark.parametrize(("after_s", "objective"), [(5.0, "minimum_time"), (6.2, "smooth")])
def test_a_session_too_soon_to_settle_for_is_told_so(after_s, objective):
    agility = other_body.PLATFORM["agility"] | {"settle_s": 5.0}
    request = request_of({"agility": agility}, 0) | {"slew": {"objective": objective}}
    asked = request["sessions"][0]
    start_utc, stop_utc = (utc_from_text(asked[side]) for side in ("start", "stop"))
    epoch = {"epoch": utc_text(shifted_utc(start_utc, -after_s), 1)}
    request |= {"initial_state": request["initial_state"] | epoch}
    with pytest.raises(InfeasibleSlew) as refused:
        planned(request, start_utc, stop_utc)
    refusal = refused.value
    assert refusal.field == "sessions.0.start"
    assert refusal.limit == "duration"
    assert ("settle" in refusal.detail) == (after_s <= 5.0)
    assert ("the body needs" in refusal.detail) == (after_s > 5.0)
    told_start_utc, told_stop_utc = refusal.earliest_feasible_start_utc, refusal.feasible_stop_utc
    assert elapsed_s(told_start_utc, start_utc) > 5.0 - after_s
    assert planned(request, told_start_utc, told_stop_utc).verification.passed
