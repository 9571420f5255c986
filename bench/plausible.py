"""Plans plausible requests by the thousand and looks at every answer by other geometry.

    OPENBLAS_NUM_THREADS=1 python bench/plausible.py --requests 3000 --log out/plausible.jsonl
    OPENBLAS_NUM_THREADS=1 python bench/plausible.py --requests 60 --costs

(One thread, as in a service's children: others only wait, at the cost of a processor.)

Prints what came of them: planned, refused by kind, bugs, tables the oracle finds at fault,
advised starts that were followed and planned, processor time until the answer is written, and the
slowest seeds.  With `--log` each is written down at once: what is there isn't done again, so that
a run may be broken off, and done in slices by `--seed`, and all that is there is summed up.  Ends
with 1 if anything went wrong or took more than 10 s of a processor.

`--costs` prints what of the work is counted where, and how long it takes: a row's worth is to be
10 microseconds everywhere, or an answer takes longer than it may.  The numbers to mend are the
constants "of `effort`" beside each place.
"""

import argparse
import json
import multiprocessing
import sys
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import numpy as np

sys.path.append(str(Path(__file__).parents[1] / "tests"))
sys.path.append(str(Path(__file__).parents[1] / "tests" / "properties"))
from plausible_requests import demanding_request, plausible_request
from plausible_trials import Outcome, as_advised, outcome
from work_costs import kept_ledger

from planner.base import effort

LIMIT_S = 10.0  # of a processor: what any answer may take
SLOWEST = 10
COMPILES = 3  # a seed that needs all kernels of slews
KINDS = {"demanding": demanding_request, "plain": plausible_request}
Record = dict[str, Any]  # one seed, as it is written down


def main() -> int:
    """Print the counts; how many went wrong decides the exit code."""
    arguments = _arguments()
    records = _records_in(arguments.log)
    done = {(record["requests"], record["seed"]) for record in records}
    wanted = range(arguments.seed, arguments.seed + arguments.requests)
    seeds = [seed for seed in wanted if (arguments.kind, seed) not in done]
    with kept_ledger() if arguments.costs else nullcontext() as ledger:
        for record in _tried(arguments.kind, seeds, 1 if arguments.costs else arguments.workers):
            records.append(record)
            for what in record["wrong"]:
                print(f"{arguments.kind} seed {record['seed']}: {what}", flush=True)
            if arguments.log:
                arguments.log.parent.mkdir(parents=True, exist_ok=True)
                with arguments.log.open("a") as file:
                    file.write(json.dumps(record) + "\n")
            if len(records) % 100 == 0:
                print(f"... {len(records)}", flush=True)
    if ledger is not None:
        print(*ledger.lines(), sep="\n")
    return _summary(records)


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--requests", type=int, default=3000, help="how many seeds")
    parser.add_argument("--seed", type=int, default=0, help="the first of them")
    parser.add_argument("--kind", choices=KINDS, default="demanding")
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--log", type=Path, help="JSON, a line for each seed; what is there stays")
    parser.add_argument("--costs", action="store_true", help="counted work beside time, by place")
    return parser.parse_args()


def _records_in(log: Path | None) -> list[Record]:
    return list(map(json.loads, log.read_text().splitlines())) if log and log.exists() else []


def _tried(kind: str, seeds: list[int], workers: int) -> Iterator[Record]:
    trials = [(kind, seed) for seed in seeds]
    if workers == 1:
        _warm_up()
        yield from map(_trial, trials)
        return
    context = multiprocessing.get_context("forkserver")
    with ProcessPoolExecutor(workers, context, _warm_up) as pool:  # which tells of a crash
        yield from pool.map(_trial, trials)


def _warm_up() -> None:
    """What is compiled or loaded at first is no request's work."""
    import app.work.preload  # noqa: F401

    outcome(demanding_request(COMPILES))


def _trial(kind_and_seed: tuple[str, int]) -> Record:
    """One seed: its own outcome, and that of the request as it was advised."""
    kind, seed = kind_and_seed
    request = KINDS[kind](seed)
    asked = outcome(request)
    advised = outcome(as_advised(request, asked.problem)) if asked.advises else None
    return {
        "requests": kind,
        "seed": seed,
        "wrong": list(_wrong(asked, advised)),
        "asked": _told(asked),
        "advised": None if advised is None else _told(advised),
    }


def _told(found: Outcome) -> Record:
    return {
        "kind": found.kind,
        "cpu_s": round(found.cpu_s, 3),
        "work_rows": round(found.work_rows),
        "faults": len(found.faults),
    }


def _wrong(asked: Outcome, advised: Outcome | None) -> Iterator[str]:
    for fault in asked.faults:
        yield f"{asked.kind}, {fault}"
    if advised is None:
        return
    for fault in advised.faults:
        yield f"as advised {advised.kind}, {fault}"
    if advised.kind not in ("planned", "baseline"):
        yield f"as advised {advised.kind}: {advised.problem.get('detail', '')}"


def _summary(records: list[Record]) -> int:
    asked = [record["asked"] for record in records]
    advised = [record["advised"] for record in records if record["advised"] is not None]
    runs = asked + advised
    kinds = Counter(one["kind"] for one in asked)
    print(f"{len(asked)} requests: " + ", ".join(f"{n} {kind}" for kind, n in kinds.most_common()))
    print(f"bugs: {sum(run['kind'] == 'bug' for run in runs)}")
    wrong = Counter(run["kind"] for run in runs if run["faults"])
    print(f"tables wrong by the oracle: {wrong.pop('planned', 0)}")
    print(f"refusals misshapen or ours to mend: {wrong.total() - wrong['bug']}")
    followed = sum(run["kind"] in ("planned", "baseline") for run in advised)
    print(f"advised starts that plan: {followed} of {len(advised)}")
    cpu_s = np.array([run["cpu_s"] for run in runs])
    p50, p90, p99 = np.quantile(cpu_s, [0.5, 0.9, 0.99])
    print(
        f"processor s per answer: p50 {p50:.2f}, p90 {p90:.2f}, p99 {p99:.2f}, worst "
        f"{cpu_s.max():.2f}; {int(np.sum(cpu_s > LIMIT_S))} of {len(cpu_s)} over {LIMIT_S:g}"
    )
    work = np.array([run["work_rows"] for run in runs])
    print(
        f"counted work, of {effort.PLAN} that one request may make: p50 {np.median(work):.0f}, "
        f"p99 {np.quantile(work, 0.99):.0f}, most {work.max():.0f}"
    )
    slowest = sorted(records, key=lambda one: -one["asked"]["cpu_s"])[:SLOWEST]
    told = ", ".join(
        f"{one['requests']} {one['seed']} ({one['asked']['kind']}, {one['asked']['cpu_s']:.1f} s, "
        f"work {one['asked']['work_rows']})"
        for one in slowest
    )
    print(f"slowest seeds: {told}")
    return int(any(record["wrong"] for record in records) or cpu_s.max() > LIMIT_S)


if __name__ == "__main__":
    sys.exit(main())
