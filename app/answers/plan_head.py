"""The fields every plan's answer begins with, whatever was planned."""

from dataclasses import dataclass

from pydantic import TypeAdapter

from app.store.ids import JobState, new_id


@dataclass(frozen=True, kw_only=True)
class PlanHead:
    """revision: from 1, one more for each plan that replaces another; `revises` names that."""

    id: str
    state: JobState
    revision: int
    revises: str | None


_HEAD = TypeAdapter(PlanHead)


def new_head(state: JobState) -> PlanHead:
    """Of a plan that replaces none."""
    return PlanHead(id=new_id(), state=state, revision=1, revises=None)


def whole_answer(head: PlanHead, document: bytes, table: bytes) -> bytes:
    """One JSON object of the members of the first two, and the table."""
    return b"".join([_HEAD.dump_json(head)[:-1], b",", document[1:-1], b',"table":', table, b"}"])
