"""The store of tests: SQLite, or PostgreSQL where SLEWTRACK_TEST_DATABASE_URL says."""

import os
import sqlite3
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from sqlalchemy import create_engine, make_url, text

from app.settings import Settings
from app.store.database import Database, open_database
from app.store.migrate import upgrade

SERVER = os.environ.get("SLEWTRACK_TEST_DATABASE_URL", "")


def own_postgresql(name: str) -> str:
    """URL of a new database of this name on the server for tests; empty where there is none."""
    if not SERVER:
        return ""
    own = f"slewtrack_test_{name}"
    engine = create_engine(SERVER, isolation_level="AUTOCOMMIT")
    with engine.connect() as connection:
        connection.execute(text(f"DROP DATABASE IF EXISTS {own} WITH (FORCE)"))
        connection.execute(text(f"CREATE DATABASE {own}"))
    engine.dispose()
    return make_url(SERVER).set(database=own).render_as_string(hide_password=False)


def own_settings(folder: Path, **given: Any) -> Settings:
    """Of a service whose data nobody shares: another on its database would take up its jobs."""
    return Settings(data_dir=folder, database_url=own_postgresql(uuid.uuid4().hex), **given)


@contextmanager
def empty_database(folder: Path) -> Iterator[Database]:
    """A database of its own without tables."""
    url = own_postgresql(uuid.uuid4().hex)
    database = open_database(url, folder)
    try:
        yield database
    finally:
        database.close()


@contextmanager
def fresh_database(folder: Path) -> Iterator[Database]:
    """A database of its own with all tables, empty."""
    with empty_database(folder) as database:
        upgrade(database)
        yield database


def damage(file: Path) -> None:
    """Overwrites what SQLite asks for the next job, and the probe; nobody may have it open."""
    with sqlite3.connect(file) as other:
        other.execute("PRAGMA wal_checkpoint(TRUNCATE)")
        page_bytes = other.execute("PRAGMA page_size").fetchone()[0]
        roots = dict(other.execute("SELECT name, rootpage FROM sqlite_master").fetchall())
    other.close()
    with file.open("r+b") as opened:
        for name in ("ix_jobs_state_rank_id", "probes"):
            opened.seek((roots[name] - 1) * page_bytes)
            opened.write(b"\xa5" * page_bytes)
