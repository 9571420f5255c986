"""Time of a view of 4,500 rows, computed and over HTTP.

The worked example with 11 minutes of waiting before it: 4,501 rows, one session.  Prints the
median and p95 of the geometry, of its JSON, both in one process, of a service's answer
on loopback to `GET /v1/plans/{id}/view?step_s=0.2`: first for another pixel each time, so that
nothing is known yet, then the same again.

    python bench/view.py [--views 30]
"""

import argparse
import json
import os
import tempfile
import time
from collections.abc import Callable

import httpx2 as httpx
import numpy as np
from plan import EXAMPLE, running_service

from app.answers.view import view_json
from app.requests.plan import read_plan_request
from planner.output.view import view_plan
from planner.planning.sessions.pipeline import make_plan

PIXEL_ARCSEC = 0.678
WARM_UP = 3


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--views", type=int, default=30)
    count = parser.parse_args().views
    request = json.loads(EXAMPLE.read_text())
    request["initial_state"]["epoch"] = "2015-02-27T17:22:50Z"
    body = json.dumps(request).encode()
    plan = make_plan(read_plan_request(body))
    view = view_plan(plan, 0.2, PIXEL_ARCSEC)
    print(f"{len(view.t_s)} rows, {count} times, load {os.getloadavg()[0]:.1f}")
    _tell("geometry", count, lambda _: view_plan(plan, 0.2, PIXEL_ARCSEC))
    _tell("JSON", count, lambda _: view_json(view, "x", PIXEL_ARCSEC, verified=True))
    with tempfile.TemporaryDirectory() as folder:
        os.environ |= {"SLEWTRACK_DATA_DIR": folder, "SLEWTRACK_DATABASE_URL": ""}
        with running_service() as (client, _):
            made = client.post(
                "/v1/plans", content=body, headers={"Content-Type": "application/json"}
            )
            made.raise_for_status()
            address = f"{made.headers['location']}/view?step_s=0.2&pixel_arcsec="
            _tell("first answer", count, lambda number: _get(client, f"{address}1.{number:04}"))
            _tell("known answer", count, lambda _: _get(client, f"{address}1"))


def _get(client: httpx.Client, address: str) -> None:
    client.get(address).raise_for_status()


def _tell(name: str, count: int, work: Callable[[int], object]) -> None:
    took_s = []
    for number in range(count + WARM_UP):
        began_s = time.perf_counter()
        work(number)
        took_s.append(time.perf_counter() - began_s)
    p50_ms, p95_ms = 1e3 * np.percentile(took_s[WARM_UP:], (50, 95))
    print(f"{name:<16}{p50_ms:>8.1f} ms median{p95_ms:>8.1f} ms p95")


if __name__ == "__main__":
    main()
