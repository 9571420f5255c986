"""Checks of all that the service depends on."""

import asyncio
import time
from collections.abc import Callable, Mapping
from datetime import UTC, datetime

import numpy as np
from anyio import to_thread

from app.answers.service import ReadinessCheckOut, State
from app.jobs.child import Bounds
from app.jobs.worker_process import run_in_worker
from app.log.logs import log
from app.store.database import Database
from app.store.unavailable import StoreUnavailable
from planner.base.solvers import Solver, Work
from planner.world.frames.earth_orientation import iers_data_end_utc
from planner.world.frames.time_scales import DAY_S, elapsed_s

# Asked for by everyone without a key: answered anew no more often than this.
_KEPT_S = 5.0
# Most time for an answer, more than a silent database is waited for; a check that takes longer is
# told as it was found before, for a while.
_WAIT_S, _OLD_S = 1.8, 20.0
_CHILD_BOUNDS = Bounds(deadline_s=10.0, memory_mib=300)
IERS_WARNING_DAYS = 30.0


Check = Callable[[], tuple[State, str]]


class Readiness:
    """Asks all checks at once, each by one thread at a time."""

    def __init__(self, checks: Mapping[str, Check]) -> None:
        self._checks = [_LastAnswer(name, check) for name, check in checks.items()]

    async def now(self) -> tuple[ReadinessCheckOut, ...]:
        """At most some seconds old, and answered within two."""
        tasks = [check.ask() for check in self._checks]
        pending = [one for one in tasks if one is not None]
        if pending:
            await asyncio.wait(pending, timeout=_WAIT_S)
        return tuple(check.answer() for check in self._checks)


class _LastAnswer:
    """A check, and what it found last."""

    def __init__(self, name: str, check: Check) -> None:
        self._name = name
        self._check = check
        self._found: ReadinessCheckOut | None = None
        self._found_s = 0.0
        self._asking: asyncio.Task[None] | None = None

    def ask(self) -> "asyncio.Task[None] | None":
        """What to wait for; None while the last answer is kept."""
        is_kept = self._found is not None and time.monotonic() - self._found_s < _KEPT_S
        if self._asking is None and not is_kept:
            self._asking = asyncio.create_task(self._ask())
        return self._asking

    async def _ask(self) -> None:
        try:
            self._found = await to_thread.run_sync(_run_check, self._name, self._check)
            self._found_s = time.monotonic()
        finally:
            self._asking = None

    def answer(self) -> ReadinessCheckOut:
        """Of a check that takes its time, what it found before, while that isn't old."""
        if self._found is None or time.monotonic() - self._found_s > _OLD_S:
            return ReadinessCheckOut(
                name=self._name, state="failed", detail="it hasn't answered yet"
            )
        return self._found


def _run_check(name: str, check: Check) -> ReadinessCheckOut:
    try:
        state, detail = check()
    except StoreUnavailable as error:
        state, detail = "failed", error.detail
    except Exception as error:  # noqa: BLE001 (whatever is wrong with it, it isn't ready)
        log.error("not ready", check=name, exc_info=error)
        state, detail = "failed", "it doesn't answer; the log says why"
    return ReadinessCheckOut(name=name, state=state, detail=detail)


def database_takes_writes(database: Database) -> tuple[State, str]:
    """As much as a plan takes is written, and removed again."""
    database.require_writable()
    return "ok", f"{database.url.get_backend_name()} takes what is written"


def solver_answers() -> tuple[State, str]:
    """A child is forked, solves a small problem by Ipopt and hands back its answer."""
    found = run_in_worker(_CHILD_BOUNDS, _least_of_a_parabola)
    if abs(found - 1.0) > 1e-6:  # Ipopt's tolerance is 1e-8
        raise ArithmeticError(f"the least of (x - 1)^2 came out at {found}")
    return "ok", "a child process solved a small problem"


def _least_of_a_parabola() -> float:
    import casadi

    x = casadi.SX.sym("x")
    programme = {"x": x, "p": casadi.SX(0, 1), "f": (x - 1.0) ** 2, "g": casadi.SX(0, 1)}
    return float(Solver(programme, {}, Work(0.0, 0.0)).solve(x0=np.zeros(1)).x_numbers[0])


def earth_orientation_covers_now() -> tuple[State, str]:
    """Whether UT1 and pole are known for today, and for how long yet."""
    end_utc = iers_data_end_utc()
    left_days = elapsed_s(end_utc, datetime.now(UTC)) / DAY_S
    if left_days < IERS_WARNING_DAYS:
        return "degraded", (
            f"Earth orientation data end on {end_utc:%Y-%m-%d}; plans for later times say how far "
            "off they may be; install a newer astropy-iers-data"
        )
    return "ok", f"Earth orientation is known or predicted until {end_utc:%Y-%m-%d}"
