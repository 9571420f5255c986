"""A campaign as jobs, one per pass, and what happens to a pass that is refused."""

import hashlib
import json
from collections.abc import Mapping
from typing import Any

from sqlalchemy import Connection

from app.store import jobs
from app.store.ids import new_id
from app.store.jobs import Job, NewJob
from app.work.campaign import Part, without_refused

KIND = "plan"
RANK = 1  # after what somebody waits for


def add_part(connection: Connection, whole: Job, part: Part, deadline_s: float) -> None:
    """Accept the plan of one pass, in the transaction that has the campaign's row locked."""
    _accept(connection, part, whole.id, whole.key_id, deadline_s)


def replace_refused(connection: Connection, refused: Job, problem: Mapping[str, Any]) -> None:
    """Accept the pass once more without the look at fault, if any other is left.

    In the transaction that finishes the refused plan, whose row it holds, so that the campaign
    never sees itself complete in between.
    """
    part = Part(
        request=jobs.request_of(connection, refused.id) or b"", told=refused.options["campaign"]
    )
    repaired = without_refused(part, problem.get("field"), problem["detail"])
    if repaired is not None and refused.parent_id is not None:
        _accept(connection, repaired, refused.parent_id, refused.key_id, refused.deadline_s)


def _accept(
    connection: Connection, part: Part, whole_id: str, key_id: str | None, deadline_s: float
) -> None:
    jobs.accept(
        connection,
        NewJob(
            id=new_id(),
            kind=KIND,
            name=json.loads(part.request)["name"],
            request=part.request,
            request_sha256=hashlib.sha256(part.request).hexdigest(),
            deadline_s=deadline_s,
            options={"campaign": dict(part.told)},
            key_id=key_id,
            parent_id=whole_id,
            rank=RANK,
        ),
    )
