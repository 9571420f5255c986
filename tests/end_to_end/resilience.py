"""Every accepted job is finished or reported, once, whatever is killed in the middle.

Rounds of one campaign each.  While it is asked for, chosen and planned, the service, one of its
solver children or (--cluster) a Dask worker is killed with SIGKILL at random moments, and what a
machine's supervisor would start again is started again; no child outlives whom it works for.
Then the database is audited: the campaign is there once and done; every pass has one last plan,
every plan that is done is stored once and ended once; no look is lost: each is in a last plan or
told as left out.

    OMP_NUM_THREADS=1 PYTHONPATH=tests python tests/end_to_end/resilience.py [--rounds 20]
        [--targets 200] [--days 0.5] [--kills 3] [--cluster] [--seed 1]
        [--database postgresql+psycopg://USER@HOST/NAME]

The database must be this script's own.
"""

import argparse
import contextlib
import json
import os
import random
import re
import signal
import subprocess
import sys
import tempfile
import time
import zlib
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import httpx2 as httpx
from live_service import children_of
from waiting import PATIENCE_S, alive, eventually

from app.store import events, jobs, results
from app.store.database import Database, open_database

ROOT = Path(__file__).parents[2]
BIN = Path(sys.executable).parent


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=20)
    parser.add_argument("--targets", type=int, default=200)
    parser.add_argument("--days", type=float, default=0.5)
    parser.add_argument("--kills", type=int, default=3)
    parser.add_argument("--cluster", action="store_true")
    parser.add_argument("--database", default="")
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args()
    rng = random.Random(asked.seed)
    killed: Counter[str] = Counter()
    totals: Counter[str] = Counter()
    with tempfile.TemporaryDirectory(prefix="slewtrack-resilience-") as folder:
        house = House(folder=Path(folder), database_url=asked.database, cluster=asked.cluster)
        house.start()
        try:
            for number in range(asked.rounds):
                body = campaign_body(asked.targets, asked.days, number)
                began_s = time.monotonic()
                victims = _round(house, body, asked.kills, rng, f"round-{asked.seed}-{number}")
                found = _audited(house, f"round {number}")
                killed.update(victims)
                totals.update(found)
                print(
                    f"round {number}: killed {', '.join(victims)}; {found['plans']} plans, "
                    f"{found['begun']} times begun, {found['refused']} refused; "
                    f"{time.monotonic() - began_s:.0f} s",
                    flush=True,
                )
        finally:
            house.end()
    print(
        f"{asked.rounds} campaigns, {sum(killed.values())} kills ({dict(killed)}): "
        f"{totals['plans']} plans, {totals['looks']} looks, none lost, none doubled; begun "
        f"{totals['begun']} times, {totals['refused']} refused, {totals['failed']} failed"
    )


@dataclass
class House:
    """The service, `solves` at a time, and with a cluster its scheduler and two workers."""

    folder: Path
    database_url: str
    cluster: bool
    solves: int = 2
    scheduler: str = ""
    running: dict[str, "subprocess.Popen[bytes]"] = field(default_factory=dict)
    campaign_id: str = ""

    def start(self) -> None:
        if self.cluster:
            self._run("scheduler")
            said = r"Scheduler at: +(tcp://\S+)"
            self.scheduler = eventually(lambda: self._told("scheduler", said))
            self._run("worker 0")
            self._run("worker 1")
        self._run("service")

    def _told(self, name: str, pattern: str) -> str:
        """What its log says last of it; empty where it says nothing yet."""
        found = re.findall(pattern, (self.folder / f"{name}.log").read_text(errors="replace"))
        return found[-1] if found else ""

    def _run(self, name: str) -> None:
        address = ["--host", "127.0.0.1", "--port", "0", "--dashboard-address", "127.0.0.1:0"]
        commands = {
            "scheduler": ["dask", "scheduler", "--no-dashboard", *address],
            "worker": ["slewtrack", "worker", "--scheduler", self.scheduler, "--solves", "1"],
            "service": ["slewtrack", "serve", "--port", "0"],
        }
        program, *arguments = commands[name.split()[0]]
        environment = os.environ | {
            "OMP_NUM_THREADS": "1",
            "SLEWTRACK_DATA_DIR": str(self.folder),
            "SLEWTRACK_DATABASE_URL": self.database_url,
            "SLEWTRACK_DASK_SCHEDULER": self.scheduler,
            "SLEWTRACK_WORKERS": str(self.solves),
            "SLEWTRACK_LEASE_S": "3",
            "SLEWTRACK_JOB_ATTEMPTS": "20",
        }
        with (self.folder / f"{name}.log").open("ab") as log:
            self.running[name] = subprocess.Popen(
                [str(BIN / program), *arguments], env=environment, stdout=log, stderr=log
            )

    def kill_one(self, rng: random.Random) -> str | None:
        """SIGKILL, and start again what a supervisor would; None where there was no child."""
        kinds = ["service", "child", "worker"] if self.cluster else ["service", "child"]
        kind = rng.choice(kinds)
        if kind == "child":
            holders = [one for name, one in self.running.items() if name != "scheduler"]
            children = [pid for holder in holders for pid in children_of(holder.pid)]
            if not children:
                return None
            with contextlib.suppress(ProcessLookupError):
                os.kill(rng.choice(children), signal.SIGKILL)
            return "child"
        self.kill(rng.choice([name for name in self.running if name.startswith(kind)]))
        return kind

    def kill(self, name: str) -> None:
        """Its children end by themselves; then it is started again."""
        orphans = children_of(self.running[name].pid)
        self.running[name].kill()
        self.running[name].wait()
        eventually(lambda: not any(map(alive, orphans)))
        self._run(name)

    def end(self) -> None:
        for process in reversed(self.running.values()):
            process.terminate()
        for process in self.running.values():
            process.wait(timeout=PATIENCE_S)

    def ask(self, method: str, path: str, body: bytes | None = None, **headers: str) -> Any:
        """The answer's JSON; tried again while the service is down."""

        def answered() -> httpx.Response | None:
            address = self._told("service", r"running on (http://[\d.:]+)")
            with contextlib.suppress(httpx.TransportError):
                given = {"content": body, "headers": headers, "timeout": 30.0}
                return httpx.request(method, address + path, **given)
            return None

        answer = eventually(answered)
        assert answer.is_success, answer.text[:500]
        return answer.json()

    @contextlib.contextmanager
    def database(self) -> Any:
        database: Database = open_database(self.database_url, self.folder)
        try:
            yield database
        finally:
            database.close()


def _round(house: House, body: bytes, kills: int, rng: random.Random, key: str) -> list[str]:
    """One campaign to its end; whom it lost on the way.

    The service is killed as it is asked, too: who has no answer asks again under the same key.
    """
    headers = {"Content-Type": "application/json", "Idempotency-Key": key}
    house.ask("GET", "/healthz")
    with ThreadPoolExecutor(1) as thread:
        asking = thread.submit(house.ask, "POST", "/v1/campaigns", body, **headers)
        time.sleep(rng.uniform(0.0, 0.1))
        house.kill("service")
        accepted = asking.result()
    house.campaign_id = accepted["id"]
    victims = []
    moved, moved_s = 0, time.monotonic()
    while True:
        time.sleep(rng.uniform(0.2, 2.5))
        told = house.ask("GET", f"/v1/campaigns/{house.campaign_id}")
        if told["state"] not in ("queued", "running"):
            break
        if len(victims) < kills:
            victim = house.kill_one(rng)
            victims += [victim] if victim is not None else []
        ended = sum(one["state"] not in ("queued", "running") for one in told["passes"] or ())
        if ended != moved:
            moved, moved_s = ended, time.monotonic()
        if time.monotonic() > moved_s + PATIENCE_S:
            raise AssertionError(f"still for {PATIENCE_S:g} s: {json.dumps(told)[:2000]}")
    # Asked again under its key it is the same one, not another.
    assert house.ask("POST", "/v1/campaigns", body, **headers)["id"] == house.campaign_id
    return victims


def _audited(house: House, name: str) -> dict[str, int]:
    """What the database holds of the campaign; raises AssertionError where it is wrong."""
    with house.database() as database, database.reading() as connection:
        whole = jobs.get(connection, house.campaign_id)
        document = results.document(connection, house.campaign_id)
        parts = jobs.parts_of(connection, house.campaign_id)
        assert whole is not None, name
        [same] = [one for one in jobs.latest(connection, "campaign", 9) if one.name == whole.name]
        assert same.id == whole.id, name
        assert whole.state == "done", (name, whole)
        assert document is not None, name
        choice = json.loads(zlib.decompress(document))
        last = {part.options["campaign"]["pass"]: part for part in parts}
        assert len(last) == choice["passes"], (name, len(last), choice["passes"])
        for one in (whole, *parts):
            ends = [
                event.data["state"]
                for event in events.after(connection, one.id, 0)
                if event.kind == events.STATE and event.data["state"] not in ("queued", "running")
            ]
            assert ends == [one.state], (name, one.id, ends)
            assert one.state == "done" or one.problem is not None, (name, one)
        replaced = [part for part in parts if part.id != last[part.options["campaign"]["pass"]].id]
        assert all(part.state == "refused" for part in replaced), name
        for part in parts:
            stored = bool(results.get(connection, part.id))
            assert stored == (part.state == "done"), (name, part.id, part.state)
        told = [part.options["campaign"] for part in last.values()]
        looks = sum(len(one["looks"]) + len(one["left_out"]) for one in told)
        assert looks == choice["looks"], (name, looks, choice["looks"])
    states = Counter(part.state for part in parts)
    return {
        "plans": states["done"],
        "looks": looks,
        "begun": whole.attempts + sum(part.attempts for part in parts),
        "refused": states["refused"],
        "failed": states["failed"],
    }


def campaign_body(targets: int, days: float, number: int) -> bytes:
    """Real OCO-3 targets, another part of them each round."""
    listed = json.loads((ROOT / "tests" / "data" / "oco3_targets.json").read_text())["targets"]
    orbit = json.loads((ROOT / "examples" / "las_vegas_2015.json").read_text())["orbit"]
    first = 37 * number % len(listed)
    chosen = (listed + listed)[first : first + targets]
    stop_s = 43200 + round(86400 * days)
    asked = {
        "name": f"round {number}",
        "platform": "iss-hrc",
        "orbit": orbit,
        "targets": [
            {
                "id": identity,
                "priority": 1.0 + row % 5,
                "session_s": 30.0,
                "min_session_s": 15.0,
                "target": {"mode": "ground", "latitude_deg": latitude, "longitude_deg": longitude},
            }
            for row, (identity, _, latitude, longitude) in enumerate(chosen)
        ],
        "start": "2015-02-27T12:00:00Z",
        "stop": time.strftime(
            "%Y-%m-%dT%H:%M:%SZ",
            time.gmtime(1424995200 + stop_s),  # midnight of that day
        ),
        "conditions": {"min_elevation_deg": 30.0},
    }
    return json.dumps(asked).encode()


if __name__ == "__main__":
    main()
