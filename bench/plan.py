"""How long does a whole POST /v1/plans take, and where does the time go?

Starts the service on loopback in a process of its own and posts the example over one kept
connection.  Prints p50 and p95 of the answer's time and of each stage inside it.

    python bench/plan.py [--requests 200]
"""

import argparse
import json
import os
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import httpx2 as httpx
import numpy as np

EXAMPLE = Path(__file__).parent.parent / "examples" / "las_vegas_2015.json"
WARM_UP = 5


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--requests", type=int, default=200)
    count = parser.parse_args().requests
    with running_service() as (client, _):
        _report(*_measured(client, count))


@contextmanager
def running_service() -> Iterator[tuple[httpx.Client, int]]:
    """A service on loopback: a client of it and its process id."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    command = Path(sys.executable).with_name("slewtrack")
    quiet = os.environ | {"SLEWTRACK_LOG_LEVEL": "warning"}
    service = subprocess.Popen([command, "serve", "--port", str(port)], env=quiet)
    try:
        with httpx.Client(base_url=f"http://127.0.0.1:{port}", timeout=60.0) as client:
            _wait_for(client)
            yield client, service.pid
    finally:
        service.terminate()
        service.wait(timeout=20)


def _wait_for(client: httpx.Client) -> None:
    for _ in range(600):
        try:
            client.get("/healthz").raise_for_status()
        except httpx.TransportError:
            time.sleep(0.1)
        else:
            return
    raise SystemExit("the service did not start within 60 s")


def _measured(
    client: httpx.Client, count: int
) -> tuple[list[float], list[float], list[dict[str, float]]]:
    request = json.loads(EXAMPLE.read_text())
    whole_s: list[float] = []
    stages: list[dict[str, float]] = []
    for number in range(count + WARM_UP):
        # A start of its own for every request, so that nothing can be answered from memory.
        request["initial_state"]["angles_deg"] = {"alpha": -30.0 + 0.25 * number, "beta": 5.0}
        began_s = time.perf_counter()
        answer = client.post("/v1/plans", json=request)
        whole_s.append(time.perf_counter() - began_s)
        stages.append(answer.raise_for_status().json()["solver"]["stages_wall_s"])
    return whole_s[:1], whole_s[WARM_UP:], stages[WARM_UP:]


def _report(first_s: list[float], whole_s: list[float], stages: list[dict[str, float]]) -> None:
    print(f"POST /v1/plans, 90 s session, {len(whole_s)} requests on one connection")
    print(f"first answer of the process {1e3 * first_s[0]:.0f} ms\n")
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
