"""The one who answers a command's questions: this process, or a running service."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from app.cli.local import Local
    from app.cli.service import TellingClient

Members = Mapping[str, Any]
OnProgress = Callable[[Any], None]  # told of stage, done and of, where these are known


@contextmanager
def planner_at(url: str | None) -> "Iterator[Local | TellingClient]":
    """The service at this address, or this process without one; both are asked alike."""
    if url is None:
        from app.cli.local import Local

        yield Local()
        return
    from app.cli.service import service

    with service(url) as client:
        yield client
