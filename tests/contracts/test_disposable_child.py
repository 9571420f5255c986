"""Can work that runs wild hurt the service?"""

import operator
import os
import time

import pytest

from app.jobs.disposable import Bounds, ChildDied, ChildFailed, TooDemanding, run_disposable
from planner.errors import InvalidInput

BOUNDS = Bounds(deadline_s=30.0, memory_mib=200)


def refuse(detail):
    raise InvalidInput(detail, field="sessions.0", limit="rate")


def test_work_is_done_elsewhere():
    assert run_disposable(BOUNDS, operator.add, 2, 3) == 5
    assert run_disposable(BOUNDS, os.getpid) != os.getpid()


def test_much_goes_in_and_out():
    much = os.urandom(5_000_000)  # more than a pipe holds
    assert run_disposable(BOUNDS, bytes, much) == much


def test_a_refusal_comes_through_whole():
    with pytest.raises(InvalidInput, match="not so") as refused:
        run_disposable(BOUNDS, refuse, "not so")
    assert (refused.value.field, refused.value.limit) == ("sessions.0", "rate")


def test_too_long_a_work_is_killed():
    with pytest.raises(TooDemanding, match=r"0\.5 s"):
        run_disposable(Bounds(deadline_s=0.5, memory_mib=200), time.sleep, 3600.0)


def test_too_much_memory_is_refused():
    with pytest.raises(TooDemanding, match="200 MiB"):
        run_disposable(BOUNDS, bytes, 300 * 2**20)
    assert len(run_disposable(BOUNDS, bytes, 50 * 2**20)) == 50 * 2**20


def test_a_crash_is_noticed():
    with pytest.raises(ChildDied, match="-6"):  # SIGABRT
        run_disposable(BOUNDS, os.abort)


def test_a_bug_is_told_with_its_traceback():
    with pytest.raises(ChildFailed, match="ZeroDivisionError"):
        run_disposable(BOUNDS, operator.truediv, 1.0, 0.0)
