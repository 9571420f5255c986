"""A service under attack: who asks it with a good key, and what of each answer counts."""

import json
import os
import re
import subprocess
import sys
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path

import httpx2 as httpx
from hostile_servers import PASSWORD, Database

SLEWTRACK = Path(sys.executable).with_name("slewtrack")
SLOW_S = 2.0
PATIENCE_S = 120.0
WAIT_S = 1  # so that a plan that is worth seconds is no slow answer
# Short, as a log that cuts its lines would show no more of them.
BODY, QUERY = "canary-body", "canary-query"
_ENDED = ("done", "refused", "failed", "cancelled")


@dataclass
class Toll:
    """What one family of attacks cost."""

    tried: int = 0
    broken: int = 0
    slow: int = 0
    leaks: int = 0
    complaints: list[str] = field(default_factory=list)

    @property
    def is_clean(self) -> bool:
        return not (self.broken or self.slow or self.leaks or self.complaints)

    def __str__(self) -> str:
        wrong = len(self.complaints)
        return f"{self.tried:>7}{self.broken:>5}{self.slow:>6}{self.leaks:>7}{wrong:>7}"

    def with_leaks(self, lines: list[str]) -> "Toll":
        told = [f"in the log: {line}" for line in lines[:3]]
        return replace(self, leaks=len(lines), complaints=[*self.complaints, *told])

    def count(self, answer: httpx.Response, took_s: float, *, may_fail: bool = False) -> None:
        """may_fail: whether a 503 that says when to ask again is what the moment calls for."""
        self.tried += 1
        self.slow += took_s > SLOW_S
        told_to_wait = answer.status_code == 503 and "Retry-After" in answer.headers
        if answer.status_code >= 500 and not (may_fail and told_to_wait):
            self.broken += 1
            self.complaints.append(f"{answer.status_code} {answer.text[:200]}")
        if took_s > SLOW_S:
            self.complaints.append(f"{took_s:.1f} s: {answer.request.method} {answer.url}"[:200])

    def require(self, answer: httpx.Response, *statuses: int) -> None:
        if answer.status_code not in statuses:
            asked = f"{answer.request.method} {str(answer.url)[:100]}"
            self.complain(f"{asked}: {answer.status_code}, not {statuses}: {answer.text[:200]}")

    def require_short(self, answer: httpx.Response, most: int) -> None:
        if len(answer.content) > most:
            self.complain(f"a refusal of {len(answer.content)} bytes: {answer.text[:100]}")

    def complain(self, text: str) -> None:
        self.complaints.append(text)


@dataclass
class Siege:
    """A running service that asks everyone for a key, and the holder of a good one."""

    address: str
    secret: str
    folder: Path
    log: Path
    database: Database
    process: "subprocess.Popen[bytes]"
    client: httpx.Client
    accepted: list[str] = field(default_factory=list)

    @property
    def port(self) -> int:
        return int(self.address.rsplit(":", 1)[1])

    def ask(
        self, method: str, path: str, toll: Toll, body: bytes = b"", *, may_fail: bool = False
    ) -> httpx.Response:
        """With the good key; counted."""
        headers = {"Content-Type": "application/json"} if body else {}
        began_s = time.monotonic()
        answer = self.client.request(method, path, content=body, headers=headers)
        toll.count(answer, time.monotonic() - began_s, may_fail=may_fail)
        if answer.status_code == 202:
            self.accepted.append(answer.headers["Location"])
        return answer

    def get(self, path: str, toll: Toll, *, may_fail: bool = False) -> httpx.Response:
        return self.ask("GET", path, toll, may_fail=may_fail)

    def post(
        self, path: str, body: object, toll: Toll, *, may_fail: bool = False
    ) -> httpx.Response:
        return self.ask("POST", path, toll, json.dumps(body).encode(), may_fail=may_fail)

    def at_once(self, method: str, path: str, count: int, toll: Toll) -> list[httpx.Response]:
        """The same from so many threads."""
        with ThreadPoolExecutor(count) as threads:
            return list(threads.map(lambda _: self.ask(method, path, toll), range(count)))

    def wait_for_jobs(self) -> list[dict[str, object]]:
        """What became of all that was accepted."""
        until_s = time.monotonic() + PATIENCE_S
        told = []
        for location in self.accepted:
            while (answer := self.client.get(location)).json().get("state") not in _ENDED:
                if time.monotonic() > until_s:
                    raise TimeoutError(f"{location} has not ended after {PATIENCE_S:g} s")
                time.sleep(0.2)
            told.append(answer.json())
        self.accepted.clear()
        return told

    def require_no_bug_in_jobs(self, toll: Toll) -> None:
        """Refusals and deadlines are fine, our own failures are not."""
        for job in self.wait_for_jobs():
            problem = job.get("problem") or {}
            if problem.get("status", 0) >= 500:
                toll.broken += 1
                toll.complain(json.dumps(problem))

    def leaks(self) -> list[str]:
        """Lines of the log with a secret, a body or a query in them."""
        canaries = (self.secret.split("_", 2)[2][:12], PASSWORD, BODY, QUERY)
        lines = self.log.read_text(errors="replace").splitlines()
        return [line for line in lines if any(canary in line for canary in canaries)]


@contextmanager
def besieged(folder: Path, database: Database, log_format: str) -> Iterator[Siege]:
    """`slewtrack serve` with keys required, on a free port of loopback."""
    environment = os.environ | {
        "SLEWTRACK_DATA_DIR": str(folder),
        "SLEWTRACK_DATABASE_URL": database.url,
        "SLEWTRACK_REQUIRE_KEYS": "true",
        "SLEWTRACK_LOG_FORMAT": log_format,
        "OMP_NUM_THREADS": "1",
    }
    made = subprocess.run(
        [SLEWTRACK, "keys", "create", "bench", "--scope", "write"],
        env=environment, capture_output=True, text=True, check=True,
    )  # fmt: skip
    secret = made.stdout.strip()
    log = folder / "service.log"
    with log.open("wb") as stderr:
        process = subprocess.Popen(
            [SLEWTRACK, "serve", "--port", "0"], stderr=stderr, env=environment
        )
    headers = {"Authorization": f"Bearer {secret}", "Prefer": f"wait={WAIT_S}"}
    try:
        address = _address(process, log)
        with httpx.Client(base_url=address, headers=headers, timeout=PATIENCE_S) as client:
            _await_readiness(client)
            yield Siege(address, secret, folder, log, database, process, client)
    finally:
        process.terminate()
        process.wait(timeout=60)


def _await_readiness(client: httpx.Client) -> None:
    """On a busy machine the first child takes longer to answer than readiness has patience."""
    until_s = time.monotonic() + PATIENCE_S
    while (answer := client.get("/readyz")).status_code != 200:
        if time.monotonic() > until_s:
            raise SystemExit(f"the service is not ready: {answer.text}")
        time.sleep(0.2)


def _address(process: "subprocess.Popen[bytes]", log: Path) -> str:
    while process.poll() is None:
        if found := re.search(r"running on (http://[\d.:]+)", log.read_text()):
            return found[1]
        time.sleep(0.05)
    raise SystemExit(f"the service did not start: {log.read_text()[-2000:]}")
