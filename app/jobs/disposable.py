"""How does work that may run wild stay harmless?  In a process of its own, thrown away after.

Children are forked from a small server that has imported what they need and nothing of the
service: one costs some 20 ms, can be killed at any moment, and takes no lock with it.
Its memory is limited by RLIMIT_DATA, which Linux applies to heaps and private mappings.
"""

import multiprocessing
import os
import pickle
import resource
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from multiprocessing import forkserver
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Any, ClassVar, TypeVar

from planner.errors import Refusal

T = TypeVar("T")
# What the children run: the server imports it once, so that a child needn't.
_IMPORTED = ["app.cli", "app.api.horizon_work", "app.api.spacecraft_work"]
_MEBIBYTE = 2**20


@dataclass(frozen=True, kw_only=True)
class Bounds:
    """Most time a piece of work may take, and most memory beyond what its process starts with."""

    deadline_s: float
    memory_mib: int


class TooDemanding(Refusal):
    """Sound, but more work than one request may make."""

    slug: ClassVar[str] = "too-demanding"
    title: ClassVar[str] = "The request asks for too much at a time"


class ChildFailed(RuntimeError):
    """The work raised what is no refusal; the message holds its traceback."""


class ChildDied(RuntimeError):
    """The child ended without a word."""


def start_server() -> None:
    """Begin to start the server children are forked from; returns at once."""
    # Read when NumPy is loaded: threads cost more than they save on matrices of this size.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    multiprocessing.get_context("forkserver").set_forkserver_preload(_IMPORTED)
    forkserver.ensure_running()


def run_disposable(bounds: Bounds, work: Callable[..., T], *given: object) -> T:
    """What `work(*given)` returns; both go through pickle, so `work` is a module's function.

    Raises the Refusal that the work raises; TooDemanding beyond the bounds; ChildFailed;
    ChildDied.
    """
    start_server()
    context = multiprocessing.get_context("forkserver")
    answers, childs_end = context.Pipe(duplex=False)
    child = context.Process(target=_answer, args=(childs_end, bounds, work, given), daemon=True)
    with answers:
        child.start()
        childs_end.close()
        try:
            value: T = _outcome(answers, child, bounds)
            return value
        finally:
            child.kill()
            child.join()
            child.close()


def _outcome(answers: Connection, child: BaseProcess, bounds: Bounds) -> Any:  # noqa: ANN401 (the work's)
    if not answers.poll(bounds.deadline_s):
        raise TooDemanding(
            f"this takes more than the {bounds.deadline_s:g} s it may; ask for less at a time"
        )
    try:
        done, value = pickle.loads(answers.recv_bytes())  # noqa: S301 (our own child's)
    except EOFError:
        child.join()
        raise ChildDied(f"exit code {child.exitcode}") from None
    if done:
        return value
    if isinstance(value, Refusal):
        raise value
    raise ChildFailed(value)


def _answer(
    answers: Connection, bounds: Bounds, work: Callable[..., object], given: tuple[object, ...]
) -> None:
    """The child's whole life."""
    # A child whose service was killed must end by itself.
    _limit(resource.RLIMIT_CPU, int(bounds.deadline_s) * (os.cpu_count() or 1) + 1)
    _limit(resource.RLIMIT_CORE, 0)
    _limit(resource.RLIMIT_DATA, _data_bytes() + bounds.memory_mib * _MEBIBYTE)
    try:
        message = pickle.dumps((True, work(*given)))
    except Refusal as refusal:
        message = pickle.dumps((False, refusal))
    except MemoryError:
        too_much = TooDemanding(
            f"this takes more than the {bounds.memory_mib} MiB of memory it may; ask for less at "
            "a time"
        )
        message = pickle.dumps((False, too_much))
    except Exception:  # noqa: BLE001 (told to the parent, which raises it)
        message = pickle.dumps((False, traceback.format_exc()))
    answers.send_bytes(message)


def _limit(which: int, most: int) -> None:
    resource.setrlimit(which, (most, most))


def _data_bytes() -> int:
    """What the process already has of what RLIMIT_DATA counts."""
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith("VmData:"):
            return int(line.split()[1]) * 1024
    raise RuntimeError("the kernel doesn't say VmData")
