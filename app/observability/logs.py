"""What does the service write to its log, and in which form?

Every record, uvicorn's too, goes to stderr as one JSON object or one line a line.
"""

import logging
import sys
from typing import Any, Literal

import structlog

LogFormat = Literal["json", "console"]
LogLevel = Literal["debug", "info", "warning", "error"]

# Bound to the standard library's logger, so that whoever embeds us keeps control of the output.
log: structlog.stdlib.BoundLogger = structlog.wrap_logger(
    logging.getLogger("slewtrack"),
    processors=[
        structlog.contextvars.merge_contextvars,
        structlog.stdlib.render_to_log_kwargs,
    ],
    wrapper_class=structlog.stdlib.BoundLogger,
)


def configure_logs(level: LogLevel, log_format: LogFormat) -> None:
    """Send all records from `level` on to stderr."""
    shared: list[Any] = [
        structlog.stdlib.add_log_level,
        structlog.stdlib.add_logger_name,
        structlog.stdlib.ExtraAdder(),
        structlog.processors.TimeStamper(fmt="iso", utc=True),
        _without_colours,
    ]
    last: list[Any] = [structlog.stdlib.ProcessorFormatter.remove_processors_meta]
    if log_format == "json":
        last += [structlog.processors.dict_tracebacks, structlog.processors.JSONRenderer()]
    else:
        last += [structlog.dev.ConsoleRenderer(colors=False)]
    handler = logging.StreamHandler(sys.stderr)
    handler.setFormatter(
        structlog.stdlib.ProcessorFormatter(foreign_pre_chain=shared, processors=last)
    )
    root = logging.getLogger()
    root.handlers = [handler]
    root.setLevel(level.upper())
    for name in ("uvicorn", "uvicorn.error"):
        logging.getLogger(name).handlers = []
        logging.getLogger(name).propagate = True


def _without_colours(_: object, __: str, record: dict[str, Any]) -> dict[str, Any]:
    """Uvicorn says some things twice, the second time in colour."""
    record.pop("color_message", None)
    return record
