"""Plans, the results of jobs that make them."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from datetime import datetime

from sqlalchemy import Connection

from app.ids import is_id
from app.store import jobs, results
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
    document, table_columns, *session = content
    return StoredPlan(
        **vars(job),
        document=unzip(document),
        table_columns=table_columns,
        session_document=b"".join(map(unzip, session)),
    )


def find(
    connection: Connection, plan_id: str, kinds: Collection[str]
) -> tuple[Job | None, StoredPlan | None, bytes]:
    """A job of these kinds by what may be its id, the plan that it made, and the plan's request."""
    job = jobs.get(connection, plan_id) if is_id(plan_id) else None
    if job is None or job.kind not in kinds:
        return None, None, b""
    return job, get(connection, job), jobs.request_of(connection, plan_id) or b""


def get(connection: Connection, job: Job) -> StoredPlan | None:
    """What a job made; None before it is made, or where it couldn't be."""
    content = results.get(connection, job.id)
    return plan_of(job, content) if content else None
