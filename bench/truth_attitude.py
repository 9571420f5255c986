"""Attitude errors against the stated ones: point 1 of bench/truth.py.

The law lvlh's mean is of the telemetry's first half, tried on its second.
"""

from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
from truth_pointing import telemetry
from truth_rows import Row, nees_row

from planner.world.attitude import LvlhAttitude
from planner.world.attitude.errors import MEAN_SIGMA_DEG
from planner.world.frames.time_scales import Instants, elapsed_s

YEAR_UTC = datetime(2017, 12, 31, tzinfo=UTC)  # day 1 of the telemetry's hours is 1 January
PERIOD_S = 5560.0
NOON_UTC = datetime(2018, 10, 12, 12, tzinfo=UTC)
MANOEUVRE_END_UTC = datetime(2018, 10, 13, 0, 33, tzinfo=UTC)
SETTLED_S = 3.0 * 3600.0
HALF_HOUR_S = 1800.0


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
