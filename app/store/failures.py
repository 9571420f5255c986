"""Failures of a database that are of its state, full, locked or away, and no bugs of ours."""

import sqlite3

from sqlalchemy.exc import DBAPIError, OperationalError, SQLAlchemyError
from sqlalchemy.exc import TimeoutError as NoConnectionFree

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


def is_of_the_store(error: Exception) -> bool:
    """Whether the database, not what was asked of it, is at fault."""
    if isinstance(error, NoConnectionFree):
        return True
    cause = _cause(error)
    if isinstance(cause, sqlite3.Error):
        # Python's own complaints, of a connection that was closed, say, have no code.
        code = getattr(cause, "sqlite_errorcode", None)
        return code is not None and code & 0xFF in _SQLITE
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
        return getattr(cause, "sqlite_errorcode", 0) & 0xFF == sqlite3.SQLITE_BUSY
    return isinstance(error, SQLAlchemyError) and getattr(cause, "sqlstate", None) is None


def is_damage(error: Exception) -> bool:
    """Whether what is stored is no longer what was stored, so that waiting doesn't help."""
    cause = _cause(error)
    code = getattr(cause, "sqlite_errorcode", 0) & 0xFF
    sqlstate = getattr(cause, "sqlstate", None)
    return code in (sqlite3.SQLITE_NOTADB, sqlite3.SQLITE_CORRUPT) or sqlstate in _CORRUPTED


def may_leave_stale_pages(error: Exception) -> bool:
    """Whether a connection may go on seeing what the file held when it was damaged."""
    code = getattr(_cause(error), "sqlite_errorcode", 0) & 0xFF
    return is_damage(error) or code == sqlite3.SQLITE_IOERR


def _cause(error: Exception) -> BaseException | None:
    """The driver's own error."""
    return error.orig if isinstance(error, DBAPIError) else error
