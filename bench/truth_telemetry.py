"""Clock, lag and gains that a comparison states, against flights of the tests' own program.

`tests/other_platform.py` shares no code with the planner: its own motor, encoder and clock.  What
is asked: squares of errors over their stated sigmas, and no lag where there is none.
"""

import json
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from truth_rows import Row

from app.requests.examples import LAS_VEGAS, PLAN_EXAMPLES
from app.requests.plan import read_plan_request
from planner.inflight.telemetry.compare import compare
from planner.inflight.telemetry.platforms.registry import sensors_of
from planner.inflight.telemetry.samples import Samples, read_csv
from planner.output.export.csv import table_csv
from planner.planning.sessions.pipeline import make_plan
from planner.world.plan import FlightPlan

sys.path.append(str(Path(__file__).parents[1] / "tests"))
import other_platform

PLANS = (LAS_VEGAS, *(PLAN_EXAMPLES[name][1] for name in ("place", "star_coordinates", "sequence")))
NOISE_DEG = 1.5 / 3600.0
CHI2_GOAL = (0.7, 1.4)
LATE_SIGMA = 4.0


def rows(flights: int) -> Iterator[Row]:
    """Gains of 3e-4 to 1e-2, either way and of either axis or both; clocks 4 s and 30 ppm off."""
    chance = np.random.default_rng(42)
    plans = [make_plan(read_plan_request(json.dumps(one).encode())) for one in PLANS]
    flown = [_flown(plan) for plan in plans]
    off: dict[str, list[float]] = {"gain": [], "common offset": [], "drift": [], "lag": []}
    for number in range(flights):
        plan, (fine_s, angles_deg) = plans[number % len(plans)], flown[number % len(plans)]
        t_s = np.arange(0.0, fine_s[-1], 1.0 / chance.choice([5.0, 10.0, 20.0]))
        sizes = 10.0 ** chance.uniform(np.log10(3e-4), -2.0, 2) * chance.choice([-1.0, 1.0], 2)
        gains = 1.0 + sizes * ((True, True), (True, False), (False, True))[number % 3]
        offset_s, drift = chance.uniform(-4.0, 4.0), chance.normal(0.0, 30e-6)
        measured = [
            gain * np.interp(t_s, fine_s, one) + chance.normal(0.0, NOISE_DEG, len(t_s))
            for gain, one in zip(gains, angles_deg, strict=True)
        ]
        found = compare(plan, _samples(plan, offset_s + (1.0 + drift) * t_s, measured))
        clock = found.alignment
        off["drift"].append((clock.drift.value - drift) / clock.drift.sigma)
        if common_s := clock.common_offset_s:
            off["common offset"].append((common_s.value - offset_s) / common_s.sigma)
        for axis, gain in zip(found.axes, gains, strict=True):
            if axis.gain is not None:
                off["gain"].append((axis.gain.value - gain) / axis.gain.sigma)
        lags = [lag_s for lag_s in clock.lags_s if lag_s is not None]
        off["lag"].append(max((lag_s.value / lag_s.sigma for lag_s in lags), default=0.0))
    low, high = CHI2_GOAL
    for what, errors in off.items():
        chi2 = float(np.mean(np.square(errors)))
        seen = f"{chi2:.2f} of {len(errors)}, largest {np.abs(errors).max():.1f} sigma"
        yield Row(11, f"telemetry, gains of 3e-4 to 1e-2: {what}, squares over sigmas",
                  f"{low}-{high}", seen, low <= chi2 <= high)  # fmt: skip
    false = sum(one > LATE_SIGMA for one in off["lag"])
    yield Row(11, "telemetry, the same: lags stated where there are none", "none",
              f"{false} of {len(off['lag'])}", false == 0)  # fmt: skip


def _flown(plan: FlightPlan) -> tuple[np.ndarray, list[np.ndarray]]:
    """Times every 2 ms, and the angles of both axes, deg."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "table.csv"
        path.write_text(table_csv(plan.table))
        times, motion = other_platform.read_table(path)
    flights = [other_platform.fly(times, *one, other_platform.Drive()) for one in motion.values()]
    return np.array(flights[0][0]), [np.array(one[1]) for one in flights]


def _samples(plan: FlightPlan, tag_s: np.ndarray, angles_deg: list[np.ndarray]) -> Samples:
    axes = plan.table.dof_names
    names = [f"{name}_deg" for name in axes]
    lines = [f"{t:.6f},{a:.9f},{b:.9f}" for t, a, b in zip(tag_s, *angles_deg, strict=True)]
    csv = "\n".join([",".join(["t_s", *names]), *lines]).encode()
    return read_csv(csv, sensors_of(plan).contract, None, plan.table.epoch_utc, None)
