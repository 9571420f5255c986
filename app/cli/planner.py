"""The one who answers a command: this process, or a running service; and the bar of progress."""

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


@contextmanager
def told_progress(stage: str) -> Iterator[OnProgress]:
    """Tell it each stage, and how many parts of how many are done; it beats until it knows."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    texts = TextColumn("{task.description}"), TextColumn("{task.fields[count]}")
    console = Console(stderr=True)
    off = not console.is_terminal  # where it would leave an empty line
    columns = (texts[0], BarColumn(), texts[1], TimeElapsedColumn())
    with Progress(*columns, console=console, transient=True, disable=off) as bar:
        task = bar.add_task(stage, total=None, count="")
        yield lambda now: bar.update(
            task,
            description=now.stage or getattr(now, "state", stage),
            completed=now.done or 0,
            total=now.of,
            count=" ".join(_counts(now)),
        )


def _counts(now: Any) -> Iterator[str]:  # noqa: ANN401 (a service's or this process's)
    """Parts that are done, and of a choice its worth and bound so far."""
    if now.of is not None:
        yield f"{now.done or 0}/{now.of}"
    if getattr(now, "value", None) is not None:
        yield f"worth {now.value:.6g}"
    if getattr(now, "bound", None) is not None:
        yield f"of {now.bound:.6g} at most"
