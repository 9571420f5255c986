"""The kinds of column that all tables share."""

from datetime import UTC, datetime

from sqlalchemy import DateTime, Dialect, Float, String, Text
from sqlalchemy.ext.compiler import compiles
from sqlalchemy.sql.compiler import SQLCompiler
from sqlalchemy.sql.functions import FunctionElement
from sqlalchemy.types import TypeDecorator


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
