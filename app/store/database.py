"""The database: its address, its transactions, and failures that are none of ours.

SQLite in the data folder without any set-up, PostgreSQL by SLEWTRACK_DATABASE_URL.

What was accepted outlives a power failure, too: SQLite waits for the disk at every commit, which
takes some 4 ms.  It doesn't wait for what would be made again from that: a plan that a power
failure takes back is made once more when the service is back, under its id, the same.
"""

import asyncio
import os
import random
import sqlite3
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import TypeVar

import anyio
from anyio import to_thread
from sqlalchemy import URL, Connection, Engine, create_engine, delete, event, insert, make_url, or_
from sqlalchemy.engine.interfaces import DBAPIConnection
from sqlalchemy.exc import ArgumentError, DBAPIError, OperationalError, SQLAlchemyError
from sqlalchemy.exc import TimeoutError as NoConnectionFree
from sqlalchemy.pool import ConnectionPoolEntry

from app.ids import new_id
from app.log.logs import log
from app.store.models import ProbeRow
from app.store.unavailable import StoreDamaged, StoreUnavailable
from planner.base.errors import InvalidInput

T = TypeVar("T")
FILE = "slewtrack.sqlite3"
DRIVERS = ("sqlite", "postgresql+psycopg")
_POOLED, _POOLED_MORE = 5, 20
# More than a lock or a connection of the pool is waited for, less than two seconds; counted in
# looks, as a service that stands still itself hears nothing.
_LOOKS_FOR_ANSWER, _LOOK_FOR_ANSWER_S = 9, 0.2
_WRITES = "slewtrack_writes"  # how, as SQLite's `synchronous` has it
# SQLite's own waiting looks ten times a second, and finds no gap between the transactions of
# another busy service; so often it does.
_LOOK_S = 0.004
_OWNER_ONLY = 0o600
MIGRATION_LOCK = 0x736C6577  # "slew": any number that nobody else locks
OUTDATED = (
    "the database has been migrated by another version of slewtrack; this service writes nothing "
    "more and ends"
)
_PROBE_BYTES = 32 * 1024  # what a plan takes
_PROBE_FORGOTTEN = timedelta(minutes=1)  # by a service that died in between
# Long enough for what another process may write at once, short enough to be told in two seconds.
PATIENCE_S = 1.2
# Time in which what kept somebody waiting in vain isn't tried again.
_REST_S = 0.5
# Primary result codes, https://sqlite.org/rescode.html; SQLITE_ERROR is faulty SQL.
_SQLITE = frozenset(
    {
        sqlite3.SQLITE_PERM,
        sqlite3.SQLITE_BUSY,
        sqlite3.SQLITE_LOCKED,
        sqlite3.SQLITE_NOMEM,
        sqlite3.SQLITE_READONLY,
        sqlite3.SQLITE_INTERRUPT,
        sqlite3.SQLITE_IOERR,
        sqlite3.SQLITE_CORRUPT,
        sqlite3.SQLITE_FULL,
        sqlite3.SQLITE_CANTOPEN,
        sqlite3.SQLITE_PROTOCOL,
        sqlite3.SQLITE_NOTADB,
    }
)
# Classes and codes of SQLSTATE, PostgreSQL's appendix A: data or an index corrupted;
_CORRUPTED = ("XX001", "XX002")
# connection, authorization, rollbacks that may be tried again, resources, operator, system; no such
# database, no right to write, a standby or read-only server, a lock that didn't come.
_SQLSTATES = (
    *("08", "28", "40", "53", "57", "58", *_CORRUPTED),
    *("3D000", "42501", "25006", "55P03"),
)


class Outage:
    """Remembers when all who tried waited in vain."""

    def __init__(self) -> None:
        self._until_s = 0.0

    def require_over(self) -> None:
        """Raises StoreUnavailable while there is no use in trying."""
        if time.monotonic() < self._until_s:
            raise StoreUnavailable("the database was not to be reached just now; ask again later")

    def begin(self) -> None:
        """Somebody waited in vain."""
        self._until_s = time.monotonic() + _REST_S


class WriteLock:
    """A queue of writers: it moves as long as one of them gets through."""

    def __init__(self, outage: Outage) -> None:
        self._lock = threading.Lock()
        self._outage = outage
        self._done = 0

    @contextmanager
    def hold(self) -> Iterator[None]:
        """Raises StoreUnavailable when no writer got through for PATIENCE_S."""
        done = self._done
        while not self._lock.acquire(timeout=PATIENCE_S):
            self._outage.require_over()
            if done == self._done:
                self._outage.begin()
                self._outage.require_over()
            done = self._done
        try:
            self._outage.require_over()
            yield
        finally:
            self._done += 1
            self._lock.release()


class Database:
    """Connections to one database; every access is one transaction.

    Where the database itself is at fault, full, locked or away, either way raises
    StoreUnavailable, within two seconds.

    looks_for_answer: how often `answer` looks before it leaves a server that says nothing.
    revision: of the tables this program knows, once they are up to date: then it writes to no
    others.  when_outdated: called when it would have, from any thread and more than once.
    """

    def __init__(self, url: URL) -> None:
        self.url = url
        self.looks_for_answer = _LOOKS_FOR_ANSWER
        self.revision: str | None = None
        self.when_outdated: Callable[[], None] = lambda: None
        self._engine = _engine(url)
        self._readers, self._writers = Outage(), Outage()
        self._write_lock: WriteLock | None = None
        self._damages = 0
        if url.drivername == "sqlite":
            self._write_lock = WriteLock(self._writers)
            event.listen(self._engine, "checkout", self._read_anew_after_damage)

    async def answer(self, asking: Callable[..., T], *arguments: object) -> T:
        """What `asking` returns, which reads or writes, in a thread; raises StoreUnavailable.

        A thread is left to a server that falls silent, until that answers or is gone.
        """
        if self._write_lock is not None:  # no server
            return await to_thread.run_sync(asking, *arguments)
        async with to_thread.current_default_thread_limiter():
            its_own = anyio.CapacityLimiter(1)
            asked = asyncio.ensure_future(
                to_thread.run_sync(asking, *arguments, abandon_on_cancel=True, limiter=its_own)
            )
            try:
                for _ in range(self.looks_for_answer):
                    await asyncio.wait((asked,), timeout=_LOOK_FOR_ANSWER_S)
                    if asked.done():
                        return asked.result()
            finally:
                asked.cancel()
        self._readers.begin()
        self._writers.begin()
        raise StoreUnavailable("the database doesn't answer; ask again later")

    @contextmanager
    def reading(self) -> Iterator[Connection]:
        """A transaction that sees one state of the data."""
        with (
            self._raise_outages(self._readers),
            self._engine.connect() as connection,
            connection.begin(),
        ):
            yield connection

    @contextmanager
    def writing(self, *, lasting: bool = True) -> Iterator[Connection]:
        """A transaction that may change data; SQLite lets one in at a time.

        lasting: whether it outlives a power failure; one of the service it does either way.
        """
        with self._writer(lasting) as connection:
            if self.revision is not None:
                self._require_revision(connection)
            yield connection

    def _require_revision(self, connection: Connection) -> None:
        """Nobody migrates the tables until the transaction ends; raises StoreUnavailable."""
        if connection.dialect.name == "postgresql":  # SQLite lets one write at a time
            connection.exec_driver_sql(f"SELECT pg_advisory_xact_lock_shared({MIGRATION_LOCK})")
        found = connection.exec_driver_sql("SELECT version_num FROM alembic_version").scalar()
        if found != self.revision:
            self.when_outdated()
            raise StoreUnavailable(OUTDATED)

    def migrating(self) -> AbstractContextManager[Connection]:
        """As `writing`, for what makes the tables that `writing` looks into."""
        return self._writer(lasting=True)

    @contextmanager
    def _writer(self, lasting: bool) -> Iterator[Connection]:
        lock = self._write_lock
        with (
            self._raise_outages(self._writers),
            # Before a connection is taken, so that writers who wait leave some to readers.
            nullcontext() if lock is None else lock.hold(),
            self._engine.connect().execution_options(
                **{_WRITES: "FULL" if lasting else "NORMAL"}
            ) as connection,
            connection.begin(),
        ):
            yield connection

    @property
    def name(self) -> str:
        """What an operator knows it by: its file, or the setting that names it."""
        is_file = self.url.drivername == "sqlite"
        return str(self.url.database) if is_file else "SLEWTRACK_DATABASE_URL"

    def require_writable(self) -> None:
        """Write as much as a plan takes and remove it; raises StoreUnavailable.

        In a transaction each, so that it gets to the disk: a full one is read without complaint.
        """
        probe_id, now_utc = new_id(), datetime.now(UTC)
        # Random, as what compresses would need no room.
        values = {"id": probe_id, "at_utc": now_utc, "content": os.urandom(_PROBE_BYTES)}
        with self.writing() as connection:
            connection.execute(insert(ProbeRow).values(values))
        forgotten = ProbeRow.at_utc < now_utc - _PROBE_FORGOTTEN
        with self.writing() as connection:
            connection.execute(delete(ProbeRow).where(or_(ProbeRow.id == probe_id, forgotten)))

    @contextmanager
    def _raise_outages(self, outage: Outage) -> Iterator[None]:
        """Failures of the database from bugs in what it was asked."""
        outage.require_over()
        try:
            yield
        except (SQLAlchemyError, sqlite3.Error) as error:
            if not is_of_the_store(error):
                raise
            if keeps_all_waiting(error):
                outage.begin()
            # A connection may go on seeing what the file held when it was damaged.
            self._damages += is_damage(error) or _sqlite_code(error) == sqlite3.SQLITE_IOERR
            if is_damage(error):
                log.error("the database is damaged", error=error)
                raise StoreDamaged from error
            log.warning("the database can't be used", error=error)
            raise StoreUnavailable(
                "the database can't be read or written now; ask again later"
            ) from error

    def _read_anew_after_damage(
        self, connection: DBAPIConnection, record: ConnectionPoolEntry, _: object
    ) -> None:
        """A connection keeps pages of a damaged file until somebody writes.

        To close it instead would copy its log of changes into that file, and delete the log.
        """
        if record.info.get("damages", 0) != self._damages:
            connection.cursor().execute("PRAGMA shrink_memory")
            record.info["damages"] = self._damages

    def close(self) -> None:
        self._engine.dispose()


def open_database(database_url: str, data_dir: Path) -> Database:
    """By its URL; without one the file in `data_dir`, which is made.

    Raises InvalidInput for a URL we can't use.
    """
    if not database_url:
        data_dir.mkdir(mode=0o700, parents=True, exist_ok=True)
        file = data_dir / FILE
        _keep_to_owner(file)
        return Database(URL.create("sqlite", database=str(file)))
    try:
        url = make_url(database_url)
    except (ArgumentError, ValueError):
        url = None
    if url is None or url.drivername not in DRIVERS:
        raise InvalidInput(
            "must be postgresql+psycopg://USER:PASSWORD@HOST/NAME or sqlite:///FILE",
            field="SLEWTRACK_DATABASE_URL",
        )
    if url.drivername == "sqlite" and url.database and url.database != ":memory:":
        _keep_to_owner(Path(url.database))
    return Database(url)


def _keep_to_owner(file: Path) -> None:
    """It holds plans and digests of keys; SQLite gives the files beside it the same mode."""
    os.close(os.open(file, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, _OWNER_ONLY))
    for name in (file.name, f"{file.name}-wal", f"{file.name}-shm"):
        beside = file.with_name(name)
        if beside.exists() and beside.stat().st_mode & 0o077:
            beside.chmod(_OWNER_ONLY)


def _engine(url: URL) -> Engine:
    is_file = url.drivername == "sqlite"
    to_file = {"timeout": PATIENCE_S, "check_same_thread": False}
    to_server = {
        "client_encoding": "utf8",  # else a database made as SQL_ASCII answers in bytes
        "connect_timeout": 2,  # psycopg's least
        # One that is gone is noticed, also by who only waits for its answer.
        "tcp_user_timeout": int(PATIENCE_S * 1e3),
        "keepalives_idle": 2,
        "keepalives_interval": 1,
        "options": f"-c lock_timeout={PATIENCE_S * 1e3:.0f}",
    }
    engine = create_engine(
        url,
        pool_size=_POOLED,
        max_overflow=_POOLED_MORE,
        pool_timeout=PATIENCE_S,
        pool_pre_ping=not is_file,
        hide_parameters=True,
        connect_args=to_file if is_file else to_server,
    )
    if is_file:
        event.listen(engine, "connect", _set_up_sqlite)
        event.listen(engine, "begin", _begin_sqlite)
    return engine


def _set_up_sqlite(connection: DBAPIConnection, _: ConnectionPoolEntry) -> None:
    connection.isolation_level = None  # transactions begin as `_begin_sqlite` says
    cursor = connection.cursor()
    for pragma in ("journal_mode=WAL", "foreign_keys=ON"):
        cursor.execute(f"PRAGMA {pragma}")
    cursor.close()


def _begin_sqlite(connection: Connection) -> None:
    synchronous = connection.get_execution_options().get(_WRITES)
    if synchronous is None:
        connection.exec_driver_sql("BEGIN")
        return
    # A reader that turns writer can fail at once when another wrote in between.
    driver = connection.connection.driver_connection
    assert isinstance(driver, sqlite3.Connection)
    until_s = time.monotonic() + PATIENCE_S
    driver.execute(f"PRAGMA synchronous={synchronous}")
    driver.execute("PRAGMA busy_timeout=0")
    try:
        while not _began(driver, until_s):
            time.sleep(random.uniform(0.5, 1.5) * _LOOK_S)  # noqa: S311 (no secret)
    finally:
        driver.execute(f"PRAGMA busy_timeout={PATIENCE_S * 1e3:.0f}")


def _began(driver: sqlite3.Connection, until_s: float) -> bool:
    try:
        driver.execute("BEGIN IMMEDIATE")
    except sqlite3.OperationalError as error:
        if error.sqlite_errorcode & 0xFF != sqlite3.SQLITE_BUSY or time.monotonic() > until_s:
            raise
        return False
    return True


def is_of_the_store(error: Exception) -> bool:
    """Whether the database, not what was asked of it, is at fault."""
    if isinstance(error, NoConnectionFree):
        return True
    cause = _cause(error)
    if isinstance(cause, sqlite3.Error):
        return _sqlite_code(error) in _SQLITE
    if isinstance(error, DBAPIError):
        sqlstate: str | None = getattr(cause, "sqlstate", None)
        if sqlstate is None:  # never reached, or lost
            # Of psycopg's, ConnectionTimeout is one, too.
            return error.connection_invalidated or isinstance(error, OperationalError)
        return sqlstate.startswith(_SQLSTATES)
    return False


def keeps_all_waiting(error: Exception) -> bool:
    """Whether others who try now would wait in vain, too."""
    cause = _cause(error)
    if isinstance(cause, sqlite3.Error):
        return _sqlite_code(error) == sqlite3.SQLITE_BUSY
    return isinstance(error, SQLAlchemyError) and getattr(cause, "sqlstate", None) is None


def is_damage(error: Exception) -> bool:
    """Whether what is stored is no longer what was stored, so that waiting doesn't help."""
    damage = (sqlite3.SQLITE_NOTADB, sqlite3.SQLITE_CORRUPT)
    return _sqlite_code(error) in damage or getattr(_cause(error), "sqlstate", None) in _CORRUPTED


def _sqlite_code(error: Exception) -> int:
    """Python's own complaints, of a connection that was closed, say, have none."""
    code: int = getattr(_cause(error), "sqlite_errorcode", sqlite3.SQLITE_OK)
    return code & 0xFF


def _cause(error: Exception) -> BaseException | None:
    """The driver's own error."""
    return error.orig if isinstance(error, DBAPIError) else error
