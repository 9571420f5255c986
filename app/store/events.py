"""The events of each job, in order."""

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any

from sqlalchemy import Connection, bindparam, func, insert, select

from app.store.models import EventRow

STATE, PROGRESS = "state", "progress"
_LAST = select(func.coalesce(func.max(EventRow.seq), 0)).where(
    EventRow.job_id == bindparam("of_job")
)
_NEW = insert(EventRow)
_NEXT = _NEW.values(seq=_LAST.scalar_subquery() + 1)


@dataclass(frozen=True, kw_only=True)
class Event:
    """seq: from 1 within the job."""

    seq: int
    at_utc: datetime
    kind: str
    data: Mapping[str, Any]


def begin(connection: Connection, job_id: str, *states: Mapping[str, Any]) -> None:
    now_utc = datetime.now(UTC)
    connection.execute(
        _NEW,
        [
            {"job_id": job_id, "seq": seq, "at_utc": now_utc, "kind": STATE, "data": dict(state)}
            for seq, state in enumerate(states, start=1)
        ],
    )


def record(connection: Connection, job_id: str, kind: str, data: Mapping[str, Any]) -> None:
    """The next event of a job, whose row the transaction must have locked."""
    row = {"job_id": job_id, "at_utc": datetime.now(UTC), "kind": kind, "data": dict(data)}
    connection.execute(_NEXT, row | {"of_job": job_id})


def after(connection: Connection, job_id: str, seq: int) -> list[Event]:
    columns = (EventRow.seq, EventRow.at_utc, EventRow.kind, EventRow.data)
    found = connection.execute(
        select(*columns).where(EventRow.job_id == job_id, EventRow.seq > seq).order_by(EventRow.seq)
    )
    return [Event(**row._mapping) for row in found]
