"""Allowed fields of a log record: nothing that can be a secret, a body or a query.

Made where all records are made, so that no handler and no call, of ours or a library, tells more.
"""

import logging
import threading
import time
from types import TracebackType
from typing import Any

from app.log.exceptions import describe_error, traceback_text

OURS = "slewtrack"
WITHHELD = "text withheld, it may hold what nobody should read"
# They say which addresses are listened on, and which migrations run.
_PLAIN_INFORMERS = ("uvicorn.error", "alembic.runtime.migration")
_ExcInfo = (
    tuple[type[BaseException], BaseException, TracebackType | None] | tuple[None, None, None] | None
)


class SafeRecord(logging.LogRecord):
    """Of an exception it holds the places and types; of a library's record, where it was made."""

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
            msg, args = describe_error(msg) if isinstance(msg, BaseException) else WITHHELD, ()
        super().__init__(name, level, pathname, lineno, msg, args, None, func, sinfo)
        if foreign and level >= logging.WARNING:
            self.at = f"{pathname}:{lineno} {func}"
        if exc_info and exc_info[1] is not None:
            self.exception = self.exc_text = traceback_text(exc_info[1])


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
        where = (record.name, record.levelno, record.pathname, record.lineno)
        kind = (*where, record.msg, getattr(record, "exception", None))
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
