"""Every accepted plan is finished or reported when the service is killed again and again.

SLEWTRACK_CRASH_ROUNDS=20 kills it so often; the suite has few rounds, each at a random moment.
"""

import json
import os
import random
import signal
import time
from contextlib import suppress

import httpx2 as httpx
import pytest
from databases import fresh_database
from live_service import children_of, live_service
from sqlalchemy import func, select
from waiting import PATIENCE_S, alive, eventually

from app.ids import OPEN_STATES
from app.requests.examples import LAS_VEGAS
from app.store import events, jobs
from app.store.models import EventRow, JobRow, ResultRow

ROUNDS = int(os.environ.get("SLEWTRACK_CRASH_ROUNDS", "2"))
PLANS_PER_ROUND = 8
LEASE_S = 2.0
# Ten seconds of the session, to keep it quick; and of a target the pass never sees.
SESSION = {**LAS_VEGAS["sessions"][0], "stop": "2015-02-27T17:36:30Z"}
SHORT = {**LAS_VEGAS, "sessions": [SESSION]}
BELOW = {
    **SHORT,
    "sessions": [{**SESSION, "target": {**SESSION["target"], "latitude_deg": -36.0}}],
}


class Mission:
    """Posts plans, each under a key of its own, until the service accepted them."""

    def __init__(self) -> None:
        self.accepted: dict[str, str] = {}
        self.sent: dict[str, dict] = {}

    def post(self, address: str, key: str) -> None:
        document = self.sent.setdefault(key, BELOW if random.random() < 0.2 else SHORT)
        headers = {"Prefer": "respond-async", "Idempotency-Key": key}
        with suppress(httpx.TransportError):
            answer = httpx.post(
                f"{address}/v1/plans", json=document, headers=headers, timeout=PATIENCE_S
            )
            assert answer.status_code in (201, 202, 422), answer.text
            job_id = answer.headers["location"].rsplit("/", 1)[1]
            assert self.accepted.setdefault(key, job_id) == job_id

    def unanswered(self) -> list[str]:
        return [key for key in self.sent if key not in self.accepted]


@pytest.mark.timeout(300 * ROUNDS)
def test_nothing_accepted_is_lost_or_done_twice(tmp_path):
    seed = random.randrange(2**32)
    random.seed(seed)
    print(f"seed {seed}")  # shown when the test fails
    mission = Mission()
    with fresh_database(tmp_path) as database:
        url = database.url.render_as_string(hide_password=False)
        settings = {
            "SLEWTRACK_DATABASE_URL": url,
            "SLEWTRACK_LEASE_S": str(LEASE_S),
            "SLEWTRACK_WORKERS": "2",
            "SLEWTRACK_JOB_ATTEMPTS": "100",  # each kill takes one of some job
        }
        for number in range(ROUNDS):
            with live_service(tmp_path, **settings) as service:
                kill_at_s = time.monotonic() + random.uniform(0.2, 4.0)
                keys = [f"{number}-{k}" for k in range(PLANS_PER_ROUND)]
                for key in [*mission.unanswered(), *keys]:
                    mission.post(service.address, key)
                    for child in children_of(service.pid)[: random.random() < 0.2]:
                        with suppress(ProcessLookupError):
                            os.kill(child, signal.SIGKILL)
                time.sleep(max(kill_at_s - time.monotonic(), 0.0))
                orphans = children_of(service.pid)
                os.kill(service.pid, signal.SIGKILL)
                await_end_of(orphans)
        with live_service(tmp_path, **settings) as service:
            for key in mission.unanswered():
                mission.post(service.address, key)
            await_end_of_all_jobs(database)
        judge(database, mission)


def await_end_of(pids: list[int]) -> None:
    """Children must not outlive a service that can't tell them to end."""
    eventually(lambda: not any(map(alive, pids)))


def await_end_of_all_jobs(database) -> None:
    def none_is_open():
        with database.reading() as connection:
            return not any(state in OPEN_STATES for _, state in jobs.counts(connection))

    eventually(none_is_open)


def judge(database, mission: Mission) -> None:
    assert mission.unanswered() == []
    assert len(set(mission.accepted.values())) == len(mission.sent) == ROUNDS * PLANS_PER_ROUND
    with database.reading() as connection:
        assert connection.scalar(select(func.count()).select_from(JobRow)) == len(mission.sent)
        for key, job_id in mission.accepted.items():
            job = jobs.get(connection, job_id)
            wanted = "refused" if mission.sent[key] is BELOW else "done"
            assert job.state == wanted, json.dumps(job.problem)
            ends = [
                event.data["state"]
                for event in events.after(connection, job_id, 0)
                if event.kind == events.STATE and event.data["state"] not in ("queued", "running")
            ]
            assert ends == [wanted]
        made = sum(document is SHORT for document in mission.sent.values())
        assert connection.scalar(select(func.count()).where(ResultRow.part == 0)) == made
        begun = connection.scalar(
            select(func.count()).where(EventRow.data["attempt"].as_integer() > 1)
        )
    print(f"{len(mission.sent)} plans, {begun} begun more than once")
