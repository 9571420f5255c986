"""Every number of every request states its range, and what lies outside is refused by name.

The numbers are found in the JSON schemas, so that a new field is tested on arrival; worked
examples, and the fragments below for what none of them shows, are the documents they are set in.
"""

import contextlib
import copy
import json
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from agile_bodies import GYRO_SAT, SMALLSAT

from app.requests import examples
from app.requests.campaign import CAMPAIGN_READER, read_campaign_request
from app.requests.plan import PLAN_READER, read_plan_request
from app.requests.spacecraft import SPACECRAFT_READER, read_spacecraft_request
from app.work.flights import FLIGHTS_READER
from app.work.horizon import (
    ESTIMATE_READER,
    PICTURE_READER,
    PREDICTION_READER,
    SESSION_READER,
)
from app.work.searches import OPPORTUNITY_READER, read_opportunity_request
from planner.base.errors import InvalidInput, InvalidRequest

Document = dict[str, Any]
REFERENCE = "#/$defs/"
FAR = (1e300, -1e300, 1e9, -1e9, 5e-324, -5e-324, 0.0)
FAR_WHOLE = (10**60, -(10**60), 10**9, -(10**9), 0)  # numbers of over 80 digits aren't read


def _with(**changes: object) -> Document:
    return {**examples.LAS_VEGAS, **changes}


def _aimed(**target: object) -> Document:
    return _with(sessions=[{**examples.LAS_VEGAS["sessions"][0], "target": target}])


def _moved(**motion: object) -> Document:
    still = {"kind": "constant_rate", "rate_deg_s": 0.0}
    return _aimed(mode="test_motion", axes={"alpha": motion, "beta": still})


_CONES = [
    {"half_angle_deg": 5.0, "ra_deg": 10.0, "dec_deg": 80.0},
    {"half_angle_deg": 5.0, "direction_lvlh": [0.0, 0.0, -1.0]},
    {"half_angle_deg": 5.0, "direction_platform": [0.0, 0.0, -1.0]},
]
_AXIS = {"angle_min_deg": -175.0, "angle_max_deg": 175.0, "rate_max_deg_s": 3.0,
         "acceleration_max_deg_s2": 1.0, "jerk_max_deg_s3": 1.0, "drive": {}}  # fmt: skip
_PLACE = {"latitude_deg": 36.0, "longitude_deg": -115.0}


def _body_of(**changes: object) -> Document:
    """Las Vegas by a satellite that turns as a whole, written out."""
    plan = {
        key: value for key, value in examples.LAS_VEGAS.items() if key not in ("attitude", "slew")
    }
    start = {"epoch": examples.LAS_VEGAS["initial_state"]["epoch"]}
    return plan | {"initial_state": start, "platform": SMALLSAT | changes}


IMAGING_MODES = json.loads(
    (Path(__file__).parents[2] / "examples" / "imaging_modes.json").read_text()
)
_LINE = [[-12.390357, 20.486982], [-12.506716, 21.017679]]
_AHEAD = IMAGING_MODES["sessions"][1]["target"]["geometry"]["coordinates"]
_RING = [[-19.83, 44.05], [-19.95, 44.42], [-19.72, 44.45], [-19.60, 44.08], [-19.83, 44.05]]
_SCANNED = {"height_m": 0.0, "speed_m_s": 5500.0, "min_elevation_deg": 0.0}


def _imaged(number: int, kind: str, coordinates: object, **target: object) -> Document:
    """A session of the example of imaging modes, its target another one."""
    session = IMAGING_MODES["sessions"][number]
    geometry = {"type": kind, "coordinates": coordinates}
    asked = session | {"target": target | _SCANNED | {"geometry": geometry}}
    return IMAGING_MODES | {"sessions": [asked]}


_BATTERY = {"capacity_wh": 180.0, "start_wh": 160.0, "least_wh": 110.0, "idle_w": 38.0,
            "slew_w": 20.0, "imaging_w": 75.0}  # fmt: skip
_STATION = {"id": "svalbard", "height_m": 450.0, "min_elevation_deg": 5.0} | _PLACE
_RESOURCES = {
    "battery": _BATTERY | {"panels": [{"normal_body": [0.0, 0.0, -1.0], "power_w": 150.0}]},
    "memory": {"capacity_gbit": 512.0, "start_gbit": 40.0, "imaging_gbit_s": 1.6,
               "downlink_gbit_s": 0.4, "stations": [_STATION]},
}  # fmt: skip
_WHEELS = {"capacity_n_m_s": [0.9, 0.9, 0.9], "start_n_m_s": [0.1, -0.2, 0.0],
           "torque_body_n_m": [2e-6, 0.0, 1e-6], "unload_n_m": 2e-5}  # fmt: skip
FRAGMENTS = [
    _with(resources=_RESOURCES),
    _with(resources={"battery": _BATTERY | {"sunlight_w": 80.0}}),
    _with(conditions={}),
    _with(conditions={"duty_cycle": {"imaging_max_s": 600.0, "span_s": 5560.0}}),
    _with(conditions={"directions": [
        {"name": "radiator", "direction_body": [0.0, -1.0, 0.0], "away_from": "sun",
         "min_deg": 20.0},
        {"name": "tracker", "of": "camera", "near": "inertial", "max_deg": 179.0, "ra_deg": 10.0,
         "dec_deg": 20.0}]}),
    _body_of() | {"resources": {"momentum": _WHEELS}},
    _imaged(0, "LineString", _LINE, mode="strip"),
    _imaged(0, "MultiLineString", [_LINE], mode="corridor"),
    _imaged(1, "LineString", _AHEAD, mode="stereo", look_angle_deg=22.0, gap_s=60.0),
    _imaged(1, "LineString", _AHEAD, mode="tri_stereo", look_angle_deg=22.0, gap_s=30.0),
    _imaged(2, "MultiPolygon", [[_RING]], mode="area", azimuth_deg=0.0, overlap=0.1, swath_m=9e3),
    _body_of(),
    _body_of(
        agility={"limits": "axis", "rate_max_deg_s": [1.0, 1.0, 1.0], "settle_s": 0.0,
                 "acceleration_max_deg_s2": [0.05, 0.05, 0.05],
                 "jerk_max_deg_s3": [0.1, 0.1, 0.1]},
        roll={"rule": "azimuth", "azimuth_deg": 0.0},
        idle={"law": "nadir", "direction_body": [0.0, 0.0, 1.0], "forward_body": [1.0, 0.0, 0.0]},
        camera={"type": "frame", "boresight_body": [0.0, 0.0, 1.0], "side_body": [1.0, 0.0, 0.0],
                "field_of_view_deg": [1.0, 1.0]}),
    _body_of(
        roll={"rule": "sun_side", "direction_body": [1.0, 0.0, 0.0]},
        idle={"law": "sun", "direction_body": [0.0, 0.0, -1.0], "north_body": [1.0, 0.0, 0.0]}),
    _body_of() | {"platform": GYRO_SAT},
    _body_of(idle={"law": "inertial", "q_body_from_eci_xyzw": [0.0, 0.0, 0.0, 1.0]}),
    _body_of() | {"initial_state": {
        "epoch": examples.LAS_VEGAS["initial_state"]["epoch"],
        "q_body_from_eci_xyzw": [0.0, 0.0, 0.0, 1.0], "omega_body_deg_s": [0.0, 0.1, 0.0],
        "alpha_body_deg_s2": [0.0, 0.01, 0.0]}},
    _with(slew={"keep_out": _CONES, "avoid_modes": [{"frequency_hz": 0.2}]}),
    _with(initial_state=examples.LAS_VEGAS["initial_state"] | {
        "accelerations_deg_s2": {"alpha": 0.0, "beta": 0.0}}),
    _with(final_state={"angles_deg": {"alpha": 0.0, "beta": 0.0}}),
    _with(attitude={"law": "lvlh", "uncertainty": {
        "sigma_body_deg": [0.1, 0.1, 0.1], "swing_rms_body_deg": [0.2, 0.0, 0.0]},
        "corrections": [{
            "epoch": "2015-02-27T17:30:00Z", "turn_body_deg": [0.1, 0.0, 0.0],
            "covariance_deg2": [[1e-3, 0.0, 0.0], [0.0, 1e-3, 0.0], [0.0, 0.0, 1e-3]]}]}),
    _with(platform={
        "name": "written out",
        "outer": _AXIS | {"name": "alpha", "axis_platform": [0.0, 1.0, 0.0]},
        "inner": _AXIS | {"name": "beta", "axis_platform": [1.0, 0.0, 0.0]},
        "zero_direction_platform": [0.0, 0.0, 1.0],
        "q_platform_from_body_xyzw": [0.0, 0.0, 0.0, 1.0],
        "field_of_view_deg": [0.9, 0.6],
        "usual_yaw_pitch_roll_deg": [-4.0, -2.0, 1.0],
        "camera": {},
        "structural_modes": [{"axis_platform": [1.0, 0.0, 0.0], "frequency_hz": 0.3,
                              "inertia_kg_m2": 5e5}],
        "park_positions_deg": {"stowed": {"alpha": 0.0, "beta": 90.0}}}),
    _aimed(mode="ground_moving", epoch="2015-02-27T17:36:00Z", course_deg=0.0, speed_m_s=5.0,
           **_PLACE),
    _aimed(mode="place", name="Las Vegas, NV", min_elevation_deg=0.0),
    _aimed(mode="star", hip=91262),
    _aimed(mode="star", ra_deg=10.0, dec_deg=20.0),
    _moved(kind="constant_rate", rate_deg_s=0.1),
    _moved(kind="sine", amplitude_deg=1.0, frequency_hz=0.1),
    _moved(kind="chirp", amplitude_deg=0.1, start_frequency_hz=0.1, stop_frequency_hz=0.2,
           sweep_s=50.0),
    _moved(kind="step", step_deg=1.0, rise_s=10.0),
    _moved(kind="triangle", amplitude_deg=1.0, period_s=50.0, turn_s=5.0),
    _moved(kind="multisine", amplitudes_deg=[0.1], frequencies_hz=[0.1], phases_deg=[0.0]),
    _with(horizon_cameras=[
        examples.ESTIMATE_EXAMPLE["cameras"][0]
        | {"mask": [[[0.0, 0.0], [9.0, 0.0], [9.0, 9.0]]]}]),
]  # fmt: skip

_SPACECRAFT = next(iter(examples.SPACECRAFT_EXAMPLES.values()))[1] | {
    "initial_q_body_from_eci_xyzw": [0.0, 0.0, 0.0, 1.0],
    "settings": {"momentum_n_m_s": [0.0, 0.0, 0.0]},
}


@dataclass(frozen=True)
class Asked:
    """One kind of request."""

    name: str
    read: Callable[[bytes], object]
    schema: Document
    documents: tuple[Document, ...]


@dataclass(frozen=True)
class Number:
    """A number at a path of a document, and the range its schema states; of which field it is."""

    field: str
    path: tuple[str | int, ...]
    low: float
    high: float
    is_whole: bool


def _shown(examples: dict[str, tuple[str, Document]]) -> tuple[Document, ...]:
    return tuple(document for _, document in examples.values())


def _revised(start: str) -> Document:
    look = {"target": "Phoenix", "part": 1, "value": 0.5}
    times = ("pass_start", "start", "stop", "pass_stop")
    held = {"battery_wh": [1.0, 1.0], "memory_gbit": [1.0, 1.0]}
    held["momentum_n_m_s"] = [[0.0, 0.0, 0.0]] * 2
    return {
        "frozen_until": start,
        "looks": [look | dict.fromkeys(times, start) | {"pass_resources": held}],
    }


@cache
def _kinds() -> tuple[Asked, ...]:
    template = REFERENCE + "{model}"
    return (
        Asked("plan", read_plan_request, PLAN_READER.json_schema(template),
              (*_shown(examples.PLAN_EXAMPLES), *FRAGMENTS)),
        Asked("campaign", read_campaign_request, CAMPAIGN_READER.json_schema(template),
              tuple(d | {"rest_angles_deg": {"alpha": 0.0, "beta": 0.0}, "conditions": {},
                         "view": {}, "revises": _revised(d["start"])}
                    for d in _shown(examples.CAMPAIGN_EXAMPLES))),
        Asked("flights", FLIGHTS_READER.read, FLIGHTS_READER.json_schema(template),
              _shown(examples.FLIGHTS_EXAMPLES)),
        Asked("opportunities", read_opportunity_request,
              OPPORTUNITY_READER.json_schema(template), _shown(examples.OPPORTUNITY_EXAMPLES)),
        Asked("spacecraft", read_spacecraft_request, SPACECRAFT_READER.json_schema(template),
              (*_shown(examples.SPACECRAFT_EXAMPLES), _SPACECRAFT)),
        Asked("estimate", ESTIMATE_READER.read, ESTIMATE_READER.json_schema(template),
              (examples.ESTIMATE_EXAMPLE | {"body": {}},)),
        Asked("prediction", PREDICTION_READER.read, PREDICTION_READER.json_schema(template),
              tuple(d | {"body": {}} for d in _shown(examples.PREDICTION_EXAMPLES))),
        Asked("picture", PICTURE_READER.read, PICTURE_READER.json_schema(template),
              tuple(d | {"scene": {"atmosphere": {}}, "sensor": {}}
                    for d in _shown(examples.PICTURE_EXAMPLES))),
        Asked("series", SESSION_READER.read, SESSION_READER.json_schema(template),
              (examples.SESSION_EXAMPLE | {"body": {}},)),
    )  # fmt: skip


KINDS = [kind.name for kind in _kinds()]


@pytest.mark.parametrize("kind", _kinds(), ids=KINDS)
def test_every_number_states_its_range(kind: Asked):
    unbounded = [
        path
        for path, node in _nodes(kind.schema, "")
        if node.get("type") in ("number", "integer")
        and not {"minimum", "maximum"} <= node.keys()
        and "const" not in node
    ]
    assert unbounded == []


@pytest.mark.parametrize("kind", _kinds(), ids=KINDS)
def test_numbers_outside_are_refused_by_name_with_value_and_range(kind: Asked):
    seen = 0
    for document, number in _numbers(kind):
        seen += 1
        below, above = math.nextafter(number.low, -math.inf), math.nextafter(number.high, math.inf)
        if number.is_whole:
            below, above = int(number.low) - 1, int(number.high) + 1
        for value in (below, above, *(FAR_WHOLE if number.is_whole else FAR)):
            if number.low <= value <= number.high:
                continue
            with pytest.raises(InvalidRequest) as refusal:
                kind.read(_body(document, number.path, value))
            named = {error.field: error for error in refusal.value.errors}
            path = ".".join(map(str, number.path))
            assert path in named, (path, value, refusal.value.detail)
            assert "must lie in" in named[path].detail, named[path]
            assert named[path].value == value
    assert seen


@pytest.mark.parametrize("kind", _kinds(), ids=KINDS)
def test_numbers_at_the_ends_and_nearly_zero_are_read_or_refused(kind: Asked):
    for document, number in _numbers(kind):
        for value in (number.low, number.high, *FAR):
            if number.low <= value <= number.high:
                asked = int(value) if number.is_whole else value
                with contextlib.suppress(InvalidInput):  # where fields contradict one another
                    kind.read(_body(document, number.path, asked))


def test_examples_and_fragments_hold_every_number_there_is():
    held = {number.field for kind in _kinds() for _, number in _numbers(kind)}
    stated = {
        field
        for kind in _kinds()
        for field, node in _fields(kind.schema)
        if any("minimum" in inner for _, inner in _nodes(node, ""))
    }
    assert sorted(stated - held) == []


def _body(document: Document, path: tuple[str | int, ...], value: object) -> bytes:
    changed = copy.deepcopy(document)
    node: Any = changed
    for key in path[:-1]:
        node = node[key]
    node[path[-1]] = value
    return json.dumps(changed).encode()


@cache
def _numbers_of(name: str) -> tuple[tuple[int, Number], ...]:
    kind = next(kind for kind in _kinds() if kind.name == name)
    found: dict[str, tuple[int, Number]] = {}
    for at, document in enumerate(kind.documents):
        for number in _walk(kind.schema, kind.schema, document, (), ""):
            found.setdefault(number.field, (at, number))
    return tuple(found.values())


def _numbers(kind: Asked) -> Iterator[tuple[Document, Number]]:
    """Each number once, in the first document that has room for it."""
    for at, number in _numbers_of(kind.name):
        yield kind.documents[at], number


def _walk(
    schema: Document, node: Document, value: Any, path: tuple[str | int, ...], field: str
) -> Iterator[Number]:
    """Numbers below a value; of those left out, the ones a value can simply be set for."""
    if "$ref" in node:
        field = node["$ref"].removeprefix(REFERENCE)
        node = schema["$defs"][field]
    for choice in (*node.get("anyOf", ()), *node.get("oneOf", ())):
        if _fits(schema, choice, value):
            yield from _walk(schema, choice, value, path, field)
    if node.get("type") in ("number", "integer"):
        whole = node["type"] == "integer"
        yield Number(field, path, node["minimum"], node["maximum"], whole)
    for key, inner, inner_value in _below(node, value):
        named = f"{field}.{key}" if key in node.get("properties", {}) else field
        yield from _walk(schema, inner, inner_value, (*path, key), named)


def _below(node: Document, value: Any) -> Iterator[tuple[str | int, Document, Any]]:
    """Keys, schemas and values of what an object or list holds, or might as a number."""
    if isinstance(value, dict):
        for name, inner in node.get("properties", {}).items():
            if name in value or any("minimum" in n for n in (inner, *inner.get("anyOf", ()))):
                yield name, inner, value.get(name)
        if isinstance(more := node.get("additionalProperties"), dict):
            yield from ((name, more, inner_value) for name, inner_value in value.items())
    elif isinstance(value, list):
        every = [node["items"]] * len(value) if "items" in node else []
        items = node.get("prefixItems", every)
        yield from ((index, *pair) for index, pair in enumerate(zip(items, value, strict=False)))


def _fits(schema: Document, choice: Document, value: Any) -> bool:
    """Whether a union's choice is the one the value takes; a number where there is none."""
    if "$ref" in choice:
        choice = schema["$defs"][choice["$ref"].removeprefix(REFERENCE)]
    if "oneOf" in choice:
        return any(_fits(schema, one, value) for one in choice["oneOf"])
    if isinstance(value, dict):
        properties = choice.get("properties", {})
        tags = {k: p["const"] for k, p in properties.items() if "const" in p}
        # A kind that may be left out is listed, as the only one.
        assumed = {k: p["default"] for k, p in properties.items() if "default" in p}
        kinds = all(
            p["enum"] != [assumed.get(k)] or value.get(k, assumed[k]) == assumed[k]
            for k, p in properties.items()
            if "enum" in p
        )
        return choice.get("type") == "object" and tags.items() <= value.items() and kinds
    if isinstance(value, list):
        return choice.get("type") == "array"
    return choice.get("type") in ("number", "integer") and not isinstance(value, str)


def _nodes(node: Any, path: str) -> Iterator[tuple[str, Document]]:
    if isinstance(node, dict):
        yield path, node
    members = node.items() if isinstance(node, dict) else enumerate(node)
    for key, inner in members:
        if isinstance(inner, dict | list):
            yield from _nodes(inner, f"{path}.{key}")


def _fields(schema: Document) -> Iterator[tuple[str, Document]]:
    for name, inner in schema.get("properties", {}).items():
        yield f".{name}", inner
    for owner, definition in schema.get("$defs", {}).items():
        for name, inner in definition.get("properties", {}).items():
            yield f"{owner}.{name}", inner
