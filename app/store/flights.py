"""Results of flights, stored once and never changed."""

from sqlalchemy import Connection, insert, select

from app.store.models import FlightsRow, JobRow


def store(connection: Connection, job_id: str, document: bytes) -> None:
    """Of a job of flights, or of one of its parts."""
    connection.execute(insert(FlightsRow).values(id=job_id, document=document))


def get(connection: Connection, job_id: str) -> bytes | None:
    """What is known of all its runs; None before that is."""
    return connection.scalar(select(FlightsRow.document).where(FlightsRow.id == job_id))


def parts_of(connection: Connection, job_id: str) -> list[bytes]:
    """What those of its parts found that are done, in the order in which they were accepted."""
    found = connection.scalars(
        select(FlightsRow.document)
        .join(JobRow, JobRow.id == FlightsRow.id)
        .where(JobRow.parent_id == job_id)
        .order_by(JobRow.id)
    )
    return list(found)
