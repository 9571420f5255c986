"""Processor time of plans, refusals, windows and campaigns: the table of docs/operations.md.

python bench/sizing.py
"""

import json
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from statistics import median
from typing import Any

import slewtrack

EXAMPLES = Path(__file__).parents[1] / "examples"
TIMES = 9
Request = dict[str, Any]


def read(name: str) -> Request:
    request: Request = json.loads((EXAMPLES / f"{name}.json").read_text(encoding="utf-8"))
    return request


def refuse(request: Request) -> None:
    session = request["sessions"][0] | {"start": "2015-02-27T17:34:02Z"}
    try:
        slewtrack.plan(request | {"sessions": [session]})
    except slewtrack.Refused:
        return
    raise AssertionError("2 s are no time for a slew")


CASES: dict[str, tuple[Callable[[Request], object], str]] = {
    "plan of one session": (slewtrack.plan, "las_vegas_2015"),
    "plan of three sessions": (slewtrack.plan, "three_sessions"),
    "refusal with ways out": (refuse, "las_vegas_2015"),
    "windows of six targets": (slewtrack.opportunities, "opportunities_gallery"),
    "  with probabilities": (
        partial(slewtrack.opportunities, include=("view", "probability")),
        "opportunities_gallery",
    ),
    "campaign of cities": (slewtrack.campaign, "campaign_cities"),
}


def main() -> None:
    for name, (ask, example) in CASES.items():
        request, took_s = read(example), []
        for number in range(TIMES + 1):  # the first loads what all need
            # Another attitude each time: nothing of one answer serves the next.
            attitude = {"law": "lvlh", "yaw_deg": -4.0 + 0.01 * number, "pitch_deg": -2.0}
            begin_s = time.process_time()
            ask(request | {"attitude": attitude})
            took_s.append(time.process_time() - begin_s)
        least_s, middle_s = min(took_s[1:]), median(took_s[1:])
        print(f"{name:24} {middle_s:.2f} s ({least_s:.2f} least), {86400 / middle_s:9,.0f} a day")


if __name__ == "__main__":
    main()
