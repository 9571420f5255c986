"""Time by stage and memory of a fleet's campaign, on one processor or more.

Small satellites of examples/campaign_ten.json, their planes spread evenly, and places drawn between
60 deg of latitude, with priorities 1 to 5, over a day.  Carriers are searched and passes chosen by
the children that the service has.  Times are on the clock.

    python bench/fleet.py [--carriers 10] [--targets 1000] [--workers 1] [--lose S] [--request FILE]
                          [--scheduler ADDRESS]

--workers: as many processors and children.  --lose: kills a child after so many seconds, which the
answer must not show: its digest is printed.  --request: writes the request, for the service.
--scheduler: address of a Dask scheduler, whose workers do the work.
"""

import argparse
import hashlib
import json
import os
import resource
import signal
import threading
import time
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np

from app.jobs.kinds import CAMPAIGN, CARRIERS
from app.jobs.shares import Places, Sharing
from app.jobs.worker_process import Stop, Task, run_here
from app.requests.campaign import read_campaign_request
from app.store.packed import unzip
from app.work.progress import Progress
from planner.world.orbits.tle import checksum

ROOT = Path(__file__).parent.parent
_PAGE_BYTES = os.sysconf("SC_PAGE_SIZE")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--carriers", type=int, default=10)
    parser.add_argument("--targets", type=int, default=1000)
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--lose", type=float)
    parser.add_argument("--request", type=Path)
    parser.add_argument("--scheduler")
    asked = parser.parse_args()
    body = json.dumps(fleet_request(asked.carriers, asked.targets)).encode()
    if asked.request is not None:
        asked.request.write_bytes(body)
    os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[: asked.workers])
    watch = Watch(asked.lose)
    places = Places(take=lambda: True, leave=lambda: None, most=asked.workers - 1)
    run_task = run_here
    if asked.scheduler:  # children import what stands above
        from app.jobs.dask_executor import DaskExecutor

        run_task = DaskExecutor(asked.scheduler).run
    sharing = Sharing(run_task=run_task, places=places, attempts=2)
    begins: dict[str, float] = {}

    def tell(progress: Progress) -> None:
        begins.setdefault(progress.stage, time.monotonic())

    task = Task(job_id="", bounds=CAMPAIGN.bounds, work=len, arguments=(body,))
    run_task(task, Stop())  # their server is warm, as ever
    begun = time.monotonic()
    task = replace(task, work=CAMPAIGN.work, arguments=(body, read_campaign_request(body)))
    made = sharing.run(CARRIERS, task, Stop(), tell)
    ended = time.monotonic()
    told = json.loads(unzip(made.document))
    print(
        f"{asked.carriers} carriers x {asked.targets} targets x 1 day on {asked.workers} of "
        f"{os.cpu_count()} processors, load {os.getloadavg()[0]:.1f}: {ended - begun:.1f} s, "
        f"{told['looks']} looks in {told['passes']} passes, value {told['value']:.1f} of at most "
        f"{told['bound']:.1f} ({told['gap_share']:.2%}), greedy {told['greedy_value']:.1f}"
    )
    ends = [*list(begins.values())[1:], ended]
    stages = zip(begins.items(), ends, strict=True)
    print("  " + ", ".join(f"{stage} {end - began:.1f} s" for (stage, began), end in stages))
    digest = hashlib.sha256(b"".join([made.document, *(part.request for part in made.parts)]))
    here_mib = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(
        f"  at most {watch.most_mib:.0f} MiB in a child and {here_mib:.0f} here, {watch.lost} "
        f"children killed; answer {digest.hexdigest()[:12]}"
    )


class Watch(threading.Thread):
    """Sees what children take, and kills the one that has worked most when it is time."""

    def __init__(self, lose_s: float | None) -> None:
        super().__init__(daemon=True)
        self.most_mib, self.lost = 0.0, 0
        self._lose_s = np.inf if lose_s is None else time.monotonic() + lose_s
        self.start()

    def run(self) -> None:
        while True:
            time.sleep(0.2)
            worked: dict[int, int] = {}
            for child in (one for server in _children(os.getpid()) for one in _children(server)):
                with suppress(OSError):  # it has ended meanwhile
                    fields = Path(f"/proc/{child}/stat").read_text().rsplit(")", 1)[1].split()
                    self.most_mib = max(self.most_mib, int(fields[21]) * _PAGE_BYTES / 2**20)
                    worked[child] = int(fields[11])
            if worked and time.monotonic() > self._lose_s:
                os.kill(max(worked, key=worked.__getitem__), signal.SIGKILL)
                self.lost, self._lose_s = self.lost + 1, np.inf


def _children(pid: int) -> list[int]:
    return [int(one) for one in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]


def fleet_request(carriers: int, targets: int) -> dict[str, object]:
    """All that isn't told is the example's."""
    request = json.loads((ROOT / "examples" / "campaign_ten.json").read_text())
    rng = np.random.default_rng(1)
    latitude_deg = np.rad2deg(np.arcsin(rng.uniform(-1.0, 1.0, targets) * np.sin(np.pi / 3.0)))
    places = np.column_stack([latitude_deg, rng.uniform(-180.0, 180.0, targets)])
    priority = rng.integers(1, 6, targets)
    request["targets"] = [
        {
            "id": f"t{number}",
            "target": {"mode": "ground", "latitude_deg": place[0], "longitude_deg": place[1]},
            "session_s": 20.0,
            "priority": int(priority[number]),
        }
        for number, place in enumerate(places.tolist())
    ]
    request["stop"] = "2015-02-28T12:00:00Z"
    given = request["carriers"]
    request["carriers"] = [
        {
            **given[n % len(given)],
            "id": f"c{n}",
            "orbit": _spread(given[n % len(given)]["orbit"], n, carriers),
        }
        for n in range(carriers)
    ]
    return request


def _spread(orbit: dict[str, str], number: int, of: int) -> dict[str, str]:
    """In one of ten planes, evenly along it."""
    node_deg = (36.0 * (number % 10) + 17.0 * (number // 10)) % 360.0
    anomaly_deg = (360.0 * (number // 10) / max(of // 10, 1) + 11.0 * (number % 10)) % 360.0
    line = orbit["line2"]
    line = f"{line[:17]}{node_deg:8.4f}{line[25:43]}{anomaly_deg:8.4f}{line[51:68]}"
    return {**orbit, "line2": f"{line}{checksum(line)}"}


if __name__ == "__main__":
    main()
