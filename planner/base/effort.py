"""The work of a request and its bound: counted, never timed.

What is expensive charges its work by `charge` where it does it: rows examined, solver
iterations times the rows of their problem, cells of a flood.  One request so always gets one
answer, however busy the machine.  The unit is 10 microseconds of a core of 2024, about the
work on one row of a table, its line of sight, angles and limits.  What each thing costs stands
beside the place that does it, "of `effort`"; `bench/plausible.py --costs` prints how long
each place's row takes, and none may take longer.

The count is a context variable: solvers lie eight calls below the request, in signatures that
speak of angles and limits, and none of the callers between has a use for it.  Outside `at_most`
nothing is bounded.
"""

import math
from contextvars import ContextVar, Token
from dataclasses import dataclass, field

PLAN = 800_000  # 8 to 10 s: what one plan or refusal may cost


class WorkLimitReached(Exception):
    """What was to be done next is beyond the bound: no refusal, the search it is in ends."""

    def __init__(self, effort: "Effort") -> None:
        super().__init__("the work that may be done is done")
        self.effort = effort


@dataclass(eq=False)
class Effort:
    """What is done, and how much may be, in rows' worth of work.

    outer: the bound around it, which counts the same work.  is_exhausted: work was left undone.
    finishes: whether it may go on beyond all of them.
    """

    bound: float
    outer: "Effort | None" = None
    done_rows: float = 0.0
    is_exhausted: bool = False
    finishes: bool = False
    _made: set[object] = field(default_factory=set)
    _token: Token["Effort | None"] = field(init=False, repr=False)

    @property
    def remaining(self) -> float:
        """Least of its own and of all around it."""
        own = max(self.bound - self.done_rows, 0.0)
        return own if self.outer is None else min(own, self.outer.remaining)

    def __enter__(self) -> "Effort":
        self.outer = _NOW.get()
        self._token = _NOW.set(self)
        return self

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> bool:
        _NOW.reset(self._token)
        return isinstance(error, WorkLimitReached) and error.effort is self

    def require(self) -> None:
        """Raises WorkLimitReached, of the outermost bound that is reached."""
        if self.finishes:
            return
        if self.outer is not None:
            self.outer.require()
        if self.done_rows >= self.bound:
            self.is_exhausted = True
            raise WorkLimitReached(self)

    def add(self, rows: float) -> None:
        """Counted here and all around."""
        self.done_rows += rows
        if self.outer is not None:
            self.outer.add(rows)

    def is_first(self, made: object) -> bool:
        """Whether nothing equal was made since the outermost bound began."""
        if self.outer is not None:
            return self.outer.is_first(made)
        is_first = made not in self._made
        self._made.add(made)
        return is_first


_NOW: ContextVar[Effort | None] = ContextVar("effort", default=None)


def at_most(bound: float) -> Effort:
    """Work in a `with` is counted, and where it reaches the bound, the block ends quietly.

    Whoever opens it keeps the best found so far, and reports `is_exhausted`.
    """
    return Effort(bound)


def finish() -> Effort:
    """Work in a `with` is counted, and goes on though a bound is reached: what hands over the best
    found, in little time."""
    return Effort(math.inf, finishes=True)


def charge(rows: float) -> None:
    """Called by what is about to do, or to go on with, so much work.

    Raises WorkLimitReached when a bound is reached already: what is begun is finished.
    """
    effort = _NOW.get()
    if effort is not None:
        effort.require()
        effort.add(rows)


def count(rows: float) -> None:
    """The same for what is known only when it is done: nothing is raised."""
    effort = _NOW.get()
    if effort is not None:
        effort.add(rows)


def count_once(made: object, rows: float) -> None:
    """The same for what is made once and kept: in each request's count, whoever made it first."""
    effort = _NOW.get()
    if effort is not None and effort.is_first(made):
        count(rows)


def remaining() -> float:
    """What may still be done; infinite where nothing is bounded."""
    effort = _NOW.get()
    return math.inf if effort is None else effort.remaining
