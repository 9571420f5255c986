"""Checks of all that the service depends on."""

import asyncio
import math
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
        self._checks = checks
        self._found: dict[str, tuple[ReadinessCheckOut, float]] = {}  # and when
        self._asking: dict[str, asyncio.Task[None]] = {}

    async def now(self) -> tuple[ReadinessCheckOut, ...]:
        """At most some seconds old, and answered within two.

        Of a check that takes its time, what it found before, while that isn't old.
        """
        for name in self._checks.keys() - self._asking.keys():
            if self._age_s(name) >= _KEPT_S:
                self._asking[name] = asyncio.create_task(self._ask(name))
        if self._asking:
            await asyncio.wait(self._asking.values(), timeout=_WAIT_S)
        return tuple(
            self._found[name][0]
            if self._age_s(name) <= _OLD_S
            else ReadinessCheckOut(name=name, state="failed", detail="it hasn't answered yet")
            for name in self._checks
        )

    async def _ask(self, name: str) -> None:
        try:
            found = await to_thread.run_sync(_run_check, name, self._checks[name])
            self._found[name] = (found, time.monotonic())
        finally:
            del self._asking[name]

    def _age_s(self, name: str) -> float:
        return time.monotonic() - self._found[name][1] if name in self._found else math.inf


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
