"""Work that runs wild can't hurt the service."""

import json
import operator
import os
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from functools import partial
from multiprocessing import forkserver
from pathlib import Path
from threading import Timer

import child_work
import pytest
from waiting import alive, eventually

from app.jobs import child, worker_process
from app.jobs.child import Bounds, TooDemanding
from app.jobs.worker_process import (
    ChildDied,
    ChildFailed,
    Stop,
    Stopped,
    run_in_worker,
    spare_children,
)
from app.requests.examples import PLAN_EXAMPLES
from app.work.plan import plan_and_pack
from app.work.progress import Progress
from planner.base.errors import InvalidInput

BOUNDS = Bounds(deadline_s=120.0, memory_mib=200)


def test_work_is_done_elsewhere():
    assert run_in_worker(BOUNDS, operator.add, 2, 3) == 5
    assert run_in_worker(BOUNDS, os.getpid) != os.getpid()


def test_much_goes_in_and_out():
    much = os.urandom(5_000_000)  # more than a pipe holds
    assert run_in_worker(BOUNDS, bytes, much) == much


def test_progress_comes_through_in_order():
    heard = []
    run_in_worker(BOUNDS, child_work.say_how_far, on_progress=heard.append)
    assert heard == [Progress(stage="begun"), Progress(stage="half", done=1, of=2)]
    run_in_worker(BOUNDS, child_work.say_how_far)  # nobody need listen


@pytest.mark.parametrize("stream", [1, 2])
def test_what_a_child_prints_goes_nowhere(stream):
    """It may hold the request."""
    assert run_in_worker(BOUNDS, os.readlink, f"/proc/self/fd/{stream}") == os.devnull


def test_ctrl_c_ends_no_child():
    """The terminal sends it to all; the service ends its children as it sees fit."""
    assert run_in_worker(BOUNDS, signal.raise_signal, signal.SIGINT) is None


def test_too_long_a_work_is_killed():
    with pytest.raises(TooDemanding, match=r"0\.5 s of a processor"):
        run_in_worker(Bounds(deadline_s=0.5, memory_mib=200), child_work.spin)


def test_work_that_gets_no_processor_is_not_late():
    """A busy machine gives it one later: whether a request is refused must not hang on that."""
    assert run_in_worker(Bounds(deadline_s=0.2, memory_mib=200), time.sleep, 1.0) is None


def test_a_child_that_hangs_is_killed_and_the_request_not_blamed(monkeypatch):
    monkeypatch.setattr(worker_process, "_SILENT_S", 1.0)
    with pytest.raises(ChildDied, match="did nothing for 1 s"):
        run_in_worker(BOUNDS, time.sleep, 3600.0)
    with pytest.raises(TooDemanding):  # this one works all the while
        run_in_worker(Bounds(deadline_s=1.0, memory_mib=200), child_work.spin)


def test_too_much_memory_is_refused():
    with pytest.raises(TooDemanding, match="200 MiB"):
        run_in_worker(BOUNDS, bytes, 300 * 2**20)
    assert len(run_in_worker(BOUNDS, bytes, 50 * 2**20)) == 50 * 2**20


def test_a_crash_is_noticed():
    with pytest.raises(ChildDied, match="-6"):  # SIGABRT
        run_in_worker(BOUNDS, os.abort)


def test_a_bug_is_told_with_its_traceback():
    with pytest.raises(ChildFailed, match="ZeroDivisionError"):
        run_in_worker(BOUNDS, operator.truediv, 1.0, 0.0)


@contextmanager
def one_child():
    """Inside, one and the same does all."""
    children = worker_process._children
    with spare_children(1):
        eventually(lambda: children._working == 0 and len(children._waiting) == 1)
        yield run_in_worker(BOUNDS, os.getpid)


def test_sound_work_leaves_its_child_for_more():
    with one_child() as same:
        with pytest.raises(InvalidInput):
            run_in_worker(BOUNDS, child_work.refuse, "not so")
        assert run_in_worker(BOUNDS, os.getpid) == same


def test_each_work_has_bounds_of_its_own():
    with one_child() as same:
        may_use_s = []
        for deadline_s, memory_mib in ((120.0, 50), (600.0, 200), (240.0, 100)):
            bounds = Bounds(deadline_s=deadline_s, memory_mib=memory_mib)
            child, most_s = run_in_worker(bounds, child_work.used_to_end)
            assert child == same
            may_use_s.append(most_s)
        assert may_use_s[0] < may_use_s[2] < may_use_s[1]
        with pytest.raises(TooDemanding, match="100 MiB"):
            run_in_worker(bounds, child_work.allocate, 150 * 2**20)
        assert run_in_worker(BOUNDS, child_work.allocate, 150 * 2**20) == 150 * 2**20


@pytest.mark.parametrize(
    "work", [child_work.keep_much, os.abort, partial(operator.truediv, 1.0, 0.0)]
)
def test_a_child_that_grew_or_failed_does_nothing_more(work):
    with one_child() as first:
        with suppress(ChildDied, ChildFailed):
            run_in_worker(BOUNDS, work)
        assert run_in_worker(BOUNDS, os.getpid) != first


def test_a_child_that_works_alone_does_nothing_more():
    with one_child() as first:
        alone = Bounds(deadline_s=120.0, memory_mib=200, alone=True)
        assert run_in_worker(alone, os.getpid) == first
        assert run_in_worker(BOUNDS, os.getpid) != first


def kill_that_waits(pid):
    [child] = worker_process._children._waiting
    os.kill(pid, signal.SIGKILL)
    eventually(lambda: child._has_ended(0.0))


def test_a_child_killed_while_it_waits_is_not_noticed():
    with one_child() as first:
        kill_that_waits(first)
        assert run_in_worker(BOUNDS, os.getpid) != first


def test_a_child_that_is_dead_already_is_not_killed(monkeypatch):
    """Its number may be another process's by then."""
    killed = []
    with one_child() as first:
        kill_that_waits(first)
        monkeypatch.setattr(os, "kill", lambda pid, _: killed.append(pid))
        assert run_in_worker(BOUNDS, os.getpid) != first
        monkeypatch.undo()
    assert first not in killed  # others may be thrown away meanwhile


def test_a_child_that_waited_does_the_work():
    with spare_children(1):
        [child] = eventually(lambda: list(worker_process._children._waiting))
        pid = child._process.pid
        eventually(lambda: all(is_asleep(pid) for _ in range(25)))  # it has warmed up
        assert run_in_worker(BOUNDS, os.getpid) == pid


def is_asleep(pid):
    time.sleep(0.02)
    return "State:\tS" in Path(f"/proc/{pid}/status").read_text()


SERVICE = """
import threading, time
from app.jobs import worker_process

class Child(worker_process._Child):  # the moment is known, as late as it may be
    def __init__(self):
        super().__init__()
        begun.set()

def work():
    worker_process.run_in_worker(BOUNDS, time.sleep, 3600.0)

begun = threading.Event()
BOUNDS = worker_process.Bounds(deadline_s=3600.0, memory_mib=200)
worker_process._Child = Child
if __name__ == "__main__":
    threading.Thread(target=work, daemon=True).start()
    begun.wait("""


@pytest.mark.parametrize("ends", ["0.05)", ")"], ids=["before its child is there", "at work"])
def test_a_service_ends_whatever_its_child_is_at(ends):
    done = subprocess.run([sys.executable, "-c", SERVICE + ends], capture_output=True, check=False)
    assert done.returncode == 0, done.stderr


def test_a_service_that_needed_no_child_ends_without_complaint():
    command = [sys.executable, "-c", "import app.jobs.worker_process"]
    done = subprocess.run(command, capture_output=True, check=True)
    assert done.stderr == b""


@pytest.mark.parametrize(
    ("work", "exit_code"), [(child_work.die_within_a_word, "-6"), (child_work.fall_silent, "-9")]
)
def test_a_child_that_breaks_off_is_noticed(work, exit_code):
    with pytest.raises(ChildDied, match=exit_code):
        run_in_worker(BOUNDS, work)


def test_work_stopped_before_it_begins_costs_no_child():
    stop = Stop()
    stop.request()
    with one_child() as same:
        with pytest.raises(Stopped):
            run_in_worker(BOUNDS, os.getpid, stop=stop)
        assert run_in_worker(BOUNDS, os.getpid) == same


def test_a_fork_that_fails_is_not_missed_by_those_that_follow(monkeypatch):
    def fail():
        raise ConnectionRefusedError

    with monkeypatch.context() as broken:
        broken.setattr(worker_process, "start_server", fail)
        for _ in range(3):
            with pytest.raises(ConnectionRefusedError):
                run_in_worker(BOUNDS, os.getpid)
    with one_child() as first:
        with suppress(ChildDied):
            run_in_worker(BOUNDS, os.abort)
        eventually(
            lambda: worker_process._children._waiting
        )  # replaced before anything is asked for
        assert run_in_worker(BOUNDS, os.getpid) != first


def test_a_fork_that_fails_leaves_nothing_open(monkeypatch):
    def fail(_):
        raise EOFError

    run_in_worker(BOUNDS, os.getpid)
    before = open_when_idle()
    monkeypatch.setattr(forkserver, "read_signed", fail)
    with pytest.raises(EOFError) as kept:
        run_in_worker(BOUNDS, os.getpid)
    assert kept.value
    assert open_when_idle() <= before  # others' may be collected meanwhile


def test_a_child_that_died_leaves_nothing_open():
    """Whoever keeps the error keeps what it refers to."""
    run_in_worker(BOUNDS, os.getpid)
    before = open_when_idle()
    with pytest.raises(ChildDied) as kept:
        run_in_worker(BOUNDS, os.abort)
    assert kept.value
    assert open_when_idle() <= before


def open_when_idle():
    """The descriptors, when no child is to be thrown away any more."""
    eventually(lambda: not any(isinstance(thread, Timer) for thread in threading.enumerate()))
    return set(os.listdir("/proc/self/fd"))


def look_after_parent_is_gone():
    """In a process whose parent isn't the server children are forked from."""
    from app.work import preload

    orphan = os.fork()
    if orphan == 0:
        with suppress(OSError):  # this child has let go of the pipe itself
            child._die_with_service(preload.SERVER_PID)
        os._exit(0)
    return os.waitstatus_to_exitcode(os.waitpid(orphan, 0)[1])


def test_a_child_whose_server_was_gone_before_it_began_ends():
    assert run_in_worker(BOUNDS, look_after_parent_is_gone) == -signal.SIGKILL


def test_a_child_that_is_stopped_ends(tmp_path):
    notes, stop = child_work.Notes(tmp_path / "notes"), Stop()
    with one_child() as stopped, ThreadPoolExecutor() as threads:
        threads.submit(lambda: (eventually(notes.pids), stop.request()))
        with pytest.raises(Stopped):
            run_in_worker(BOUNDS, child_work.hang, os.fsencode(notes.file), stop=stop)
        eventually(lambda: not alive(stopped))


def test_a_plan_does_not_depend_on_what_its_child_planned_before():
    requests = [json.dumps(PLAN_EXAMPLES[name][1]).encode() for name in ("tle", "sequence")]
    bounds = Bounds(deadline_s=120.0, memory_mib=1000)
    fresh = [run_in_worker(bounds, plan_and_pack, request).table_columns for request in requests]
    with one_child() as same:
        again = [
            run_in_worker(bounds, plan_and_pack, request) for request in (*requests, *requests)
        ]
        assert run_in_worker(bounds, os.getpid) == same
    assert [made.table_columns for made in again] == [*fresh, *fresh]
