"""Work on other machines is done, stopped, bounded and, when a machine dies, done again."""

import json
import os
import re
import subprocess
import sys
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from child_work import find_looks_once, find_once_hung, hang_once, let_go
from dask import config
from databases import own_settings
from distributed import Client
from job_cases import KINDS, BoundsWithABug
from waiting import PatientClient, alive, eventually

from app.http.app import create_app
from app.http.routes import search_routes
from app.jobs import dask_executor
from app.jobs.child import Bounds, TooDemanding
from app.jobs.dask_address import check_scheduler
from app.jobs.dask_executor import SLOT, DaskExecutor
from app.jobs.kinds import CAMPAIGN, RUNS
from app.jobs.shares import Places, Sharing
from app.jobs.worker_process import ChildDied, ChildFailed, Stop, Stopped, Task
from app.requests.campaign import read_campaign_request
from app.requests.examples import LAS_VEGAS, OPPORTUNITY_EXAMPLES
from app.work.campaign import choose, split_by_carrier
from app.work.cluster_prices import WORKER_OF, priced_by_workers
from app.work.flights import PlanToFly, fly_part
from app.work.plan import plan_and_pack
from app.work.progress import Progress
from planner.base.errors import InvalidInput
from planner.base.reporting import tell_nobody
from planner.planning.campaigns import fleet, looks_of_carrier
from planner.planning.campaigns.joined import joined_of
from planner.planning.campaigns.network import Cut
from planner.planning.campaigns.pricing import (
    AskedPass,
    Question,
    free_path,
    held_path,
    most_at_best,
)

BIN = Path(sys.executable).parent
HERE = Path(__file__).parent
EXAMPLES = HERE.parents[1] / "examples"
CANARY = "canarybody4711"
THREADS = ThreadPoolExecutor(4)
WITHIN_S = 200.0  # a loaded machine takes long to start a worker


@contextmanager
def running(*command, stderr=subprocess.DEVNULL, **settings):
    places = os.pathsep.join((str(HERE), str(HERE.parent), os.environ.get("PYTHONPATH", "")))
    environment = os.environ | {"PYTHONPATH": places, "OMP_NUM_THREADS": "1"} | settings
    process = subprocess.Popen(
        [str(BIN / command[0]), *command[1:]], env=environment, stderr=stderr
    )
    try:
        yield process
    finally:
        process.kill()
        process.wait()


@pytest.fixture(scope="module")
def logs(tmp_path_factory):
    return tmp_path_factory.mktemp("logs")


@pytest.fixture(scope="module")
def scheduler(logs):
    loopback = ("--host", "127.0.0.1", "--port", "0", "--dashboard-address", "127.0.0.1:0")
    command = ("dask", "scheduler", "--no-dashboard", *loopback)
    log = logs / "scheduler"
    with log.open("wb") as stderr, running(*command, stderr=stderr):
        found = eventually(lambda: re.search(r"Scheduler at: +(tcp://\S+)", log.read_text()))
        yield found[1]


@pytest.fixture(scope="module")
def executor(scheduler):
    executor = DaskExecutor(scheduler)
    yield executor
    executor.close()


@contextmanager
def worker(scheduler, log, solves=2):
    told = ("--scheduler", scheduler, "--solves", str(solves))
    settings = {"SLEWTRACK_LOG_FORMAT": "json", "SLEWTRACK_LOG_LEVEL": "debug"}
    with (
        log.open("wb") as stderr,
        running("slewtrack", "worker", *told, stderr=stderr, **settings) as process,
    ):
        yield process


@pytest.fixture(scope="module")
def a_worker(scheduler, logs):
    with worker(scheduler, logs / "first", solves=3) as process:  # as many as one test hangs on it
        yield process


def submitted(executor, work, notes, stop=None, bounds=None, on_progress=lambda _: None):
    task = Task(
        job_id=work,
        bounds=bounds or KINDS[work].bounds,
        work=KINDS[work].work,
        arguments=(os.fsencode(notes), None),
    )
    return THREADS.submit(executor.run, task, stop or Stop(), on_progress)


def pids(notes):
    return notes.read_text().split() if notes.exists() else []


def keys_without_worker(dask_scheduler):
    return [task.key for task in dask_scheduler.unrunnable]


def test_worker_of_another_version_gets_no_work(executor, scheduler, tmp_path, caplog):
    name = ["--name", "other", "--nthreads", "1", "--no-nanny", "--no-dashboard"]
    other = ["--resources", f"{SLOT}.dev=1", *name]
    stop = Stop()
    with running("dask", "worker", scheduler, *other), Client(scheduler) as client:
        client.wait_for_workers(1, timeout=WITHIN_S)
        future = submitted(executor, "note", tmp_path / "notes", stop)
        [key] = eventually(lambda: client.run_on_scheduler(keys_without_worker))
        assert key.startswith("slewtrack-note")
        stop.request()
        with pytest.raises(Stopped):
            future.result(WITHIN_S)
        eventually(lambda: not client.run_on_scheduler(keys_without_worker))  # forgotten
    assert pids(tmp_path / "notes") == []
    assert "no worker of this version is connected" in caplog.text


def test_work_is_done_in_a_child_of_the_worker(executor, a_worker, tmp_path):
    assert submitted(executor, "note", tmp_path / "notes").result(WITHIN_S).state == "done"
    assert len(pids(tmp_path / "notes")) == 1


def test_flights_are_the_same_wherever_they_are_flown(executor, a_worker):
    body = json.dumps(LAS_VEGAS).encode()
    table = plan_and_pack(body).table_columns
    asked = b'{"runs": 4, "seed": 5}'
    what = PlanToFly(plan_id="", asked=asked, request=body, table_columns=table)
    parts = [what.to_bytes(first=first, count=2) for first in (0, 2)]
    futures = [
        THREADS.submit(
            executor.run,
            Task(job_id="runs", bounds=RUNS.bounds, work=RUNS.work, arguments=(part, None)),
            Stop(),
            lambda _: None,
        )
        for part in parts
    ]
    assert [future.result(WITHIN_S) for future in futures] == [fly_part(part) for part in parts]


def test_how_far_work_is_comes_back(executor, a_worker, tmp_path):
    heard = []
    future = submitted(executor, "tell", tmp_path / "notes", on_progress=heard.append)
    try:
        eventually(lambda: len(heard) > 1)
    finally:
        let_go(tmp_path / "notes")
    assert future.result(WITHIN_S).state == "done"
    assert heard[:2] == [Progress(stage="telling", done=1), Progress(stage="telling", done=2)]


def test_errors_come_back_as_they_were(executor, a_worker, tmp_path):
    with pytest.raises(ChildFailed, match="RuntimeError"):
        submitted(executor, "fail", tmp_path / "notes").result(WITHIN_S)
    with pytest.raises(ChildDied):
        submitted(executor, "die", tmp_path / "notes").result(WITHIN_S)
    half_a_second = Bounds(deadline_s=0.5, memory_mib=200)
    with pytest.raises(TooDemanding):
        submitted(executor, "spin", tmp_path / "none", bounds=half_a_second).result(WITHIN_S)


def test_stopped_work_frees_the_worker(executor, a_worker, tmp_path):
    stop, an_hour = Stop(), Bounds(deadline_s=3600.0, memory_mib=200)  # nothing else ends it
    future = submitted(executor, "hang", tmp_path / "notes", stop, an_hour)
    (pid,) = eventually(lambda: pids(tmp_path / "notes"))
    stop.request()
    with pytest.raises(Stopped):
        future.result(WITHIN_S)
    eventually(lambda: not alive(pid))


def test_what_a_worker_was_at_is_done_by_another(
    client, executor, scheduler, a_worker, logs, tmp_path, monkeypatch
):
    """A job, a search that is waited for and the looks of a fleet's carriers all hang on the first,
    which is killed with its machine; the second is told to end.  Each time the next finds that it
    was begun.  No worker tells what it was asked, whatever fails: in JSON here, other formats hide
    the same (test_store_failures.py)."""
    folder = tmp_path / CANARY
    folder.mkdir()
    for work, bounds in (("fail", None), ("die", None), ("note", BoundsWithABug(CANARY))):
        # The last is a bug on the worker, which Dask tells in its words.
        failed = submitted(executor, work, folder / work, bounds=bounds)
        assert failed.exception(WITHIN_S) is not None
    path, asked = "/v1/opportunities?include=view", {"json": OPPORTUNITY_EXAMPLES["cities"][1]}
    windows_here = client.post(path, **asked).json()
    job_file, search_file, looks_file = (folder / name for name in ("job", "search", "looks"))
    finding = partial(find_once_hung, os.fsencode(search_file))
    monkeypatch.setattr(search_routes, "find_windows", finding)
    body = (EXAMPLES / "campaign_fleet.json").read_bytes()
    monkeypatch.setattr(fleet, "BOUNDS", replace(fleet.BOUNDS, large_target_days=0.0))
    given = [b"%s\n%s" % (bytes(looks_file), one) for one in split_by_carrier(body)]
    shares = replace(CAMPAIGN.shares, work=partial(find_looks_once, hang_once))
    places = Places(take=lambda: True, leave=lambda: None, most=0)
    sharing = Sharing(run_task=executor.run, places=places, attempts=1)
    task = Task(job_id="fleet", bounds=CAMPAIGN.bounds, work=choose, arguments=())
    settings = own_settings(tmp_path, dask_scheduler=scheduler, workers=1)
    with PatientClient(create_app(settings)) as served:
        job = submitted(executor, "hang_once", job_file)
        search = THREADS.submit(served.post, path, **asked)
        looks = THREADS.submit(sharing.make, shares, given, task, Stop())
        files = (job_file, search_file, looks_file)
        begun = [eventually(lambda file=file: pids(file))[0] for file in files]
        a_worker.kill()
        with worker(scheduler, logs / "second") as second:
            assert job.result(WITHIN_S).state == "done"
            windows_there = search.result(WITHIN_S).json()
            campaign_there = choose(body, None, looks.result(WITHIN_S))
            assert not any(map(alive, begun))
            told = submitted(executor, "hang_once", folder / "told")
            (pid,) = eventually(lambda: pids(folder / "told"))
            second.terminate()
            assert second.wait(WITHIN_S) == 0
            eventually(lambda: not alive(pid))
    with worker(scheduler, logs / "third"):
        assert told.result(WITHIN_S).state == "done"
    assert [len(pids(file)) for file in (*files, folder / "told")] == [2, 2, 4, 2]
    assert windows_there["windows"] == windows_here["windows"]
    assert windows_there["next"] == windows_here["next"]
    assert campaign_there == choose(body)
    for name in ("scheduler", "first", "second", "third"):
        assert CANARY not in (logs / name).read_text(), name
    [*first], [*second] = ((logs / name).read_text().splitlines() for name in ("first", "second"))
    assert any('"logger": "distributed.worker"' in line for line in second)
    assert all(isinstance(json.loads(line), dict) for line in first[:-1] + second)


def test_passes_of_a_fleet_are_priced_alike_by_workers_and_here(scheduler, logs, monkeypatch):
    """One worker is killed: what it kept is priced here."""
    request = read_campaign_request((EXAMPLES / "campaign_fleet.json").read_bytes())
    looks = partial(looks_of_carrier, tell=tell_nobody, modes_by_pass=True)
    joined = joined_of({carrier: looks(one) for carrier, one in request.requests.items()})
    price = np.linspace(0.0, 0.5, len(joined.candidates))
    most = partial(most_at_best, labels_max=10_000, orders_max=10_000)
    plain = [AskedPass(number) for number in range(len(joined.order))]
    dear = [  # to look at all, and nothing by its first way
        one._replace(
            cuts=(Cut(None, 0, 0, int(network.last[0] - network.first[0])),),
            cost=np.linspace(0.0, 0.1, network.stop_step + 1),
        )
        for one, network in zip(plain, joined.networks.values(), strict=True)
    ]
    asked = [(free_path, plain), (held_path, plain), (held_path, dear), (most, plain)]
    answers = [joined.priced_passes.answers(Question(put, price), own) for put, own in asked]
    assert answers[1] != answers[2]
    passes_here = []
    price_here = joined.priced_passes.answers

    def count(question, own):
        passes_here.append(len(own))
        return price_here(question, own)

    monkeypatch.setattr(joined.priced_passes, "answers", count)
    monkeypatch.setenv(WORKER_OF, scheduler)
    with worker(scheduler, logs / "one") as one, worker(scheduler, logs / "other"):
        with Client(scheduler) as client:
            client.wait_for_workers(2, timeout=WITHIN_S)
        with priced_by_workers(joined) as ask:
            assert [ask(Question(put, price), own) for put, own in asked] == answers
            assert passes_here == [0] * len(asked)
            one.kill()
            put, own = asked[2]
            assert ask(Question(put, price), own[1:]) == answers[2][1:]
    assert 0 < passes_here[-1] < len(own) - 1


def test_looking_for_a_scheduler_in_vain_leaves_no_descriptors(monkeypatch, tmp_path):
    monkeypatch.setattr(dask_executor, "CONNECT_S", 0.1)
    monkeypatch.setattr(dask_executor, "_PAUSE_S", 0.0)
    tries = []
    monkeypatch.setattr(dask_executor.log, "warning", lambda *_, **__: tries.append(descriptors()))
    executor, stop = DaskExecutor("tcp://127.0.0.1:1"), Stop()
    future = submitted(executor, "note", tmp_path / "notes", stop)
    eventually(lambda: len(tries) > 5)
    stop.request()
    with pytest.raises(Stopped):
        future.result(WITHIN_S)
    executor.close()
    assert tries[5] <= tries[0]


class LosingClient:
    """Loses the first task it is given, and never ends another."""

    status = "closed"

    def __init__(self):
        self.futures = []

    def submit(self, *_, **__):
        self.futures.append(Future())
        if len(self.futures) == 1:
            self.futures[0].cancel()
        return self.futures[-1]


def test_work_taken_up_again_after_a_loss_can_be_stopped(monkeypatch, tmp_path):
    monkeypatch.setattr(dask_executor, "_PAUSE_S", 0.0)
    executor, client, stop = DaskExecutor("tcp://127.0.0.1:1"), LosingClient(), Stop()
    monkeypatch.setattr(executor, "_connect", lambda: client)
    future = submitted(executor, "note", tmp_path / "notes", stop)
    eventually(lambda: len(client.futures) == 2)
    stop.request()
    try:
        with pytest.raises(Stopped):
            future.result(WITHIN_S)
    finally:
        client.futures[1].cancel()
        executor.close()


def descriptors():
    return len(os.listdir("/proc/self/fd"))


def test_worker_that_waits_for_its_scheduler_ends_when_told():
    nobody = ("--scheduler", "tcp://127.0.0.1:1", "--solves", "1")
    told = {"stderr": subprocess.PIPE, "SLEWTRACK_LOG_LEVEL": "debug"}
    with running("slewtrack", "worker", *nobody, **told) as process:
        while b"distributed.worker" not in (line := process.stderr.readline()):
            assert line, "it ended by itself"
        process.terminate()
        assert process.wait(WITHIN_S) == 0
        process.stderr.close()


TLS = "distributed.comm.tls."


@pytest.mark.parametrize("address", ["", "nonsense", "10.0.0.1:8786", "tcp://:8786", "tcp://a:x"])
def test_what_is_no_address_is_refused(address):
    with pytest.raises(InvalidInput, match="tcp://HOST:PORT") as refused:
        check_scheduler(address, "client", "--scheduler")
    assert refused.value.field == "--scheduler"


def test_connections_without_the_certificates_they_need_are_refused(tmp_path):
    check_scheduler("tcp://10.0.0.1:8786", "worker", "--scheduler")
    with pytest.raises(InvalidInput, match="WORKER__CERT"):
        check_scheduler("tls://10.0.0.1:8786", "worker", "--scheduler")
    missing = str(tmp_path / "missing.pem")
    files = {TLS + "ca-file": missing, TLS + "client.cert": missing, TLS + "client.key": missing}
    with config.set(files), pytest.raises(InvalidInput, match=r"missing\.pem"):
        check_scheduler("tls://10.0.0.1:8786", "client", "--scheduler")
    required = config.set({"distributed.comm.require-encryption": True})
    with required, pytest.raises(InvalidInput, match="tls://10"):
        check_scheduler("tcp://10.0.0.1:8786", "client", "--scheduler")
