"""The tables: jobs, their results and events, probes, keys, the audit log; kinds of column."""

from datetime import UTC, datetime
from typing import Any

from sqlalchemy import (
    JSON,
    CheckConstraint,
    DateTime,
    Dialect,
    Float,
    ForeignKey,
    Index,
    LargeBinary,
    MetaData,
    String,
    Text,
    UniqueConstraint,
)
from sqlalchemy.ext.compiler import compiles
from sqlalchemy.orm import DeclarativeBase, Mapped, mapped_column
from sqlalchemy.sql.compiler import SQLCompiler
from sqlalchemy.sql.functions import FunctionElement
from sqlalchemy.types import TypeDecorator

from app.ids import STATES, JobState


class PlainString(TypeDecorator[str]):
    """Text that every database takes: PostgreSQL knows no U+0000, UTF-8 no lone surrogate."""

    impl = String
    cache_ok = True

    def process_bind_param(self, value: str | None, dialect: Dialect) -> str | None:
        if value is None:
            return None
        return value.replace("\0", "\ufffd").encode("utf-8", "replace").decode()


class PlainText(PlainString):
    """Of any length."""

    impl = Text
    cache_ok = True


class UtcDateTime(TypeDecorator[datetime]):
    """Aware and UTC in Python on every database; SQLite itself keeps no zone."""

    impl = DateTime(timezone=True)
    cache_ok = True

    def process_bind_param(self, value: datetime | None, dialect: Dialect) -> datetime | None:
        return None if value is None else value.astimezone(UTC)

    def process_result_value(self, value: datetime | None, dialect: Dialect) -> datetime | None:
        if value is None:
            return None
        return value.astimezone(UTC) if value.tzinfo else value.replace(tzinfo=UTC)


class database_now_s(FunctionElement[float]):  # noqa: N801 (reads as the SQL function it is)
    """Seconds since 1970 by the clock of the database, which all services on it share."""

    type = Float()
    inherit_cache = True


@compiles(database_now_s, "sqlite")
def _sqlite_now(_: database_now_s, __: SQLCompiler, **___: object) -> str:
    return "((julianday('now') - 2440587.5) * 86400.0)"


@compiles(database_now_s, "postgresql")
def _postgresql_now(_: database_now_s, __: SQLCompiler, **___: object) -> str:
    return "extract(epoch from clock_timestamp())::double precision"


_STATES = ", ".join(f"'{state}'" for state in STATES)
_ID = PlainString(36)


class Base(DeclarativeBase):
    """What Alembic compares a database with."""

    # Named, so that a migration can drop a constraint on every database.
    metadata = MetaData(
        naming_convention={
            "ix": "ix_%(table_name)s_%(column_0_N_name)s",
            "uq": "uq_%(table_name)s_%(column_0_N_name)s",
            "ck": "ck_%(table_name)s_%(constraint_name)s",
            "fk": "fk_%(table_name)s_%(column_0_name)s",
            "pk": "pk_%(table_name)s",
        }
    )


class JobRow(Base):
    """A piece of work that was accepted.

    id: sorts by time.  request: the body, zlib.  options: what was asked beside the body.
    idempotency: SHA-256 of who sent which Idempotency-Key where; None without one.
    rank: smaller goes first.  lease_until_s: by `database_now_s`; a running job without a lease
    waits for others.
    plan_id: the job of the plan that this one is about; whoever deletes that deletes this.
    revises: the job of the plan that this one is to replace.  series: of a plan that is made, the
    job of its first revision; revision: from 1 within the series.
    platform ... target_words: `app.store.job`; targets: the first of target_count.
    words, target_words: what filters look into, `folded`.
    """

    __tablename__ = "jobs"

    id: Mapped[str] = mapped_column(_ID, primary_key=True)
    kind: Mapped[str] = mapped_column(PlainString(32))
    state: Mapped[JobState] = mapped_column(PlainString(16))
    name: Mapped[str] = mapped_column(PlainText)
    request: Mapped[bytes] = mapped_column(LargeBinary)
    request_sha256: Mapped[str] = mapped_column(PlainString(64))
    options: Mapped[dict[str, Any]] = mapped_column(JSON)
    key_id: Mapped[str | None] = mapped_column(PlainString(64))
    idempotency: Mapped[str | None] = mapped_column(PlainString(64), unique=True)
    parent_id: Mapped[str | None] = mapped_column(ForeignKey("jobs.id", ondelete="CASCADE"))
    plan_id: Mapped[str | None] = mapped_column(_ID)
    revises: Mapped[str | None] = mapped_column(_ID)
    series: Mapped[str | None] = mapped_column(_ID)
    revision: Mapped[int | None]
    rank: Mapped[int]
    attempts: Mapped[int]
    lease_token: Mapped[str | None] = mapped_column(PlainString(32))
    lease_until_s: Mapped[float | None]
    deadline_s: Mapped[float]
    created_utc: Mapped[datetime] = mapped_column(UtcDateTime)
    started_utc: Mapped[datetime | None] = mapped_column(UtcDateTime)
    finished_utc: Mapped[datetime | None] = mapped_column(UtcDateTime)
    cancel_requested: Mapped[bool]
    problem: Mapped[dict[str, Any] | None] = mapped_column(JSON(none_as_null=True))
    platform: Mapped[str | None] = mapped_column(PlainText)
    start_utc: Mapped[datetime | None] = mapped_column(UtcDateTime)
    stop_utc: Mapped[datetime | None] = mapped_column(UtcDateTime)
    targets: Mapped[list[str] | None] = mapped_column(JSON(none_as_null=True))
    target_count: Mapped[int | None]
    probability_in_frame: Mapped[float | None]
    words: Mapped[str | None] = mapped_column(PlainText)
    target_words: Mapped[str | None] = mapped_column(PlainText)

    __table_args__ = (
        CheckConstraint(f"state IN ({_STATES})", name="state"),
        UniqueConstraint("series", "revision"),
        Index(None, "state", "rank", "id"),  # what to take up next
        Index(None, "kind", "id"),  # lists
        Index(None, "parent_id", "state"),
        Index(None, "plan_id", "id"),  # lists
        Index(None, "lease_token"),
        Index(None, "finished_utc"),  # retention
    )


class EventRow(Base):
    """Something that happened to a job; seq counts from 1 within it."""

    __tablename__ = "events"

    job_id: Mapped[str] = mapped_column(ForeignKey("jobs.id", ondelete="CASCADE"), primary_key=True)
    seq: Mapped[int] = mapped_column(primary_key=True, autoincrement=False)
    at_utc: Mapped[datetime] = mapped_column(UtcDateTime)
    kind: Mapped[str] = mapped_column(PlainString(32))
    data: Mapped[dict[str, Any]] = mapped_column(JSON)


class ResultRow(Base):
    """Bytes that a job made; never changed: a trigger refuses UPDATE.

    part: 0 is the document, from 1 on what belongs to it; see `app.work.result`.
    """

    __tablename__ = "results"

    job_id: Mapped[str] = mapped_column(ForeignKey("jobs.id", ondelete="CASCADE"), primary_key=True)
    part: Mapped[int] = mapped_column(primary_key=True, autoincrement=False)
    content: Mapped[bytes] = mapped_column(LargeBinary)


class ProbeRow(Base):
    """What readiness wrote and is about to remove."""

    __tablename__ = "probes"

    id: Mapped[str] = mapped_column(_ID, primary_key=True)
    at_utc: Mapped[datetime] = mapped_column(UtcDateTime)
    content: Mapped[bytes] = mapped_column(LargeBinary)


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
