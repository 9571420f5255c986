"""Battery and memory: the judge's own integration, a third one, and ways out of what runs out."""

import copy
import json
import re
from importlib.resources import files
from pathlib import Path

import numpy as np
import pytest
from planner_values import plan_of
from random_resources import IDLES, PLATFORM, asked, beneath, plans, refusals, utc
from skyfield.api import load, load_file, wgs84

from app.requests.examples import LAS_VEGAS
from planner.base.errors import InfeasibleSlew, ResourceRunsOut
from planner.planning.resources import resource_curves, spans_above
from planner.planning.sessions.pipeline import make_plan
from planner.planning.sessions.summary import summarise
from planner.verification import verify
from planner.verification.platforms.registry import judge_of
from planner.verification.resources import resource_levels
from planner.world.frames.time_scales import Instants, elapsed_s, utc_text

TIME_SCALE = load.timescale(builtin=True)
EPHEMERIS = load_file(str(files("skyfield_data") / "data" / "de421.bsp"))
OF_CAPACITY = 1e-6
EXAMPLES = Path(__file__).parents[2] / "examples"
WGS84_M = np.array([6378137.0, 6378137.0, 6356752.3142])


@pytest.fixture(scope="module")
def planned():
    """Some image, some send to a station, some move axes and do neither; all of it happens."""
    made = [plan for _, plan in plans(seed=7, count=10, looks_down=True)]
    modes = {one.target.mode for plan in made for one in plan.scenario.sessions}
    assert modes == {"ground", "star", "station", "test_motion"}
    return made


def test_the_judge_finds_the_same_levels_by_itself(planned):
    for plan in planned:
        judge = judge_of(plan.table, plan.scenario)
        judged = resource_levels(plan.table, plan.scenario, judge, plan.waits)
        for curve, (name, *_, t_s, level, _) in zip(resource_curves(plan), judged, strict=True):
            ours, theirs = (
                np.interp(plan.table.t_s, *one) for one in ((curve.t_s, curve.level), (t_s, level))
            )
            assert curve.name == name
            np.testing.assert_allclose(ours, theirs, rtol=0.0, atol=OF_CAPACITY * curve.capacity)


def test_a_third_integration_finds_the_same_levels_within_a_second_of_each_edge(planned):
    for plan in planned:
        for curve, (level, step) in zip(
            resource_curves(plan), levels_by_seconds(plan), strict=True
        ):
            ours = np.interp(np.arange(len(level)), curve.t_s, curve.level)
            edges = 40  # of light, contacts, sessions and waits within three hours, at most
            np.testing.assert_allclose(level, ours, rtol=0.0, atol=edges * step)


def test_another_start_is_told_where_waits_leave_enough():
    """A session with no time before it, after 22 minutes that axes wait and don't slew."""
    request = copy.deepcopy(LAS_VEGAS)
    request["initial_state"]["epoch"] = "2015-02-27T17:10:00Z"
    salt_lake_city = {"mode": "ground", "latitude_deg": 40.76, "longitude_deg": -111.9}
    begins = {"start": request["sessions"][0]["stop"], "stop": "2015-02-27T17:38:20Z"}
    request["sessions"].append(begins | {"target": salt_lake_city})
    battery = {"capacity_wh": 100.0, "least_wh": 50.0, "idle_w": 1.0, "slew_w": 300.0}
    told = []
    for resources in ({}, {"resources": {"battery": battery | {"start_wh": 100.0}}}):
        with pytest.raises(InfeasibleSlew) as refused:
            plan_of(request | resources)
        told.append(refused.value.earliest_feasible_start_utc)
    assert told[0] is not None
    assert told[1] == told[0]


def test_contacts_that_a_body_turns_to_send_what_it_imaged():
    """At 69 deg off nadir, which no look may be; each Gbit and Wh is told by hand."""
    document = json.loads((EXAMPLES / "smallsat_contacts.json").read_text())
    plan = make_plan(asked(document))
    looks, *contacts = (one.elevation_max_rad for one in plan.verification.sessions)
    assert min(contacts) < np.deg2rad(10.0) < np.deg2rad(80.0) < looks
    battery, memory = resource_curves(plan)
    stops_s = [elapsed_s(one.stop, plan.table.epoch_utc) for one in plan.scenario.sessions]
    imaged, first, second = 40.0 * 1.6, 200.0 * 0.4, 260.0 * 0.4
    held = 120.0 + np.cumsum([imaged, -first, -second])
    np.testing.assert_allclose(np.interp(stops_s, memory.t_s, memory.level), held, atol=1e-9)
    document["resources"]["battery"]["downlink_w"] = 0.0
    without, _ = resource_curves(make_plan(asked(document)))
    sent_wh = 60.0 * (200.0 + 260.0) / 3600.0
    assert without.level[-1] - battery.level[-1] == pytest.approx(sent_wh, abs=1e-9)
    summary = summarise(plan)
    assert [one.ground_sample_m is None for one in summary.sessions] == [False, True, True]
    look = summary.sessions[0].probability_in_frame
    assert [one.probability_in_frame for one in summary.sessions] == [look, None, None]
    assert summary.probability_in_frame == look


def levels_by_seconds(plan):
    """Of each resource, summed from second to second; and the most that one second adds."""
    table, resources = plan.table, plan.scenario.resources
    count = (len(table.t_s) - 1) // 5 + 1
    t_s = np.arange(count, dtype=float)
    instants = Instants(table.epoch_utc, t_s)
    times = TIME_SCALE.from_datetimes([instants.utc(second) for second in range(count)])
    states = plan.scenario.orbit.ephemeris(instants.utc(0), instants.utc(-1)).states(instants)
    r_m = states.r_sat_eci_m
    to_sun_m = (EPHEMERIS["sun"] - EPHEMERIS["earth"]).at(times).position.m.T - r_m
    # In axes turned with the pole only, in which the Earth is an ellipsoid of revolution.
    polar = np.moveaxis(times.M, -1, 0)
    here, sun = (np.einsum("nij,nj->ni", polar, one) / WGS84_M for one in (r_m, to_sun_m))
    nearest = np.clip(-np.sum(here * sun, axis=1) / np.sum(sun * sun, axis=1), 0.0, None)
    lit = np.linalg.norm(here + nearest[:, None] * sun, axis=1) > 1.0
    sessions = plan.scenario.sessions
    imaging, sending, waiting = (
        np.any(
            [
                (t_s >= elapsed_s(a, table.epoch_utc)) & (t_s < elapsed_s(b, table.epoch_utc))
                for a, b in spans
            ]
            or [t_s < 0],
            axis=0,
        )
        for spans in (
            [(one.start, one.stop) for one in sessions if one.target.mode in ("ground", "star")],
            [(one.start, one.stop) for one in sessions if one.target.mode == "station"],
            plan.waits,
        )
    )
    battery, memory = resources.battery, resources.memory
    charge_w = np.full(count, battery.sunlight_w or 0.0)
    q_body = plan.scenario.q_body_from_eci(instants, states, table.position[::5])
    sun_body = q_body.apply(to_sun_m / np.linalg.norm(to_sun_m, axis=1, keepdims=True))
    for panel in battery.panels:
        normal = np.asarray(panel.normal_body) / np.linalg.norm(panel.normal_body)
        charge_w += panel.power_w * np.maximum(sun_body @ normal, 0.0)
    drawn_w = battery.idle_w + battery.imaging_w * imaging + battery.slew_w * ~(imaging | waiting)
    heard = np.zeros(count, dtype=bool)
    for station in memory.stations:
        place, above = (
            wgs84.latlon(station.latitude_deg, station.longitude_deg, height_m)
            .at(times)
            .position.m.T
            for height_m in (station.height_m, station.height_m + 1000.0)
        )
        up, away = (above - place) / 1000.0, r_m - place
        sine = np.sum(up * away, axis=1) / np.linalg.norm(away, axis=1)
        heard |= np.degrees(np.arcsin(sine)) >= station.min_elevation_deg
    drawn_w += battery.downlink_w * (heard | sending)
    steps_wh = (charge_w * lit - drawn_w) / 3600.0
    most_wh = (charge_w.max() + drawn_w.max()) / 3600.0
    yield summed(battery.begins_wh, steps_wh, -np.inf, battery.capacity_wh), most_wh
    sent = np.maximum(memory.downlink_gbit_s * heard, memory.pointed_gbit_s * sending)
    steps_gbit = memory.imaging_gbit_s * imaging - sent
    most_gbit = memory.imaging_gbit_s + sent.max()
    yield summed(memory.start_gbit, steps_gbit, 0.0, np.inf), most_gbit
    if resources.momentum is not None:
        yield from momenta_by_seconds(plan, q_body, r_m, waiting)


def momenta_by_seconds(plan, q_body, r_m, waiting):
    """Of the wheels about x, y and z, by Euler's equations in the body's axes."""
    momentum = plan.scenario.resources.momentum
    inertia_kg_m2 = np.array(plan.scenario.platform.inertia_kg_m2)
    spin = plan.table.rate_rad_s[::5] @ inertia_kg_m2
    turn = (q_body[1:] * q_body[:-1].inv()).as_matrix()
    up = q_body.apply(r_m)
    torque_n_m = np.cross(up, up @ inertia_kg_m2) * 3.0 * 3.986004418e14
    torque_n_m = torque_n_m / np.linalg.norm(up, axis=1)[:, None] ** 5 + momentum.torque_body_n_m
    level = np.array([momentum.start_n_m_s])
    for k in range(len(spin) - 1):
        free = turn[k] @ (level[-1] + spin[k] + torque_n_m[k]) - spin[k + 1]
        most = momentum.unload_n_m * waiting[k]
        level = np.vstack([level, np.sign(free) * np.maximum(np.abs(free) - most, 0.0)])
    yield from ((one, momentum.unload_n_m + np.abs(torque_n_m).max()) for one in level.T)


def summed(level, steps, least, most):
    levels = [level]
    for step in steps[:-1].tolist():
        levels.append(min(max(levels[-1] + step, least), most))
    return np.array(levels)


def test_what_a_refusal_offers_is_planned_as_told():
    for request, refusal in refusals(seed=3, count=3):
        assert refusal.limit in ("battery", "memory")
        assert refusal.earliest_feasible_start_utc is not None, refusal.detail
        number = int(refusal.field.split(".")[1])
        instead = copy.deepcopy(request)
        instead["sessions"][number] |= {
            "start": utc_text(refusal.earliest_feasible_start_utc, 6),
            "stop": utc_text(refusal.feasible_stop_utc, 6),
        }
        kept = enumerate(instead["sessions"])
        instead["sessions"] = [one for n, one in kept if n not in refusal.costs_sessions]
        assert make_plan(asked(instead)).verification.passed


def test_where_no_session_will_do_it_is_told_what_to_begin_with():
    """By an initial charge that idling uses up, and wheels that begin too full for any slew."""
    star = {"target": {"mode": "star", "ra_deg": 120.0, "dec_deg": 60.0}}
    request = {
        "platform": PLATFORM | {"idle": IDLES[2]},
        "orbit": LAS_VEGAS["orbit"],
        "initial_state": {"epoch": utc(0.0)},
        "sessions": [star | {"start": utc(600.0), "stop": utc(620.0)}],
    }
    battery = {"capacity_wh": 100.0, "start_wh": 51.0, "least_wh": 50.0, "idle_w": 30.0}
    held = {"capacity_n_m_s": [2.0, 2.0, 2.0], "start_n_m_s": [0.0, 0.3, 0.1]}
    wheels = make_plan(asked(request | {"resources": {"momentum": held}}))
    y = resource_curves(wheels)[1]
    tight = held | {"capacity_n_m_s": [2.0, float(np.abs(y.level).max()) - 1e-3, 2.0]}
    for resources, because in (
        ({"battery": battery}, "would without any session"),
        ({"momentum": tight}, "neither a later start by .* nor a shorter session was found"),
    ):
        with pytest.raises(ResourceRunsOut, match=because) as refused:
            make_plan(asked(request | {"resources": resources}))
        [name, member, value] = re.search(
            r"begin with resources\.(\w+)\.(\w+) (\[.*\]|[\d.]+)", refused.value.detail
        ).groups()
        begins = copy.deepcopy(resources)
        begins[name][member] = json.loads(value)
        plan = make_plan(asked(request | {"resources": begins}))
        assert plan.verification.passed
        least = min(one.margin / one.limit for one in plan.verification.resources)
        assert 0.0 <= least < 1e-2  # the nearest that will do


def test_a_full_memory_is_told_a_downlink_before_that_is_planned():
    request = json.loads((EXAMPLES / "smallsat_contacts.json").read_text())
    request["sessions"] = request["sessions"][:1]
    del request["conditions"]
    memory = request["resources"]["memory"] | {"capacity_gbit": 170.0}
    request["resources"]["memory"] = memory
    with pytest.raises(ResourceRunsOut) as refused:
        make_plan(asked(request))
    assert "downlink" not in refused.value.detail  # without a station there is none
    place = beneath(19_680.0, "station")  # nine minutes before the session
    del place["mode"]
    memory["stations"] = [{"id": "pacific", "height_m": 20.0} | place]
    with pytest.raises(ResourceRunsOut, match="with a downlink before") as refused:
        make_plan(asked(request))
    numbers = re.search(
        r"latitude_deg (\S+), longitude_deg (\S+), height_m (\S+), min_elevation_deg (\S+)\) "
        r"from (\S+) to (\S+),",
        refused.value.detail,
    ).groups()
    names = ("latitude_deg", "longitude_deg", "height_m", "min_elevation_deg")
    target = {"mode": "station"} | dict(zip(names, map(float, numbers[:4]), strict=True))
    downlink = {"target": target, "start": numbers[4], "stop": numbers[5]}
    request["sessions"].insert(0, downlink)
    plan = make_plan(asked(request))
    [kept] = [one for one in plan.verification.resources if one.name == "memory"]
    assert plan.verification.passed
    assert kept.margin >= 0.0


def test_wheels_that_slews_fill_are_told_gentler_slews():
    wheels = {"capacity_n_m_s": [2.0, 2.0, 2.0]}
    request = {
        "platform": PLATFORM | {"idle": IDLES[2]},
        "orbit": LAS_VEGAS["orbit"],
        "initial_state": {"epoch": utc(0.0)},
        "slew": {"lead": {"max_duration_s": 100.0}},
        "sessions": [
            {
                "target": {"mode": "star", "ra_deg": 120.0, "dec_deg": 60.0},
                "start": utc(600.0),
                "stop": utc(620.0),
            }
        ],
        "resources": {"momentum": wheels},
    }
    held = [float(np.abs(one.level).max()) for one in resource_curves(make_plan(asked(request)))]
    wheels["capacity_n_m_s"] = [max(0.7 * most, 0.01) for most in held]
    with pytest.raises(ResourceRunsOut, match=r"slew\.lead\.max_duration_s 200") as refused:
        make_plan(asked(request))
    assert refused.value.limit == "momentum"
    request["slew"]["lead"]["max_duration_s"] = 200.0
    margins = make_plan(asked(request)).verification.resources
    assert min(one.margin for one in margins) >= 0.0


def test_the_judge_rejects_what_runs_out_and_waits_that_are_none(planned):
    plan = next(one for one in planned if one.waits)
    slews = tuple((one.start_utc, one.stop_utc) for one in plan.segments if one.kind == "slew")
    judged = verify(plan.table, plan.scenario, slews)
    assert [one.limit for one in judged.findings if one.severity == "error"] == ["battery"] * len(
        slews
    )
    assert "doesn't wait" in judged.findings[0].detail
    battery = plan.scenario.resources.battery
    object.__setattr__(battery, "least_wh", battery.capacity_wh)
    (finding,) = verify(plan.table, plan.scenario, plan.waits).findings
    assert (finding.limit, finding.severity) == ("battery", "error")


def test_spans_begin_and_end_where_the_function_is_zero():
    def bumps(t_s):  # one wide, one that only just comes up between two samples, one just not
        return np.maximum.reduce([
            1.0 - ((t_s - 100.0) / 33.3) ** 2,
            1e-3 - ((t_s - 305.0) / 20.0) ** 2,
            -1e-3 - ((t_s - 505.0) / 20.0) ** 2,
        ])  # fmt: skip

    found = list(spans_above(bumps, 1000.0))
    half_s = 20.0 * np.sqrt(1e-3)
    expected = [(66.7, 133.3), (305.0 - half_s, 305.0 + half_s)]
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-6)
