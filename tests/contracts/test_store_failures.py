"""Answers and logs of a service whose database fails under it: soon, and without a secret."""

import asyncio
import json
import os
import resource
import signal
import sqlite3
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from pathlib import Path

import httpx2 as httpx
import psycopg
import pytest
from databases import SERVER, damage, fresh_database
from job_cases import new_job
from live_service import ROOT, children_of, live_service
from relay import Relay
from sqlalchemy import create_engine, text
from sqlalchemy.exc import DBAPIError
from waiting import eventually

from app.requests.examples import LAS_VEGAS
from app.store import jobs
from app.store.database import FILE, is_damage, is_of_the_store, keeps_all_waiting, open_database
from app.store.keys import KeyStore
from app.store.migrate import upgrade
from app.store.unavailable import StoreDamaged, StoreUnavailable

PASSWORD, BODY, QUERY, COOKIE = (f"canary{word}4711" for word in ("pass", "body", "query", "head"))
ORDER = {**LAS_VEGAS, "name": BODY}
# What may be answered within; for a machine that does other things.  bench/ measures.
SOON_S = 20.0


def superuser(statement: str, *more: str) -> None:
    engine = create_engine(SERVER, isolation_level="AUTOCOMMIT")
    with engine.connect() as connection:
        for one in (statement, *more):
            connection.execute(text(one))
    engine.dispose()


def disconnect(name: str) -> str:
    return f"SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE datname = '{name}'"


@contextmanager
def locked(database, service, relay):
    if SERVER:
        engine = create_engine(database.url)
        with engine.connect() as connection:
            tables = "jobs, keys, audit, events, results, probes"
            connection.execute(text(f"LOCK TABLE {tables} IN ACCESS EXCLUSIVE MODE"))
            yield
        engine.dispose()
    else:
        other = sqlite3.connect(database.url.database, isolation_level=None)
        other.execute("BEGIN EXCLUSIVE")
        yield
        other.close()


@contextmanager
def full(database, service, relay):
    """PostgreSQL: no transaction may write.  SQLite: its files may not grow."""
    if SERVER:
        name = database.url.database
        superuser(f"ALTER DATABASE {name} SET default_transaction_read_only = on", disconnect(name))
        yield
        superuser(f"ALTER DATABASE {name} RESET ALL", disconnect(name))
    else:
        with sqlite3.connect(database.url.database) as other:
            other.execute("PRAGMA wal_checkpoint(TRUNCATE)")
        other.close()
        before = resource.prlimit(service.pid, resource.RLIMIT_FSIZE)
        most = Path(database.url.database).stat().st_size
        resource.prlimit(service.pid, resource.RLIMIT_FSIZE, (most, before[1]))
        yield
        resource.prlimit(service.pid, resource.RLIMIT_FSIZE, before)


@contextmanager
def away(database, service, relay):
    """PostgreSQL lets nobody in; where SQLite's file was is something else."""
    if SERVER:
        name = database.url.database
        superuser(f"ALTER DATABASE {name} ALLOW_CONNECTIONS false", disconnect(name))
        yield
        superuser(f"ALTER DATABASE {name} ALLOW_CONNECTIONS true")
    else:
        file = Path(database.url.database)
        with sqlite3.connect(file) as other:
            other.execute("PRAGMA wal_checkpoint(TRUNCATE)")
        other.close()
        kept = file.read_bytes()
        with file.open("r+b") as opened:
            opened.write(b"\xa5" * len(kept))
        yield
        with file.open("r+b") as opened:
            opened.write(kept)


@contextmanager
def silent(database, service, relay):
    """Connections stay open, and nothing comes."""
    relay.is_silent = True
    yield
    relay.is_silent = False


FAILURES = (locked, full, away, silent) if SERVER else (locked, full, away)


@contextmanager
def network_to(database):
    """URL with a password, which PostgreSQL's `trust` doesn't look at, and what lies between."""
    if SERVER:
        relay = Relay(database.url.host, database.url.port)
        url = database.url.set(password=PASSWORD, host="127.0.0.1", port=relay.port)
        yield url.render_as_string(hide_password=False), relay
        relay.hang_up()
    else:
        yield database.url.render_as_string(), None


def test_a_failing_store_answers_503_and_tells_no_secret(tmp_path):
    """Failing in one way after the other, and well between; logged as JSON.  On the console the
    same is hidden: `test_no_bug_tells_what_it_was_at`."""
    with fresh_database(tmp_path) as database, network_to(database) as (url, relay):
        _, secret = KeyStore(database).create("k", ["admin"])
        settings = {
            "SLEWTRACK_DATABASE_URL": url,
            "SLEWTRACK_LOG_FORMAT": "json",
            "SLEWTRACK_LOG_LEVEL": "debug",
            "SLEWTRACK_REQUIRE_KEYS": "true",
        }
        with live_service(tmp_path, **settings) as service:
            headers = {"Authorization": f"Bearer {secret}", "Prefer": "respond-async"}
            client = httpx.Client(base_url=service.address, headers=headers, timeout=SOON_S)
            accepted = client.post(f"/v1/plans?revises={QUERY}", json=ORDER)
            assert accepted.status_code == 422
            for failure in FAILURES:
                # A database of a loaded machine may take longer than the service waits, and 503 is
                # then what it answers.
                location = eventually(
                    lambda: client.post("/v1/plans", json=ORDER).headers.get("location")
                )
                assert_told(failure, client, location, (database, service, relay))
                assert_outlived(client, location)
            with ThreadPoolExecutor() as threads:
                waiting = threads.submit(ended, service.address, headers)
                os.kill(service.pid, signal.SIGTERM)
                waiting.result()
        told = service.log.read_text()
    for canary in (secret, secret.split("_", 2)[2], PASSWORD, BODY, QUERY):
        assert canary not in told
    for word in ('"bug"', "Traceback"):
        assert word not in told
    assert SERVER or "the database is damaged" in told


def assert_told(failure, client, location, between):
    _, service, _ = between
    with failure(*between):
        answers = eventually(lambda: failing(client, location, failure))
        eventually(lambda: client.get("/readyz").status_code == 503)
        is_damaged = failure is away and not SERVER
        ready = client.get("/readyz").json()["detail"]
        assert is_damaged == ("restore it from a backup" in ready)
        for child in children_of(service.pid):
            with suppress(ProcessLookupError):
                os.kill(child, signal.SIGKILL)
    for answer in answers:
        assert answer.headers["content-type"] == "application/problem+json"
        kind = "store-damaged" if is_damaged else "store-unavailable"
        assert answer.json()["type"].endswith(f":{kind}")
        assert is_damaged == ("restore it from a backup" in answer.json()["detail"])
        assert is_damaged or int(answer.headers["retry-after"]) > 0
        assert is_damaged == ("retry-after" not in answer.headers)


def assert_outlived(client, location):
    eventually(lambda: client.get(location).json().get("state") == "done")
    eventually(lambda: client.get("/readyz").status_code == 200)


def failing(client, location, failure):
    """The answers that were 503 once all that writes is."""
    answers = [
        client.post("/v1/plans", json=ORDER, params={"dry_run": "false"}),
        client.post("/v1/campaigns", json={"name": BODY}),
        client.get("/v1/plans", params={"name": QUERY}),
        client.get("/v1/audit"),
        client.get(location),
        client.get("/metrics"),
        client.delete("/v1/plans/01890a5d-ac96-774b-bcce-b302099a8057"),
    ]
    assert all(answer.status_code in (200, 202, 404, 422, 503) for answer in answers), [
        answer.text for answer in answers
    ]
    reads = SERVER and failure is not full
    refused = [answer for answer in answers if answer.status_code == 503]
    return refused if answers[0] in refused and (not reads or len(refused) > 5) else None


def ended(address, headers):
    """A request that is at work when the service is told to stop."""
    with suppress(httpx.TransportError):
        httpx.post(f"{address}/v1/plans", json=ORDER, headers=headers, timeout=SOON_S)


RAISING = f"""
import asyncio, json, logging, sys, threading, warnings
from fastapi.testclient import TestClient
from app.http.app import create_app
from app.log.logs import configure_logs, log

configure_logs("debug", sys.argv[1])
app = create_app()

@app.post("/v1/broken")
async def broken(token: str = ""):
    body = "{BODY}"
    async def forgotten():
        raise KeyError(body)
    asyncio.get_running_loop().call_soon(print_nothing, body)
    task = asyncio.ensure_future(forgotten())
    await asyncio.sleep(0.01)
    del task
    try:
        raise ValueError(body)
    except ValueError as error:
        raise ExceptionGroup(body, [RuntimeError(token, error)]) from error

def print_nothing(body):
    raise RuntimeError(body)

def thread():
    raise RuntimeError("{BODY}")

with TestClient(app, raise_server_exceptions=False) as client:
    answer = client.post("/v1/broken?token={QUERY}", headers={{"Cookie": "{COOKIE}"}})
    assert answer.status_code == 500, answer.text
    started = threading.Thread(target=thread)
    started.start(), started.join()
    library = logging.getLogger("library")
    for text in (BODY := "{BODY}",):
        library.error("it failed: %s %r %(", text, RuntimeError(text))
        library.error("it failed for %s at %d", text, 7, extra={{"request": text}})
        library.error(f"it failed for {{text}}", stack_info=False)
        library.error(RuntimeError(text))
        log.error("ours", error=RuntimeError(text), request=[text])
        warnings.warn(text)
raise RuntimeError("{BODY}")
"""


@pytest.mark.parametrize("log_format", ["json", "console"])
def test_no_bug_tells_what_it_was_at(tmp_path, log_format):
    environment = os.environ | {"SLEWTRACK_DATA_DIR": str(tmp_path), "SLEWTRACK_DATABASE_URL": ""}
    ran = subprocess.run(
        [sys.executable, "-c", RAISING, log_format],
        capture_output=True,
        text=True,
        cwd=ROOT,
        env=environment,
    )
    assert ran.returncode == 1
    for told in ("KeyError", "ExceptionGroup", "RuntimeError", "print_nothing", "uncaught"):
        assert told in ran.stderr
    assert "text withheld" in ran.stderr
    assert "it failed" not in ran.stderr
    for canary in (BODY, QUERY, COOKIE):
        assert canary not in ran.stderr
    if log_format == "json":
        assert all(isinstance(json.loads(line), dict) for line in ran.stderr.splitlines())


def test_of_many_lines_of_a_kind_one_a_second_is_told():
    code = (
        "import logging, time\n"
        "from app.log.logs import configure_logs, log\n"
        "configure_logs('info', 'json')\n"
        "def burst():\n"
        "    for n in range(1000): logging.getLogger('library').error('out of %d', n)\n"
        "burst(); time.sleep(1.1); burst(); log.warning('another kind')"
    )
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT)
    told = [json.loads(line) for line in ran.stderr.splitlines()]
    # A machine that stands still for a second tells one more.
    assert 3 <= len(told) < 20
    assert sum(one.get("left_out", 0) for one in told) > 900


@pytest.mark.parametrize("path", ["/v1/plans", "/v1/spacecraft/plans", "/v1/campaigns"])
def test_one_of_many_deletes_deletes(client, tmp_path, path):
    kinds = {"/v1/plans": "plan", "/v1/spacecraft/plans": "spacecraft"}
    new = new_job(kinds.get(path, "campaign"), tmp_path)
    with client.app.state.database.writing() as connection:
        jobs.accept(connection, new, lease_s=3600.0)
        jobs.finish(connection, jobs.get(connection, new.id), "cancelled")
    with ThreadPoolExecutor(16) as threads:
        codes = list(
            threads.map(lambda _: client.delete(f"{path}/{new.id}").status_code, range(16))
        )
    assert sorted(codes) == [204] + [404] * 15


def test_a_server_that_takes_no_connection_in_time_is_at_fault():
    timeout = psycopg.errors.ConnectionTimeout("connection timeout expired")
    error = DBAPIError.instance("", {}, timeout, psycopg.Error)
    assert is_of_the_store(error)
    assert keeps_all_waiting(error)


def test_a_silent_server_is_left_to_the_thread_that_asks_it(tmp_path):
    """It is told while the thread still waits, and nobody else waits just after."""
    answers = threading.Event()
    database = open_database("postgresql+psycopg://nobody@127.0.0.1:1/none", tmp_path)
    database.looks_for_answer = 1
    try:
        with pytest.raises(StoreUnavailable, match="doesn't answer"):
            asyncio.run(database.answer(answers.wait))
        for begin in (database.reading, database.writing):
            with pytest.raises(StoreUnavailable, match="just now"), begin():
                pass
    finally:
        answers.set()
        database.close()


def test_what_sqlite_takes_its_time_for_is_waited_for(tmp_path):
    """Its writers queue as long as one of them gets through."""
    database = open_database("", tmp_path)
    assert asyncio.run(database.answer(lambda: time.sleep(2.5) or "written")) == "written"
    database.close()


@pytest.mark.skipif(bool(SERVER), reason="of SQLite")
def test_a_database_damaged_in_the_middle_is_told_as_damaged(tmp_path):
    """Its header is whole; a service answers as above."""
    database = open_database("", tmp_path)
    upgrade(database)
    database.close()
    damage(tmp_path / FILE)
    with (
        pytest.raises(StoreDamaged, match="restore it from a backup"),
        database.writing() as connection,
    ):
        jobs.accept(connection, new_job("plan", tmp_path))
    database.close()


@pytest.mark.parametrize("kind", [psycopg.errors.DataCorrupted, psycopg.errors.IndexCorrupted])
def test_what_postgresql_finds_corrupted_is_damage(kind):
    damaged = DBAPIError.instance("", {}, kind("invalid page in block 0"), psycopg.Error)
    assert is_of_the_store(damaged)
    assert is_damage(damaged)
    full = psycopg.errors.DiskFull("could not extend file")
    assert not is_damage(DBAPIError.instance("", {}, full, psycopg.Error))


@pytest.mark.skipif(bool(SERVER), reason="of SQLite")
def test_a_restored_sqlite_file_is_read_anew(tmp_path):
    """A connection that saw the damage would keep its pages, as nothing was written since."""
    database = open_database("", tmp_path)
    upgrade(database)
    assert count_jobs(database) == 0
    other = sqlite3.connect(tmp_path / FILE)
    other.execute("PRAGMA user_version = 1")  # else what was read before is still known
    with away(database, None, None), pytest.raises(StoreDamaged):
        count_jobs(database)
    assert count_jobs(database) == 0
    other.close()
    database.close()


@pytest.mark.skipif(bool(SERVER), reason="of SQLite")
def test_what_was_stored_before_a_damage_outlives_it(tmp_path):
    """It is in the log beside the file, which is deleted with the last connection."""
    database = open_database("", tmp_path)
    upgrade(database)
    file = tmp_path / FILE
    with sqlite3.connect(file) as other:
        other.execute("PRAGMA wal_checkpoint(TRUNCATE)")
    other.close()
    KeyStore(database).create("k", ["read"])
    kept = file.read_bytes()
    with file.open("r+b") as opened:
        opened.write(b"\xa5" * len(kept))
    with pytest.raises(StoreUnavailable):
        count_jobs(database)
    with file.open("r+b") as opened:
        opened.write(kept)
    assert count_jobs(database) == 0
    assert [key.name for key in KeyStore(database).all()] == ["k"]
    database.close()


def count_jobs(database):
    with database.reading() as reader:
        return reader.execute(text("SELECT count(*) FROM jobs")).scalar()
