"""How well telemetry's clock can be told, and is: the bound of Cramer and Rao, and many noises.

    PYTHONPATH=.:tests:tests/oracles .venv/bin/python bench/telemetry_clock.py drift|lag

drift: its bound, errors and sigmas, by plan.  lag: chi-squares of offset, drift and lag.

The telemetry is that of tests/other_platform.py; the bound is drawn up from the table by itself.
"""

import copy
import json
import math
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import other_platform
from clock_bound import drift_bound

from app.requests.examples.plan import LAS_VEGAS
from app.requests.plan import read_plan_request
from planner.arrays import Array
from planner.export import FlightPlan
from planner.export.csv import table_csv
from planner.sessions.pipeline import make_plan
from planner.telemetry.alignment import Alignment
from planner.telemetry.columns import TelemetryColumn, meaning_of
from planner.telemetry.compare import compare
from planner.telemetry.samples import Samples

ARCSEC = math.radians(1.0 / 3600.0)
SEEDS = 60
DRIFT, OFFSET_S = 5e-6, 0.37


def session(target: dict[str, Any], start: str, stop: str) -> dict[str, Any]:
    return {"target": target, "start": f"2015-02-27T{start}Z", "stop": f"2015-02-27T{stop}Z"}


def ground(latitude_deg: float, longitude_deg: float) -> dict[str, Any]:
    place = {"latitude_deg": latitude_deg, "longitude_deg": longitude_deg, "height_m": 0.0}
    return {"mode": "ground", **place}


VEGAS = LAS_VEGAS["sessions"][0]
PLANS = {
    "one pass, 90 s of tracking": [VEGAS],
    "Polaris for 900 s": [session({"mode": "star", "hip": 11767}, "17:36:20", "17:51:20")],
    "four targets of a pass": [
        VEGAS,
        session(ground(44.0, -100.0), "17:39:30", "17:40:30"),
        session(ground(50.0, -75.0), "17:43:30", "17:44:30"),
        session(ground(51.0, -50.0), "17:47:30", "17:48:30"),
    ],
    "two passes, an orbit apart": [VEGAS, session(ground(36.1, -115.2), "19:12:00", "19:13:00")],
}


def planned(sessions: list[dict[str, Any]]) -> FlightPlan:
    request = copy.deepcopy(LAS_VEGAS) | {"sessions": sessions}
    return make_plan(read_plan_request(json.dumps(request).encode()))


def flown(plan: FlightPlan) -> tuple[Array, list[Array], Any]:
    """Times and, by axis, the angles of the other program."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "table.csv"
        path.write_text(table_csv(plan.table))
        times, motion = other_platform.read_table(path)
    flights = [
        np.array(other_platform.fly(times, *columns, other_platform.Drive()))
        for columns in motion.values()
    ]
    return flights[0][:, 0], [np.radians(one[:, 1]) for one in flights], (times, motion)


def sampled(
    fine_s: Array,
    angle_rad: list[Array],
    t_s: Array,
    noise_arcsec: float,
    chance: np.random.Generator,
    late_s: Sequence[float] = (0.0, 0.0),
) -> list[Array]:
    return [
        np.interp(t_s - late_s[k], fine_s, angle_rad[k])
        + noise_arcsec * ARCSEC * chance.standard_normal(len(t_s))
        for k in (0, 1)
    ]


def compared(plan: FlightPlan, tag_s: Array, angles_rad: list[Array]) -> Alignment:
    names = plan.scenario.platform.axis_names
    columns = []
    for name, angle_rad in zip(names, angles_rad, strict=True):
        meaning = meaning_of(f"{name}_rad", names)
        assert meaning is not None
        columns.append(TelemetryColumn(name=name, meaning=meaning, value=angle_rad))
    samples = Samples(epoch_utc=plan.table.epoch_utc, t_s=tag_s, columns=tuple(columns))
    return compare(plan, samples).alignment


def drift() -> None:
    for name, sessions in PLANS.items():
        plan = planned(sessions)
        fine_s, angle_rad, table = flown(plan)
        t_s = np.arange(0.0, plan.table.t_s[-1], 1.0 / 15.0)
        for noise_arcsec in (2.0, 5.0, 20.0):
            free, least = (
                drift_bound(table, t_s, noise_arcsec * ARCSEC, with_drives=own)
                for own in (False, True)
            )
            seeds = SEEDS if noise_arcsec == 5.0 else 0
            text = ""
            if seeds:
                found = []
                for seed in range(seeds):
                    chance = np.random.default_rng(seed)
                    angles = sampled(fine_s, angle_rad, t_s, noise_arcsec, chance)
                    tag_s = OFFSET_S + (1.0 + DRIFT) * t_s
                    one = compared(plan, tag_s, angles).drift
                    found.append((one.value - DRIFT, one.sigma))
                error, sigma = np.array(found).T
                text = (
                    f"; {seeds} noises: rms error {1e6 * np.sqrt(np.mean(error**2)):.3f} ppm, "
                    f"over the bound {np.sqrt(np.mean(error**2)) / least:.2f}, mean error "
                    f"{1e6 * error.mean():+.3f}, told sigma {1e6 * sigma.mean():.3f}, chi-square "
                    f"{np.mean((error / sigma) ** 2):.2f}, within 1e-6: "
                    f"{100.0 * np.mean(np.abs(error) < 1e-6):.0f} %"
                )
            print(
                f"{name}, {plan.table.t_s[-1]:.0f} s, {noise_arcsec:g} arcsec: bound "
                f"{1e6 * least:.3f} ppm ({1e6 * free:.3f} without friction){text}",
                flush=True,
            )


def lag() -> None:
    plan = planned([VEGAS])
    fine_s, angle_rad, _ = flown(plan)
    t_s = np.arange(0.0, plan.table.t_s[-1], 0.2)
    tag_s = OFFSET_S + t_s
    first = sampled(fine_s, angle_rad, t_s, 2.0, np.random.default_rng(0))
    lag_sigma_s = max(one.sigma for one in compared(plan, tag_s, first).lags_s if one)
    for axis, name in enumerate(plan.scenario.platform.axis_names):
        for sigmas in (0.0, 0.5, 1.0, 2.0, 4.0, 8.0):
            late_s = [0.0, 0.0]
            late_s[axis] = sigmas * lag_sigma_s
            found = []
            for seed in range(SEEDS):
                chance = np.random.default_rng(seed)
                angles = sampled(fine_s, angle_rad, t_s, 2.0, chance, late_s)
                one = compared(plan, tag_s, angles)
                own, other = one.lags_s[axis], one.lags_s[1 - axis]
                assert own is not None
                assert other is not None
                apart_s = own.value - other.value
                found.append(
                    [
                        (one.offset_s.value - OFFSET_S) / one.offset_s.sigma,
                        one.drift.value / one.drift.sigma,
                        (apart_s - late_s[axis]) / own.sigma,
                    ]
                )
            offset, drift, late = np.mean(np.square(found), axis=0)
            within = np.mean(np.abs(np.array(found)[:, 0]) < 3.0)
            print(
                f"{name} late by {sigmas:g} sigma ({1e3 * late_s[axis]:.2f} ms): chi-square of the "
                f"offset {offset:.2f} ({100 * within:.0f} % within 3 sigma), drift {drift:.2f}, "
                f"lag {late:.2f}",
                flush=True,
            )


if __name__ == "__main__":
    {"drift": drift, "lag": lag}[sys.argv[1]]()
