"""Time of a whole POST /v1/plans, by stage.

Starts the service on loopback in a process of its own and posts the example over one kept
connection.  Prints how long it takes to listen, to its first answer, p50 and p95 of the later
answers and of each stage inside them, and the processor's time for one, children included.

    python bench/plan.py [--requests 200] [--beside ../another-checkout]

With `--beside` another state of the sources answers turn by turn with this one, so that both
meet the same machine.
"""

import argparse
import json
import math
import os
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import httpx2 as httpx
import numpy as np

EXAMPLE = Path(__file__).parent.parent / "examples" / "las_vegas_2015.json"
WARM_UP = 5


HERE = Path(__file__).parent.parent


@dataclass
class Measured:
    """listens_s: from its start until the service answers at all; first_s: its first plan after.

    stages: of each answer.  processor_s: of one, by the service and all it started.
    """

    checkout: Path
    listens_s: float
    first_s: float
    whole_s: list[float] = field(default_factory=list)
    stages: list[dict[str, float]] = field(default_factory=list)
    processor_s: float = math.nan


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--requests", type=int, default=200)
    parser.add_argument("--beside", type=Path, help="another checkout, to compare with")
    given = parser.parse_args()
    checkouts = [HERE] if given.beside is None else [given.beside.resolve(), HERE]
    measured = _measure(checkouts, given.requests)
    print(f"POST /v1/plans, 90 s session, {given.requests} requests on one connection")
    print(f"{os.cpu_count()} processors, load of the last minute {os.getloadavg()[0]:.1f}")
    for one in measured:
        _report(one)
    if len(measured) > 1:
        before, after = measured
        print(f"\n{after.checkout} over {before.checkout}")
        for name, ratio in {
            "first answer": after.first_s / before.first_s,
            "median": np.median(after.whole_s) / np.median(before.whole_s),
            "processor": after.processor_s / before.processor_s,
        }.items():
            print(f"{name:<16}{ratio:>9.2f}")


@contextmanager
def running_service(checkout: Path = HERE) -> Iterator[tuple[httpx.Client, int]]:
    """A service on loopback, of the sources in a folder: a client of it and its process id."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    command = Path(sys.executable).with_name("slewtrack")
    quiet = os.environ | {"SLEWTRACK_LOG_LEVEL": "warning", "PYTHONPATH": str(checkout)}
    service = subprocess.Popen([command, "serve", "--port", str(port)], env=quiet, cwd=checkout)
    try:
        with httpx.Client(base_url=f"http://127.0.0.1:{port}", timeout=60.0) as client:
            _wait_for(client)
            yield client, service.pid
    finally:
        service.terminate()
        service.wait(timeout=20)


def _wait_for(client: httpx.Client) -> None:
    for _ in range(6000):
        try:
            client.get("/healthz").raise_for_status()
        except httpx.TransportError:
            time.sleep(0.01)
        else:
            return
    raise SystemExit("the service did not start within 60 s")


def _measure(checkouts: list[Path], count: int) -> list[Measured]:
    """Each service begins while no other is at work; then they answer turn by turn."""
    request = json.loads(EXAMPLE.read_text())
    with ExitStack() as stack:
        services, measured = [], []
        for checkout in checkouts:
            began_s = time.perf_counter()
            folder = stack.enter_context(tempfile.TemporaryDirectory())
            os.environ["SLEWTRACK_DATA_DIR"] = folder
            client, pid = stack.enter_context(running_service(checkout))
            listens_s = time.perf_counter() - began_s
            first_s, _ = _answer(client, request)
            services.append((client, pid))
            measured.append(Measured(checkout, listens_s, first_s))
            for _ in range(WARM_UP):
                _answer(client, request)
        before_s = [_processor_s(pid) for _, pid in services]
        for number in range(count):
            # A start of its own for every request, so that nothing can be answered from memory.
            request["initial_state"]["angles_deg"] = {"alpha": -30.0 + 0.25 * number, "beta": 5.0}
            for (client, _), one in zip(services, measured, strict=True):
                whole_s, stages = _answer(client, request)
                one.whole_s.append(whole_s)
                one.stages.append(stages)
        for (_, pid), one, since_s in zip(services, measured, before_s, strict=True):
            one.processor_s = (_processor_s(pid) - since_s) / count
    return measured


def _answer(client: httpx.Client, request: dict[str, Any]) -> tuple[float, dict[str, float]]:
    """How long it takes, and its stages."""
    began_s = time.perf_counter()
    answer = client.post("/v1/plans", json=request)
    took_s = time.perf_counter() - began_s
    return took_s, answer.raise_for_status().json()["solver"]["stages_wall_s"]


def _processor_s(pid: int) -> float:
    """Spent by a process and all that live below it, to the nanosecond."""
    threads = Path(f"/proc/{pid}/task")
    spent_s = sum(int((task / "schedstat").read_text().split()[0]) for task in threads.iterdir())
    below = [
        int(child)
        for task in threads.iterdir()
        for child in (task / "children").read_text().split()
    ]
    return spent_s / 1e9 + sum(_processor_s(child) for child in below)


def _report(measured: Measured) -> None:
    whole_s, stages = measured.whole_s, measured.stages
    print(f"\n{measured.checkout}")
    print(f"listens after {1e3 * measured.listens_s:.0f} ms")
    print(f"first answer of the process {1e3 * measured.first_s:.0f} ms")
    print(f"processor {1e3 * measured.processor_s:.1f} ms a plan\n")
    print(f"{'stage':<16}{'p50 ms':>9}{'p95 ms':>9}")
    rows = {name: [stage[name] for stage in stages] for name in stages[0]}
    inside = np.sum(list(rows.values()), axis=0)
    rows["HTTP and JSON"] = list(np.array(whole_s) - inside)
    rows["whole"] = whole_s
    for name, seconds in rows.items():
        p50, p95 = np.percentile(seconds, [50, 95]) * 1e3
        print(f"{name:<16}{p50:>9.1f}{p95:>9.1f}")


if __name__ == "__main__":
    main()
