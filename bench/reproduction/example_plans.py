"""The requests of examples/, planned, and what there is to see of them."""

import json
from functools import cache
from pathlib import Path
from typing import Any

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


def level_request(example: str) -> dict[str, Any]:
    request: dict[str, Any] = json.loads((EXAMPLES / example).read_text(encoding="utf-8"))
    return {**request, "attitude": {"law": "lvlh"}}


@cache
def plan_of(example: str) -> Plan:
    """With the attitude level, as the papers tell none."""
    return plan(read_request(level_request(example)))


@cache
def view_of(example: str) -> PlanView:
    """At every row."""
    return view_plan(plan_of(example), None, HRC_PIXEL_ARCSEC)


def closest(track: TargetTrack, t_s: NDArray) -> tuple[int, float]:
    """The row of a session at the least range, and when that is."""
    rows = track.in_session.nonzero()[0]
    row = int(rows[track.range_m[rows].argmin()])
    return row, float(t_s[row])
