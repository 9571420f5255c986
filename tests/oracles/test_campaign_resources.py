"""Campaigns with battery and memory: all subsets of looks tried, plans made of what was chosen.

The levels of every subset are the planner's own integration over the whole campaign, which knows no
rows, prices or repairs.
"""

import itertools
import json
import zlib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console
from test_schedule_brute_force import EUROPE, WEST, request_for

from app.cli.campaign import print_campaign
from app.requests.campaign import read_campaign_request
from app.requests.plan import read_plan_request
from app.work.campaign import choose, plan_pass
from app.work.result import Result
from planner.base.errors import ResourceRunsOut
from planner.planning.campaigns import campaign as campaigns
from planner.planning.campaigns import choose_campaign, scenario_of
from planner.planning.campaigns.charging import Charging
from planner.planning.campaigns.path import best_path
from planner.planning.resources import Along, Uses, resource_curves
from planner.planning.sessions.pipeline import make_plan
from planner.verification import verify
from planner.world.clouds import Clouds
from planner.world.frames.time_scales import elapsed_s
from planner.world.platforms.choice import BODIES
from planner.world.resources import Battery, Memory, Momentum, Panel, Resources, Station

EXAMPLES = Path(__file__).parents[2] / "examples"
MIXED = WEST[:2] + EUROPE[:3]
MATERA = Station(id="matera", latitude_deg=40.65, longitude_deg=16.7)
WALLOPS = Station(id="wallops", latitude_deg=37.94, longitude_deg=-75.46)
FULL = Memory(capacity_gbit=100.0, imaging_gbit_s=1.0)
SENT = replace(FULL, capacity_gbit=60.0, downlink_gbit_s=0.04, stations=(MATERA, WALLOPS))
POOR = Battery(
    capacity_wh=110.0, least_wh=70.0, idle_w=50.0, slew_w=20.0, imaging_w=1500.0, sunlight_w=76.0,
)  # fmt: skip
CLOUDS = Clouds(
    format="ascii_grid",
    content="ncols 2\nnrows 1\nxllcorner -180\nyllcorner -90\ncellsize 180\n0.8 0.1\n",
)
SMALLSAT = {"platform": BODIES["smallsat-120kg"], "rest_angles_deg": None}


def chosen(monkeypatch, request):
    """A campaign, and what it was chosen from."""
    kept, found = {}, campaigns.choose_keeping

    def keeping(*given):
        kept["keeping"], kept["networks"], kept["looking"], *_ = given
        kept["choice"], rows = found(*given)
        return kept["choice"], rows

    monkeypatch.setattr(campaigns, "choose_keeping", keeping)
    return choose_campaign(request), kept


def least_room(keeping, passes):
    """The least room left of each resource, by the planner's own integration."""
    around = Charging(keeping._request, keeping._looks.viewing.ephemeris)
    spans = [[keeping.ends_s(look) for look in looks] for looks in passes if looks]
    moves = [keeping._looks.pass_span_s(one[0][0], one[-1][1]) for one in spans]
    rests = [0.0, *(end for span in moves for end in span), around.last_s]
    battery = around.resources.battery
    uses = Uses(
        sessions=tuple(span for one in spans for span in one),
        targets=tuple(keeping._candidates[look.target].target for one in passes for look in one),
        idle=tuple(zip(rests[::2], rests[1::2], strict=True)),
    )
    t_s = np.unique(np.concatenate([np.arange(0.0, around.last_s, 60.0), rests]))
    charge_w = np.full(len(t_s), (battery.sunlight_w or 0.0) if battery else 0.0)
    along = Along(charge_w, *(np.zeros(0) for _ in range(3)))
    return [curve.room.min() / curve.capacity for curve in around.curves(t_s, along, uses)]


def subsets(number, network, looking):
    """Of every set of targets with a length each, the path of a pass that is worth most."""
    targets = np.unique(network.target).tolist()
    lengths = looking.length_steps.shape[1]
    yield 0.0, ()
    for choice in itertools.product(range(-1, lengths), repeat=len(targets)):
        wanted = {t: k for t, k in zip(targets, choice, strict=True) if k >= 0}
        worth = looking.less_prices(np.full(len(looking.look_limit), np.inf))
        worth = looking.settled(worth, number)
        steps, price = np.zeros_like(worth.steps), worth.price.copy()
        for target, length in wanted.items():
            steps[target, length] = worth.steps[target, length]
            price[target] = -1000.0
        if not wanted or not all(steps[t, k] for t, k in wanted.items()):
            continue
        path = best_path(network, worth._replace(steps=steps, price=price))
        if len(path.looks) == len(wanted):
            yield sum(look.value for look in path.looks), path.looks


def best_of_all(kept):
    """No choice of one subset for each pass, each target once, is worth more and keeps."""
    keeping, networks, looking = kept["keeping"], kept["networks"], kept["looking"]
    options = [
        sorted(subsets(number, one, looking), key=lambda option: -option[0])
        for number, one in enumerate(networks)
    ]
    most = np.append(np.cumsum([one[0][0] for one in options[::-1]])[::-1], 0.0)
    best = [0.0]

    def go_on(number, value, passes, taken):
        if value + most[number] <= best[0] + 1e-9:
            return
        if number == len(options):
            if min(least_room(keeping, passes)) >= -1e-9:
                best[0] = value
            return
        for worth, looks in options[number]:
            seen = {look.target for look in looks}
            if value + worth + most[number + 1] <= best[0] + 1e-9:
                return
            if not seen & taken:
                go_on(number + 1, value + worth, [*passes, looks], taken | seen)

    go_on(0, 0.0, [], frozenset())
    return best[0]


@pytest.mark.parametrize(
    ("resources", "fields"),
    [
        (Resources(memory=FULL), {}),
        (Resources(battery=POOR, memory=SENT), {"clouds": CLOUDS}),
        (Resources(memory=SENT), SMALLSAT),
        (Resources(battery=replace(POOR, sunlight_w=82.0, imaging_w=2500.0)), SMALLSAT),
    ],
)
def test_no_subset_that_keeps_is_worth_more_than_the_bound(monkeypatch, resources, fields):
    request = request_for(MIXED, 1.0, **fields)
    free = choose_campaign(request)
    campaign, kept = chosen(monkeypatch, replace(request, resources=resources))
    passes = kept["choice"].passes
    assert min(least_room(kept["keeping"], passes)) >= -1e-9
    best = best_of_all(kept)
    assert campaign.bound >= best - 1e-9
    assert 0.97 * best <= campaign.value <= campaign.bound
    assert campaign.value < free.value - 0.01  # else nothing was kept from
    assert campaign.bound <= free.bound + 1e-9
    for one in campaign.left_out:
        assert (one.lacks is None) == ("pass its limit" not in one.because)


@pytest.mark.parametrize(("fields", "power_w"), [({}, 400.0), (SMALLSAT, 180.0)])
def test_passes_are_planned_with_what_those_before_leave(monkeypatch, fields, power_w):
    """With panels, whose charge on a body's slews is that of the motion of least jerk: to 0.2 % of
    the capacity.  A plan may wait where the campaign takes two axes to move: it keeps more."""
    panels = (Panel(normal_body=(0.0, 0.0, -1.0), power_w=power_w),)
    battery = replace(POOR, least_wh=60.0, imaging_w=400.0, sunlight_w=None, panels=panels)
    resources = Resources(battery=battery, memory=SENT)
    request = request_for(MIXED, 1.0, resources=resources, **fields)
    campaign, kept = chosen(monkeypatch, request)
    passes = kept["choice"].passes
    for number, flight in enumerate(campaign.passes):
        scenario = scenario_of(request, flight, number)
        plan = make_plan(scenario)
        assert verify(plan.table, plan.scenario, plan.waits).passed
        assert scenario.resources == flight.resources
        end_s = elapsed_s(plan.table.epoch_utc, request.start) + float(plan.table.t_s[-1])
        told = kept["keeping"].levels(passes, np.array([end_s]))
        for curve in resource_curves(plan):
            left = float(curve.level[-1] - told[curve.name][0])
            assert abs(left) <= (2e-3 if curve.name == "battery" else 1e-9) * curve.capacity
    assert len(campaign.passes) > 1


def test_requests_of_passes_say_what_they_begin_with_and_the_report_what_a_target_lacks():
    """The example: two cities are left out for its memory."""
    body = (EXAMPLES / "campaign_resources.json").read_bytes()
    made = choose(body)
    choice = json.loads(zlib.decompress(made.content[0]))
    lacks = {one["target"]: one["lacks"] for one in choice["left_out"]}
    assert lacks == {"Los Angeles": "memory", "Boston": "memory"}
    [part] = made.parts
    planned, result = plan_pass(part)
    assert planned is part
    assert isinstance(result, Result), result
    memory = read_plan_request(part.request).resources.memory
    assert memory.start_gbit < read_campaign_request(body).resources.memory.start_gbit
    console = Console(record=True, width=200)
    print_campaign(console, choice, [])
    assert "left out for memory: Boston, a look from" in console.export_text()


def test_what_a_campaign_cannot_keep_is_refused():
    request = request_for(MIXED, 1.0)
    wheels = Momentum(capacity_n_m_s=(1.0, 1.0, 1.0))
    with pytest.raises(ValueError, match=r"resources\.momentum must be left out of a campaign"):
        replace(request, resources=Resources(momentum=wheels))
    dying = replace(request, resources=Resources(battery=replace(POOR, sunlight_w=10.0)))
    with pytest.raises(ResourceRunsOut, match="without any look; begin with more") as refused:
        choose_campaign(dying)
    assert refused.value.field == "resources.battery"
