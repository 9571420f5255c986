"""The progress of work, as planners tell it to whoever asked: stage, parts done, of how many."""

from typing import Protocol


class Reporter(Protocol):
    """Told of each stage, and how many parts of how many are done.

    value: of the best answer so far, of work that improves one.  bound: none is worth more, once
    that is proven.
    """

    def __call__(
        self,
        stage: str,
        done: int,
        of: int,
        /,
        *,
        value: float | None = None,
        bound: float | None = None,
    ) -> None: ...


def tell_nobody(
    stage: str, done: int, of: int, /, *, value: float | None = None, bound: float | None = None
) -> None:
    """The reporter of work that nobody follows."""
