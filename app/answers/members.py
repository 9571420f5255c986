"""Members that answers share: the provenance and the head of every plan, with their writers."""

import hashlib
import json
from dataclasses import dataclass
from datetime import datetime
from functools import cache
from typing import Annotated, Any, TypeVar, cast

from pydantic import ConfigDict, Field, TypeAdapter

from app.ids import JobState
from app.versions import versions
from planner.world.frames.time_scales import utc_text

# `__pydantic_config__` of what many routes answer: FastAPI makes adapters of it for each of them,
# which takes a tenth of a second, when it is only the API's document that tells of them.
BUILT_ON_FIRST_USE = ConfigDict(defer_build=True)
Answer = TypeVar("Answer")


def to_json(answer: object) -> bytes:
    """UTF-8, by the members as the answer's class declares them."""
    kind: type = type(answer)
    return _adapter(kind).dump_json(answer, by_alias=True, warnings="error")


def to_members(answer: object) -> dict[str, Any]:
    """As `to_json` writes them."""
    members: dict[str, Any] = json.loads(to_json(answer))
    return members


def from_store(kind: type[Answer], members: object) -> Answer:
    """What was stored; members that only other versions know are passed over."""
    plain: type = kind
    return cast(Answer, _adapter(plain).validate_python(members))


@cache
def _adapter(kind: type) -> TypeAdapter[object]:
    return TypeAdapter(kind)


@dataclass(frozen=True, kw_only=True)
class ProvenanceOut:
    """The basis of an answer.

    input_sha256: of the request's bytes.
    planned_at: time of the computation; UTC.
    versions: of slewtrack and of what it computes with.
    """

    input_sha256: str
    planned_at: str
    versions: dict[str, str]


def provenance(planned_at_utc: datetime, *parts: bytes) -> ProvenanceOut:
    """Of an answer to the request that has these parts, in order."""
    digest = hashlib.sha256()
    for part in parts:
        digest.update(part)
    return ProvenanceOut(
        input_sha256=digest.hexdigest(),
        planned_at=utc_text(planned_at_utc),
        versions=versions(),
    )


@dataclass(frozen=True, kw_only=True)
class PlanHead:
    """How a plan is found again.

    id: of the plan, as its address names it.
    state: `done` once verified.
    revision: from 1, one more for each plan that replaces another.
    revises: id of the plan it replaces; null for none. E.g.
    `"01a203fd-cbae-73f8-8276-319f76b8842c"`.
    requested_by: name of the API key that the request came with; null without keys. E.g. `"anna"`.
    """

    __pydantic_config__ = BUILT_ON_FIRST_USE

    id: str
    state: JobState
    revision: Annotated[int, Field(ge=1)]
    revises: str | None
    requested_by: str | None


def whole_answer(head: PlanHead, document: bytes, table: bytes) -> bytes:
    """One JSON object of the members of the first two, and the table."""
    return b"".join([to_json(head)[:-1], b",", document[1:-1], b',"table":', table, b"}"])
