"""Solutions of the fleet benchmark pass its rules, judged by frames and code of their own.

The rules are those of aeossp_standard's README.  Satellites are python-sgp4's, turned by
Greenwich mean sidereal time (IAU 1982); the Sun is the Astronomical Almanac's low-precision one.
Both stand within 20 m and 0.01 deg of the benchmark's.
"""

import itertools
import math
import sys
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
import pytest
import yaml
from sgp4.api import Satrec, jday

sys.path.insert(0, str(Path(__file__).parents[2] / "bench"))
from aeossp import actions_of, read_case, solve

CASE = Path(__file__).parents[1] / "data" / "aeossp_small"
# The frames' difference over the shortest range, and the rows' by it.
ANGLE_DEG = 0.003
EARTH_M, FLATTENING = 6_378_137.0, 1 / 298.257223563


@pytest.fixture(scope="module")
def solved():
    case = read_case(CASE)
    return case, solve(case, lambda text: None)


def test_a_solution_keeps_every_rule_and_its_bound(solved):
    case, found = solved
    actions = actions_of(case, found.passes, found.chosen)
    assert judge(actions, files()) == []
    weight = dict(zip(case.tasks.ids, case.tasks.weight, strict=True))
    value = sum(weight[one["task_id"]] for one in actions)
    assert len({one["task_id"] for one in actions}) == len(actions)
    assert found.greedy_value < value <= found.bound + 1e-6
    # Nothing is worth a grain, half a unit, more: this case is solved to the optimum.
    assert found.bound - value < 0.5


def test_each_rule_is_tried(solved):
    """A look shifted, swapped or made longer is found."""
    case, found = solved
    actions = actions_of(case, found.passes, found.chosen)
    by_satellite = [one for one in actions if one["satellite_id"] == actions[0]["satellite_id"]]
    hour = {
        **actions[0],
        **{end: _later(actions[0][end], 3600) for end in ("start_time", "end_time")},
    }
    assert any("window" in fault or "view" in fault for fault in judge([hour], files()))
    again = [by_satellite[0], {**by_satellite[1], **_times(by_satellite[0])}]
    assert any("slew" in fault for fault in judge(again, files()))
    empty = files()
    for satellite in empty["satellites"]:
        satellite["resource_model"]["initial_battery_wh"] = 0.5
    assert any("battery" in fault for fault in judge(actions, empty))


def test_batteries_are_spared_where_they_would_run_empty(tmp_path):
    told = files()
    for satellite in told["satellites"]:
        power = satellite["resource_model"]
        power["initial_battery_wh"] = 0.05 * power["battery_capacity_wh"]
        power["sunlit_charge_power_w"] = 1.1 * power["idle_power_w"]
    for name in ("mission", "satellites", "tasks"):
        (tmp_path / f"{name}.yaml").write_text(yaml.safe_dump({name: told[name]}))
    case = read_case(tmp_path)
    found = solve(case, lambda text: None)
    before = actions_of(case, found.passes, found.unspared)
    assert any("battery" in fault for fault in judge(before, told))
    actions = actions_of(case, found.passes, found.chosen)
    assert 0 < len(actions) < len(before)
    assert judge(actions, told) == []


def files():
    return {
        name: yaml.safe_load((CASE / f"{name}.yaml").read_text())[name]
        for name in ("mission", "satellites", "tasks")
    }


def judge(actions, told):
    """Every rule that is broken, in words."""
    mission = told["mission"]
    start, step_s = _utc(mission["horizon_start"]), mission["action_time_step_s"]
    end_s = (_utc(mission["horizon_end"]) - start).total_seconds()
    tasks = {one["task_id"]: one for one in told["tasks"]}
    faults = []
    for satellite in told["satellites"]:
        own = [one for one in actions if one["satellite_id"] == satellite["satellite_id"]]
        own.sort(key=lambda one: one["start_time"])
        orbit = Satrec.twoline2rv(satellite["tle_line1"], satellite["tle_line2"])
        attitude, power = satellite["attitude_model"], satellite["resource_model"]
        loads, ended_s, held = [], 0.0, None
        for one in own:
            task = tasks[one["task_id"]]
            begin_s, stop_s = (
                (_utc(one[end]) - start).total_seconds() for end in ("start_time", "end_time")
            )
            is_within = _utc(task["release_time"]) <= _utc(one["start_time"]) and _utc(
                one["end_time"]
            ) <= _utc(task["due_time"])
            if not is_within or stop_s - begin_s != task["required_duration_s"]:
                faults.append(f"window of {one}")
            if task["required_sensor_type"] != satellite["sensor"]["sensor_type"]:
                faults.append(f"sensor of {one}")
            for at_s in np.arange(begin_s, stop_s + 1.0, step_s):
                r_m, los_m, up = _geometry(orbit, start, at_s, task)
                off_nadir_deg = _angle_deg(-r_m, los_m)
                if off_nadir_deg > attitude["max_off_nadir_deg"] + ANGLE_DEG or los_m @ up >= 0.0:
                    faults.append(f"view of {one} at {at_s}: {off_nadir_deg}")
            r_m, los_m, _ = _geometry(orbit, start, begin_s, task)
            angle_deg = _angle_deg(-r_m if held is None else held, los_m)
            needs_s = _slew_s(angle_deg, attitude) + attitude["settling_time_s"]
            # By a hundredth of a second the frames' difference could change it.
            if begin_s - ended_s < needs_s - 0.01:
                faults.append(f"slew to {one}: {begin_s - ended_s} of {needs_s}")
            loads += [
                (begin_s - needs_s, begin_s, power["slew_power_w"]),
                (begin_s, stop_s, power["imaging_power_w"]),
            ]
            ended_s, held = stop_s, _geometry(orbit, start, stop_s, task)[1]
        edges_s = {*np.arange(0.0, end_s + 1.0, mission["resource_sample_step_s"]).tolist()}
        edges_s = np.array(sorted(edges_s.union(*[(a, b) for a, b, _ in loads])))
        level_wh = power["initial_battery_wh"]
        for a_s, b_s in itertools.pairwise(edges_s):
            middle_s = 0.5 * (a_s + b_s)
            gain_w = power["sunlit_charge_power_w"] * _is_lit(orbit, start, middle_s)
            gain_w -= power["idle_power_w"]
            gain_w -= sum(power_w for x_s, y_s, power_w in loads if x_s <= middle_s < y_s)
            level_wh = min(power["battery_capacity_wh"], level_wh + gain_w * (b_s - a_s) / 3600.0)
            if level_wh < 0.0:
                faults.append(f"battery of {satellite['satellite_id']} at {b_s}")
                break
    return faults


def _geometry(orbit, start, at_s, task):
    """Satellite, line of sight and the target's up, in the mean equator and equinox of date."""
    r_m, gmst_rad = _orbit(orbit, start, at_s)
    latitude, longitude = math.radians(task["latitude_deg"]), math.radians(task["longitude_deg"])
    squared = FLATTENING * (2.0 - FLATTENING)
    normal_m = EARTH_M / math.sqrt(1.0 - squared * math.sin(latitude) ** 2)
    angle = longitude + gmst_rad
    across_m = (normal_m + task["altitude_m"]) * math.cos(latitude)
    height_m = (normal_m * (1.0 - squared) + task["altitude_m"]) * math.sin(latitude)
    target_m = np.array([across_m * math.cos(angle), across_m * math.sin(angle), height_m])
    return r_m, target_m - r_m, target_m


def _orbit(orbit, start, at_s):
    moment = start + timedelta(seconds=float(at_s))
    day, part = jday(
        moment.year,
        moment.month,
        moment.day,
        moment.hour,
        moment.minute,
        moment.second + moment.microsecond * 1e-6,
    )
    error, r_km, _ = orbit.sgp4(day, part)
    assert error == 0
    centuries = (day - 2451545.0 + part) / 36525.0
    gmst_s = 67310.54841 + (876600 * 3600 + 8640184.812866) * centuries
    gmst_s += 0.093104 * centuries**2 - 6.2e-6 * centuries**3
    return np.array(r_km) * 1e3, math.radians(gmst_s / 240.0 % 360.0)


def _is_lit(orbit, start, at_s):
    r_m, _ = _orbit(orbit, start, at_s)
    days = (start - datetime(2000, 1, 1, 12, tzinfo=UTC)).total_seconds() / 86400.0 + at_s / 86400.0
    mean = math.radians(357.528 + 0.9856003 * days)
    longitude = math.radians(280.460 + 0.9856474 * days)
    longitude += math.radians(1.915) * math.sin(mean) + math.radians(0.020) * math.sin(2.0 * mean)
    tilt = math.radians(23.439 - 4e-7 * days)
    sun = np.array(
        [
            math.cos(longitude),
            math.cos(tilt) * math.sin(longitude),
            math.sin(tilt) * math.sin(longitude),
        ]
    )
    along_m = r_m @ sun
    return along_m >= 0.0 or np.linalg.norm(r_m - along_m * sun) >= EARTH_M


def _slew_s(angle_deg, attitude):
    """By hand: a triangle of rates, or a trapezium."""
    rate, acceleration = (
        attitude["max_slew_velocity_deg_per_s"],
        attitude["max_slew_acceleration_deg_per_s2"],
    )
    peak = min(rate, math.sqrt(angle_deg * acceleration))
    return angle_deg / peak + peak / acceleration if peak > 0.0 else 0.0


def _angle_deg(first, second):
    return math.degrees(
        math.atan2(np.linalg.norm(np.cross(first, second)), float(np.dot(first, second)))
    )


def _utc(text):
    return datetime.fromisoformat(text)


def _later(text, by_s):
    return (_utc(text) + timedelta(seconds=by_s)).strftime("%Y-%m-%dT%H:%M:%SZ")


def _times(action):
    return {end: action[end] for end in ("start_time", "end_time")}
