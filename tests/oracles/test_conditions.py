"""Conditions of light and view in windows and plans against Skyfield's Sun, Moon and places."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from opportunity_requests import START, iss_request, oco3_targets
from planner_values import read_request
from skyfield.api import wgs84
from skyfield.framelib import itrs

from app.requests.examples import LAS_VEGAS
from app.work.searches import read_opportunity_request
from planner.base.errors import InvalidRequest, NotVisible
from planner.planning.opportunities import OpportunityConditions, find_opportunities
from planner.planning.sessions.pipeline import make_plan
from planner.verification import verify
from planner.world.conditions import Conditions
from planner.world.frames.time_scales import Instants, shifted_utc, utc_text

EXAMPLES = Path(__file__).parents[2] / "examples"
EDGE_S = 1e-3  # promised
SEMI_AXES_KM = np.array([6378.137, 6378.137, 6356.752314245])
PIXEL_RAD = 1.15 / 350e3  # of the ISS's camera: Sumarokov 2016
ALL = {
    "min_elevation_deg": 20.0,
    "max_off_nadir_deg": 62.0,
    "max_ground_sample_m": 6.0,
    "sun_elevation_min_deg": 5.0,
    "sun_elevation_max_deg": 80.0,
    "glint_keep_out_deg": 15.0,
    "sun_keep_out_deg": 20.0,
    "moon_keep_out_deg": 5.0,
    "carrier_light": "sunlit",
}


class Sky:
    """What Skyfield has of one place and the ISS, by name of the condition, at seconds since."""

    def __init__(self, skyfield, target, epoch_utc, pixel_rad=PIXEL_RAD):
        self.timescale, self.kernel, self.satellite = skyfield
        self.epoch_utc, self.pixel_rad = epoch_utc, pixel_rad
        self.site = wgs84.latlon(
            target.latitude_deg, target.longitude_deg, elevation_m=target.height_m or 0.0
        )

    def value(self, name, t_s):
        t = self.timescale.tt_jd(*Instants(self.epoch_utc, np.asarray(t_s)).tt_jd())
        elevation, azimuth, distance = (self.satellite - self.site).at(t).altaz()
        on_ground = self.kernel["earth"] + self.site
        sun_up, sun_azimuth, _ = on_ground.at(t).observe(self.kernel["sun"]).apparent().altaz()
        if name == "elevation":
            return elevation.degrees
        if name == "ground_sample":
            return distance.m * self.pixel_rad / np.sin(elevation.radians)
        if name == "sun_elevation":
            return sun_up.degrees
        if name == "glint":  # MODIS' glint angle, Ackerman et al. 2010, from Cox and Munk 1954
            cosine = np.sin(sun_up.radians) * np.sin(elevation.radians) - np.cos(
                sun_up.radians
            ) * np.cos(elevation.radians) * np.cos(sun_azimuth.radians - azimuth.radians)
            return np.rad2deg(np.arccos(cosine))
        los_km = (self.site - self.satellite).at(t).position.km
        if name == "off_nadir":
            return between_deg(los_km, -self.satellite.at(t).position.km)
        carrier = (self.kernel["earth"] + self.satellite).at(t)
        if name in ("sun_keep_out", "moon_keep_out"):
            body = carrier.observe(self.kernel[name.removesuffix("_keep_out")]).apparent()
            return between_deg(los_km, body.position.km)
        sun_km = carrier.observe(self.kernel["sun"]).apparent().frame_xyz(itrs).km
        return above_the_limb(self.satellite.at(t).frame_xyz(itrs).km, sun_km)


def above_the_limb(r_km, sun_km):
    """Of the ray to the Sun, in radii of the ellipsoid squeezed into a sphere."""
    r, ray = r_km / SEMI_AXES_KM[:, None], sun_km / SEMI_AXES_KM[:, None]
    ray = ray / np.linalg.norm(ray, axis=0)
    ahead = np.maximum(-np.sum(r * ray, axis=0), 0.0)
    return np.linalg.norm(r + ahead * ray, axis=0) - 1.0


def between_deg(one, other):
    across = np.linalg.norm(np.cross(one, other, axis=0), axis=0)
    return np.rad2deg(np.arctan2(across, np.sum(one * other, axis=0)))


@pytest.mark.parametrize(
    ("name", "conditions", "limit", "off_s"),
    [
        ("ground_sample", {"max_ground_sample_m": 3.0}, 3.0, EDGE_S),
        ("glint", {"glint_keep_out_deg": 60.0}, 60.0, EDGE_S),
        # one milliarcsecond (frames) at 15 arcsec/s or less
        ("sun_elevation", {"sun_elevation_min_deg": 20.0}, 20.0, EDGE_S),
        # 5.3 arcsec of the carrier's aberration, left out here, at some 0.3 deg/s
        ("sun_keep_out", {"sun_keep_out_deg": 70.0}, 70.0, 10 * EDGE_S),
        ("moon_keep_out", {"moon_keep_out_deg": 70.0}, 70.0, 10 * EDGE_S),
        # the Sun leaves the limb at 0.065 deg/s, seen 5 arcsec off by a carrier at 7.7 km/s
        ("carrier_light", {"carrier_light": "sunlit"}, 0.0, 0.03),
        ("carrier_light", {"carrier_light": "eclipsed"}, 0.0, 0.03),
    ],
)
def test_edges_of_windows_lie_where_skyfield_has_them(skyfield, name, conditions, limit, off_s):
    request = iss_request(
        4.0,
        targets=oco3_targets(every=10),
        conditions=OpportunityConditions(min_elevation_deg=10.0, **conditions),
    )
    windows = find_opportunities(request).windows
    compared = 0
    for number, wanted in enumerate(request.targets):
        sky, mine = Sky(skyfield, wanted.target, START), windows.target == number
        edges_s = np.concatenate(
            [
                windows.rise_s[mine & (windows.opened_by == name)],
                windows.set_s[mine & (windows.closed_by == name)],
            ]
        )
        if name.endswith("keep_out") and len(edges_s):  # others are where the body rises or sets
            edges_s = edges_s[np.abs(sky.value(name, edges_s) - limit) < 0.01]
        if not len(edges_s):
            continue
        rate = (sky.value(name, edges_s + 0.05) - sky.value(name, edges_s - 0.05)) / 0.1
        assert np.abs((sky.value(name, edges_s) - limit) / rate).max() < off_s
        compared += len(edges_s)
    assert compared > 5


def smallsat(**conditions):
    request = json.loads((EXAMPLES / "smallsat_resources.json").read_text())
    del request["resources"]
    return request | {"conditions": conditions}


@pytest.mark.parametrize("base", [LAS_VEGAS, smallsat()], ids=["two axes", "body"])
def test_margins_of_a_plan_are_skyfields(skyfield, base):
    plan = make_plan(read_request(base | {"conditions": ALL}))
    names = [bound.name for bound in plan.scenario.conditions.bounds]
    assert len(names) == len(ALL)
    for told, session in zip(plan.verification.sessions, plan.scenario.sessions, strict=True):
        assert [one.name for one in told.conditions] == list(ALL)
        pixel_rad = plan.scenario.platform.camera.pixel_rad
        sky = Sky(skyfield, session.target, plan.table.epoch_utc, pixel_rad)
        for name, one in zip(names, told.conditions, strict=True):
            assert one.margin >= 0.0
            seen = sky.value(name, np.array([one.t_s, one.t_s + 0.05]))[0]
            if name == "carrier_light":
                assert (seen > 0.0) == (one.extreme > 0.0)
            elif one.unit == "m":
                assert one.extreme == pytest.approx(seen, rel=1e-5)
            else:  # 5 arcsec of the carrier's aberration
                assert one.extreme == pytest.approx(seen, abs=2e-3)


def test_the_judge_finds_each_condition_that_is_not_met():
    plan = make_plan(read_request(LAS_VEGAS | {"conditions": ALL}))
    [told] = plan.verification.sessions
    for bound, margin in zip(plan.scenario.conditions.bounds, told.conditions, strict=True):
        tighter = {"carrier_light": "eclipsed"}
        if bound.name != "carrier_light":
            past = 1e-3 if bound.is_least else -1e-3
            tighter = {bound.field: margin.extreme + past}
        if bound.name == "moon_keep_out":
            continue  # the Earth hides it: no angle is too small
        scenario = replace(plan.scenario, conditions=Conditions(**tighter))
        report = verify(plan.table, scenario)
        assert [finding.limit for finding in report.findings if finding.severity == "error"] == [
            bound.name
        ]


@pytest.mark.parametrize(
    ("limit", "conditions"),
    [
        (
            "direction",
            {"directions": [{"name": "x", "of": "camera", "near": "nadir", "max_deg": 45.0}]},
        ),
        ("off_nadir", {"max_off_nadir_deg": 45.0}),
        ("ground_sample", {"max_ground_sample_m": 2.5}),
        ("glint", {"glint_keep_out_deg": 60.0}),
        ("elevation", {"min_elevation_deg": 45.0}),
        ("sun_elevation", {"sun_elevation_min_deg": 36.0}),
    ],
)
def test_a_refusal_names_the_condition_and_a_start_that_is_planned(limit, conditions):
    request = LAS_VEGAS | {"conditions": conditions}
    with pytest.raises(NotVisible) as refused:
        make_plan(read_request(request))
    refusal = refused.value
    assert refusal.limit == limit
    assert next(iter(conditions)) in refusal.detail
    assert refusal.at_utc is not None
    assert refusal.earliest_feasible_start_utc is not None, refusal.detail
    moved = request["sessions"][0] | {
        "start": utc_text(refusal.earliest_feasible_start_utc),
        "stop": utc_text(refusal.feasible_stop_utc),
    }
    plan = make_plan(read_request(request | {"sessions": [moved]}))
    assert plan.verification.passed
    assert plan.verification.sessions[0].conditions[0].margin >= 0.0


def test_conditions_that_make_no_sense_are_refused_by_field():
    for conditions, told in (
        ({"sun_elevation_min_deg": 10.0, "sun_elevation_max_deg": 5.0}, "sun_elevation_min_deg"),
        ({"carrier_light": "dusk"}, "carrier_light"),
        ({"min_duration_s": 10.0}, "min_duration_s"),
        ({"directions": [{"name": "x", "near": "sun", "max_deg": 45.0}]}, "direction_body"),
        ({"directions": [CAMERA | {"name": "x", "near": "sun"}]}, "max_deg"),
        (
            {"directions": [CAMERA | {"name": "x", "near": "inertial", "max_deg": 45.0}]},
            "ra_deg must be given",
        ),
        (directions(*([CAMERA | AROUND[0]] * 17))["conditions"], "at most 16"),
        ({"directions": [CAMERA | AROUND[0] | {"name": "x"}] * 2}, "directions.1.name"),
    ):
        with pytest.raises(InvalidRequest, match=told):
            read_request(LAS_VEGAS | {"conditions": conditions})


def directions(*kept):
    return {"conditions": {"directions": [{"name": f"d{n}"} | one for n, one in enumerate(kept)]}}


CAMERA = {"of": "camera"}
AROUND = (
    {"away_from": "sun", "min_deg": 1.0},
    {"near": "sun", "max_deg": 179.0},
    {"away_from": "nadir", "min_deg": 1.0},
    {"near": "nadir", "max_deg": 179.0},
    {"away_from": "inertial", "ra_deg": 250.0, "dec_deg": 20.0, "min_deg": 1.0},
    {"near": "inertial", "ra_deg": 70.0, "dec_deg": -20.0, "max_deg": 179.0},
    {"near": "limb", "max_deg": 1.0},
)


@pytest.mark.parametrize("base", [LAS_VEGAS, smallsat()], ids=["two axes", "body"])
def test_angles_of_the_boresight_are_skyfields(skyfield, base):
    plan = make_plan(read_request(base | directions(*(CAMERA | one for one in AROUND))))
    [told, session] = plan.verification.sessions[0], plan.scenario.sessions[0]
    sky = Sky(skyfield, session.target, plan.table.epoch_utc)
    for wanted, one in zip(AROUND, told.conditions, strict=True):
        about = wanted.get("near", wanted.get("away_from"))
        t = sky.timescale.tt_jd(*Instants(sky.epoch_utc, np.array([one.t_s, one.t_s])).tt_jd())
        r_km = sky.satellite.at(t).position.km
        los_km = (sky.site - sky.satellite).at(t).position.km
        edge_deg = 0.0
        if about == "sun":
            seen = (sky.kernel["earth"] + sky.satellite).at(t)
            seen = seen.observe(sky.kernel["sun"]).apparent()
            centre, edge_deg = (
                seen.position.km,
                np.rad2deg(np.arcsin(695_700.0 / seen.distance().km[0])),
            )
            edge_deg = edge_deg if "near" in wanted else -edge_deg
        elif about == "inertial":
            ra, dec = np.radians([wanted["ra_deg"], wanted["dec_deg"]])
            centre = np.array([np.cos(dec) * np.cos(ra), np.cos(dec) * np.sin(ra), np.sin(dec)])
            centre = np.stack([centre, centre], axis=1)
        else:
            centre = -r_km
        seen_deg = between_deg(los_km, centre)[0] + edge_deg
        if about == "limb":  # of a sphere, which the ellipsoid is within 0.3 deg of
            seen_deg -= np.rad2deg(np.arcsin(6378.137 / np.linalg.norm(r_km[:, 0])))
        assert one.extreme == pytest.approx(seen_deg, abs=0.5 if about == "limb" else 5e-3)
        assert one.margin >= 0.0
    assert plan.verification.passed


@pytest.mark.parametrize("name", ["gallery", "smallsat"])
@pytest.mark.parametrize(
    "kept",
    [
        CAMERA | {"away_from": "nadir", "min_deg": 30.0},
        CAMERA | {"near": "inertial", "ra_deg": 100.0, "dec_deg": 20.0, "max_deg": 100.0},
        {"direction_body": [0.3, 0.5, -0.8], "near": "sun", "max_deg": 70.0},
    ],
    ids=["nadir", "stars", "sun"],
)
def test_windows_keep_directions_and_their_sessions_are_planned(name, kept):
    request = json.loads((EXAMPLES / f"opportunities_{name}.json").read_text())
    plain = find_opportunities(read_opportunity_request(json.dumps(request).encode())).windows
    request["conditions"] = request.get("conditions", {}) | directions(kept)["conditions"]
    read = read_opportunity_request(json.dumps(request).encode())
    found = find_opportunities(read)
    windows = found.windows
    lasts_s = float((windows.set_s - windows.rise_s).sum())
    assert 0.0 < lasts_s < float((plain.set_s - plain.rise_s).sum())
    [name] = [f"directions.{one['name']}" for one in request["conditions"]["directions"]]
    assert name in {*windows.opened_by.tolist(), *windows.closed_by.tolist()}
    spans_s = windows.sessions_s(found.start_utc)
    held = np.flatnonzero(np.diff(spans_s, axis=1)[:, 0] > 10.0)[:2]
    for row in held.tolist():
        begins_s, ends_s = spans_s[row]
        number = int(windows.target[row])
        wanted = request["targets"][number]
        plan = {key: request[key] for key in ("platform", "orbit", "attitude") if key in request}
        plan |= {
            "initial_state": {"epoch": utc_text(shifted_utc(found.start_utc, begins_s - 1200.0))},
            "sessions": [
                {
                    "target": wanted["target"],
                    "start": utc_text(shifted_utc(found.start_utc, begins_s), 6),
                    "stop": utc_text(shifted_utc(found.start_utc, ends_s), 6),
                }
            ],
            "conditions": directions(kept)["conditions"],
        }
        if name == "gallery":
            plan["initial_state"]["angles_deg"] = {"alpha": 0.0, "beta": 0.0}
        made = make_plan(read_request(plan))
        assert made.verification.passed
        [margin] = made.verification.sessions[0].conditions
        assert margin.margin >= 0.0
