"""The results of jobs, stored once and never changed: the document, and what belongs to it."""

from collections.abc import Sequence

from sqlalchemy import Connection, bindparam, insert, select

from app.store.models import JobRow, ResultRow

# Statements of every plan, built once: that takes longer than SQLite needs to answer them.
_NEW = insert(ResultRow)
_OF_JOB = (
    select(ResultRow.content)
    .where(ResultRow.job_id == bindparam("of_job"))
    .order_by(ResultRow.part)
)
_DOCUMENT = _OF_JOB.where(ResultRow.part == 0)


def store(connection: Connection, job_id: str, content: Sequence[bytes]) -> None:
    """Of a job that has none yet."""
    rows = [{"job_id": job_id, "part": part, "content": one} for part, one in enumerate(content)]
    connection.execute(_NEW, rows)


def get(connection: Connection, job_id: str) -> Sequence[bytes]:
    """What a job made; nothing before it is made."""
    return connection.scalars(_OF_JOB, {"of_job": job_id}).all()


def document(connection: Connection, job_id: str) -> bytes | None:
    """Of what a job made; None before it is made."""
    return connection.scalar(_DOCUMENT, {"of_job": job_id})


def documents_of_parts(connection: Connection, job_id: str) -> Sequence[bytes]:
    """Of those of its parts that are done, in the order in which they were accepted."""
    return connection.scalars(
        select(ResultRow.content)
        .join(JobRow, JobRow.id == ResultRow.job_id)
        .where(JobRow.parent_id == job_id, ResultRow.part == 0)
        .order_by(JobRow.id)
    ).all()
