"""The audit log: actions, times and keys."""

from datetime import UTC, datetime
from typing import Annotated

from sqlalchemy import Connection, insert, select

from app.store.models import AuditRow
from planner.base.answer_members import Member, answer
from planner.world.frames.time_scales import Utc


@answer
class AuditEntry:
    """One deed.

    id: greater than those before.
    at_utc: time of the action; UTC.
    key_id: id of the API key it was done with; null without one. E.g.
    `"01a203fd-cbae-73f8-8276-319f76b8842c"`.
    action: the action, such as `plan.accept`.
    subject: id of what it was done to.
    detail: more about it, if there is.
    """

    id: Annotated[int, Member(least=1)]
    at_utc: Utc
    key_id: str | None
    action: str
    subject: str
    detail: str


_NEW = insert(AuditRow)
_ENTRIES = select(*(getattr(AuditRow, name) for name in AuditEntry.__dataclass_fields__))


def record(
    connection: Connection, *, key_id: str | None, action: str, subject: str, detail: str = ""
) -> None:
    """In the transaction of the deed itself, so that there is neither without the other."""
    row = {"key_id": key_id, "action": action, "subject": subject, "detail": detail}
    connection.execute(_NEW, row | {"at_utc": datetime.now(UTC)})


def entries(connection: Connection, limit: int, before: int) -> list[AuditEntry]:
    """The latest first, of those older than the one with the id `before`."""
    query = _ENTRIES.where(AuditRow.id < before).order_by(AuditRow.id.desc()).limit(limit)
    return [AuditEntry(**row) for row in connection.execute(query).mappings()]
