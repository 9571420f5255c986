"""Whether anything can be written now: a full disk is read without complaint."""

import os
from datetime import UTC, datetime, timedelta

from sqlalchemy import delete, insert, or_

from app.store.database import Database
from app.store.ids import new_id
from app.store.models import ProbeRow

_BYTES = 32 * 1024  # what a plan takes
_FORGOTTEN = timedelta(minutes=1)  # by a service that died in between


def write_and_remove(database: Database) -> None:
    """In a transaction each, so that it gets to the disk; raises StoreUnavailable."""
    probe_id, now_utc = new_id(), datetime.now(UTC)
    # Random, as what compresses would need no room.
    values = {"id": probe_id, "at_utc": now_utc, "content": os.urandom(_BYTES)}
    with database.writing() as connection:
        connection.execute(insert(ProbeRow).values(values))
    forgotten = ProbeRow.at_utc < now_utc - _FORGOTTEN
    with database.writing() as connection:
        connection.execute(delete(ProbeRow).where(or_(ProbeRow.id == probe_id, forgotten)))
