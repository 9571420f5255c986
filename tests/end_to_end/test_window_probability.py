"""The probability beside a window is that of the plan made of its session."""

from dataclasses import replace
from datetime import timedelta

import numpy as np
import pytest
from scenarios import HRC, LAS_VEGAS, SALT_LAKE, TLE, at, scenario, session

from app.requests.examples import message
from planner.planning.opportunities import (
    OpportunityConditions,
    OpportunityRequest,
    OpportunityTarget,
    find_opportunities,
)
from planner.planning.sessions import window_probability
from planner.planning.sessions.pipeline import make_plan
from planner.planning.sessions.window_probability import probabilities_in_frame
from planner.world.attitude import LvlhAttitude
from planner.world.attitude.aem import AemAttitude
from planner.world.frames.time_scales import shifted_utc
from planner.world.orbits import OemOrbit
from planner.world.targets import BodyTarget, GroundTarget, MovingGroundTarget, StarTarget

COLOGNO = GroundTarget(latitude_deg=45.53, longitude_deg=9.28, height_m=130.0)  # 46 h later
SIRIUS = StarTarget(ra_deg=101.287, dec_deg=-16.716)
BOAT = MovingGroundTarget(
    latitude_deg=36.0, longitude_deg=-115.0, epoch=at(0.0), course_deg=90.0, speed_m_s=10.0
)
NEARLY = 0.02


def search(target, hours, *, above_deg=20.0, **more):
    return OpportunityRequest(
        **{
            "orbit": TLE,
            "attitude": LvlhAttitude(yaw_deg=-4.0, pitch_deg=-2.0, roll_deg=1.0),
            "platform": HRC,
            "targets": (OpportunityTarget(id="it", target=target),),
            "start": at(-600.0),
            "stop": at(3600.0 * hours),
            "conditions": OpportunityConditions(min_elevation_deg=above_deg),
        }
        | more
    )


def planned_probability(request, found, window):
    """Of a plan of the window's session, as it stands."""
    start, stop = (
        shifted_utc(found.start_utc, float(t_s))
        for t_s in found.windows.sessions_s(found.start_utc)[window]
    )
    asked = scenario(session(request.targets[found.windows.target[window]].target, 0.0, 1.0))
    plan = make_plan(
        replace(
            asked,
            orbit=request.orbit,
            attitude=request.law,
            platform=request.platform,
            initial_state=replace(asked.initial_state, epoch=start - timedelta(seconds=120)),
            sessions=(replace(asked.sessions[0], start=start, stop=stop),),
        )
    )
    return plan.budgets[0].probability_in_frame


CASES = {
    "a city today": search(LAS_VEGAS, 2.0),
    "a city low in the north": search(SALT_LAKE, 12.0, above_deg=5.0),
    "a city two days on": search(COLOGNO, 52.0),
    "a star": search(SIRIUS, 1.5, above_deg=0.0),
    "the Moon": search(BodyTarget(name="moon"), 1.0, above_deg=0.0),
    "a boat": search(BOAT, 1.0, above_deg=10.0),
    "messages of the mission": search(
        LAS_VEGAS,
        0.16,
        orbit=OemOrbit(content=message("orbit.oem")),
        attitude=AemAttitude(content=message("attitude.aem")),
        start=at(0.0),
    ),
}


@pytest.mark.parametrize("request_", CASES.values(), ids=CASES)
def test_a_window_and_the_plan_of_its_session_agree(request_):
    found = find_opportunities(request_)
    probability = probabilities_in_frame(request_, found.windows)
    known = np.flatnonzero(np.isfinite(probability))
    assert len(known) >= 1
    for window in {known[0], known[-1]}:
        expected = planned_probability(request_, found, window)
        assert probability[window] == pytest.approx(expected, abs=NEARLY)


def test_older_elements_make_it_less_likely():
    """A city low at first and high two days on: the soonest is the likelier all the same."""
    request = search(COLOGNO, 52.0)
    found = find_opportunities(request)
    probability = probabilities_in_frame(request, found.windows)
    today = found.windows.rise_s < 86_400.0
    assert probability[today].max() > 2.0 * probability[~today].max()


def test_the_soonest_windows_are_told_where_there_are_too_many(monkeypatch):
    options = replace(window_probability.OPTIONS, most=2.5 * window_probability.OPTIONS.window)
    monkeypatch.setattr(window_probability, "OPTIONS", options)
    places = [LAS_VEGAS, SALT_LAKE]
    request = search(
        LAS_VEGAS,
        30.0,
        targets=tuple(
            OpportunityTarget(id=str(number), target=place) for number, place in enumerate(places)
        ),
    )
    found = find_opportunities(request)
    told = np.isfinite(probabilities_in_frame(request, found.windows))
    assert 2 <= told.sum() < len(told)
    assert found.windows.rise_s[told].max() < found.windows.rise_s[~told].min()
