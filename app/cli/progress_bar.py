"""The progress of long work, as a bar on a terminal's stderr, and nothing anywhere else."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from app.cli.planner import OnProgress


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
