"""A pure function of many things, done for several of them at a time by threads."""

import math
import os
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import TypeVar

from planner.base import effort


@dataclass(frozen=True, kw_only=True)
class ThreadOptions:
    """How many of them there are."""

    most: int = 4  # a bound's labels take some 300 MB in each, of the 4 GB of a request


OPTIONS = ThreadOptions()
T = TypeVar("T")
R = TypeVar("R")


def done_at_once(function: Callable[[T], R], things: Iterable[T]) -> Iterator[R]:
    """What it makes of each, in their order, whatever the number of cores.

    It pays for compiled work, which is free of the interpreter's lock.  Work is counted in the
    caller's effort; nothing that the function does is ended by a bound.
    """

    def counted(one: T) -> tuple[R, float]:
        with effort.at_most(math.inf) as own:  # threads begin without their caller's
            return function(one), own.done_rows
        raise AssertionError("no bound was reached")

    with ThreadPoolExecutor(min(os.cpu_count() or 1, OPTIONS.most)) as threads:
        for made, rows in threads.map(counted, things):
            effort.count(rows)
            yield made
