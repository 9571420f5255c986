"""Random requests with battery and memory, for both kinds of platform; bodies have wheels, too."""

import json

import numpy as np
import pytest
from skyfield.api import EarthSatellite, load, wgs84

from app.requests.examples import LAS_VEGAS
from app.requests.plan import read_plan_request
from planner.base.errors import Refusal, ResourceRunsOut
from planner.planning.resources import resource_curves
from planner.planning.sessions.pipeline import make_plan
from planner.world.frames.time_scales import elapsed_s

TIME_SCALE = load.timescale(builtin=True)
CARRIER = EarthSatellite(LAS_VEGAS["orbit"]["line1"], LAS_VEGAS["orbit"]["line2"], ts=TIME_SCALE)
EPOCH = np.datetime64("2015-02-27T12:00:00", "ms")
NORMALS = ([0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.2, 0.0])
IDLES = (
    {"law": "sun", "direction_body": [0.0, 0.0, -1.0]},
    {"law": "nadir", "direction_body": [0.0, 0.0, 1.0], "forward_body": [1.0, 0.0, 0.0]},
    {"law": "inertial", "q_body_from_eci_xyzw": [0.5, 0.5, 0.5, 0.5]},
)
PLATFORM = {
    "kind": "body",
    "name": "smallsat",
    "agility": {"limits": "magnitude", "rate_max_deg_s": 1.5, "acceleration_max_deg_s2": 0.12,
                "jerk_max_deg_s3": 0.06, "settle_s": 4.0},
    "camera": {"type": "frame", "boresight_body": [0.0, 0.0, 1.0], "side_body": [1.0, 0.0, 0.0],
               "field_of_view_deg": [1.0, 1.0]},
    "inertia_kg_m2": [[11.0, 0.1, 0.0], [0.1, 13.0, 0.0], [0.0, 0.0, 9.0]],
}  # fmt: skip


def utc(seconds):
    return f"{EPOCH + np.timedelta64(round(float(seconds) * 1000), 'ms')}Z"


def beneath(seconds, mode):
    """A place on the ground some 450 km beside where the carrier is then."""
    place = wgs84.subpoint(CARRIER.at(TIME_SCALE.utc(2015, 2, 27, 12, 0, seconds)))
    latitude_deg, longitude_deg = place.latitude.degrees, place.longitude.degrees
    return {"mode": mode, "latitude_deg": latitude_deg - 4.0 * np.sign(latitude_deg),
            "longitude_deg": longitude_deg}  # fmt: skip


def random_request(rng, *, looks_down=False):
    """One or two sessions within an orbit or two.  looks_down: some at the ground and stations."""
    is_body = bool(rng.integers(2))
    start_s = float(rng.uniform(300.0, 5000.0))
    sessions = []
    for _ in range(int(rng.integers(1, 3))):
        stop_s = start_s + float(rng.uniform(40.0, 300.0))
        target = {"mode": "star", "ra_deg": float(rng.uniform(0.0, 360.0)),
                  "dec_deg": float(rng.uniform(-80.0, 80.0))}  # fmt: skip
        if not is_body:
            rates = rng.uniform(-0.02, 0.02, 2).tolist()
            axes = {
                a: {"kind": "constant_rate", "rate_deg_s": r}
                for a, r in zip(("alpha", "beta"), rates, strict=True)
            }
            target = {"mode": "test_motion", "axes": axes}
        if looks_down and rng.integers(3):
            mode = "station" if is_body or rng.integers(2) else "ground"
            target = beneath(0.5 * (start_s + stop_s), mode)
        sessions.append({"target": target, "start": utc(start_s), "stop": utc(stop_s)})
        start_s = stop_s + float(rng.uniform(300.0, 1500.0))
    capacity_wh, imaging_w = float(rng.uniform(50.0, 300.0)), float(rng.uniform(100.0, 400.0))
    battery = {"capacity_wh": capacity_wh, "start_wh": float(rng.uniform(0.6, 1.0)) * capacity_wh,
               "idle_w": float(rng.uniform(5.0, 30.0)), "slew_w": float(rng.uniform(0.0, 60.0)),
               "imaging_w": imaging_w}  # fmt: skip
    if rng.integers(4):
        battery["panels"] = [
            {"normal_body": n, "power_w": float(rng.uniform(20.0, 120.0))}
            for n in NORMALS[: rng.integers(1, 4)]
        ]
    else:
        battery["sunlight_w"] = float(rng.uniform(20.0, 120.0))
    stations = [
        {
            "id": f"station {number}",
            "latitude_deg": float(rng.uniform(-60.0, 60.0)),
            "longitude_deg": float(rng.uniform(-180.0, 180.0)),
        }
        for number in range(rng.integers(1, 5))
    ]
    memory = {
        "capacity_gbit": 500.0,
        "start_gbit": float(rng.uniform(0.0, 100.0)),
        "imaging_gbit_s": float(rng.uniform(0.2, 0.6)),
        "downlink_gbit_s": 0.5,
        "stations": stations,
    }
    if looks_down:
        battery["downlink_w"] = float(rng.uniform(20.0, 100.0))
        memory["pointed_gbit_s"] = float(rng.uniform(0.3, 0.8))  # of stations' 0.5
    request = {
        "platform": PLATFORM | {"idle": IDLES[rng.integers(3)]} if is_body else "iss-hrc",
        "orbit": LAS_VEGAS["orbit"],
        "initial_state": {"epoch": utc(0.0)},
        "sessions": sessions,
        "resources": {"battery": battery, "memory": memory},
    }
    if rng.integers(2):
        request["final_state"] = "idle" if is_body else "rest"
    if not is_body:
        request["attitude"] = LAS_VEGAS["attitude"]
        request["initial_state"]["angles_deg"] = {"alpha": 0.0, "beta": 0.0}
        return request
    request["resources"]["momentum"] = {
        "capacity_n_m_s": [2.0, 2.0, 2.0],
        "start_n_m_s": rng.uniform(-0.3, 0.3, 3).tolist(),
        "torque_body_n_m": rng.uniform(-2e-5, 2e-5, 3).tolist(),
        "unload_n_m": float(rng.choice([0.0, 2e-5, 1e-3])),
    }
    return request


def asked(request):
    return read_plan_request(json.dumps(request).encode())


def plans(seed, count, of=None, *, looks_down=False):
    """So many requests that are planned, with their plans.  of: a kind of platform."""
    rng = np.random.default_rng(seed)
    while count:
        request = random_request(rng, looks_down=looks_down)
        if of == "body" and "attitude" in request:
            continue
        try:
            made = make_plan(asked(request))
        except Refusal:  # a star behind the Earth, too little time, or nothing left
            continue
        count -= 1
        yield request, made


def refusals(seed, count, of=("battery", "memory")):
    """Requests that run out of what one session uses, and their refusals.

    The limit lies between the levels before that session and at its worst.
    """
    rng = np.random.default_rng(seed)
    for request, plan in plans(seed, 10 * count):
        curves = [one for one in resource_curves(plan) if one.resource in of]
        if not curves:
            continue
        curve = curves[int(rng.integers(len(curves)))]
        start_s = elapsed_s(plan.scenario.sessions[-1].start, plan.table.epoch_utc)
        worst = float(curve.room.min())
        before = float(curve.room[curve.t_s <= start_s].min())
        if before - worst < 1e-3 * curve.capacity:
            continue
        level = float(rng.uniform(0.1, 0.6)) * (before - worst) + worst
        resources = request["resources"]
        if curve.name == "battery":
            resources["battery"]["least_wh"] = level
        elif curve.name == "memory":
            resources["memory"]["capacity_gbit"] -= level
        else:
            resources["momentum"]["capacity_n_m_s"]["xyz".index(curve.name[-1])] -= level
        with pytest.raises(ResourceRunsOut) as refused:
            make_plan(asked(request))
        yield request, refused.value
        count -= 1
        if not count:
            return
