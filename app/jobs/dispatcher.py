"""Gets accepted work done, once, whatever dies in between.

The database is the truth; this holds leases on the jobs it works on and can lose them at any
moment.  One thread takes work up and keeps the leases; results are stored in the executor's.
"""

import time
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from datetime import UTC, datetime, timedelta
from functools import partial
from itertools import chain, repeat
from threading import Event, Lock, Thread

from sqlalchemy import Connection
from sqlalchemy.exc import IntegrityError, SQLAlchemyError

from app.ids import JobState
from app.jobs.child import Bounds
from app.jobs.job_completion import give_up, settle, take_up_again
from app.jobs.kinds import JOB_KINDS, JobKind
from app.jobs.refusals import QueueFull
from app.jobs.shares import Places, Sharing
from app.jobs.worker_process import RunTask, Stop, Task
from app.log.logs import log
from app.settings import Settings
from app.store import audit, events, jobs
from app.store.database import Database
from app.store.job import Job
from app.store.jobs import Claim, NewJob
from app.store.unavailable import StoreUnavailable
from app.work.progress import Progress
from app.work.result import Result

POLL_S = 0.25  # for work and cancellations that other services on the database wrote
PROGRESS_S = 0.5  # least time between two progress events of one job
_PAUSE_S = 1.0  # when the database doesn't answer
_STORE_PAUSES_S = (0.2, 1.0, 2.0, 4.0, 8.0)  # the last again and again
_PRUNE_S = 3600.0
_PRUNED_AT_ONCE = 200


@dataclass(kw_only=True)
class _Running:
    """A job this service works on; the token is of its lease, empty until it is accepted."""

    job_id: str
    kind: JobKind
    parent_id: str | None
    token: str = ""
    stop: Stop = field(default_factory=Stop)
    began_s: float = field(default_factory=time.monotonic)
    progress_s: float = field(default_factory=time.monotonic)
    untold: Progress | None = None  # it came too soon after what was stored


# Told of a job's kind, the state its work ended in, how long it took and the iterations.
OnEnd = Callable[[str, JobState, float, int | None], None]


class Dispatcher:
    """Accepts jobs, and works on those of the database as far as there is room."""

    def __init__(
        self, database: Database, run_task: RunTask, settings: Settings, on_end: OnEnd
    ) -> None:
        self._database = database
        self.run_task = run_task
        self._threads = ThreadPoolExecutor(settings.workers, thread_name_prefix="solve")
        self._settings = settings
        self._on_end = on_end
        self._lock = Lock()
        self._free = settings.workers
        self._running: dict[str, _Running] = {}
        self._watchers: dict[str, list[Future[Job | None]]] = {}
        self._places = Places(
            take=self._take_place, leave=self._hand_place_on, most=settings.workers - 1
        )
        self._wake = Event()
        self._may_wait = True  # whether a look at the queue could find anything
        self._closing = Event()
        self._thread = Thread(target=self._work_until_closed, name="dispatcher", daemon=True)
        self._extended_s = self._pruned_s = time.monotonic()

    def start(self) -> None:
        self._thread.start()

    def close(self) -> None:
        """Give what runs back to the queue, for the next service."""
        self._closing.set()
        self._wake.set()
        self._thread.join()
        for running in self._now_running():
            running.stop.request()
        self._threads.shutdown()

    def submit(self, new: NewJob, request: object = None) -> Job:
        """Accept a job, begun at once where there is room; or the one accepted under its key.

        request: as it was read, lest work begun at once reads it again.
        Raises QueueFull.
        """
        if not self._take_place():
            job, _ = self._accept_once(new, mine=False)
            self._wake_up()
            return job
        # Worked on while the database writes it down; nobody hears of what isn't accepted.
        running = _Running(job_id=new.id, kind=JOB_KINDS[new.kind], parent_id=new.parent_id)
        work = self._work(running, new.deadline_s, new.request, request)
        token = None
        try:
            job, token = self._accept_once(new, mine=True)
        finally:
            if token is None:
                running.stop.request()
                self._leave_place()
        if token is not None:
            running.token = token
            self._follow(running, work)
        return job

    def _accept_once(self, new: NewJob, mine: bool) -> tuple[Job, str | None]:
        try:
            return self._write_job(new, mine)
        except IntegrityError:  # the same key came in elsewhere at the same time
            return self._write_job(new, mine)

    def _write_job(self, new: NewJob, mine: bool) -> tuple[Job, str | None]:
        with self._database.writing() as connection:
            if new.idempotency is not None:
                known = jobs.find_idempotent(connection, new.idempotency)
                if known is not None:
                    return known, None
            if not mine:
                waiting = jobs.count_waiting(connection)
                if waiting >= self._settings.queue_max:
                    raise QueueFull(
                        f"{waiting} requests wait already, the most that may; ask again when some "
                        "are done"
                    )
            token = jobs.accept(connection, new, self._settings.lease_s if mine else None)
            audit.record(connection, key_id=new.key_id, action=f"{new.kind}.accept", subject=new.id)
            job = jobs.get(connection, new.id)
        assert job is not None
        return job, token

    def cancel(self, job_id: str, key_id: str | None) -> Job | None:
        """End a job; one that another service works on ends within its POLL_S."""
        with self._database.writing() as connection:
            job = jobs.cancel(connection, job_id)
            if job is None:
                return None
            audit.record(connection, key_id=key_id, action=f"{job.kind}.cancel", subject=job_id)
        running = self._running.get(job_id)
        if running is not None:
            running.stop.request()
        elif not job.is_open:
            self._tell_watchers(job_id, job)
        return job

    @contextmanager
    def watching(self, job_id: str) -> Iterator[tuple[Future[Job | None], bool]]:
        """A future, and whether the job is worked on here now.

        Done when work on the job here has ended and that is stored, whenever it began; None
        unless it is the end of the job, too.
        """
        ended: Future[Job | None] = Future()
        with self._lock:
            self._watchers.setdefault(job_id, []).append(ended)
            is_here = job_id in self._running
        try:
            yield ended, is_here
        finally:
            with self._lock:
                watchers = self._watchers.get(job_id, [])
                if ended in watchers:
                    watchers.remove(ended)
                if not watchers:
                    self._watchers.pop(job_id, None)

    def _tell_watchers(self, job_id: str, end: Job | None) -> None:
        with self._lock:
            watchers = self._watchers.pop(job_id, [])
        for ended in watchers:
            ended.set_result(end)

    def _wake_up(self) -> None:
        self._may_wait = True
        self._wake.set()

    def _take_place(self) -> bool:
        with self._lock:
            if self._free <= 0 or self._closing.is_set():
                return False
            self._free -= 1
            return True

    def _leave_place(self) -> None:
        with self._lock:
            self._free += 1

    def _hand_place_on(self) -> None:
        """To a job that waits, before anybody takes it again."""
        self._leave_place()
        self._wake_up()

    def _now_running(self) -> list[_Running]:
        with self._lock:
            return list(self._running.values())

    # Work on a job

    def _work(
        self, running: _Running, deadline_s: float, body: bytes, request: object = None
    ) -> Future[Result]:
        kind = running.kind
        task = Task(
            job_id=running.job_id,
            bounds=Bounds(deadline_s=deadline_s, memory_mib=kind.bounds.memory_mib),
            work=kind.work,
            arguments=(body, request),
        )
        run_task = self.run_task
        if kind.shares is not None:
            attempts = self._settings.job_attempts
            sharing = Sharing(run_task=run_task, places=self._places, attempts=attempts)
            run_task = partial(sharing.run, kind.shares)
        return self._threads.submit(
            run_task,
            task,
            running.stop,
            lambda progress: self._record_progress(running, progress),
        )

    def _follow(self, running: _Running, work: Future[Result]) -> None:
        with self._lock:
            before = self._running.get(running.job_id)
            self._running[running.job_id] = running
        if before is not None:  # its lease ran out, and nobody would end it any more
            before.stop.request()
        if self._closing.is_set():  # which may not have seen it
            running.stop.request()
        work.add_done_callback(lambda done: self._end(running, done))

    def _record_progress(self, running: _Running, progress: Progress) -> None:
        now_s = time.monotonic()
        if now_s - running.progress_s < PROGRESS_S or not running.token:
            running.untold = progress
            return
        running.progress_s, running.untold = now_s, None
        data = {name: value for name, value in asdict(progress).items() if value is not None}
        try:
            with self._database.writing() as connection:
                if jobs.job_of_lease(connection, running.token) is not None:
                    events.record(connection, running.job_id, events.PROGRESS, data)
        except (StoreUnavailable, SQLAlchemyError) as error:  # the work matters more
            log.warning("progress can't be stored", job=running.job_id, error=error)

    def _end(self, running: _Running, done: Future[Result]) -> None:
        took_s = time.monotonic() - running.began_s
        settled = None
        try:
            settled = self._store_end(running, done)
            if settled is not None:
                result = done.result() if done.exception() is None else None
                iterations = None if result is None else result.iterations
                self._on_end(running.kind.name, settled.state, took_s, iterations)
        except Exception as error:  # noqa: BLE001 (its lease runs out, and it is taken up again)
            log.error("the end couldn't be stored", job=running.job_id, exc_info=error)
        finally:
            self._leave_place()
            with self._lock:
                if self._running.get(running.job_id) is running:
                    del self._running[running.job_id]
            is_open = settled is not None and settled.is_open
            self._tell_watchers(running.job_id, None if is_open else settled)
            # A look that finds nothing would only keep the answer waiting for the interpreter.
            if self._may_wait or is_open or running.parent_id is not None:
                self._wake_up()

    def _store_end(self, running: _Running, done: Future[Result]) -> Job | None:
        """What the job has become; None when it is no longer ours.

        What no database takes would fail again at every attempt: it is given up at once.
        """
        most = self._settings.job_attempts
        try:
            return self._change(
                running, lambda connection, job: settle(connection, job, running.kind, done, most)
            )
        except StoreUnavailable:
            raise  # the service ends before the database is back: the next takes it up
        except Exception as error:  # noqa: BLE001 (whatever it is, the job must end)
            log.error("a result can't be stored", job=running.job_id, exc_info=error)
            return self._change(running, give_up)

    def _change(self, running: _Running, change: Callable[[Connection, Job], Job]) -> Job | None:
        """What `change` makes of a job that is still ours, when the database is back.

        Until then its place is taken, so that no more is begun than can be kept.
        """
        pauses_s = chain(_STORE_PAUSES_S, repeat(_STORE_PAUSES_S[-1]))
        while True:
            try:
                # What has no parts is made again from its request, were this lost.
                lasting = running.kind.parts is not None
                with self._database.writing(lasting=lasting) as connection:
                    job = jobs.job_of_lease(connection, running.token)
                    if job is None:
                        log.warning("a lease was lost", job=running.job_id)
                        return None
                    return change(connection, job)
            except StoreUnavailable:
                if self._closing.is_set():
                    raise
                log.warning("a result can't be stored yet", job=running.job_id)
                self._closing.wait(next(pauses_s))

    # The thread

    def _work_until_closed(self) -> None:
        while not self._closing.is_set():
            try:
                self._begin_waiting()
                self._keep_leases()
                for running in self._now_running():  # a stage that began right after another
                    if running.untold is not None:
                        self._record_progress(running, running.untold)
                self._prune()
            except StoreUnavailable:  # which is told where it is raised
                self._closing.wait(_PAUSE_S)
            except Exception as error:  # noqa: BLE001 (nothing is worked on without this thread)
                log.error("jobs can't be looked after", exc_info=error)
                self._closing.wait(_PAUSE_S)
            self._wake.wait(POLL_S)
            self._wake.clear()

    def _begin_waiting(self) -> None:
        while self._is_work_waiting() and self._take_place():
            claimed = None
            try:
                claimed = self._claim_next()
            finally:
                if claimed is None:
                    self._leave_place()
            if claimed is None:
                return
            job = claimed.job
            kind, token = JOB_KINDS[job.kind], claimed.token
            running = _Running(job_id=job.id, kind=kind, parent_id=job.parent_id, token=token)
            self._follow(running, self._work(running, job.deadline_s, claimed.request))

    def _is_work_waiting(self) -> bool:
        self._may_wait = True
        if self._free <= 0:
            return False
        with self._database.reading() as connection:
            self._may_wait = jobs.is_work_waiting(connection, tuple(JOB_KINDS))
        return self._may_wait

    def _claim_next(self) -> Claim | None:
        """The next job that is to be worked on."""
        while True:
            with self._database.writing() as connection:
                claimed = jobs.claim(connection, tuple(JOB_KINDS), self._settings.lease_s)
                if claimed is None:
                    return None
                job = claimed.job
                if job.cancel_requested:
                    jobs.finish(connection, job, "cancelled")
                elif job.attempts >= self._settings.job_attempts:
                    take_up_again(connection, job, self._settings.job_attempts)
                else:
                    return claimed

    def _keep_leases(self) -> None:
        """Keep the leases; end what somebody cancelled or is no longer ours."""
        by_token = {running.token: running for running in self._now_running()}
        if not by_token:
            return
        now_s = time.monotonic()
        if now_s - self._extended_s >= self._settings.lease_s / 4.0:
            with self._database.writing() as connection:
                unwanted = jobs.extend(connection, tuple(by_token), self._settings.lease_s)
            self._extended_s = now_s
        else:
            with self._database.reading() as connection:
                unwanted = jobs.leases_to_end(connection, tuple(by_token))
        for token in unwanted:
            by_token[token].stop.request()

    def _prune(self) -> None:
        """Delete what the operator doesn't keep."""
        now_s = time.monotonic()
        if self._settings.retention_days is None or now_s < self._pruned_s:
            return
        before_utc = datetime.now(UTC) - timedelta(days=self._settings.retention_days)
        with self._database.writing() as connection:
            gone = jobs.remove_finished(connection, before_utc, _PRUNED_AT_ONCE)
            for job_id in gone:
                audit.record(connection, key_id=None, action="retention.delete", subject=job_id)
        self._pruned_s = now_s + (0.0 if len(gone) == _PRUNED_AT_ONCE else _PRUNE_S)
