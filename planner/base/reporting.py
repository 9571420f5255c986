"""The progress of work, as planners tell it to whoever asked: stage, parts done, of how many."""

from collections.abc import Callable

Reporter = Callable[[str, int, int], None]


def tell_nobody(stage: str, done: int, of: int) -> None:
    """The reporter of work that nobody follows."""
