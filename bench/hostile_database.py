"""Databases that fail under a running service, and what it must answer meanwhile."""

import os
import resource
import sqlite3
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager

from hostile_siege import BODY, QUERY, Siege, Toll
from sqlalchemy import create_engine, text

from app.requests.examples.plan import LAS_VEGAS

_FAILS_S = 5.0
_LOOK_S = 1.0  # /readyz looks every 5 s

Fault = Callable[[Siege], AbstractContextManager[None]]


@contextmanager
def _sqlite_locked(siege: Siege) -> Iterator[None]:
    holder = sqlite3.connect(siege.folder / "slewtrack.sqlite3", isolation_level=None)
    holder.execute("BEGIN EXCLUSIVE")
    try:
        yield
    finally:
        holder.close()


@contextmanager
def _sqlite_full(siege: Siege) -> Iterator[None]:
    """No file of the service grows any more."""
    pid = siege.process.pid
    before = resource.prlimit(pid, resource.RLIMIT_FSIZE)
    resource.prlimit(pid, resource.RLIMIT_FSIZE, (0, before[1]))
    try:
        yield
    finally:
        resource.prlimit(pid, resource.RLIMIT_FSIZE, before)


@contextmanager
def _sqlite_corrupt(siege: Siege) -> Iterator[None]:
    path = siege.folder / "slewtrack.sqlite3"
    other = sqlite3.connect(path)
    other.execute("PRAGMA wal_checkpoint(TRUNCATE)")
    other.close()
    whole = path.read_bytes()
    with path.open("r+b") as file:
        file.write(os.urandom(len(whole)))
    yield


@contextmanager
def _postgresql_locked(siege: Siege) -> Iterator[None]:
    engine = create_engine(siege.database.direct_url)
    with engine.connect() as connection, connection.begin():
        tables = connection.scalars(
            text("SELECT tablename FROM pg_tables WHERE schemaname = 'public'")
        ).all()
        connection.execute(text(f"LOCK TABLE {', '.join(tables)} IN ACCESS EXCLUSIVE MODE"))
        yield
    engine.dispose()


@contextmanager
def _postgresql_full(siege: Siege) -> Iterator[None]:
    """Each insert and update fails as on a disk without room (SQLSTATE 53100)."""
    engine = create_engine(siege.database.direct_url, isolation_level="AUTOCOMMIT")
    with engine.connect() as connection:
        connection.execute(text(
            "CREATE FUNCTION no_room() RETURNS trigger LANGUAGE plpgsql AS $$ BEGIN RAISE "
            "EXCEPTION 'could not extend file: No space left' USING ERRCODE = '53100'; END $$"
        ))  # fmt: skip
        tables = connection.scalars(
            text("SELECT tablename FROM pg_tables WHERE schemaname = 'public'")
        ).all()
        for table in tables:
            connection.execute(text(
                f"CREATE TRIGGER no_room BEFORE INSERT OR UPDATE ON {table} "
                "FOR EACH STATEMENT EXECUTE FUNCTION no_room()"
            ))  # fmt: skip
        yield
        connection.execute(text("DROP FUNCTION no_room CASCADE"))
    engine.dispose()


@contextmanager
def _postgresql_down(siege: Siege) -> Iterator[None]:
    relay = siege.database.relay
    assert relay is not None
    relay.refuses = True
    relay.hang_up()
    yield
    relay.refuses = False


@contextmanager
def _postgresql_silent(siege: Siege) -> Iterator[None]:
    """As when a network is cut: nothing comes back, not even a refusal."""
    relay = siege.database.relay
    assert relay is not None
    relay.is_silent = True
    yield
    relay.is_silent = False


def _attack(fault: Fault, *, reads_work: bool, heals: bool = True) -> Callable[[Siege], Toll]:
    def attack(siege: Siege) -> Toll:
        toll = Toll()
        plan = LAS_VEGAS | {"name": BODY}
        kept = siege.post("/v1/plans", plan, toll).json()["id"]
        with fault(siege):
            until_s = time.monotonic() + _FAILS_S
            while time.monotonic() < until_s:
                refused = siege.post("/v1/plans", plan, toll, may_fail=True)
                read = siege.get(f"/v1/plans?name={QUERY}", toll, may_fail=True)
                siege.get(f"/v1/plans/{kept}", toll, may_fail=True)
                siege.ask("DELETE", "/v1/plans/nothing", toll, may_fail=True)
                toll.require(refused, 503)
                toll.require(read, *((200, 503) if reads_work else (503,)))
            time.sleep(max(until_s + _LOOK_S - time.monotonic(), 0.0))
            toll.require(siege.get("/readyz", toll, may_fail=True), 503)
        if heals:
            _require_recovery(siege, toll, plan)
        return toll

    return attack


def _require_recovery(siege: Siege, toll: Toll, plan: object) -> None:
    until_s = time.monotonic() + 60.0
    while time.monotonic() < until_s:
        if siege.post("/v1/plans", plan, Toll(), may_fail=True).status_code in (201, 202):
            siege.wait_for_jobs()
            return
        time.sleep(0.5)
    toll.complain("60 s after the database works again no plan is accepted")


DATABASES: dict[str, dict[str, Callable[[Siege], Toll]]] = {
    "sqlite": {
        "locked": _attack(_sqlite_locked, reads_work=True),
        "full": _attack(_sqlite_full, reads_work=True),
        "corrupt": _attack(_sqlite_corrupt, reads_work=True, heals=False),
    },
    "postgresql": {
        "locked": _attack(_postgresql_locked, reads_work=False),
        "full": _attack(_postgresql_full, reads_work=True),
        "down": _attack(_postgresql_down, reads_work=False),
        "silent": _attack(_postgresql_silent, reads_work=False),
    },
}
