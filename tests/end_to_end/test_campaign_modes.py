"""Campaigns of imaging modes: all scans of a mode or none, planned as they were chosen."""

import json
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from planner_values import planned_passes

from app.requests.campaign import CAMPAIGN_READER
from app.requests.plan import read_plan_request
from app.work import campaign as campaign_work
from planner.base.errors import InvalidRequest
from planner.planning.campaigns import campaign as campaigns
from planner.planning.campaigns import carrier_looks, choose_campaign, scenario_of
from planner.planning.campaigns.network import NEVER
from planner.planning.resources import resource_curves
from planner.planning.sessions.pipeline import make_plan
from planner.world.frames.earth_orientation import c_itrf_from_eci
from planner.world.frames.time_scales import Instants, elapsed_s, shifted_utc

EXAMPLE = json.loads((Path(__file__).parents[2] / "examples" / "campaign_modes.json").read_text())
STRIP, STEREO, CORRIDOR, AREA = (one["target"] for one in EXAMPLE["targets"])


def read(**changes):
    return CAMPAIGN_READER.read(json.dumps(EXAMPLE | changes).encode())


@pytest.fixture(scope="module")
def chosen():
    request = read()
    return request, choose_campaign(request)


def test_every_scan_of_a_mode_is_planned_as_it_was_chosen(chosen):
    request, campaign = chosen
    seen = {}
    for flight, plan in planned_passes(request, campaign):
        assert len(plan.scenario.sessions) == len(flight.looks)
        for look, session in zip(flight.looks, plan.scenario.sessions, strict=True):
            assert (session.start, session.stop) == (look.start_utc, look.stop_utc)
            assert session.of == look.target
            assert look.part is not None
            seen.setdefault(look.target, []).append((look.part, look.parts))
    assert {"strip", "stereo"} <= seen.keys()
    for parts in seen.values():
        assert sorted(parts) == [(part, len(parts)) for part in range(1, len(parts) + 1)]
    assert campaign.greedy_value <= campaign.value <= campaign.bound


def test_panels_and_wheels_of_a_body_that_settles_before_a_scan_are_followed():
    """From where it settles, which the last begin of a scan has, too."""
    panel = {"normal_body": [0.0, 0.0, -1.0], "power_w": 180.0}
    battery = {"capacity_wh": 110.0, "start_wh": 80.0, "idle_w": 50.0, "panels": [panel]}
    wheels = {"capacity_n_m_s": [0.4, 0.4, 0.4], "unload_n_m": 2e-4}
    resources = {"battery": battery, "momentum": wheels}
    request = read(platform="smallsat-120kg", resources=resources)
    [(flight, plan)] = planned_passes(request, choose_campaign(request))
    charge, *momenta = (float(one.level[-1]) for one in resource_curves(plan))
    assert charge == pytest.approx(flight.held.battery_wh[1], abs=2e-3 * 110.0)
    assert momenta == pytest.approx(flight.held.momentum_n_m_s[1], abs=2e-3 * 0.4)


def test_looks_of_a_stereo_are_at_their_angles_in_order(chosen):
    request, campaign = chosen
    looks = [one for flight in campaign.passes for one in flight.looks if one.target == "stereo"]
    assert [look.part for look in looks] == [1, 2]
    for look, wanted_deg in zip(looks, (22.0, -22.0), strict=True):
        middle_utc = look.start_utc + (look.stop_utc - look.start_utc) / 2
        assert ahead_deg(request, look.path, middle_utc) == pytest.approx(wanted_deg, abs=1.1)


def ahead_deg(request, path, at_utc):
    """How far the line's middle is ahead of nadir, along the track."""
    ephemeris = request.orbit.ephemeris(at_utc - timedelta(seconds=5), at_utc)
    instants = Instants(at_utc, np.zeros(1))
    states = ephemeris.states(instants)
    half = timedelta(seconds=path.duration_s / 2)
    r_itrf_m = path.starting(at_utc - half).r_target_itrf_m(instants)[0]
    to_middle = c_itrf_from_eci(instants)[0].T @ r_itrf_m - states.r_sat_eci_m[0]
    down = -states.r_sat_eci_m[0] / np.linalg.norm(states.r_sat_eci_m[0])
    v = states.v_sat_eci_m_s[0] - (states.v_sat_eci_m_s[0] @ down) * down
    return np.rad2deg(np.arctan2(to_middle @ v / np.linalg.norm(v), to_middle @ down))


def test_the_request_of_a_pass_is_read_as_it_was_chosen(chosen):
    request, campaign = chosen
    flight = campaign.passes[0]
    asked = {target["id"]: target["target"] for target in EXAMPLE["targets"]}
    part = campaign_work._part(EXAMPLE, asked, EXAMPLE, request, 0, flight)
    scenario = read_plan_request(part.request)
    assert scenario.sessions == scenario_of(request, flight, 0).sessions
    assert scenario.on_conflict == "refuse"
    told = part.facts["looks"]
    assert [(one["target"], one["part"]) for one in told] == [
        (one.target, one.part) for one in flight.looks
    ]
    # What can't be flown takes all scans of its mode with it.
    refused = next(n for n, one in enumerate(told) if one["target"] == "stereo")
    less = campaign_work.without_refused(part, f"sessions.{refused}.start", "why")
    assert [one["target"] for one in less.facts["left_out"]] == ["stereo"]
    assert len(read_plan_request(less.request).sessions) == len(told) - 2
    assert "stereo" not in [one["target"] for one in less.facts["looks"]]


def short_line(north_deg, east_deg, target=STRIP):
    (x, y), *_ = STRIP["geometry"]["coordinates"]
    ends = [[x + east_deg, y + north_deg], [x + east_deg - 0.06, y + north_deg + 0.27]]
    return target | {"geometry": {"type": "LineString", "coordinates": ends}}


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_choice_is_the_best_of_all_subsets_or_near_it(seed, monkeypatch):
    """Strips and stereo pairs that can't all be had: every sequence is tried by itself."""
    random = np.random.default_rng(seed)
    kept = {}
    build = carrier_looks._build_networks

    def keeping(*given):
        kept["networks"] = build(*given)
        return kept["networks"]

    monkeypatch.setattr(carrier_looks, "_build_networks", keeping)
    targets = [
        {
            "id": str(number),
            "priority": float(random.uniform(1.0, 3.0)),
            "target": short_line(
                float(random.uniform(0.0, 0.8)),
                float(random.uniform(-2.0, 2.0)),
                STEREO if number < 2 else STRIP,
            ),
        }
        for number in range(5)
    ]
    # Within 120 s from idle to idle there is no time for all.
    request = read(targets=targets, step_s=6.0, start="2024-06-01T10:00:00Z",
                   stop="2024-06-01T10:02:00Z")  # fmt: skip
    looking = {}
    choose = campaigns.choose_keeping

    def keep_looking(keeping, passes, *given, **named):
        looking["it"] = passes.looking
        return choose(keeping, passes, *given, **named)

    monkeypatch.setattr(campaigns, "choose_keeping", keep_looking)
    campaign = choose_campaign(request)
    [network] = kept["networks"]
    best = best_whole(network, looking["it"])
    assert 0.0 < campaign.value <= best + 1e-9
    assert campaign.bound >= best - 1e-9
    assert campaign.value >= 0.98 * best


def best_whole(network, looking):
    """The most that a sequence with whole groups is worth."""
    lasts_steps = looking.length_steps[:, 0]
    takes = lasts_steps + int(looking.settle_steps[0])

    def gain(way, begin):
        cell = network.offset[way] + begin - network.first[way]
        lasts = lasts_steps[network.target[way]]
        end = cell + takes[network.target[way]]
        seen = network.quality_sum[end] - network.quality_sum[end - lasts]
        return looking.look_value[network.target[way], 0] * seen / lasts

    @cache
    def after(way, step, seen):
        """Of each set of targets seen later the most that it is worth."""
        is_back = network.ends[network.offset[way] + step - network.first[way]]
        best = {frozenset(): 0.0} if is_back else {}
        for to, from_step in arrivals(network, way, step):
            if network.target[to] not in seen:
                merge(best, beginning(to, from_step, seen))
        return best

    def beginning(way, from_step, seen):
        best, target = {}, network.target[way]
        for begin in range(from_step, network.last[way] - takes[target] + 1):
            for later, value in after(way, begin + takes[target], seen | {target}).items():
                merge(best, {later | {target}: value + gain(way, begin)})
        return best

    found = {frozenset(): 0.0}
    for way, cell in enumerate(network.enters):
        if cell != NEVER:
            from_step = network.first[way] + cell - network.offset[way]
            merge(found, beginning(way, from_step, frozenset()))
    groups = [set(looking.members(group)) for group in range(looking.groups)]
    return max(
        value
        for targets, value in found.items()
        if all(group <= targets or group.isdisjoint(targets) for group in groups)
    )


def merge(best, more):
    for targets, value in more.items():
        best[targets] = max(best.get(targets, -np.inf), value)


def arrivals(network, way, step):
    """Ways that can be joined after one is left at a step, and when first."""
    edges = range(network.edge_from[way], network.edge_from[way + 1])
    row = network.arrival_offset[way] + (step - network.first[way]) * len(edges)
    for edge in edges:
        to, cell = network.edge_to[edge], network.arrival[row + edge - edges[0]]
        if cell != NEVER:
            yield to, cell - network.offset[to] + network.first[to]


def test_a_crowded_pass_is_filled_by_its_best_order_and_planned():
    """Of fourteen strips in 210 s, by more than a search by worth alone finds, near the bound."""
    random = np.random.default_rng(4)
    targets = [
        {
            "id": str(number),
            "priority": float(random.uniform(1.0, 5.0)),
            "target": short_line(float(random.uniform(0.0, 7.0)), float(random.uniform(-2.0, 2.0))),
        }
        for number in range(14)
    ]
    request = read(targets=targets, step_s=0.4, view={"ground_sample": 0.0},
                   start="2024-06-01T10:00:00Z", stop="2024-06-01T10:03:30Z")  # fmt: skip
    campaign = choose_campaign(request)
    [flight] = campaign.passes
    # There is less time before the first look and after the last than a slew may take.
    assert flight.start_utc == request.start
    assert flight.looks[-1].stop_utc < flight.stop_utc <= request.stop
    assert campaign.greedy_value < campaign.value <= campaign.bound
    assert campaign.value > 0.9 * campaign.bound  # a strip less than may be
    plan = make_plan(scenario_of(request, flight, 0))
    assert plan.verification.passed
    assert len(plan.scenario.sessions) == len(flight.looks)
    assert shifted_utc(plan.table.epoch_utc, float(plan.table.t_s[-1])) <= request.stop


def test_a_mode_that_no_pass_can_hold_is_told_so():
    wide = AREA | {"geometry": {"type": "Polygon", "coordinates": [
        [[-20.4, 43.0], [-20.6, 45.0], [-18.6, 45.1], [-18.4, 43.1], [-20.4, 43.0]]]}}  # fmt: skip
    slow = wide | {"speed_m_s": 3000.0}
    campaign = choose_campaign(read(targets=[{"id": "wide", "target": slow}]))
    [unseen] = campaign.unseen
    assert (unseen.target, unseen.closed_by) == ("wide", "duration")
    assert "scans and the settling between them" in unseen.because
    assert campaign.passes == ()


def test_modes_are_chosen_once_over_days_and_beside_places():
    """A strip that comes into view in several passes gets a look in the best one."""
    place = {"mode": "ground", "latitude_deg": 25.0, "longitude_deg": -13.0}
    request = read(
        targets=[
            {"id": "strip", "target": STRIP, "priority": 3.0},
            {"id": "stereo", "target": STEREO},
            {"id": "place", "target": place, "session_s": 5.0},
        ],
        stop="2024-06-03T09:58:00Z",
    )
    campaign = choose_campaign(request)
    looks = [one.target for flight in campaign.passes for one in flight.looks]
    assert sorted(looks) == ["place", "stereo", "stereo", "strip"]
    assert campaign.windows > 6
    assert 0.95 * campaign.bound <= campaign.value <= campaign.bound
    twice = choose_campaign(
        replace(request, targets=tuple(replace(one, looks=2) for one in request.targets))
    )
    again = [(one.target, n) for n, flight in enumerate(twice.passes) for one in flight.looks]
    assert [name for name, _ in again].count("stereo") == 4
    assert len({n for name, n in again if name == "stereo"}) == 2


def test_two_axes_scan_too():
    asked = json.loads((Path(__file__).parents[2] / "examples/campaign_cities.json").read_text())
    line = {"type": "LineString", "coordinates": [[-115.2, 36.1], [-115.15, 36.15]]}
    strip = {"mode": "strip", "geometry": line, "speed_m_s": 300.0}
    body = asked | {"targets": [{"id": "strip", "target": strip}]}
    request = CAMPAIGN_READER.read(json.dumps(body).encode())
    campaign = choose_campaign(request)
    [flight] = campaign.passes
    plan = make_plan(scenario_of(request, flight, 0))
    assert plan.verification.passed
    assert plan.scenario.sessions[0].start == flight.looks[0].start_utc
    assert elapsed_s(flight.looks[0].stop_utc, flight.looks[0].start_utc) > 20.0
    assert flight.looks[0].start_utc > datetime(2015, 2, 27, tzinfo=UTC)


@pytest.mark.parametrize(
    ("target", "words"),
    [
        ({"target": STRIP, "session_s": 10.0}, "session_s: must be left out for strip"),
        ({"target": STRIP, "group": "a"}, "group: must be left out for strip"),
        ({"target": AREA, "roll": {"rule": "nearest"}}, "must not be nearest for area"),
        ({"target": {"mode": "star", "name": "Vega"}}, "session_s: is required"),
    ],
)
def test_what_a_mode_has_not_is_refused(target, words):
    with pytest.raises(InvalidRequest, match=words):
        read(targets=[{"id": "it", **target}])
