"""How long do a thousand flights take, and do they agree with what plans tell of themselves?

    PYTHONPATH=. .venv/bin/python bench/flights.py [runs of the first, runs of each plan]

First: so many runs of a 90 s session (1,000 unless given), by the service's own parts, on two
processors.  Then 20 plans, by elements of several ages and attitudes known well or badly, each
flown as often (1,000): their standard scores, and the chance of a sum of squares as large.
"""

import os
import sys
import time
import zlib
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from datetime import timedelta
from json import dumps, loads
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import chi2

from app.answers.flights import FlightsFound, FlightsHead, flights_found
from app.answers.members import from_store
from app.jobs.disposable import run_disposable, start_server
from app.jobs.kinds import RUNS
from app.work.flights import PlanToFly, fly_part, prepare_flights, unpacked_outcomes
from app.work.plan import plan_and_pack
from planner.frames.time_scales import utc_from_text, utc_text

EXAMPLE = Path(__file__).parents[1] / "examples" / "las_vegas_2015.json"
PROCESSORS = 2
ATTITUDES = (
    {"law": "lvlh"},
    {"law": "lvlh", "uncertainty": {"sigma_body_deg": [0.1, 0.1, 0.1]}},
    {"law": "lvlh", "uncertainty": {"swing_rms_body_deg": [0.05, 0.0, 0.0]}},
    {
        "law": "lvlh",
        "uncertainty": {
            "sigma_body_deg": [0.05, 0.1, 0.05],
            "swing_rms_body_deg": [0.1, 0.05, 0.05],
        },
    },
)
# Beside the example's session, in seconds: as elements and their errors, the view changes.
STARTS_S = (-30, -15, 0, 15, 30)


def main() -> None:
    start_server()
    words = [int(word) for word in sys.argv[1:]]
    runs, of_each = (*words, *(1000, 1000)[len(words) :])
    request = loads(EXAMPLE.read_text())
    flown(request, 2, 0)  # compiles
    began_s = time.perf_counter()
    found = flown(request, runs, 1)
    took_s = time.perf_counter() - began_s
    print(
        f"{runs} runs of a 90 s session on {PROCESSORS} processors: {took_s:.1f} s "
        f"(load {os.getloadavg()[0]:.1f}); in frame {found.probability_in_frame:.3f}, sharp "
        f"{found.probability_sharp:.3f}"
    )
    if not of_each:
        return
    squares = []
    for number, plan in enumerate(plans(request)):
        found = flown(plan, of_each, number)
        told = found.sessions[0].told_probability_in_frame
        value = found.probability_in_frame or 0.0
        score = (value - told) / np.sqrt(max(told * (1.0 - told), 1e-9) / of_each)
        squares.append(score**2)
        print(
            f"plan {number:2}: told {told:.3f}, flown {value:.3f}, {score:+.2f} sigma; sharp "
            f"{found.probability_sharp:.3f}; {'; '.join(found.warnings) or 'no warning'}"
        )
    chance = chi2.sf(sum(squares), len(squares))
    print(f"sum of squares {sum(squares):.1f} of {len(squares)}: chance {chance:.3f}")


def plans(request: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """20 of them: five starts by four attitudes."""
    [session] = request["sessions"]
    for attitude in ATTITUDES:
        for late_s in STARTS_S:
            times = {
                end: utc_text(utc_from_text(session[end]) + timedelta(seconds=late_s))
                for end in ("start", "stop")
            }
            yield {**request, "attitude": attitude, "sessions": [session | times]}


def flown(request: dict[str, Any], runs: int, seed: int) -> FlightsFound:
    """As the service does it: in parts, each in a child."""
    body = dumps(request).encode()
    plan = plan_and_pack(body)
    asked = dumps({"runs": runs, "seed": seed}).encode()
    what = PlanToFly(plan_id="", asked=asked, request=body, table_columns=plan.table_columns)
    new = prepare_flights(what.to_bytes())
    bounds = replace(RUNS.bounds, deadline_s=600.0)
    with ThreadPoolExecutor(PROCESSORS) as threads:
        parts = list(threads.map(lambda part: run_disposable(bounds, fly_part, part), new.parts))
    head = from_store(FlightsHead, loads(zlib.decompress(new.document)))
    return flights_found(head, [unpacked_outcomes(part) for part in parts])


if __name__ == "__main__":
    main()
