"""Events say how far work is, of every kind, and never that it goes back."""

import json
from pathlib import Path

import pytest
from planner_values import read_request
from waiting import PatientClient

from app.http.app import create_app
from app.jobs.kinds import CAMPAIGN, JOB_KINDS, PLAN, SPACECRAFT_PLAN
from app.requests.campaign import read_campaign_request
from app.requests.examples import CAMPAIGN_EXAMPLES, LAS_VEGAS, SPACECRAFT_EXAMPLES
from app.requests.spacecraft import read_spacecraft_request
from planner.base.errors import Refusal
from planner.planning.campaigns import choose_campaign, choose_what_is_asked
from planner.planning.sessions.pipeline import make_plan
from planner.spacecraft.plan import plan_imaging

EXAMPLES = Path(__file__).parents[2] / "examples"
STRIP = SPACECRAFT_EXAMPLES["geojson"][1] | {"simulation_runs": 2}


def plan_stages(tell):
    make_plan(read_request(LAS_VEGAS), tell)


def spacecraft_stages(tell):
    plan_imaging(read_spacecraft_request(json.dumps(STRIP).encode()), tell)


def campaign_stages(tell):
    request = json.dumps(CAMPAIGN_EXAMPLES["cities"][1]).encode()
    choose_campaign(read_campaign_request(request), tell)
    tell("plans", 0, 2)
    tell("plans", 2, 2)


@pytest.mark.parametrize(
    ("kind", "work"),
    [(PLAN, plan_stages), (SPACECRAFT_PLAN, spacecraft_stages), (CAMPAIGN, campaign_stages)],
    ids=lambda one: getattr(one, "name", None),
)
def test_percent_is_known_of_every_stage_and_grows(kind, work):
    told = []
    work(lambda *progress, **_: told.append(progress))
    percents = [kind.percent(*progress) for progress in told]
    assert None not in percents, {stage for stage, *_ in told} - set(kind.stages)
    assert percents == sorted(percents)
    assert (percents[0], percents[-1] <= 100) == (0, True)
    assert len({stage for stage, *_ in told}) > 3


@pytest.mark.parametrize("name", ["cities", "fleet", "resources"])
def test_a_campaign_tells_value_and_bound_as_they_are_reached(name):
    """Of one carrier or several; of resources no value that would take more than there is."""
    body = (EXAMPLES / f"campaign_{name}.json").read_bytes()
    told = []
    _, campaign = choose_what_is_asked(
        read_campaign_request(body), lambda stage, *_, **known: told.append((stage, known))
    )
    values = [known["value"] for _, known in told if "value" in known]
    assert values == sorted(values)
    assert len(values) >= 3
    assert values[0] >= campaign.greedy_value - 1e-9
    assert told[-1] == ("proof", {"value": campaign.value, "bound": campaign.bound})
    bounds = [known["bound"] for _, known in told if "bound" in known]
    assert bounds == pytest.approx([campaign.bound] * len(bounds))
    stages = [stage for stage, known in told if "bound" in known]
    assert stages == (["proof"] if name == "resources" else ["bound", "proof"])


def test_a_session_that_cannot_be_is_told_while_another_is_sought():
    request = STRIP | {"stop": STRIP["start"].replace("00Z", "30Z")}
    told = []
    with pytest.raises(Refusal):
        plan_imaging(
            read_spacecraft_request(json.dumps(request).encode()),
            lambda stage, *_: told.append(stage),
        )
    assert told[-1] == "alternatives"
    assert told.count("candidates") == 1


def test_a_plan_that_cannot_be_tells_how_much_of_the_ways_out_is_looked_for():
    request = json.loads(json.dumps(LAS_VEGAS))
    session = request["sessions"][0]
    request["sessions"].append(
        {**session, "start": session["stop"], "stop": "2015-02-27T17:38:20Z"}
    )
    request["sessions"][1]["target"] = {
        "mode": "ground",
        "latitude_deg": 40.76,
        "longitude_deg": -111.9,
    }
    told = []
    with pytest.raises(Refusal):
        make_plan(read_request(json.dumps(request).encode()), lambda *one: told.append(one))
    percents = [PLAN.percent(*one) for one in told if one[0] == "alternatives"]
    assert len(percents) >= 2
    assert percents == sorted(set(percents))
    assert PLAN.stages["slews and tracks"] < percents[0] <= percents[-1] < 100


@pytest.mark.parametrize("kind", JOB_KINDS.values(), ids=lambda kind: kind.name)
def test_percent_of_odd_progress(kind):
    assert kind.percent("no such stage") is None
    for stage in kind.stages:
        assert 0 <= kind.percent(stage, 0, 0) <= 100
        assert kind.percent(stage, 5, 3) <= 100


def test_a_stream_says_when_to_come_back_and_how_far_it_is():
    campaign = CAMPAIGN_EXAMPLES["cities"][1]
    with PatientClient(create_app()) as client:
        location = client.post("/v1/campaigns", json=campaign).headers["location"]
        text = client.get(f"{location}/events").text
    assert text.count("\nretry: 2000\n") == 1
    assert "retry" in text.split("\n\n")[0]
    told = [
        json.loads(line.removeprefix("data: "))
        for line in text.splitlines()
        if line.startswith("data: ") and '"stage"' in line
    ]
    percents = [one["percent"] for one in told]
    assert percents == sorted(percents)
    assert percents[-1] == 100  # the last of the passes is planned
