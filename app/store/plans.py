"""Plans, the results of jobs that make them."""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime

from sqlalchemy import Connection

from app.store import results
from app.store.job import Job
from app.store.packed import unzip


@dataclass(frozen=True, kw_only=True)
class StoredPlan(Job):
    """A job with the plan it made.

    document: the answer's JSON without the table.  table_columns: `app.store.packed`.
    session_document: of an imaging session its own answer's, else empty.
    """

    document: bytes
    table_columns: bytes
    session_document: bytes = b""

    @property
    def planned_utc(self) -> datetime:
        """When it was made: the date its files state."""
        assert self.finished_utc is not None
        return self.finished_utc


def plan_of(job: Job, content: Sequence[bytes]) -> StoredPlan:
    """What a job that has ended made, as it is stored."""
    document, table_columns, *session = content
    return StoredPlan(
        **vars(job),
        document=unzip(document),
        table_columns=table_columns,
        session_document=b"".join(map(unzip, session)),
    )


def get(connection: Connection, job: Job) -> StoredPlan | None:
    """What a job made; None before it is made, or where it couldn't be."""
    content = results.get(connection, job.id)
    return plan_of(job, content) if content else None
