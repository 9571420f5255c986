"""Where is the data, and how is it read and written?

SQLite in the data folder without any set-up, PostgreSQL by SLEWTRACK_DATABASE_URL.

What was accepted outlives a power failure, too: SQLite waits for the disk at every commit, which
takes some 4 ms twice a plan.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from sqlalchemy import URL, Connection, Engine, create_engine, event, make_url
from sqlalchemy.engine.interfaces import DBAPIConnection
from sqlalchemy.exc import ArgumentError
from sqlalchemy.pool import ConnectionPoolEntry

from planner.errors import InvalidInput

FILE = "slewtrack.sqlite3"
DRIVERS = ("sqlite", "postgresql+psycopg")
_BUSY_S = 30.0  # how long SQLite waits for another writer
_POOLED, _POOLED_MORE = 5, 20
_WRITES = "slewtrack_writes"


class Database:
    """Connections to one database; every access is one transaction."""

    def __init__(self, url: URL) -> None:
        self.url = url
        self._engine = _engine(url)

    @contextmanager
    def reading(self) -> Iterator[Connection]:
        """A transaction that sees one state of the data."""
        with self._engine.connect() as connection, connection.begin():
            yield connection

    @contextmanager
    def writing(self) -> Iterator[Connection]:
        """A transaction that may change data; SQLite lets one in at a time."""
        writer = self._engine.connect().execution_options(**{_WRITES: True})
        with writer as connection, connection.begin():
            yield connection

    def close(self) -> None:
        """Give all connections back."""
        self._engine.dispose()


def open_database(database_url: str, data_dir: Path) -> Database:
    """By its URL; without one the file in `data_dir`, which is made.

    Raises InvalidInput for a URL we can't use.
    """
    if not database_url:
        data_dir.mkdir(mode=0o700, parents=True, exist_ok=True)
        return Database(URL.create("sqlite", database=str(data_dir / FILE)))
    try:
        url = make_url(database_url)
    except ArgumentError:
        url = None
    if url is None or url.drivername not in DRIVERS:
        raise InvalidInput(
            "must be postgresql+psycopg://USER:PASSWORD@HOST/NAME or sqlite:///FILE",
            field="SLEWTRACK_DATABASE_URL",
        )
    return Database(url)


def _engine(url: URL) -> Engine:
    if url.drivername != "sqlite":
        return create_engine(
            url,
            pool_size=_POOLED,
            max_overflow=_POOLED_MORE,
            pool_pre_ping=True,
            # Else a database made as SQL_ASCII answers in bytes.
            connect_args={"client_encoding": "utf8"},
        )
    engine = create_engine(
        url,
        pool_size=_POOLED,
        max_overflow=_POOLED_MORE,
        connect_args={"timeout": _BUSY_S, "check_same_thread": False},
    )
    event.listen(engine, "connect", _set_up_sqlite)
    event.listen(engine, "begin", _begin_sqlite)
    return engine


def _set_up_sqlite(connection: DBAPIConnection, _: ConnectionPoolEntry) -> None:
    connection.isolation_level = None  # transactions begin as `_begin_sqlite` says
    cursor = connection.cursor()
    for pragma in ("journal_mode=WAL", "synchronous=FULL", "foreign_keys=ON"):
        cursor.execute(f"PRAGMA {pragma}")
    cursor.close()


def _begin_sqlite(connection: Connection) -> None:
    writes = connection.get_execution_options().get(_WRITES)
    # A reader that turns writer can fail at once when another wrote in between.
    connection.exec_driver_sql("BEGIN IMMEDIATE" if writes else "BEGIN")
