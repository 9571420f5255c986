"""How much more of a campaign is planned in a second by two solver processes than by one?

The same campaign on a service with one and with two workers, twice each, alternately; from the
moment its passes were chosen until the last plan is stored.  Needs two processors that do
nothing else: the load of others is printed, and what the solvers used of the processors.

    OMP_NUM_THREADS=1 python bench/throughput.py [--targets 200] [--days 1] [--rounds 2]
"""

import argparse
import os
import resource
import tempfile
import time
from pathlib import Path

from app.store import jobs
from bench.resilience import House, campaign_body


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--targets", type=int, default=200)
    parser.add_argument("--days", type=float, default=1.0)
    parser.add_argument("--rounds", type=int, default=2)
    asked = parser.parse_args()
    took_s: dict[int, list[float]] = {1: [], 2: []}
    for _ in range(asked.rounds):
        for solves, times_s in took_s.items():
            times_s.append(_planning_s(solves, campaign_body(asked.targets, asked.days, 0)))
    best = {solves: min(times_s) for solves, times_s in took_s.items()}
    print(f"throughput on 2 workers is {best[1] / best[2]:.2f} times that on one")


def _planning_s(solves: int, body: bytes) -> float:
    with tempfile.TemporaryDirectory(prefix="slewtrack-throughput-") as folder:
        house = House(folder=Path(folder), database_url="", cluster=False, solves=solves)
        before_s = _children_s()
        house.start()
        try:
            headers = {"Content-Type": "application/json"}
            campaign_id = house.ask("POST", "/v1/campaigns", body, **headers)["id"]
            while house.ask("GET", f"/v1/campaigns/{campaign_id}")["state"] == "running":
                time.sleep(0.5)
            with house.database() as database, database.reading() as connection:
                parts = jobs.parts_of(connection, campaign_id)
        finally:
            house.end()
        took_s = (
            max(part.finished_utc for part in parts) - min(part.started_utc for part in parts)
        ).total_seconds()
        looks = sum(len(part.options["campaign"]["looks"]) for part in parts)
        used_s, load = _children_s() - before_s, os.getloadavg()[0]
        print(
            f"{solves} workers: {len(parts)} plans, {looks} looks in {took_s:.1f} s; processors "
            f"worked {used_s:.1f} s with start and choice; load {load:.1f}"
        )
    return took_s


def _children_s() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


if __name__ == "__main__":
    main()
