"""Sessions that a body's windows offer are planned; what isn't a body's is refused."""

from dataclasses import replace
from datetime import timedelta

import numpy as np
import pytest
from agile_bodies import SMALLSAT, smallsat
from scenarios import LAS_VEGAS, TLE, at

from planner.planning.opportunities import OpportunityRequest, OpportunityTarget, WindowSearch
from planner.planning.opportunities.unseen import unseen_of
from planner.planning.sessions import window_probability
from planner.planning.sessions.pipeline import make_plan
from planner.planning.sessions.window_probability import probabilities_in_frame
from planner.world.attitude import LvlhAttitude
from planner.world.frames.time_scales import shifted_utc
from planner.world.platforms import ISS_HRC
from planner.world.platforms.body import AzimuthRoll, LinesAcrossTrack, NearestRoll, SunSide
from planner.world.scenario import InitialState, Scenario, Session
from planner.world.targets import GroundTarget, StarTarget

BOSTON = GroundTarget(latitude_deg=42.36, longitude_deg=-71.06)
RADIATOR, CAMERA = SMALLSAT["exclusions"][1], SMALLSAT["exclusions"][0]
FRAME = {"type": "frame", "field_of_view_deg": [0.5, 0.3]}
KEPT = [RADIATOR | {"when": "imaging"}, CAMERA | {"when": "imaging"}]
ROLLS = {
    "nearest": {"exclusions": KEPT},
    "lines across the track": {"roll": {"rule": "lines_across_track"}, "exclusions": KEPT},
    "a frame": {"camera": FRAME, "exclusions": KEPT},
    "each target by a rule of its own": {"exclusions": KEPT},
}
OWN_ROLLS = (
    AzimuthRoll(azimuth_deg=110.0),
    LinesAcrossTrack(),
    SunSide(direction_body=(-1.0, 0.0, 0.0)),
)
NEARLY = 0.03  # three sigma of a thousand paths beside four times as many


def request(platform, *targets, **fields):
    return OpportunityRequest(
        **{
            "orbit": TLE,
            "platform": platform,
            "start": at(0.0),
            "stop": at(14400.0),
            "targets": tuple(
                OpportunityTarget(id=str(number), target=target)
                for number, target in enumerate(targets)
            ),
            **fields,
        }
    )


@pytest.mark.parametrize("case", ROLLS)
def test_the_session_of_every_window_of_a_body_plans_as_it_stands(case):
    """And the probability told of it is the plan's."""
    asked = request(smallsat(**ROLLS[case]), LAS_VEGAS, BOSTON, StarTarget(name="Vega"))
    if "of its own" in case:
        own = (replace(one, roll=roll) for one, roll in zip(asked.targets, OWN_ROLLS, strict=True))
        asked = replace(asked, targets=tuple(own))
    search = WindowSearch(asked)
    told = search.tell(search.find())
    sessions_s = told.sessions_s(asked.start)[:3]
    probability = probabilities_in_frame(asked, told)[:3]
    assert len(sessions_s) == 3
    for row, (start_s, stop_s), told_probability in zip(
        told.target.tolist(), sessions_s.tolist(), probability.tolist(), strict=False
    ):
        start, stop = (
            shifted_utc(asked.start, t_s) for t_s in (start_s, min(stop_s, start_s + 300.0))
        )
        wanted = asked.targets[row]
        plan = make_plan(
            Scenario(
                platform=asked.platform,
                orbit=asked.orbit,
                initial_state=InitialState(epoch=start - timedelta(seconds=150.0)),
                sessions=(Session(target=wanted.target, start=start, stop=stop, roll=wanted.roll),),
            )
        )
        assert plan.verification.passed
        [budget] = plan.budgets
        assert told_probability == pytest.approx(budget.probability_in_frame, abs=NEARLY)


def test_quick_wander_leaves_the_latest_windows_without_a_probability(monkeypatch):
    """Its work is counted: of a body whose attitude forgets itself within a second."""
    slow, quick = (
        request(
            smallsat(knowledge=SMALLSAT["knowledge"] | {"correlation_s": correlation_s}),
            LAS_VEGAS,
            BOSTON,
            StarTarget(name="Vega"),
        )
        for correlation_s in (20.0, 1.0)
    )
    most = 3.5 * window_probability.OPTIONS.window
    options = replace(window_probability.OPTIONS, most=most)
    monkeypatch.setattr(window_probability, "OPTIONS", options)
    search = WindowSearch(slow)
    told = search.tell(search.find())
    of_slow, of_quick = (np.isfinite(probabilities_in_frame(one, told)) for one in (slow, quick))
    assert 1 <= of_quick.sum() < of_slow.sum()


def test_an_attitude_is_no_bodys():
    with pytest.raises(ValueError, match="attitude must be left out for smallsat-120kg"):
        request(smallsat(), LAS_VEGAS, attitude=LvlhAttitude())


@pytest.mark.parametrize(
    ("platform", "roll", "words"),
    [
        (smallsat(), AzimuthRoll(azimuth_deg=1.0), "targets.1.roll must not be azimuth, which"),
        (smallsat(), SunSide(direction_body=(0.0, 0.0, 1.0)), "targets.1.roll.direction_body"),
        (ISS_HRC, NearestRoll(), "targets.1.roll must be left out for iss-hrc: only a body"),
    ],
    ids=["says nothing of a star", "along the boresight", "two axes"],
)
def test_a_roll_that_a_target_cannot_have_is_refused(platform, roll, words):
    vega = OpportunityTarget(id="Vega", target=StarTarget(name="Vega"), roll=roll)
    with pytest.raises(ValueError, match=words):
        request(platform, targets=(OpportunityTarget(id="it", target=BOSTON), vega))


CLOSED = {
    "off_nadir": {"off_nadir_max_deg": 2.0},
    "exclusion": {"exclusions": [CAMERA | {"min_deg": 179.0}]},
    "rate": {"torque_max_n_m": None, "agility": SMALLSAT["agility"] | {"rate_max_deg_s": 0.1}},
}


@pytest.mark.parametrize(("cause", "changes"), CLOSED.items(), ids=CLOSED)
def test_what_closes_all_windows_of_a_body_is_told(cause, changes):
    asked = request(smallsat(**changes), LAS_VEGAS)
    search = WindowSearch(asked)
    [unseen] = unseen_of(asked, search.carrier, search.find().target)
    assert unseen.closed_by == cause
