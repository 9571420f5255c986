"""The audit log: who did what, and when."""

from dataclasses import dataclass
from datetime import UTC, datetime

from sqlalchemy import Connection, insert, select

from app.store.database import Database
from app.store.models import AuditRow


@dataclass(frozen=True, kw_only=True)
class AuditEntry:
    """One deed; see `AuditRow`."""

    id: int
    at_utc: datetime
    key_id: str | None
    action: str
    subject: str
    detail: str


def record(
    connection: Connection, *, key_id: str | None, action: str, subject: str, detail: str = ""
) -> None:
    """In the transaction of the deed itself, so that there is neither without the other."""
    row = {"key_id": key_id, "action": action, "subject": subject, "detail": detail}
    connection.execute(insert(AuditRow), row | {"at_utc": datetime.now(UTC)})


def entries(database: Database, *, limit: int, before: int) -> list[AuditEntry]:
    """The latest first, of those older than the one with the id `before`."""
    wanted = (
        select(AuditRow.__table__)
        .where(AuditRow.id < before)
        .order_by(AuditRow.id.desc())
        .limit(limit)
    )
    with database.reading() as connection:
        return [AuditEntry(**row) for row in connection.execute(wanted).mappings()]
