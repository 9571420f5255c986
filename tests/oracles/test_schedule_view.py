"""Looks lie where the view is best, and what is said of views, and of none, is Skyfield's."""

import math
from dataclasses import replace
from datetime import timedelta

import numpy as np
import pytest
from opportunity_requests import ISS, START, oco3_targets
from skyfield.api import wgs84

from planner.planning.campaigns import (
    CampaignRequest,
    CampaignTarget,
    ViewWeights,
    choose_campaign,
    scenario_of,
)
from planner.planning.opportunities import OpportunityConditions, OpportunityTarget
from planner.planning.sessions.pipeline import make_plan
from planner.world.frames.time_scales import Instants, elapsed_s
from planner.world.platforms import PLATFORMS, FieldMask
from planner.world.targets import StarTarget

# Under LVLH all that is 10 deg or more above the horizon lies within 69 deg of the nadir.
BELOW = FieldMask(
    name="lid",
    corners_platform=tuple(
        (math.cos(clock) * 6.0, math.sin(clock) * 6.0, 1.0) for clock in range(0, 6)
    ),
)
STEP_S = 2.0
LENGTH_S = 40.0


def request_for(listed, days=1.0, **fields):
    return CampaignRequest(
        **{
            "orbit": ISS,
            "platform": PLATFORMS["iss-hrc"],
            "targets": tuple(
                CampaignTarget(id=one.id, target=one.target, session_s=LENGTH_S) for one in listed
            ),
            "start": START,
            "stop": START + timedelta(days=days),
            "conditions": OpportunityConditions(min_elevation_deg=30.0),
            "step_s": STEP_S,
            **fields,
        }
    )


@pytest.fixture(scope="module")
def alone():
    """Campaigns of one target each: nothing competes."""
    requests = [request_for([one]) for one in oco3_targets(every=40)]
    return [(request, choose_campaign(request)) for request in requests]


def times_of(skyfield, t_s):
    """Whose nutation Skyfield sums up once, which takes four times as long as a target's look."""
    return skyfield[0].tt_jd(*Instants(START, np.asarray(t_s)).tt_jd())


def elevations_deg(skyfield, request, row, times):
    return (skyfield[2] - place_of(request, row)).at(times).altaz()[0].degrees


def place_of(request, row):
    target = request.targets[row].target
    return wgs84.latlon(target.latitude_deg, target.longitude_deg)


def sights(skyfield, request, row, t_s):
    """Elevation, deg, range and the carrier's height, m, and the Sun's elevation, deg."""
    _, ephemeris, satellite = skyfield
    times, place = times_of(skyfield, t_s), place_of(request, row)
    altitude, _, distance = (satellite - place).at(times).altaz()
    sun = (ephemeris["earth"] + place).at(times).observe(ephemeris["sun"]).apparent().altaz()[0]
    height_m = wgs84.height_of(satellite.at(times)).m
    return altitude.degrees, distance.m, height_m, sun.degrees


def test_a_look_that_nothing_competes_with_is_centred_on_the_highest_elevation(skyfield, alone):
    centred = 0
    for request, campaign in alone:
        for [look] in (flight.looks for flight in campaign.passes):
            begins_s = elapsed_s(look.start_utc, START)
            t_s = np.arange(begins_s - 400.0, begins_s + 400.0)
            elevation_deg = elevations_deg(skyfield, request, 0, times_of(skyfield, t_s))
            highest_s = t_s[np.argmax(elevation_deg)]
            # Half a step of the grid, half a second of the search, and as much again: elevation
            # is symmetric about its highest only on a straight course.
            assert begins_s + LENGTH_S / 2.0 == pytest.approx(highest_s, abs=2.5)
            centred += 1
    assert centred >= 10


def test_quality_is_that_of_skyfields_elevation_range_and_sun(skyfield):
    weights = ViewWeights(ground_sample=1.0, sun=0.5)
    request = request_for(oco3_targets(every=20), view=weights)
    campaign = choose_campaign(request)
    looks = [look for flight in campaign.passes for look in flight.looks]
    assert len(looks) > 15
    for look in looks:
        t_s = elapsed_s(look.start_utc, START) + np.arange(0.0, LENGTH_S + 1.0, STEP_S)
        elevation_deg, range_m, height_m, sun_deg = sights(skyfield, request, look.row, t_s)
        sharp = height_m * np.sin(np.radians(elevation_deg)) / range_m
        quality = sharp * np.sqrt(np.maximum(np.sin(np.radians(sun_deg)), 0.0))
        # Skyfield's elevation holds refraction-free geometry on WGS84 as ours: 1e-4 of it is
        # what 50 m of the straight-down distance make.
        assert look.quality == pytest.approx(
            np.trapezoid(quality, dx=1.0 / (len(t_s) - 1)), abs=3e-4
        )
        middle = len(t_s) // 2
        assert math.degrees(look.elevation_rad) == pytest.approx(elevation_deg[middle], abs=0.01)
        assert math.degrees(look.sun_elevation_rad) == pytest.approx(sun_deg[middle], abs=0.01)
        assert look.value == pytest.approx(look.quality)
    assert campaign.value == pytest.approx(sum(look.value for look in looks))


def test_weights_of_zero_leave_the_view_out():
    blind = ViewWeights(ground_sample=0.0)
    campaign = choose_campaign(request_for(oco3_targets(every=40), view=blind))
    looks = [look for flight in campaign.passes for look in flight.looks]
    assert {look.quality for look in looks} == {1.0}
    assert campaign.value == len(looks)


def test_probability_is_the_plans_at_an_instant():
    listed = oco3_targets(every=80)
    request = request_for(listed, view=ViewWeights(ground_sample=0.0, probability=1.0))
    flights = choose_campaign(request).passes
    assert len(flights) > 3
    for flight in flights:
        whole = scenario_of(request, flight, 0)
        away = timedelta(seconds=LENGTH_S / 2 - 1)
        *sessions, rest = whole.sessions
        short = [replace(one, start=one.start + away, stop=one.stop - away) for one in sessions]
        plan = make_plan(replace(whole, sessions=(*short, rest)))
        for look, budget in zip(flight.looks, plan.budgets, strict=False):
            # 1,024 points instead of 16,384 are good to 0.01, an instant for 2 s to 0.015.
            told = budget.probability_in_frame
            assert look.probability_in_frame == pytest.approx(told, abs=0.025)
            # A mean over the look, in whose 40 s an elevation changes by some degrees.
            assert look.quality == pytest.approx(look.probability_in_frame, abs=0.05)


def test_unseen_targets_say_what_closed_them(skyfield):
    listed = oco3_targets(every=30)
    low = replace(listed[0], id="too far north")
    low = replace(low, target=replace(low.target, latitude_deg=64.0, longitude_deg=10.0))
    conditions = OpportunityConditions(min_elevation_deg=30.0, sun_elevation_min_deg=40.0)
    request = request_for([*listed, low], conditions=conditions)
    campaign = choose_campaign(request)
    t_s = np.arange(0.0, 86400.0, 10.0)
    times = times_of(skyfield, t_s)
    causes = set()
    for one in campaign.unseen:
        elevation_deg = elevations_deg(skyfield, request, one.row, times)
        # In 10 s overhead the elevation changes by 10 deg, so far from its highest by less.
        assert elevation_deg.max() <= math.degrees(one.best_elevation_rad) + 0.01
        best_s = elapsed_s(one.best_time_utc, START)
        at_best_deg = sights(skyfield, request, one.row, [best_s])[0][0]
        assert math.degrees(one.best_elevation_rad) == pytest.approx(at_best_deg, abs=0.01)
        high = elevation_deg >= 30.0
        expected = "elevation" if not high.any() else "sun_elevation"
        assert one.closed_by == expected
        if high.any():
            sun_deg = sights(skyfield, request, one.row, t_s[high])[3]
            assert sun_deg.max() < 40.0 + 0.1
            assert "sun_elevation_min_deg 40" in one.because
        causes.add(one.closed_by)
    assert causes == {"elevation", "sun_elevation"}


@pytest.mark.parametrize(
    ("fields", "cause", "said"),
    [
        ({"conditions": {"max_off_nadir_deg": 0.5}}, "off_nadir", "max_off_nadir_deg 0.5"),
        ({"conditions": {"min_duration_s": 3000.0}}, "duration", "min_duration_s 3000"),
        ({"conditions": {"sun_keep_out_deg": 180.0}}, "sun_keep_out", "sun_keep_out_deg 180"),
        ({"conditions": {"moon_keep_out_deg": 180.0}}, "moon_keep_out", "moon_keep_out_deg 180"),
        ({"session_s": 900.0}, "duration", "less than the 900 s of a look"),
        ({"minutes": 1.0}, "rest", "leave their rest"),
        ({"masks": (BELOW,)}, "mask", "stands in the platform's view"),
    ],
)
def test_each_condition_that_closes_a_target_is_named(fields, cause, said):
    day = OpportunityConditions(min_elevation_deg=30.0, sun_elevation_min_deg=10.0)
    request = request_for(oco3_targets(every=100), conditions=day)
    look = choose_campaign(request).passes[0].looks[0]
    begins = look.start_utc
    conditions = OpportunityConditions(min_elevation_deg=10.0, **fields.get("conditions", {}))
    span = timedelta(minutes=fields.get("minutes", 120.0)) / 2
    session_s = fields.get("session_s", LENGTH_S)
    request = replace(
        request,
        targets=(replace(request.targets[look.row], session_s=session_s),),
        conditions=conditions,
        platform=replace(request.platform, masks=fields.get("masks", ())),
        start=begins - span,
        stop=begins + span,
    )
    [one] = choose_campaign(request).unseen
    assert one.closed_by == cause
    assert said in one.because
    assert one.best_elevation_rad > math.radians(30.0)


def test_a_star_that_stays_too_low_above_the_limb_says_so():
    """Over the limb of the Earth a star climbs as high as the orbit's plane lets it."""
    conditions = OpportunityConditions(min_elevation_deg=85.0)
    polaris = OpportunityTarget(id="Polaris", target=StarTarget(name="Polaris"))
    request = request_for([polaris], conditions=conditions)
    [one] = choose_campaign(request).unseen
    assert one.closed_by == "elevation"
    assert one.because == "it stays below 85 deg above the limb"
    # The orbit reaches 51.6 deg of latitude, and from 400 km the limb lies 18 deg below level.
    assert 60.0 < math.degrees(one.best_elevation_rad) < 75.0


def test_who_is_left_out_is_displaced_by_looks_worth_as_much():
    listed = oco3_targets(every=2)
    conditions = OpportunityConditions(min_elevation_deg=30.0, sun_elevation_min_deg=10.0)
    request = request_for(listed, conditions=conditions)
    campaign = choose_campaign(request)
    looked_at = {look.target for flight in campaign.passes for look in flight.looks}
    assert {one.target for one in campaign.left_out}.isdisjoint(looked_at)
    displaced = [one for one in campaign.left_out if one.displaced_by]
    assert displaced
    for one in displaced:
        assert set(one.displaced_by) <= looked_at
        assert one.displaced_value >= one.value - 1e-9
    # Without those in its way, and nothing else to do, it is looked at as said.
    one = displaced[0]
    by_itself = choose_campaign(replace(request, targets=(request.targets[one.row],)))
    [look] = [look for flight in by_itself.passes for look in flight.looks]
    assert look.value >= one.value - 1e-9
