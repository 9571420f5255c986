"""Allowed fields of a log record: nothing that can be a secret, a body or a query.

Made where all records are made, so that no handler and no call, of ours or a library, tells more.
"""

import logging
import sys
import threading
import time
from collections.abc import Mapping
from types import TracebackType
from typing import Any

from app.log.exceptions import describe_error, traceback_text

OURS = "slewtrack"
WITHHELD = "text withheld, it may hold what nobody should read"
_STACK_MAX = 20
# They say which addresses are listened on, and which migrations run.
_PLAIN_INFORMERS = ("uvicorn.error", "alembic.runtime.migration")
# Its default handler joins these with reprs of what it was at.
_ASYNCIO = (
    "Task exception was never retrieved",
    "Future exception was never retrieved",
    "Task was destroyed but it is pending!",
    "socket.accept() out of system resource",
    "Exception in callback",
    "Fatal read error on socket transport",
    "Fatal write error on socket transport",
)

_ExcInfo = (
    tuple[type[BaseException], BaseException, TracebackType | None] | tuple[None, None, None] | None
)


class SafeRecord(logging.LogRecord):
    """Of an exception it holds the places and types; of a library's text, literals and numbers."""

    def __init__(  # noqa: PLR0913, RUF100 (logging's own signature)
        self,
        name: str,
        level: int,
        pathname: str,
        lineno: int,
        msg: object,
        args: Any,  # noqa: ANN401 (logging's own signature)
        exc_info: _ExcInfo,
        func: str | None = None,
        sinfo: str | None = None,
        **_: Any,  # noqa: ANN401 (logging's own signature)
    ) -> None:
        foreign = bool(name) and name != OURS
        if foreign and not (name in _PLAIN_INFORMERS and level <= logging.INFO):
            msg = _literal(name, msg)
            args = () if msg == WITHHELD else _numbers(args)
        super().__init__(name, level, pathname, lineno, msg, args, None, func, sinfo)
        if foreign and level >= logging.WARNING:
            self.at = f"{pathname}:{lineno} {func}"
        if exc_info and exc_info[1] is not None:
            self.exception = self.exc_text = traceback_text(exc_info[1])


def _literal(logger: str, msg: object) -> str:
    """The text when it stands in the code that logs it, so that it is made of no data."""
    if isinstance(msg, BaseException):
        return describe_error(msg)
    if not isinstance(msg, str):
        return WITHHELD
    if logger == "asyncio":
        known = (text for text in _ASYNCIO if msg.startswith(text))
        return next(known, WITHHELD)
    frame = sys._getframe(2)
    for _ in range(_STACK_MAX):
        if msg in frame.f_code.co_consts:
            return msg
        if frame.f_back is None:
            break
        frame = frame.f_back
    return WITHHELD


def _numbers(args: Any) -> Any:  # noqa: ANN401 (logging's own)
    if isinstance(args, Mapping):
        return {name: _number(value) for name, value in args.items()}
    return tuple(_number(value) for value in args or ())


def _number(value: object) -> object:
    if isinstance(value, BaseException):
        return describe_error(value)
    return value if isinstance(value, int | float) else "..."


def keep_loggable(_: object, __: str, event: dict[str, Any]) -> dict[str, Any]:
    """What comes with a record: plain values of ours, exceptions as they may be told."""
    foreign = event.get("logger") != OURS
    for name, value in tuple(event.items()):
        if isinstance(value, BaseException):
            event[name] = describe_error(value)
        elif name.startswith("_"):  # structlog's own, which doesn't get out
            continue
        elif foreign and name not in _FROM_US:
            del event[name]
        elif not isinstance(value, str | int | float | None):
            event[name] = f"<{type(value).__name__}>"
    return event


_FROM_US = frozenset({"event", "level", "logger", "timestamp", "at", "exception", "left_out"})


class OneASecond(logging.Filter):
    """Of warnings and errors of one kind one a second; the next tells how many were left out."""

    def __init__(self) -> None:
        super().__init__()
        self._lock = threading.Lock()
        self._last_s: dict[tuple[object, ...], float] = {}
        self._left_out: dict[tuple[object, ...], int] = {}

    def filter(self, record: logging.LogRecord) -> bool:
        """False for what is left out."""
        if record.levelno < logging.WARNING:
            return True
        kind = (record.name, record.levelno, record.pathname, record.lineno, record.msg)
        now_s = time.monotonic()
        with self._lock:
            if now_s - self._last_s.get(kind, -1.0) < 1.0:
                self._left_out[kind] = self._left_out.get(kind, 0) + 1
                return False
            self._last_s[kind] = now_s
            left_out = self._left_out.pop(kind, 0)
        if left_out:
            record.left_out = left_out
        return True
