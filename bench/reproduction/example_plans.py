"""The requests of examples/, planned, and what there is to see of them."""

from functools import cache
from pathlib import Path

from numpy.typing import NDArray

from planner.output.view.targets import TargetTrack
from planner.output.view.view import PlanView, view_plan
from planner.planning.sessions.plan import Plan
from planner.world.platforms.camera import HRC_PIXEL_ARCSEC
from slewtrack import plan, read_request

EXAMPLES = Path(__file__).parents[2] / "examples"
LAS_VEGAS = "las_vegas_2015.json"
BOSTON = "gallery/boston.json"
THREE_SESSIONS = "three_sessions.json"


@cache
def plan_of(example: str) -> Plan:
    return plan(read_request((EXAMPLES / example).read_bytes()))


@cache
def view_of(example: str) -> PlanView:
    """At every row."""
    return view_plan(plan_of(example), None, HRC_PIXEL_ARCSEC)


def closest(track: TargetTrack, t_s: NDArray) -> tuple[int, float]:
    """The row of a session at the least range, and when that is."""
    rows = track.in_session.nonzero()[0]
    row = int(rows[track.range_m[rows].argmin()])
    return row, float(t_s[row])
