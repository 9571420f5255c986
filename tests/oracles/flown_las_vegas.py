"""The Las Vegas pass, planned once, and telemetry of it by a program that only reads its CSV."""

from functools import cache

import numpy as np
import other_platform
from other_platform import Clock
from planner_values import plan_of

from app.requests.examples import LAS_VEGAS
from planner.inflight.telemetry.following import PlannedMotion
from planner.output.export.csv import table_csv

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
    return plan_of(request)


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


def csv_of(t_s, alpha_deg, beta_deg):
    rows = zip(t_s, alpha_deg, beta_deg, strict=True)
    text = [f"{t:.6f},{alpha:.9f},{beta:.9f}" for t, alpha, beta in rows]
    return "\n".join(["t_s,alpha_deg,beta_deg", *text]).encode()


def flown_deg(rate_hz=15.0, seed=1, late_s=(0.0, 0.0)):
    """Tags 0.37 s ahead, and both angles as planned, each later by so much, with 2 arcsec of
    noise."""
    plan, chance = planned(), np.random.default_rng(seed)
    t_s = np.arange(0.0, plan.table.t_s[-1], 1.0 / rate_hz)
    alpha_deg, beta_deg = (
        np.degrees(PlannedMotion(plan.table, axis).angle_rad(t_s - late_s[axis]))
        + chance.normal(0.0, 2.0 / 3600.0, len(t_s))
        for axis in (0, 1)
    )
    return t_s + 0.37, alpha_deg, beta_deg
