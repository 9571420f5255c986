"""The part of an exception that may be logged: its type, its place, a reason in known words.

Never its message nor the values of variables: they may hold a request, a key or a password.
"""

import os
import traceback
from collections.abc import Iterator
from types import TracebackType

_CHAIN_MAX = 8
_FRAMES_MAX = 40  # of each exception, the outermost and the innermost half


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
    return next((str(code) for code in codes if code), "")


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
