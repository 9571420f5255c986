"""The progress of long work, as a bar on a terminal's stderr, and nothing anywhere else."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, Progress, ProgressColumn, Task, TextColumn, TimeElapsedColumn
from rich.text import Text

from app.cli.planner import OnProgress

Tell = Callable[[str, int | None, int | None], None]


class _Count(ProgressColumn):
    """How many of how many, where that is known."""

    def render(self, task: Task) -> Text:
        if task.total is None:
            return Text("")
        return Text(f"{task.completed:.0f}/{task.total:.0f}")


@contextmanager
def progress_bar(stage: str) -> Iterator[Tell]:
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
def told_progress(stage: str) -> Iterator[OnProgress]:
    """The same for who tells of work as a whole."""
    with progress_bar(stage) as tell:
        yield lambda now: tell(now.stage or str(getattr(now, "state", stage)), now.done, now.of)


@contextmanager
def reported_to(on_progress: OnProgress | None) -> Iterator[None]:
    """What the work inside reports of itself."""
    from app.work import progress

    progress.report_through(on_progress or (lambda _: None))
    try:
        yield
    finally:
        progress.report_through(lambda _: None)


@contextmanager
def reported_work(stage: str) -> Iterator[None]:
    """The same, as a bar."""
    with told_progress(stage) as tell, reported_to(tell):
        yield
