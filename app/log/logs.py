"""The service's log: its records and their form.

Every record, libraries' too, goes to stderr as one JSON object or one line; on the console the
places an exception went through follow it.
"""

import json
import logging
import sys
import threading
import time
import warnings
from types import TracebackType
from typing import Any, Literal, TextIO

import structlog

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


LogFormat = Literal["json", "console"]
LogLevel = Literal["debug", "info", "warning", "error"]

# Bound to the standard library's logger, so that whoever embeds us keeps control of the output.
log: structlog.stdlib.BoundLogger = structlog.wrap_logger(
    logging.getLogger(OURS),
    processors=[
        structlog.contextvars.merge_contextvars,
        structlog.stdlib.render_to_log_kwargs,
    ],
    wrapper_class=structlog.stdlib.BoundLogger,
)

# Commands say in one line of their own what is wrong, and Python would write ours below it.
logging.getLogger(OURS).addHandler(logging.NullHandler())


def configure_logs(level: LogLevel, log_format: LogFormat) -> None:
    """Send all records from `level` on to stderr, and nothing around them."""
    logging.setLogRecordFactory(SafeRecord)
    shared: list[Any] = [
        structlog.stdlib.add_log_level,
        structlog.stdlib.add_logger_name,
        structlog.stdlib.ExtraAdder(),
        structlog.processors.TimeStamper(fmt="iso", utc=True),
        keep_loggable,
    ]
    last: list[Any] = [structlog.stdlib.ProcessorFormatter.remove_processors_meta]
    if log_format == "json":
        # Without structlog's way with other objects, their repr.
        strict = structlog.processors.JSONRenderer(serializer=lambda event, **_: json.dumps(event))
        last.append(strict)
    else:
        last.append(structlog.dev.ConsoleRenderer(colors=False))
    handler = _Handler(sys.stderr)
    handler.addFilter(OneASecond())
    handler.setFormatter(
        structlog.stdlib.ProcessorFormatter(foreign_pre_chain=shared, processors=last)
    )
    handler.setLevel(level.upper())  # for loggers with a level of their own, too
    root = logging.getLogger()
    root.handlers = [handler]
    root.setLevel(level.upper())
    for logger in logging.getLogger().manager.loggerDict.values():
        if isinstance(logger, logging.Logger):  # with handlers of its own, as Dask's have
            logger.handlers = []
            logger.propagate = True
    # Of its doings, values withheld, little is left.
    logging.getLogger("distributed").setLevel("INFO" if level == "debug" else "WARNING")
    sys.excepthook = lambda _, error, __: _log_uncaught(error)
    threading.excepthook = lambda what: _log_uncaught(what.exc_value)
    sys.unraisablehook = lambda what: _log_uncaught(what.exc_value)
    warnings.showwarning = _log_warning


class _Handler(logging.StreamHandler[TextIO]):
    """Tells where a record came from that can't be formatted, not what was in it."""

    _UNTELLABLE = "a record can't be written"

    def handleError(self, record: logging.LogRecord) -> None:  # noqa: N802 (logging's own)
        if record.msg == self._UNTELLABLE:
            return  # nothing can: stderr is closed
        where = (record.pathname, record.lineno)
        self.emit(SafeRecord(OURS, logging.ERROR, *where, self._UNTELLABLE, (), sys.exc_info()))


def _log_uncaught(error: BaseException | None) -> None:
    if error is not None and not isinstance(error, KeyboardInterrupt | SystemExit):
        log.critical("uncaught", exc_info=error)


def _log_warning(
    message: Warning | str,
    category: type[Warning],
    filename: str,
    lineno: int,
    *_: object,
    **__: object,
) -> None:
    kind = describe_error(message) if isinstance(message, Warning) else category.__name__
    log.warning("a warning of Python's", kind=kind, file=filename, line=lineno)
