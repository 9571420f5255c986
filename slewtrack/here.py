"""The answers of a service made in this process, refused as a service refuses."""

import json
from functools import cache
from http import HTTPStatus
from typing import TYPE_CHECKING

from slewtrack.client.asking import Ask, Reply
from slewtrack.client.calls import Calls, Exchange

if TYPE_CHECKING:
    from app.here import Desk


@cache
def _desk() -> "Desk":
    from app.here import Desk

    return Desk()


async def _reply(ask: Ask) -> Reply:
    """Raises what `on_line` does, and what is our own failure."""
    from app.answers.problem import problem_of
    from planner.base.errors import Refusal

    try:
        return Reply(status=HTTPStatus.OK, headers={}, body=_desk().answer(ask))
    except Refusal as refusal:
        problem = problem_of(refusal)
        return Reply(status=problem["status"], headers={}, body=json.dumps(problem).encode())


# The calls of `Client` without a service; `spacecraft` has those of the spacecraft.
calls_here = Calls(Exchange(answer=_reply, meaning=lambda error: error, patience_s=0.0))
