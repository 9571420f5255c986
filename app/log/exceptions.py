"""The part of an exception that may be logged: its type, its place, a reason in known words.

Never its message nor the values of variables: they may hold a request, a key or a password.
"""

import os
import traceback
from collections.abc import Iterator
from types import TracebackType

_CHAIN_MAX = 8
_FRAMES_MAX = 40  # of each exception, the outermost and the innermost half
# What SQLite, libpq and PostgreSQL say that holds no name, no address and no value.
_WORDS = (
    "database is locked",
    "database table is locked",
    "database or disk is full",
    "attempt to write a readonly database",
    "unable to open database file",
    "file is not a database",
    "database disk image is malformed",
    "disk I/O error",
    "invalid connection option",
    "connection refused",
    "connection timeout expired",
    "timeout expired",
    "password authentication failed",
    "no password supplied",
    "no pg_hba.conf entry",
    "does not exist",
    "could not translate host name",
    "name or service not known",
    "failed to resolve host",
    "network is unreachable",
    "no such file or directory",
    "server closed the connection unexpectedly",
    "the connection is lost",
    "the database system is",
    "remaining connection slots are reserved",
    "too many clients already",
    "terminating connection",
    "the connection is closed",
)


def reason(error: BaseException) -> str:
    """Why, in words that hold nothing of what was asked; empty where there are none such.

    An exception of ours whose message is safe says so by `tells_no_secret`.
    """
    if getattr(error, "tells_no_secret", False):
        return str(error)
    if isinstance(error, OSError) and error.errno is not None:
        return os.strerror(error.errno)
    cause = getattr(error, "orig", None) or error  # SQLAlchemy's, of the driver's
    codes = (getattr(cause, name, None) for name in ("sqlite_errorname", "sqlstate"))
    code = next((code for code in codes if code), "")
    text = str(cause).lower() if type(cause).__module__.startswith(("sqlite3", "psycopg")) else ""
    words = next((words for words in _WORDS if words.lower() in text), "")
    return ", ".join(part for part in (code, words) if part)


def describe_error(error: BaseException) -> str:
    """Type and reason."""
    kind = type(error)
    name = kind.__name__ if kind.__module__ == "builtins" else f"{kind.__module__}.{kind.__name__}"
    why = reason(error)
    return f"{name}: {why}" if why else name


def traceback_text(error: BaseException) -> str:
    """The exception and what it came of, each with the places it went through."""
    return "\n".join(_lines(error))


def _lines(error: BaseException) -> Iterator[str]:
    seen_ids: list[int] = []
    link = ""
    following: BaseException | None = error
    while following is not None and id(following) not in seen_ids and len(seen_ids) < _CHAIN_MAX:
        seen_ids.append(id(following))
        yield link + describe_error(following)
        yield from _places(following.__traceback__)
        if isinstance(following, BaseExceptionGroup):
            for part in following.exceptions[:_CHAIN_MAX]:
                yield from (f"  {line}" for line in _lines(part))
        link = "caused by " if following.__cause__ is not None else "while handling "
        hidden = following.__suppress_context__
        following = following.__cause__ or (None if hidden else following.__context__)


def _places(trace: TracebackType | None) -> Iterator[str]:
    places = [
        f"  {frame.f_code.co_filename}:{line} {frame.f_code.co_qualname}"
        for frame, line in traceback.walk_tb(trace)
    ]
    half = _FRAMES_MAX // 2
    if len(places) > _FRAMES_MAX:
        places[half:-half] = [f"  ({len(places) - _FRAMES_MAX} more)"]
    yield from places
