"""The progress of long work, as a bar on a terminal's stderr, and nothing anywhere else."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, Progress, ProgressColumn, Task, TextColumn, TimeElapsedColumn
from rich.text import Text

OnProgress = Callable[[str, int | None, int | None], None]


class _Count(ProgressColumn):
    """How many of how many, where that is known."""

    def render(self, task: Task) -> Text:
        if task.total is None:
            return Text("")
        return Text(f"{task.completed:.0f}/{task.total:.0f}")


@contextmanager
def progress_bar(stage: str) -> Iterator[OnProgress]:
    """Tell it each stage, and how many parts of how many are done; it beats until it knows."""
    columns = (TextColumn("{task.description}"), BarColumn(), _Count(), TimeElapsedColumn())
    console = Console(stderr=True)
    off = not console.is_terminal  # where it would leave an empty line
    with Progress(*columns, console=console, transient=True, disable=off) as bar:
        task = bar.add_task(stage, total=None)

        def tell(stage: str, done: int | None = None, of: int | None = None) -> None:
            bar.update(task, description=stage, completed=done or 0, total=of)

        yield tell


@contextmanager
def reported_work(stage: str) -> Iterator[None]:
    """What the work inside reports of itself."""
    from app.work import progress

    with progress_bar(stage) as tell:
        progress.report_through(lambda now: tell(now.stage, now.done, now.of))
        try:
            yield
        finally:
            progress.report_through(lambda _: None)
