"""The tables of who may ask, and who did what."""

from datetime import datetime

from sqlalchemy import JSON, Index
from sqlalchemy.orm import Mapped, mapped_column

from app.store.columns import PlainString, PlainText, UtcDateTime
from app.store.models import Base


class KeyRow(Base):
    """An API key; see `app.store.api_keys.Key`.  Never deleted: the audit log names it."""

    __tablename__ = "keys"

    id: Mapped[str] = mapped_column(PlainString(64), primary_key=True)
    name: Mapped[str] = mapped_column(PlainText)
    secret_sha256: Mapped[str] = mapped_column(PlainString(64))
    scopes: Mapped[list[str]] = mapped_column(JSON)
    created_utc: Mapped[datetime] = mapped_column(UtcDateTime)
    revoked_utc: Mapped[datetime | None] = mapped_column(UtcDateTime)
    rate_per_minute: Mapped[int | None]
    concurrency: Mapped[int | None]


class AuditRow(Base):
    """Something somebody did; only ever added to.

    key_id: None without a key (on loopback, on the command line).  subject: id of what it was
    done to.
    """

    __tablename__ = "audit"

    id: Mapped[int] = mapped_column(primary_key=True, autoincrement=True)
    at_utc: Mapped[datetime] = mapped_column(UtcDateTime)
    key_id: Mapped[str | None] = mapped_column(PlainString(64))
    action: Mapped[str] = mapped_column(PlainString(32))
    subject: Mapped[str] = mapped_column(PlainString(64))
    detail: Mapped[str] = mapped_column(PlainText)

    __table_args__ = (Index(None, "subject"),)
