"""Brings a database to the tables this version needs."""

import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from sqlalchemy import Connection, inspect, text
from sqlalchemy.exc import ProgrammingError

from app.log.exceptions import reason
from app.store.database import MIGRATION_LOCK, Database, open_database
from app.store.unavailable import StoreUnavailable
from planner.base.errors import InvalidInput

_FOLDER = Path(__file__).parent / "migrations"
_OTHERS_S = 30.0  # how long others that start may take to migrate
_PAUSE_S = 0.2


@contextmanager
def open_migrated(database_url: str, data_dir: Path) -> Iterator[Database]:
    """As `open_database` does, up to date, and closed at the end."""
    database = open_database(database_url, data_dir)
    try:
        upgrade(database)
        yield database
    finally:
        database.close()


def upgrade(database: Database) -> None:
    """Bring it up to date; services that start together do so one after the other.

    Raises InvalidInput for a database of another version, or that doesn't answer.
    """
    until_s = time.monotonic() + _OTHERS_S
    while True:
        try:
            with database.migrating() as connection:
                if connection.dialect.name == "postgresql":
                    connection.execute(text(f"SET LOCAL lock_timeout = '{_OTHERS_S:.0f}s'"))
                    connection.execute(
                        text("SELECT pg_advisory_xact_lock(:lock)"), {"lock": MIGRATION_LOCK}
                    )
                present, head = _revision(connection), _head()
                if present != head:
                    _migrate(connection, present, head)
                database.revision = head
        except StoreUnavailable as error:
            # Locked by another that starts, say; without a cause, it was just now.
            locked = not error.__cause__ or reason(error.__cause__).startswith("SQLITE_BUSY")
            if not locked or time.monotonic() > until_s:
                raise _unusable(database, error.__cause__ or error) from error
            time.sleep(_PAUSE_S)
        except ProgrammingError as error:
            if getattr(error.orig, "sqlstate", None) is not None:
                raise
            raise _unusable(database, error) from error  # the URL has what libpq doesn't know
        else:
            return


def _unusable(database: Database, error: BaseException) -> InvalidInput:
    why = reason(error) or "does its server run, and are host, user and password right?"
    return InvalidInput(f"the database can't be used: {why}", field=database.name)


def _revision(connection: Connection) -> str | None:
    """What the database is of; None before it has any tables."""
    if not inspect(connection).has_table("alembic_version"):
        return None
    return connection.execute(text("SELECT version_num FROM alembic_version")).scalar()


def _head() -> str:
    """The newest revision, which its file is named by: `m0001_first.py` makes 1."""
    return str(max(int(file.name[1:5]) for file in (_FOLDER / "versions").glob("m*_*.py")))


def _migrate(connection: Connection, present: str | None, head: str) -> None:
    """Raises InvalidInput for what is of a revision that isn't known here."""
    # A tenth of a second, which only starts that change the tables wait for.
    from alembic import command
    from alembic.config import Config
    from alembic.script import ScriptDirectory

    config = Config(attributes={"connection": connection})
    config.set_main_option("script_location", str(_FOLDER).replace("%", "%%"))
    known = {script.revision for script in ScriptDirectory.from_config(config).walk_revisions()}
    if present is not None and present not in known:
        raise InvalidInput(
            f"the database is of revision {present!r}, which this version of slewtrack doesn't "
            f"know: it knows up to {head!r}. A later version wrote it, or one from before the "
            "first release; install that one, or use another database",
            field="SLEWTRACK_DATABASE_URL",
        )
    command.upgrade(config, head)
