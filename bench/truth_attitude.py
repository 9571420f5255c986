"""Attitude errors against the stated ones: points 1 and 3 of bench/truth.py.

The law lvlh's mean is of the telemetry's first half, tried on its second; the law harmonic's
constants were chosen on the parts that bench/truth_laws.py says.
"""

from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
from truth_laws import (
    BLEND,
    CUT_EVERY_S,
    GOAL,
    PERIOD_S,
    TUNED,
    YEAR_UTC,
    Errors,
    Told,
    forecasts,
    of_the_best,
)
from truth_pointing import telemetry
from truth_rows import Row, nees_row

from planner.world.attitude import LvlhAttitude
from planner.world.attitude.errors import MEAN_SIGMA_DEG
from planner.world.frames.time_scales import Instants, elapsed_s

NOON_UTC = datetime(2018, 10, 12, 12, tzinfo=UTC)
MANOEUVRE_END_UTC = datetime(2018, 10, 13, 0, 33, tzinfo=UTC)
SETTLED_S = 3.0 * 3600.0
HALF_HOUR_S = 1800.0
STRETCH = 3  # forecasts, 5 minutes apart
DRAWS = 400
ASKED_LEADS_S = (300, 900, 1800, 5400)  # of the law harmonic


def swing_rows(folder: Path) -> Iterator[Row]:
    """About the mean, wrong by as much as is assumed of what a request states."""
    t_s, q_body_from_lvlh = telemetry(folder)
    first = t_s < t_s[len(t_s) // 2]
    mean = q_body_from_lvlh[first].mean()
    turn_rad = (q_body_from_lvlh[~first] * mean.inv()).as_rotvec()
    told = LvlhAttitude().errors(Instants(NOON_UTC, np.zeros(1)))
    stated2 = np.deg2rad(MEAN_SIGMA_DEG) ** 2
    variances = np.ravel(told.sigma_body_rad) ** 2 + told.swing_rms_body_rad**2
    squares = (turn_rad**2 + stated2) / variances
    orbits = np.array_split(squares, round(np.ptp(t_s[~first]) / PERIOD_S))
    for k, axis in enumerate("xyz"):
        sets = [orbit[:, k : k + 1] for orbit in orbits]
        yield nees_row(1, f"attitude lvlh about body {axis}", sets, "")


def settling_rows(folder: Path) -> Iterator[Row]:
    """After the recorded manoeuvre, about the mean of the end, where the telemetry reaches so far;
    what is told was chosen on it."""
    t_s, q_body_from_lvlh = telemetry(folder)
    since_s = t_s - elapsed_s(MANOEUVRE_END_UTC, YEAR_UTC)
    settled = since_s > SETTLED_S
    after = since_s > 0.0
    if not settled.any():
        return
    turn_rad = (q_body_from_lvlh[after] * q_body_from_lvlh[settled].mean().inv()).as_rotvec()
    law = LvlhAttitude(manoeuvre_end=MANOEUVRE_END_UTC)
    told = law.errors(Instants(MANOEUVRE_END_UTC, since_s[after]))
    squares = turn_rad**2 / (told.sigma_body_rad**2 + told.swing_rms_body_rad**2)
    hours = np.array_split(squares, round(np.ptp(since_s[after]) / HALF_HOUR_S))
    for k, axis in enumerate("xyz"):
        sets = [hour[:, k : k + 1] for hour in hours]
        yield nees_row(1, f"attitude lvlh after a manoeuvre, about body {axis}", sets, "")


def law_rows(folder: Path, tles: Path) -> Iterator[Row]:
    for part, errors, told, found in forecasts(folder, tles):
        if TUNED in part:
            continue
        for lead_s in ASKED_LEADS_S:
            name = f"harmonic, {part}, {lead_s} s"
            yield _ratio_row(name, errors, told, lead_s)
            squares = np.mean((np.array(errors[BLEND][lead_s]) / told[lead_s]) ** 2, axis=1)
            unknown = np.logical_not(found[lead_s])
            if not part.startswith("torque") and unknown.any():
                seen = f"{squares[unknown].mean():.0f} of {unknown.sum()}"
                yield Row(3, f"{name}, NEES before it shows", "none predicts it", seen, None)
                squares = squares[~unknown]
            leads = max(1, round(len(squares) * CUT_EVERY_S / lead_s))
            sets = np.array_split(squares[:, None], leads)
            yield nees_row(3, name, sets, f"of {len(squares)}")


def _ratio_row(name: str, errors: Errors, told: Told, lead_s: int) -> Row:
    """Which law is best is known afterwards only: 90 % of the ratios when stretches of a quarter of
    an hour are drawn anew stand beside.
    """
    count = len(told[lead_s])
    ratio = of_the_best(errors, told, lead_s)
    rng = np.random.default_rng(3)
    stretches = np.array_split(np.arange(count), max(1, count // STRETCH))
    drawn = []
    for _ in range(DRAWS):
        picked = np.concatenate(
            [stretches[k] for k in rng.integers(len(stretches), size=len(stretches))]
        )
        law_errors = {
            law: {lead_s: [by_lead[lead_s][k] for k in picked]}
            for law, by_lead in errors.items()
            if len(by_lead[lead_s]) == count
        }
        drawn.append(of_the_best(law_errors, {lead_s: [told[lead_s][k] for k in picked]}, lead_s))
    low, high = np.quantile(drawn, (0.05, 0.95))
    squares = np.sum(np.square(errors[BLEND][lead_s]), axis=1)
    seen = (
        f"{ratio:.2f} ({low:.2f} to {high:.2f}) of {count}; {squares.max() / squares.sum():.0%} of "
        f"the squares in one; {len(stretches)} stretches"
    )
    is_met = True if ratio <= GOAL else None if low <= GOAL else False
    return Row(3, f"{name}: of the best law", f"<= {GOAL:g}", seen, is_met)
