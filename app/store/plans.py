"""Which plans were made?  Stored once, never changed."""

import zlib
from dataclasses import dataclass
from datetime import datetime

from sqlalchemy import Connection, func, insert, select

from app.jobs.planned import Planned
from app.jobs.states import JobState
from app.store.models import PlanRow


@dataclass(frozen=True, kw_only=True)
class StoredPlan:
    """A plan as it is read again."""

    id: str
    kind: str
    series: str
    revision: int
    revises: str | None
    name: str
    state: JobState
    document: bytes
    table_columns: bytes
    planned_utc: datetime


@dataclass(frozen=True, kw_only=True)
class Revision:
    """Where a plan stands among those that replaced each other."""

    id: str
    series: str
    revision: int
    revises: str | None


def store(
    connection: Connection, job_id: str, kind: str, revises: str | None, new: Planned
) -> None:
    """The plan of a job, as the latest revision of the series of the plan it revises."""
    before = None if revises is None else revision_of(connection, revises)
    series, last = job_id, 0
    if before is not None:
        series = before.series
        of_series = PlanRow.series == series
        connection.execute(select(PlanRow.id).where(of_series).with_for_update())  # one by one
        last = connection.scalar(select(func.max(PlanRow.revision)).where(of_series)) or 0
    connection.execute(
        insert(PlanRow).values(
            id=job_id,
            kind=kind,
            series=series,
            revision=last + 1,
            revises=revises,
            name=new.name,
            state=new.state,
            input_sha256=new.input_sha256,
            versions=new.versions,
            document=new.document,
            table_columns=new.table_columns,
            planned_utc=new.planned_utc,
        )
    )


def get(connection: Connection, plan_id: str) -> StoredPlan | None:
    """By its id."""
    columns = (getattr(PlanRow, name) for name in StoredPlan.__dataclass_fields__)
    row = connection.execute(select(*columns).where(PlanRow.id == plan_id)).one_or_none()
    if row is None:
        return None
    members = dict(row._mapping)
    return StoredPlan(**members | {"document": zlib.decompress(members["document"])})


def revision_of(connection: Connection, plan_id: str) -> Revision | None:
    """Of a plan that was made."""
    return revisions_of(connection, [plan_id]).get(plan_id)


def revisions_of(connection: Connection, plan_ids: list[str]) -> dict[str, Revision]:
    """Of those among the ids that name plans."""
    columns = (PlanRow.id, PlanRow.series, PlanRow.revision, PlanRow.revises)
    found = connection.execute(select(*columns).where(PlanRow.id.in_(plan_ids)))
    return {row.id: Revision(**row._mapping) for row in found}
