"""Counted work beside the processor time it takes, by the place that counts it.

A place that charges work is given the time until the next one, a place that counts what is done
the time since the last; so the stretches in which nothing is counted are reported, too.
"""

import sys
import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from types import FrameType

from planner.base import effort

ROW_S = 1e-5  # a row's worth of work is to take no more
LEAST_S = 0.01  # places that take less aren't told


@dataclass
class Cost:
    """Of one place in the code: longest_s, that nothing was counted for."""

    calls: int = 0
    rows: float = 0.0
    cpu_s: float = 0.0
    longest_s: float = 0.0


class Ledger:
    """What was counted, where, and how long it took."""

    def __init__(self) -> None:
        self.costs: dict[str, Cost] = defaultdict(Cost)
        self._last, self._since_s = "before anything is counted", time.process_time()

    def note(self, rows: float, *, done: bool) -> None:
        """Called by `charge` and `count` in place of their own."""
        place = _place(sys._getframe(2))
        self._charge(place if done else self._last)
        self.costs[place].calls += 1
        self.costs[place].rows += rows
        self._last, self._since_s = place, time.process_time()

    def _charge(self, place: str) -> None:
        cost, took_s = self.costs[place], time.process_time() - self._since_s
        cost.cpu_s += took_s
        cost.longest_s = max(cost.longest_s, took_s)
        self._since_s = time.process_time()

    def lines(self) -> Iterator[str]:
        """A table, the dearest places first; `!` where a row takes more than it may."""
        heads = f"{'calls':>7} {'rows':>10} {'CPU s':>8} {'us a row':>8} {'longest s':>9}"
        yield f"{'place':46} {heads}"
        for place, cost in sorted(self.costs.items(), key=lambda item: -item[1].cpu_s):
            if cost.cpu_s < LEAST_S:
                continue
            row_us = 1e6 * cost.cpu_s / cost.rows if cost.rows else float("inf")
            dear = "!" if row_us > 1e6 * ROW_S else ""
            yield (
                f"{place:46} {cost.calls:7} {cost.rows:10.0f} {cost.cpu_s:8.2f} {row_us:8.1f}"
                f" {cost.longest_s:9.2f} {dear}"
            )


def _place(frame: FrameType) -> str:
    code = frame.f_code
    return f"{code.co_filename.rpartition('planner/')[2]} {code.co_name}"


@contextmanager
def kept_ledger() -> Iterator[Ledger]:
    """Inside, all that is counted goes into it, too."""
    ledger, charge, count = Ledger(), effort.charge, effort.count

    def noting(charge: Callable[[float], None], *, done: bool) -> Callable[[float], None]:
        def charged(rows: float) -> None:
            ledger.note(rows, done=done)
            charge(rows)

        return charged

    effort.charge, effort.count = noting(charge, done=False), noting(count, done=True)
    try:
        yield ledger
    finally:
        effort.charge, effort.count = charge, count
