"""The Las Vegas pass, planned once, and telemetry of it by a program that only reads its CSV."""

import json
from functools import cache

import other_platform
from other_platform import Clock

from app.requests.examples import LAS_VEGAS
from app.requests.plan import read_plan_request
from planner.output.export.csv import table_csv
from planner.planning.sessions.pipeline import make_plan

PERFECT = {"alpha": other_platform.Drive(), "beta": other_platform.Drive()}


@cache
def planned():
    return _made(LAS_VEGAS)


@cache
def planned_in_a_minute():
    """It slews at once and tracks for a third as long, where flights are made by the hundred."""
    state = LAS_VEGAS["initial_state"] | {"epoch": "2015-02-27T17:35:55Z"}
    [session] = LAS_VEGAS["sessions"]
    brief = session | {"stop": "2015-02-27T17:36:55Z"}
    return _made(LAS_VEGAS | {"initial_state": state, "sessions": [brief]})


def _made(request):
    """With the attitude level: where an axis sticks hangs on it."""
    request = request | {"attitude": {"law": "lvlh"}}
    return make_plan(read_plan_request(json.dumps(request).encode()))


def telemetry(
    tmp_path,
    drives=PERFECT,
    clock=Clock(),  # noqa: B008 (never changed)
    *,
    rate_hz=15.0,
    noise_arcsec=2.0,
    gyro_noise_deg_s=0.001,
    columns="angles and rates",
    seed=1,
    plan=None,
):
    """The bytes of a CSV file: angles, rates, or both."""
    table = tmp_path / "table.csv"
    table.write_text(table_csv((plan or planned()).table))
    names, rows = other_platform.measure(
        other_platform.read_table(table),
        drives,
        clock,
        rate_hz,
        noise_arcsec,
        gyro_noise_deg_s,
        seed,
    )
    path = tmp_path / "telemetry.csv"
    other_platform.write_csv(path, names, rows)
    lines = [line.split(",") for line in path.read_text().splitlines()]
    kept = {"angles": (0, 1, 2), "rates": (0, 3, 4), "angles and rates": range(5)}[columns]
    return "\n".join(",".join(line[k] for k in kept) for line in lines).encode()
