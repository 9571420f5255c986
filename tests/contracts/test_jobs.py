"""Accepted work is done once, killed when it must be, and reported whatever dies."""

import os
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager

import pytest
from child_work import Notes, let_go
from job_cases import KINDS, new_job
from sqlalchemy import select, update
from waiting import PATIENCE_S, alive, eventually

from app.jobs import dispatcher as dispatcher_module
from app.jobs.dispatcher import Dispatcher
from app.jobs.kinds import JOB_KINDS
from app.jobs.worker_process import run_here
from app.settings import Settings
from app.store import audit, events, jobs, results
from app.store.database import Database
from app.store.models import JobRow
from app.store.unavailable import StoreUnavailable

RULES = {"lease_s": 120.0, "job_attempts": 3, "queue_max": 100, "retention_days": None}


@pytest.fixture(autouse=True)
def kinds(monkeypatch):
    for name, kind in KINDS.items():
        monkeypatch.setitem(JOB_KINDS, name, kind)


@pytest.fixture
def notes(tmp_path):
    """Where the processes that work note themselves."""
    return Notes(tmp_path / "notes")


@contextmanager
def dispatching(database, workers=1, **rules):
    """A service on the database, with connections of its own."""
    own = Database(database.url)
    dispatcher = Dispatcher(
        own, run_here, Settings(**RULES | {"workers": workers} | rules), lambda *_: None
    )
    dispatcher.start()
    try:
        yield dispatcher
    finally:
        dispatcher.close()
        own.close()


def job_of(database, job_id):
    with database.reading() as connection:
        return jobs.get(connection, job_id)


def ended(database, job_id):
    return eventually(lambda: (job := job_of(database, job_id)) and not job.is_open and job)


def states(database, job_id):
    with database.reading() as connection:
        told = events.after(connection, job_id, 0)
    return [event.data["state"] for event in told if event.kind == events.STATE]


def test_work_is_begun_at_once_where_there_is_room(database, notes):
    with dispatching(database) as dispatcher:
        job = dispatcher.submit(new_job("note", notes.file))
        assert job.state == "running"
        assert ended(database, job.id).state == "done"
    assert len(notes.pids()) == 1
    assert notes.pids() != [os.getpid()]
    assert states(database, job.id) == ["queued", "running", "done"]


def test_a_request_begun_at_once_is_not_read_again(database, tmp_path):
    file, held = tmp_path / "given", tmp_path / "held"
    with dispatching(database) as dispatcher:
        first = dispatcher.submit(new_job("repeat", file), "as it was read")
        ended(database, first.id)
        holding = dispatcher.submit(new_job("linger", held))
        eventually(lambda: job_of(database, holding.id).state == "running")  # in the first's place
        waiting = dispatcher.submit(new_job("repeat", file), "as it was read")
        assert waiting.state == "queued"  # for whoever takes it up
        let_go(held)
        ended(database, holding.id)
        ended(database, waiting.id)
    assert file.read_text().splitlines() == ["as it was read", "None"]


def test_work_that_waits_is_begun_as_soon_as_there_is_room(database, tmp_path, monkeypatch):
    """Not only when the queue is looked at again."""
    monkeypatch.setattr(dispatcher_module, "POLL_S", 3600.0)
    first = tmp_path / "first"
    with dispatching(database) as dispatcher:
        dispatcher.submit(new_job("linger", first))
        waiting = dispatcher.submit(new_job("note", tmp_path / "notes"))
        eventually(lambda: not dispatcher._wake.is_set())  # the queue was looked at
        let_go(first)
        assert ended(database, waiting.id).state == "done"


def test_no_more_is_worked_on_than_there_is_room_for(database, tmp_path):
    first, second = tmp_path / "first", tmp_path / "second"
    with dispatching(database) as dispatcher:
        dispatcher.submit(new_job("linger", first))
        waiting = dispatcher.submit(new_job("linger", second))
        time.sleep(4.0 * dispatcher_module.POLL_S)  # it is looked for what waits
        assert job_of(database, waiting.id).state == "queued"
        let_go(first)
        eventually(lambda: job_of(database, waiting.id).state == "running")
        assert dispatcher.submit(new_job("note", tmp_path / "third")).state == "queued"
        let_go(second)


def test_how_far_work_is_can_be_followed(database, tmp_path):
    def progress():
        with database.reading() as connection:
            told = events.after(connection, job.id, 0)
        return [event for event in told if event.kind == events.PROGRESS]

    with dispatching(database) as dispatcher:
        job = dispatcher.submit(new_job("tell", tmp_path / "notes"))
        one, other = eventually(lambda: len(told := progress()) > 1 and told[:2])
        let_go(tmp_path / "notes")
        ended(database, job.id)
    assert one.data.keys() == {"stage", "done"}  # nothing of `of`, which the work doesn't know
    assert one.data["stage"] == "telling"
    assert one.data["done"] < other.data["done"]
    # told every 20 ms, stored every half second
    assert (other.at_utc - one.at_utc).total_seconds() > 0.4


def test_a_stage_that_lasts_is_told_though_it_began_right_after_others(database, tmp_path):
    with dispatching(database) as dispatcher:
        job = dispatcher.submit(new_job("dwell", tmp_path / "notes"))

        def stages():
            with database.reading() as connection:
                told = events.after(connection, job.id, 0)
            return [event.data["stage"] for event in told if event.kind == events.PROGRESS]

        eventually(lambda: "three" in stages())
        let_go(tmp_path / "notes")
        assert ended(database, job.id).state == "done"
        assert "two" not in stages()  # nobody could have read it


def test_cancelling_kills_what_runs(database, notes):
    with dispatching(database) as dispatcher:
        job = dispatcher.submit(new_job("hang", notes.file))
        [pid] = eventually(notes.pids)
        with dispatcher.watching(job.id) as (work_ended, _):
            dispatcher.cancel(job.id, "key")
            assert work_ended.result(PATIENCE_S)
        assert job_of(database, job.id).state == "cancelled"  # stored when that is told
        eventually(lambda: not alive(pid))
        again = dispatcher.submit(new_job("note", notes.file))
        assert ended(database, again.id).state == "done"  # its place is free


def test_another_service_can_cancel(database, notes):
    with dispatching(database) as one:
        job = one.submit(new_job("hang", notes.file))
        [pid] = eventually(notes.pids)
        with dispatching(database) as other:
            other.cancel(job.id, None)
            eventually(lambda: not alive(pid))
        assert ended(database, job.id).state == "cancelled"


def test_a_job_in_the_queue_is_cancelled_unbegun(database, tmp_path, notes):
    with dispatching(database) as dispatcher:
        running = dispatcher.submit(new_job("hang", tmp_path / "other"))
        waiting = dispatcher.submit(new_job("note", notes.file))
        assert waiting.state == "queued"
        assert dispatcher.cancel(waiting.id, None).state == "cancelled"
        dispatcher.cancel(running.id, None)
        ended(database, running.id)
    assert notes.pids() == []


@pytest.mark.parametrize(
    ("work", "deadline_s", "state", "attempts", "problem"),
    [
        ("spin", 2.0, "refused", 1, "too-demanding"),
        ("die_once", 120.0, "done", 2, None),
        ("die", 120.0, "failed", 3, "interrupted"),
    ],
)
def test_work_that_hangs_is_killed_and_work_whose_process_dies_is_begun_again(
    database, notes, work, deadline_s, state, attempts, problem
):
    with dispatching(database) as dispatcher:
        job = dispatcher.submit(new_job(work, notes.file, deadline_s=deadline_s))
        found = ended(database, job.id)
        eventually(lambda: not any(map(alive, notes.pids())))
    assert (found.state, found.attempts) == (state, attempts)
    assert (found.problem is None) == (problem is None)
    assert problem is None or found.problem["type"].endswith(problem)
    if work == "spin":
        assert "2 s" in found.problem["detail"]
    else:
        assert len(notes.pids()) == attempts


@pytest.mark.parametrize("workers", [1, 3])
def test_shares_whose_processes_die_are_done_again_before_the_rest(database, notes, workers):
    with dispatching(database, workers=workers) as dispatcher:
        job = dispatcher.submit(new_job("gather", notes.file))
        found = ended(database, job.id)
        again = ended(database, dispatcher.submit(new_job("note", notes.file)).id)
    assert (found.state, found.attempts, again.state) == ("done", 1, "done")
    assert len(notes.pids()) == 2
    for number in range(3):
        died, done = Notes(notes.file.with_name(f"{notes.file.name}{number}")).pids()
        assert died != done


def test_a_bug_is_reported_without_its_text(database, tmp_path, caplog):
    with dispatching(database) as dispatcher:
        job = dispatcher.submit(new_job("fail", tmp_path / "notes"))
        found = ended(database, job.id)
    assert found.state == "failed"
    assert found.problem["type"].endswith("internal-error")
    assert "secret" not in str(found.problem)
    assert "RuntimeError" in caplog.text
    assert "child_work.py" in caplog.text
    assert "secret" not in caplog.text


def test_a_result_no_database_takes_ends_its_job(database, notes, caplog):
    with dispatching(database) as dispatcher:
        job = dispatcher.submit(new_job("leave_out", notes.file))
        found = ended(database, job.id)
    assert found.state == "failed"
    assert found.problem["type"].endswith("internal-error")
    assert len(notes.pids()) == 1  # the next attempt would fail as this one did
    with database.reading() as connection:
        assert results.get(connection, job.id) == []
    assert any("can't be stored" in str(record.__dict__) for record in caplog.records)


def test_a_result_that_the_database_did_not_take_before_the_service_ended_is_in_the_log(
    database, notes, monkeypatch, caplog
):
    def logged(message):
        return any(message in str(record.__dict__) for record in caplog.records)

    def fail(**_options):
        raise StoreUnavailable("away")

    with dispatching(database) as dispatcher:
        job = dispatcher.submit(new_job("linger", notes.file))
        monkeypatch.setattr(dispatcher._database, "writing", fail)
        let_go(notes.file)
        eventually(lambda: logged("can't be stored yet"))
    assert logged("the end couldn't be stored")
    assert job_of(database, job.id).state == "running"  # for the next, when its lease has ended


@pytest.mark.usefixtures("patient_store")
def test_two_services_do_each_job_once(database, tmp_path):
    files = [tmp_path / f"notes{number}" for number in range(12)]
    with ExitStack() as services:
        one = services.enter_context(dispatching(database))
        services.enter_context(dispatching(database))
        ids = [one.submit(new_job("note", file)).id for file in files]
        assert {ended(database, job_id).state for job_id in ids} == {"done"}
    assert [len(Notes(file).pids()) for file in files] == [1] * len(files)
    assert {job_of(database, job_id).attempts for job_id in ids} == {1}


def test_a_service_that_stops_gives_its_work_to_the_next(database, tmp_path, notes):
    with dispatching(database) as dispatcher:
        job = dispatcher.submit(new_job("hang_once", notes.file))
        waiting = dispatcher.submit(new_job("note", tmp_path / "other"))
        [pid] = eventually(notes.pids)
    assert not alive(pid)
    found = job_of(database, job.id)
    assert (found.state, found.attempts) == ("queued", 0)  # not the job's fault
    with dispatching(database):
        assert ended(database, job.id).state == "done"
        assert ended(database, waiting.id).state == "done"


def test_a_service_that_lost_its_lease_stores_nothing(database, notes):
    with dispatching(database) as dispatcher:
        job = dispatcher.submit(new_job("linger", notes.file))
        with database.writing() as connection:  # as another service does that takes it up
            connection.execute(
                update(JobRow).where(JobRow.id == job.id).values(lease_token="another's")
            )
        with dispatcher.watching(job.id) as (work_ended, is_here):
            let_go(notes.file)
            assert not is_here or not work_ended.result()
    assert job_of(database, job.id).state == "running"
    with database.reading() as connection:
        assert results.get(connection, job.id) == []


def test_a_service_that_takes_up_its_own_job_again_ends_what_it_did_at_it(database, notes):
    """As when the machine stood still: else nobody could end the first any more."""
    with dispatching(database, workers=2) as one:
        job = one.submit(new_job("hang", notes.file))
        [first] = eventually(notes.pids)
        with database.writing() as connection:
            connection.execute(update(JobRow).where(JobRow.id == job.id).values(lease_until_s=0.0))
        _, second = eventually(lambda: len(notes.pids()) == 2 and notes.pids())
        eventually(lambda: not alive(first))
        assert alive(second)
        one.cancel(job.id, "key")
        eventually(lambda: not alive(second))
        assert ended(database, job.id).state == "cancelled"


def lease_until_s(database, job_id):
    with database.reading() as connection:
        return connection.scalar(select(JobRow.lease_until_s).where(JobRow.id == job_id))


def test_leases_are_kept_while_the_work_goes_on(database, notes):
    with dispatching(database) as one, dispatching(database):
        job = one.submit(new_job("hang", notes.file))
        eventually(notes.pids)
        until_s = lease_until_s(database, job.id)
        one._extended_s -= RULES["lease_s"]  # as when it has been held for so long
        eventually(lambda: lease_until_s(database, job.id) > until_s)
        one.cancel(job.id, None)
        assert ended(database, job.id).attempts == 1
    assert len(notes.pids()) == 1


@pytest.mark.usefixtures("patient_store")
def test_the_same_key_at_the_same_time_is_one_job(database, notes):
    with dispatching(database, workers=2) as one, dispatching(database, workers=2) as other:

        def submit(number):
            new = new_job("linger", notes.file, idempotency="the key")
            return (one, other)[number % 2].submit(new).id

        with ThreadPoolExecutor(8) as threads:
            ids = set(threads.map(submit, range(8)))
        let_go(notes.file)
        [job_id] = ids
        assert ended(database, job_id).state == "done"
    assert len(notes.pids()) == 1


def test_a_key_that_another_writes_after_it_was_looked_for_is_one_job(
    database, tmp_path, monkeypatch
):
    """PostgreSQL lets that happen."""
    looks = iter((lambda *_: None, jobs.find_idempotent))
    with dispatching(database) as dispatcher:
        first = dispatcher.submit(new_job("note", tmp_path / "notes", idempotency="the key"))
        monkeypatch.setattr(jobs, "find_idempotent", lambda *given: next(looks)(*given))
        again = dispatcher.submit(new_job("note", tmp_path / "notes", idempotency="the key"))
    assert again.id == first.id


def test_what_is_not_kept_is_deleted(database, tmp_path):
    with dispatching(database) as dispatcher:
        job = dispatcher.submit(new_job("note", tmp_path / "notes"))
        ended(database, job.id)
    with dispatching(database, retention_days=1e-9):
        eventually(lambda: job_of(database, job.id) is None)


def test_the_audit_trail_says_who_did_what(database, tmp_path):
    with dispatching(database) as dispatcher:
        job = dispatcher.submit(new_job("hang", tmp_path / "notes", key_id="alice"))
        dispatcher.cancel(job.id, "bob")
        ended(database, job.id)
    with database.reading() as connection:
        found = audit.entries(connection, limit=9, before=10**9)
    told = [(entry.key_id, entry.action, entry.subject) for entry in found]
    assert told == [("bob", "hang.cancel", job.id), ("alice", "hang.accept", job.id)]


@pytest.mark.usefixtures("patient_store")
def test_work_accepted_while_the_service_stops_is_given_back(database, notes):
    with dispatching(database) as dispatcher, ThreadPoolExecutor() as threads:
        with database.writing():  # SQLite lets nobody else write
            accepting = threads.submit(dispatcher.submit, new_job("hang", notes.file))
            eventually(notes.pids)
            threads.submit(dispatcher.close)
            time.sleep(0.5)  # for it to have looked what there is to stop
        job = accepting.result()
        eventually(lambda: job_of(database, job.id).state != "running")
    assert states(database, job.id)[-1] == "queued"  # and not refused at its deadline
