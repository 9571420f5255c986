"""The progress of work, reported to whoever runs it, or to nobody."""

from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Progress:
    """What is being done now; `done` of `of` parts where that can be said.

    value: of the best answer so far, of work that improves one.  bound: none is worth more, once
    that is proven.
    """

    stage: str
    done: int | None = None
    of: int | None = None
    value: float | None = None
    bound: float | None = None


OnProgress = Callable[[Progress], None]
_reporter: OnProgress | None = None


def report_through(reporter: OnProgress) -> None:
    """From now on, in this process."""
    global _reporter
    _reporter = reporter


def report(
    stage: str,
    done: int | None = None,
    of: int | None = None,
    *,
    value: float | None = None,
    bound: float | None = None,
) -> None:
    if _reporter is not None:
        _reporter(Progress(stage=stage, done=done, of=of, value=value, bound=bound))
