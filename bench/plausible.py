"""Plans plausible requests by the thousand and looks at every answer by other geometry.

    python bench/plausible.py --count 3000 --seed 0 --workers 2 --save out/plausible

Prints what came of them: planned, refused by kind, bugs, tables the oracle finds at fault,
advised starts that were followed and planned, CPU seconds, and the slowest seeds.  Requests that
went wrong are saved.  Ends with 1 if any did.
"""

import argparse
import json
import multiprocessing
import sys
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

sys.path.append(str(Path(__file__).parents[1] / "tests" / "properties"))
from plausible_requests import plausible_request
from plausible_trials import Outcome, as_advised, outcome

from planner import effort

SLOWEST = 10


@dataclass(frozen=True)
class Trial:
    """One seed: its own outcome, and that of the request as it was advised."""

    seed: int
    asked: Outcome
    advised: Outcome | None


def main() -> int:
    """Print the counts; how many went wrong decides the exit code."""
    arguments = _arguments()
    seeds = range(arguments.seed, arguments.seed + arguments.count)
    trials = []
    for trial in _trials(seeds, arguments.workers):
        trials.append(trial)
        for what, request in _wrong(trial):
            print(f"seed {trial.seed}: {what}", flush=True)
            if arguments.save:
                arguments.save.mkdir(parents=True, exist_ok=True)
                path = arguments.save / f"{trial.seed}.json"
                path.write_text(json.dumps(request, indent=1))
        if len(trials) % 100 == 0:
            print(f"... {len(trials)} of {arguments.count}", flush=True)
    return _summary(trials)


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=3000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--save", type=Path)
    return parser.parse_args()


def _trial(seed: int) -> Trial:
    request = plausible_request(seed)
    asked = outcome(request)
    advised = outcome(as_advised(request, asked.problem)) if asked.advises else None
    return Trial(seed, asked, advised)


def _trials(seeds: range, workers: int) -> Iterator[Trial]:
    if workers == 1:
        yield from map(_trial, seeds)
        return
    with multiprocessing.get_context("forkserver").Pool(workers) as pool:
        yield from pool.imap_unordered(_trial, seeds)


def _wrong(trial: Trial) -> Iterator[tuple[str, dict[str, Any]]]:
    request = plausible_request(trial.seed)
    for fault in trial.asked.faults:
        yield f"{trial.asked.kind}, {fault}", request
    if trial.advised is None:
        return
    for fault in trial.advised.faults:
        yield f"as advised {trial.advised.kind}, {fault}", as_advised(request, trial.asked.problem)
    if not _is_planned(trial.advised):
        because = trial.advised.problem.get("detail", "")
        yield f"as advised {trial.advised.kind}: {because}", request


def _is_planned(found: Outcome) -> bool:
    return found.kind in ("planned", "baseline")


def _summary(trials: list[Trial]) -> int:
    kinds = Counter(trial.asked.kind for trial in trials)
    advised = [trial.advised for trial in trials if trial.advised is not None]
    all_runs = [trial.asked for trial in trials] + advised
    tables_wrong = sum(run.kind == "planned" and bool(run.faults) for run in all_runs)
    refusals_wrong = sum(
        run.kind not in ("planned", "bug") and bool(run.faults) for run in all_runs
    )
    followed = sum(_is_planned(run) and not run.faults for run in advised)
    print(f"{len(trials)} requests: " + ", ".join(f"{n} {kind}" for kind, n in kinds.most_common()))
    print(f"bugs: {sum(run.kind == 'bug' for run in all_runs)}")
    print(f"tables wrong by the oracle: {tables_wrong}")
    print(f"refusals misshapen or ours to mend: {refusals_wrong}")
    print(f"advised starts that plan: {followed} of {len(advised)}")
    cpu_s = np.array([run.cpu_s for run in all_runs])
    p50, p99 = np.quantile(cpu_s, [0.5, 0.99])
    print(f"CPU s per request: p50 {p50:.2f}, p99 {p99:.2f}, most {cpu_s.max():.2f}")
    work = np.array([run.work_rows for run in all_runs])
    print(
        f"counted work, of {effort.PLAN} that one request may make: p50 {np.median(work):.0f}, "
        f"p99 {np.quantile(work, 0.99):.0f}, most {work.max():.0f}"
    )
    slowest = sorted(trials, key=lambda trial: -trial.asked.cpu_s)[:SLOWEST]
    told = ", ".join(
        f"{t.seed} ({t.asked.kind}, {t.asked.cpu_s:.1f} s, work {t.asked.work_rows:.0f})"
        for t in slowest
    )
    print(f"slowest seeds: {told}")
    wrong = any(True for trial in trials for _ in _wrong(trial))
    return int(wrong)


if __name__ == "__main__":
    sys.exit(main())
