"""A body is read as its operator wrote it down, and refused by field, value and way out."""

import copy
import json

import numpy as np
import pytest
from agile_bodies import GYRO_SAT, SMALLSAT, smallsat
from pydantic import TypeAdapter

from app.requests.json_reader import JsonReader
from planner.base.errors import InvalidRequest
from planner.world.platforms.body import BodyPlatform


def test_a_body_is_written_out_as_it_was_read():
    written = TypeAdapter(BodyPlatform).dump_python(smallsat(), mode="json")
    again = JsonReader(BodyPlatform).read(json.dumps(written).encode())
    assert again == smallsat()
    assert written["agility"] == SMALLSAT["agility"]


def test_limits_may_be_given_by_axis():
    by_axis = {
        "limits": "axis",
        "rate_max_deg_s": [1.5, 1.0, 0.5],
        "acceleration_max_deg_s2": [0.1, 0.1, 0.2],
        "jerk_max_deg_s3": [0.1, 0.1, 0.2],
    }
    assert smallsat(agility=by_axis, torque_max_n_m=None).agility.by_order_rad[0] == pytest.approx(
        [0.0261799, 0.0174533, 0.0087266], abs=5e-8
    )


def changed(path, value, satellite=SMALLSAT):
    """The satellite with one member, at a dotted path, replaced."""
    document = copy.deepcopy(satellite)
    *parents, last = [int(part) if part.isdecimal() else part for part in path.split(".")]
    node = document
    for key in parents:
        node = node[key]
    node[last] = value
    return document


@pytest.mark.parametrize(
    ("path", "value", "field", "says"),
    [
        ("agility.limits", "vector", "agility.limits", "must be one of magnitude, axis"),
        ("agility.limits", "axis", "agility.rate_max_deg_s", "must be a list"),
        ("roll.rule", "sideways", "roll.rule", "must be one of lines_across_motion"),
        ("roll", {"rule": "sun_side"}, "roll.direction_body", "is required"),
        ("roll", {"rule": "sun_side", "direction_body": [0.0, 0.0, -2.0]}, "roll.direction_body",
         "1 deg or more off the line of camera.boresight_body, not 0 deg"),
        ("idle.law", "tumble", "idle.law", "must be one of nadir, sun, inertial"),
        ("idle.direction_body", [0.0, 0.0, 0.0], "idle.direction_body", "at least 0.001 long"),
        ("idle", {"law": "inertial", "q_body_from_eci_xyzw": [0.0, 0.0, 0.0, 2.0]},
         "idle.q_body_from_eci_xyzw", "unit length, not 2"),
        ("idle", {"law": "nadir", "forward_body": [0.0, 0.001, -5.0]}, "idle.forward_body",
         "1 deg or more off"),
        ("inertia_kg_m2.1.0", 0.2, "inertia_kg_m2.1.0", "must be 0.1 as inertia_kg_m2.0.1"),
        ("inertia_kg_m2.0.0", -11.0, "inertia_kg_m2", "positive principal moments"),
        ("inertia_kg_m2.0.0", 30.0, "inertia_kg_m2", "exceeds the sum of the others"),
        ("inertia_kg_m2", None, "torque_max_n_m", "says nothing without inertia_kg_m2"),
        ("torque_max_n_m", 0.028, "torque_max_n_m", "must be 0.02861 or more"),
        ("camera.type", "lidar", "camera.type", "must be one of frame, pushbroom"),
        ("camera.line_body", [0.0, 1.0, 0.1], "camera.line_body", "square to boresight_body"),
        ("camera.pixels", 8192.5, "camera.pixels", "must be a whole number"),
        ("camera.pixel_arcsec", 3600.0, "camera.pixels", "8192 deg together, more than 170"),
        ("star_trackers.needed", 3, "star_trackers.needed", "at most 2"),
        ("star_trackers.each.1.name", "st1", "star_trackers.each.1.name", "must be its own"),
        ("star_trackers.each", [], "star_trackers.each", "1 to 8 trackers, not 0"),
        ("exclusions.0.away_from", "mars", "exclusions.0.away_from", "'sun', 'moon'"),
        ("exclusions.0.of", None, "exclusions.0.of", 'must be "camera", or direction_body'),
        ("exclusions.1.name", "glint", "exclusions.2.name", "must be its own, not 'glint' again"),
        ("exclusions.1.name", "", "exclusions.1.name", "must not be empty"),
        ("exclusions.0.near", "sun", "exclusions.0.away_from", "or near with max_deg"),
        ("exclusions.0.min_deg", None, "exclusions.0.away_from", "must be given with min_deg"),
        ("exclusions.0.from", "sun", "exclusions.0.from", "not a field"),
        ("name", "", "name", "must not be empty"),
        ("mass_kg", 120.0, "mass_kg", "not a field of this object"),
    ],
)  # fmt: skip
def test_a_body_written_wrongly_is_refused_by_field_value_and_way_out(path, value, field, says):
    require_refused(changed(path, value), field, says)


def require_refused(document, field, says):
    with pytest.raises(InvalidRequest) as refused:
        JsonReader(BodyPlatform).read(json.dumps(document).encode())
    [error] = refused.value.errors[:1]
    assert error.field == field
    assert says in str(error)


@pytest.mark.parametrize(
    ("path", "value", "field", "says"),
    [
        ("agility", SMALLSAT["agility"], "agility", "must be left out with gyros"),
        ("gyros", None, "agility", "is required, or gyros"),
        ("inertia_kg_m2", None, "inertia_kg_m2", "is required with gyros"),
        ("torque_max_n_m", 0.03, "torque_max_n_m", "give gyros.turns.torque_max_n_m"),
        ("gyros.array.type", "pyramid", "gyros.array.type", "'scissored_pairs'"),
        ("gyros.turns.torque_max_n_m", 0.3, "gyros.turns.torque_max_n_m", "0.261799 or less"),
        ("gyros.turns.momentum_max_n_m_s", 0.6, "gyros.turns.momentum_max_n_m_s", "0.5 or less"),
        ("gyros.turns.rate_max_deg_s", 2.0, "gyros.turns.rate_max_deg_s", "takes 0.6767 N m s"),
        ("gyros.turns.torque_max_n_m", 0.001, "gyros.turns.rate_max_deg_s", "no torque is left"),
        ("gyros.start_n_m_s", [0.0, 0.3, 0.0], "gyros.turns.rate_max_deg_s", "unload the gyros"),
        ("gyros.turns.wheels", 4, "gyros.turns.wheels", "not a field"),
    ],
)
def test_gyros_written_wrongly_are_refused_by_field_value_and_way_out(path, value, field, says):
    require_refused(changed(path, value, GYRO_SAT), field, says)


def test_gyros_allow_what_they_can_always_give():
    """Random motions within the limits, and any total momentum that may be held: by hand."""
    body = JsonReader(BodyPlatform).read(json.dumps(GYRO_SAT).encode())
    inertia, limits = np.array(GYRO_SAT["inertia_kg_m2"]), body.envelope.by_order_rad
    chance = np.random.default_rng(0)
    rate = limits[0] * chance.choice([-1.0, 1.0], (20_000, 3))
    acceleration, jerk = (semi_axes * unit_vectors(chance, 20_000) for semi_axes in limits[1:])
    most = 0.5 - np.linalg.norm(np.abs(rate) @ np.abs(inertia), axis=1).max()
    held = most * unit_vectors(chance, 20_000)
    torque = acceleration @ inertia + np.cross(rate, held)
    change = jerk @ inertia + np.cross(acceleration, held) - np.cross(rate, np.cross(rate, held))
    for asked, given in ((torque, 0.1), (change, 0.2), (held - rate @ inertia, 0.5)):
        size = np.linalg.norm(asked, axis=1)
        assert size.max() <= given
        assert size.max() > 0.9 * given  # and not much less
    assert body.envelope.settle_s == 4.0


def unit_vectors(chance, count):
    vectors = chance.normal(size=(count, 3))
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def test_axes_of_the_camera_stand_as_the_line_and_the_boresight_say():
    """By hand: the line to body -X, the boresight to -Y; +X completes them right-handed: +Z."""
    camera = SMALLSAT["camera"] | {
        "boresight_body": [0.0, -3.0, 0.0],
        "line_body": [-2.0, 0.0, 0.0],
    }
    c_payload_from_body = smallsat(camera=camera).camera.c_payload_from_body
    expected = np.array([[0, 0, 1], [-1, 0, 0], [0, -1, 0]])
    assert c_payload_from_body == pytest.approx(expected)
