"""The requests of examples/, planned."""

from functools import cache
from pathlib import Path

from planner.sessions.pipeline import make_plan
from planner.sessions.plan import Plan
from slewtrack import read_request

EXAMPLES = Path(__file__).parents[2] / "examples"


@cache
def plan_of(example: str) -> Plan:
    """The plan of a request in examples/."""
    return make_plan(read_request((EXAMPLES / example).read_bytes()))
