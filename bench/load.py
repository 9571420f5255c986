"""Does the service keep its contract, its pace and its memory under many clients at a time?

Clients on loopback, each asking again as soon as it is answered: plans that work out, plans no
platform can fly, and bodies that are no request, in turn.  Prints throughput, p50 and p99 by
what was asked, every answer the contract doesn't have, and the memory of service and children by
quarters of the time.  Ends with 1 when an answer or the memory was not as promised.

    OMP_NUM_THREADS=1 python bench/load.py [--clients 32] [--seconds 60]
"""

import argparse
import itertools
import json
import os
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from threading import Event

import httpx2 as httpx
import numpy as np
from plan import EXAMPLE, running_service

GROWTH_MAX = 0.05  # of memory, first to last quarter
_SAMPLE_S = 0.5
_WARM_UP_S = 10.0  # before memory counts: all threads and connections are there, caches are full
_MALFORMED = (b"", b"{", b'{"name": NaN}', b"[" * 2000, b'{"name": "nothing else"}', b"\xff\xfe")


@dataclass(frozen=True, kw_only=True)
class Kind:
    """What is asked, and the answers the contract has for it: (status, type of the problem)."""

    name: str
    answers: frozenset[tuple[int, str | None]]


GOOD = Kind(name="good", answers=frozenset({(201, None), (202, None)}))
INFEASIBLE = Kind(name="infeasible", answers=frozenset({(422, "not-visible"), (202, None)}))
MALFORMED = Kind(name="malformed", answers=frozenset({(400, None), (422, "invalid-request")}))


@dataclass(frozen=True, kw_only=True)
class Answer:
    kind: Kind
    status: int
    problem: str | None
    took_s: float
    complaint: str | None


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--clients", type=int, default=32)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--database-url", default="", help="PostgreSQL in place of SQLite")
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="slewtrack-load-") as folder:
        os.environ |= {"SLEWTRACK_DATA_DIR": folder, "SLEWTRACK_DATABASE_URL": asked.database_url}
        with running_service() as (client, pid):
            sound = _report(*_loaded(str(client.base_url), pid, asked.clients, asked.seconds))
    sys.exit(0 if sound else 1)


def _loaded(
    address: str, pid: int, clients: int, seconds: float
) -> tuple[list[Answer], list[tuple[float, float]], float]:
    over = Event()
    numbers = itertools.count()
    memory_mib = []
    with ThreadPoolExecutor(clients) as threads:
        asking = [threads.submit(_ask, address, numbers, over) for _ in range(clients)]
        began_s = time.monotonic()
        time.sleep(_WARM_UP_S)
        while time.monotonic() - began_s < _WARM_UP_S + seconds:
            time.sleep(_SAMPLE_S)
            memory_mib.append(_memory_mib(pid))
        over.set()
        answers = [answer for each in asking for answer in each.result()]
    return answers, memory_mib, time.monotonic() - began_s


def _ask(address: str, numbers: Iterator[int], over: Event) -> list[Answer]:
    answers = []
    with httpx.Client(base_url=address, timeout=120.0) as client:
        while not over.is_set():
            kind, body = _request(next(numbers))
            began_s = time.perf_counter()
            try:
                answer = client.post(
                    "/v1/plans", content=body, headers={"Content-Type": "application/json"}
                )
            except httpx.HTTPError as error:
                took_s = time.perf_counter() - began_s
                answers.append(_answered(kind, took_s, 0, None, repr(error)))
            else:
                took_s = time.perf_counter() - began_s
                told = answer.json()
                problem = told.get("type", "").rsplit(":", 1)[-1] or None
                answers.append(_answered(kind, took_s, answer.status_code, problem, answer.text))
    return answers


def _answered(kind: Kind, took_s: float, status: int, problem: str | None, text: str) -> Answer:
    known = (status, problem) in kind.answers or (status, None) in kind.answers
    complaint = None if known else text[:300]
    return Answer(kind=kind, status=status, problem=problem, took_s=took_s, complaint=complaint)


def _request(number: int) -> tuple[Kind, bytes]:
    """Six of ten are good, two infeasible, two malformed; no two plans are the same."""
    turn = number % 10
    if turn in (3, 8):
        return MALFORMED, _MALFORMED[number // 10 % len(_MALFORMED)]
    request = json.loads(EXAMPLE.read_text())
    request["initial_state"]["angles_deg"] = {"alpha": -30.0 + 0.01 * (number % 4000), "beta": 5.0}
    if turn in (1, 6):
        request["sessions"][0]["target"]["latitude_deg"] *= -1.0  # the other side of the Earth
        return INFEASIBLE, json.dumps(request).encode()
    return GOOD, json.dumps(request).encode()


def _memory_mib(pid: int) -> tuple[float, float]:
    """Private memory of the service itself; and of all that descends from it."""
    own, below, found = 0.0, 0.0, {pid}
    for process in _descendants(found):
        private_mib = _private_mib(process)
        own, below = (private_mib, below) if process == pid else (own, below + private_mib)
    return own, below


def _descendants(found: set[int]) -> set[int]:
    parents = {}
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            parents[int(stat.parent.name)] = int(stat.read_text().rsplit(")", 1)[1].split()[1])
        except OSError:
            continue  # it ended
    while more := {child for child, parent in parents.items() if parent in found} - found:
        found |= more
    return found


def _private_mib(pid: int) -> float:
    try:
        rollup = Path(f"/proc/{pid}/smaps_rollup").read_text()
    except OSError:
        return 0.0  # it ended
    lines = (line.split() for line in rollup.splitlines() if line.startswith("Private_"))
    return sum(int(kib) for _, kib, _ in lines) / 1024


def _report(answers: list[Answer], memory_mib: list[tuple[float, float]], took_s: float) -> bool:
    print(f"{len(answers)} answers in {took_s:.1f} s: {len(answers) / took_s:.1f} a second")
    print(f"load {os.getloadavg()[0]:.1f}\n{'':<12}{'answers':>9}{'p50 ms':>9}{'p99 ms':>9}")
    for kind in (GOOD, INFEASIBLE, MALFORMED):
        times_s = [answer.took_s for answer in answers if answer.kind is kind]
        p50, p99 = np.percentile(times_s, [50, 99]) * 1e3 if times_s else (np.nan, np.nan)
        print(f"{kind.name:<12}{len(times_s):>9}{p50:>9.0f}{p99:>9.0f}")
    counted = Counter((answer.kind.name, answer.status, answer.problem) for answer in answers)
    for (name, status, problem), count in sorted(counted.items(), key=str):
        print(f"  {name}: {status} {problem or ''} {count}")
    outside = [answer for answer in answers if answer.complaint is not None]
    print(f"outside the contract: {len(outside)}")
    for answer in outside[:20]:
        print(f"  {answer.kind.name}: {answer.status} {answer.complaint}")
    return _is_flat(memory_mib) and not outside


def _is_flat(memory_mib: list[tuple[float, float]]) -> bool:
    """Judged by the service itself: how many children are alive changes by the moment."""
    quarters = [np.median(part, axis=0) for part in np.array_split(np.array(memory_mib), 4)]
    print("private memory by quarter, MiB: service, all its children")
    for own, below in quarters:
        print(f"  {own:.1f}  {below:.1f}")
    growth = quarters[-1][0] / quarters[0][0] - 1.0
    print(f"the service's grew by {growth:+.1%}")
    return bool(growth <= GROWTH_MAX)


if __name__ == "__main__":
    main()
