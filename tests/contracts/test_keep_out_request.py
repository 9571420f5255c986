"""Cones that make no sense are refused, and the refusal says so."""

import pytest

from planner.world.rules.keep_out import KeepOut
from planner.world.scenario import SlewOptions


@pytest.mark.parametrize(
    ("fields", "says"),
    [
        ({"half_angle_deg": 30.0}, "needs one direction"),
        ({"half_angle_deg": 30.0, "body": "sun", "ra_deg": 1.0, "dec_deg": 2.0}, "one direction"),
        ({"half_angle_deg": 30.0, "ra_deg": 1.0}, "belong together"),
        ({"half_angle_deg": 30.0, "body": "sirius"}, "body must be one of"),
        ({"half_angle_deg": 30.0, "direction_lvlh": (0.0, 0.0, 0.0)}, "at least 0.001 long"),
    ],
)
def test_cones_that_make_no_sense_are_refused(fields, says):
    with pytest.raises(ValueError, match=says):
        KeepOut(**fields)


def test_cones_are_counted():
    cones = (KeepOut(half_angle_deg=10.0, body="sun"),) * 9
    with pytest.raises(ValueError, match="keep_out must hold at most 8"):
        SlewOptions(keep_out=cones)
