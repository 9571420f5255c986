"""The plans made and the choices of campaigns, stored once and never changed."""

import json
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime
from typing import Any

from sqlalchemy import Connection, bindparam, func, insert, select

from app.store.ids import JobState
from app.store.models import CampaignRow, PlanRow
from app.store.packed import NewPlan, unzip


@dataclass(frozen=True, kw_only=True)
class StoredPlan:
    """A plan as it is read again."""

    id: str
    series: str
    revision: int
    revises: str | None
    name: str
    state: JobState
    document: bytes
    table_columns: bytes
    planned_utc: datetime


# Built once: that takes longer than SQLite needs to answer them.
_PLAN = select(*(getattr(PlanRow, name) for name in StoredPlan.__dataclass_fields__)).where(
    PlanRow.id == bindparam("of_job")
)
_NEW = insert(PlanRow)
_NOT_ITS_OWN = ("iterations", "listing")  # counted, and kept with the job


def store(
    connection: Connection, job_id: str, kind: str, revises: str | None, new: NewPlan
) -> StoredPlan:
    """The plan of a job, as the latest revision of the series of the plan it revises."""
    series, last = None, 0
    if revises is not None:
        series = connection.scalar(select(PlanRow.series).where(PlanRow.id == revises))
    if series is not None:
        of_series = PlanRow.series == series
        connection.execute(select(PlanRow.id).where(of_series).with_for_update())  # one by one
        last = connection.scalar(select(func.max(PlanRow.revision)).where(of_series)) or 0
    columns = {name: value for name, value in vars(new).items() if name not in _NOT_ITS_OWN}
    place = {"series": series or job_id, "revision": last + 1, "revises": revises}
    connection.execute(_NEW, {"id": job_id, "kind": kind, **columns, **place})
    known = columns | place | {"id": job_id, "document": zlib.decompress(new.document)}
    return StoredPlan(**{name: known[name] for name in StoredPlan.__dataclass_fields__})


def get(connection: Connection, plan_id: str) -> StoredPlan | None:
    """By its id."""
    row = connection.execute(_PLAN, {"of_job": plan_id}).one_or_none()
    if row is None:
        return None
    members = dict(row._mapping)
    return StoredPlan(**members | {"document": unzip(members["document"])})


def store_choice(connection: Connection, job_id: str, document: bytes) -> None:
    """Of a campaign's job; document: JSON, zlib."""
    connection.execute(insert(CampaignRow).values(id=job_id, document=document))


def choice_of(connection: Connection, job_id: str) -> Mapping[str, Any] | None:
    """What a campaign chose; None before anything was chosen."""
    found = connection.scalar(select(CampaignRow.document).where(CampaignRow.id == job_id))
    if found is None:
        return None
    choice: Mapping[str, Any] = json.loads(unzip(found))
    return choice
