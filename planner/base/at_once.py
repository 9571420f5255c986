"""A pure function of many things, done for several of them at a time by threads."""

import math
import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import TypeVar

from planner.base import effort


@dataclass(frozen=True, kw_only=True)
class ThreadOptions:
    """How many of them there are."""

    most: int = 4  # a bound's labels take some 300 MB in each, of the 4 GB of a request
    # of each thread's things: handing one on takes longer than a short pass's best path, and the
    # last parts end at about the same time
    parts: int = 16


OPTIONS = ThreadOptions()
T = TypeVar("T")
R = TypeVar("R")


def done_at_once(function: Callable[[T], R], things: Iterable[T]) -> Iterator[R]:
    """What it makes of each, in their order, whatever the number of cores.

    It pays for compiled work, which is free of the interpreter's lock.  Work is counted in the
    caller's effort; nothing that the function does is ended by a bound.
    """

    def counted(part: Sequence[T]) -> tuple[list[R], float]:
        with effort.at_most(math.inf) as own:  # threads begin without their caller's
            return [function(one) for one in part], own.done_rows
        raise AssertionError("no bound was reached")

    threads_most = min(os.cpu_count() or 1, OPTIONS.most)
    all_things = list(things)
    size = math.ceil(len(all_things) / (threads_most * OPTIONS.parts)) or 1
    parts = [all_things[first : first + size] for first in range(0, len(all_things), size)]
    with ThreadPoolExecutor(threads_most) as threads:
        for made, rows in threads.map(counted, parts):
            effort.count(rows)
            yield from made
