"""Gaps between sessions and duty cycles: plans, ways out, the judge, windows and campaigns."""

import copy
import json
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from planner_values import planned_passes
from random_resources import IDLES, PLATFORM, asked, utc

from app.requests.campaign import read_campaign_request
from app.requests.examples import LAS_VEGAS
from app.work.searches import read_opportunity_request
from planner.base.errors import CadenceBroken, InvalidRequest
from planner.planning.campaigns.campaign import choose_campaign
from planner.planning.opportunities import find_opportunities
from planner.planning.sessions.pipeline import make_plan
from planner.verification import verify
from planner.world.frames.time_scales import Instants, elapsed_s, utc_text
from planner.world.orbits.period import period_s

EXAMPLES = Path(__file__).parents[2] / "examples"
STARS = [{"mode": "star", "ra_deg": 182.0, "dec_deg": 38.0},
         {"mode": "star", "ra_deg": 190.0, "dec_deg": 30.0}]  # fmt: skip
BODY = {
    "platform": PLATFORM | {"idle": IDLES[2]},
    "orbit": LAS_VEGAS["orbit"],
    "initial_state": {"epoch": utc(0.0)},
    "sessions": [
        {"target": STARS[number % 2], "start": utc(1000.0 + 400.0 * number),
         "stop": utc(1100.0 + 400.0 * number)} for number in range(3)
    ],
}  # fmt: skip
AXES = json.loads((EXAMPLES / "three_sessions.json").read_text())


@pytest.mark.parametrize(
    ("base", "conditions", "limit", "session", "lasts_s"),
    [
        (BODY, {"min_gap_s": 400.0}, "min_gap", 1, 100.0),
        (BODY, {"duty_cycle": {"imaging_max_s": 250.0}}, "duty_cycle", 2, 50.0),
        (BODY, {"duty_cycle": {"imaging_max_s": 120.0, "span_s": 450.0}}, "duty_cycle", 1, 20.0),
        (BODY, {"duty_cycle": {"imaging_max_s": 100.0, "span_s": 600.0}}, "duty_cycle", 1, 100.0),
        (AXES, {"min_gap_s": 60.0}, "min_gap", 2, 90.0),
        (AXES, {"duty_cycle": {"imaging_max_s": 300.0}}, "duty_cycle", 2, 80.0),
        (AXES, {"duty_cycle": {"imaging_max_s": 100.0}}, "duty_cycle", 0, 100.0),
    ],
)
def test_a_refusal_tells_what_then_is_planned(base, conditions, limit, session, lasts_s):
    request = copy.deepcopy(base) | {"conditions": conditions}
    with pytest.raises(CadenceBroken) as refused:
        make_plan(asked(request))
    told = refused.value
    assert (told.limit, told.field) == (limit, f"sessions.{session}.start")
    assert told.at_utc is not None
    start_utc, stop_utc = told.earliest_feasible_start_utc, told.feasible_stop_utc
    assert elapsed_s(stop_utc, start_utc) == pytest.approx(lasts_s, abs=0.2)
    request["sessions"][session] |= {
        "start": utc_text(start_utc, 6), "stop": utc_text(stop_utc, 6),
    }  # fmt: skip
    kept = [one for n, one in enumerate(request["sessions"]) if n not in told.costs_sessions]
    request["sessions"] = kept
    plan = make_plan(asked(request))
    assert plan.verification.passed
    if "min_gap_s" in conditions:  # no sooner start would do
        before, after = plan.scenario.sessions[session - 1 : session + 1]
        assert elapsed_s(after.start, before.stop) == pytest.approx(conditions["min_gap_s"])


def test_the_judge_finds_the_most_imaging_of_any_span():
    plan = make_plan(asked(BODY))
    epoch_utc, rng = plan.table.epoch_utc, np.random.default_rng(4)
    spans_s = np.array(
        [[elapsed_s(at, epoch_utc) for at in (s.start, s.stop)] for s in plan.scenario.sessions]
    )
    for span_s in rng.uniform(100.0, 1500.0, 12):
        conditions = {"min_gap_s": 310.0, "duty_cycle": {"imaging_max_s": 90.0, "span_s": span_s}}
        scenario = replace(
            plan.scenario, conditions=asked(BODY | {"conditions": conditions}).conditions
        )
        judged = verify(plan.table, scenario, plan.waits)
        ends_s = np.arange(0.0, 2500.0, 0.5)
        overlap_s = np.minimum(spans_s[:, 1, None], ends_s) - np.maximum(
            spans_s[:, 0, None], ends_s - span_s
        )
        most_s = np.maximum(overlap_s, 0.0).sum(axis=0).max()
        told = {one.name: one for s in judged.sessions for one in s.conditions}
        duty_s = max(
            one.extreme for s in judged.sessions for one in s.conditions if one.name == "duty_cycle"
        )
        assert duty_s == pytest.approx(most_s, abs=0.5)  # ends half a second apart
        assert told["min_gap_s"].extreme == pytest.approx(300.0)
        limits = [one.limit for one in judged.findings if one.severity == "error"]
        assert limits.count("min_gap") == 2
        assert "duty_cycle" in limits


def test_looks_of_earlier_plans_count():
    """As the first two sessions did as sessions of its own."""
    first, second, third = BODY["sessions"]
    past = [{"start": one["start"], "stop": one["stop"]} for one in (second, first)]
    state = {"epoch": utc(1550.0), "past_looks": past}
    conditions = {"min_gap_s": 290.0, "duty_cycle": {"imaging_max_s": 300.0}}
    request = BODY | {"initial_state": state, "sessions": [third], "conditions": conditions}
    plan = make_plan(asked(request))
    told = {one.name: one for one in plan.verification.sessions[0].conditions}
    assert told["min_gap_s"].extreme == pytest.approx(300.0)
    assert told["duty_cycle"].extreme == pytest.approx(300.0)
    for rule, at_s in (
        ({"min_gap_s": 310.0}, 1800.0), ({"duty_cycle": {"imaging_max_s": 250.0}}, 1850.0)
    ):  # fmt: skip
        with pytest.raises(CadenceBroken) as refused:
            make_plan(asked(request | {"conditions": rule}))
        assert elapsed_s(refused.value.at_utc, plan.table.epoch_utc) + 1550.0 == pytest.approx(at_s)
        broken = asked(BODY | {"conditions": rule}).conditions
        judged = verify(plan.table, replace(plan.scenario, conditions=broken), plan.waits)
        assert {one.limit for one in judged.findings} == {refused.value.limit}
    state["past_looks"] = [{"start": past[0]["stop"], "stop": past[0]["start"]}]
    with pytest.raises(
        InvalidRequest, match=r"initial_state.past_looks.0.stop: .* must come after"
    ):
        asked(request)


def test_a_revolution_is_the_same_wherever_it_is_looked_at():
    scenario = asked(BODY)
    ephemeris = scenario.orbit.ephemeris(scenario.initial_state.epoch, scenario.last_utc)
    at = Instants(scenario.initial_state.epoch, np.linspace(0.0, 1800.0, 10))
    periods_s = period_s(at, ephemeris.states(at))
    assert np.ptp(periods_s) < 0.2
    # 15.549 revolutions a day, node to node: the flattening makes 0.1 % between the two
    assert periods_s.mean() == pytest.approx(86400.0 / 15.54887, rel=2e-3)


def test_a_session_of_a_window_is_no_longer_than_a_duty_cycle_lets_it():
    for name, most_s in (("gallery", 20.0), ("smallsat", 20.0), ("modes", 10.0)):
        request = json.loads((EXAMPLES / f"opportunities_{name}.json").read_text())
        plain = find_opportunities(read_opportunity_request(json.dumps(request).encode()))
        duty = {"imaging_max_s": most_s}
        request["conditions"] = request.get("conditions", {}) | {"duty_cycle": duty}
        found = find_opportunities(read_opportunity_request(json.dumps(request).encode()))
        lasts_s = np.diff(found.windows.sessions_s(found.start_utc), axis=1)
        assert np.nanmax(lasts_s) <= most_s
        was_s = np.diff(plain.windows.sessions_s(plain.start_utc), axis=1)
        assert np.nanmax(was_s) > most_s
        if name != "modes":  # a scan that lasts longer has none
            assert len(found.windows) == len(plain.windows)


def campaigns(name, conditions):
    """An example without conditions and with them, requests and choices."""
    request = json.loads((EXAMPLES / f"{name}.json").read_text())
    given = request.pop("conditions", {})
    for one in (given, given | conditions):
        scaled = read_campaign_request(json.dumps(request | {"conditions": one}).encode())
        yield scaled, choose_campaign(scaled)


def looks_s(campaign, passes=None):
    """Starts and stops of looks, (n, 2)."""
    first_utc = campaign.passes[0].start_utc
    looks = [look for one in passes or campaign.passes for look in one.looks]
    return np.array(
        [[elapsed_s(at, first_utc) for at in (one.start_utc, one.stop_utc)] for one in looks]
    )


@pytest.mark.parametrize("name", ["campaign_cities", "campaign_smallsat"])
def test_a_campaign_keeps_the_gap_within_passes_and_between_them(name):
    (_, free), (kept, campaign) = campaigns(name, {"min_gap_s": 60.0})
    gaps_s = [b[0] - a[1] for a, b in pairwise(looks_s(campaign))]
    assert min(gaps_s) == pytest.approx(60.0)
    assert min(b[0] - a[1] for a, b in pairwise(looks_s(free))) < 60.0
    assert campaign.value < free.value
    assert campaign.value <= campaign.bound <= free.bound
    assert list(planned_passes(kept, campaign))


@pytest.mark.parametrize(
    ("name", "duty", "lacking"),
    [
        ("campaign_cities", {"imaging_max_s": 70.0}, {"Phoenix"}),
        # it would have room beside the others, did these move
        ("campaign_cities", {"imaging_max_s": 45.0, "span_s": 90.0}, {"Phoenix"}),
        (
            "campaign_smallsat",
            {"imaging_max_s": 45.0, "span_s": 20_000.0},
            {"Los Angeles", "Boston"},
        ),
    ],
)
def test_a_campaign_keeps_the_duty_cycle_and_its_plans_count_the_passes_before(name, duty, lacking):
    (_, free), (kept, campaign) = campaigns(name, {"duty_cycle": duty})
    most_s, span_s = kept.duty_cycle.imaging_max_s, kept.duty_cycle.span_s

    def imaged_s(looks):
        """In the span that has most, which ends as a look does or begins as one does."""
        ends_s = np.concatenate([looks.ravel(), looks.ravel() + span_s])[:, None]
        parts_s = np.minimum(looks[:, 1], ends_s) - np.maximum(looks[:, 0], ends_s - span_s)
        return np.maximum(parts_s, 0.0).sum(axis=1).max()

    assert imaged_s(looks_s(campaign)) <= most_s + 1e-6 < imaged_s(looks_s(free))
    assert campaign.value < free.value
    assert campaign.value <= campaign.bound <= free.bound
    assert campaign.gap_share < 0.25
    short = [one for one in campaign.left_out if one.lacks == "duty_cycle"]
    assert lacking <= {one.target for one in short}
    for one in short:
        assert f"the duty cycle would pass its limit of {most_s:g} s" in one.because
    assert not any(one.lacks for one in free.left_out)
    *_, (one, plan) = planned_passes(kept, campaign)
    told = [c for s in plan.verification.sessions for c in s.conditions if c.name == "duty_cycle"]
    assert max(c.extreme for c in told) > sum(np.diff(looks_s(campaign, [one])).ravel()) - 1e-6


def test_a_campaign_refuses_by_name_a_gap_that_its_choice_does_not_keep():
    request = json.loads((EXAMPLES / "campaign_cities.json").read_text())
    with pytest.raises(InvalidRequest, match="min_gap_s"):
        read_campaign_request(json.dumps(request | {"conditions": {"min_gap_s": 1801.0}}).encode())


def test_a_span_holds_its_imaging():
    duty = {"imaging_max_s": 700.0, "span_s": 600.0}
    with pytest.raises(InvalidRequest, match="imaging_max_s: must be span_s"):
        asked(BODY | {"conditions": {"duty_cycle": duty}})
