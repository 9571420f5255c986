"""Is the attitude off by as much as told?  Points 1 and 3 of bench/truth.py.

The law lvlh's mean is of the telemetry's first half, tried on its second; the law harmonic's
constants were chosen on the parts that bench/attitude.py says.
"""

from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
from attitude import BLEND, GOAL, TUNED, forecasts, of_the_best
from truth_pointing import telemetry
from truth_rows import Row, blocked_nees_row, nees_row

from planner.attitude import LvlhAttitude
from planner.attitude.errors import MEAN_SIGMA_DEG
from planner.frames.time_scales import Instants

NOON_UTC = datetime(2018, 10, 12, 12, tzinfo=UTC)
A_HOUR = 12  # forecasts
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
    for axis, value in zip(
        "xyz", (np.mean(turn_rad**2, axis=0) + stated2) / variances, strict=True
    ):
        yield nees_row(1, f"attitude lvlh about body {axis}", value, "of 5 h")


def law_rows(folder: Path, tles: Path) -> Iterator[Row]:
    for part, errors, told in forecasts(folder, tles):
        if TUNED in part:
            continue
        for lead_s in ASKED_LEADS_S:
            ratio = of_the_best(errors, told, lead_s)
            of = f"of {len(told[lead_s])}"
            name = f"harmonic, {part}, {lead_s} s"
            yield Row(3, f"{name}: of the best law", f"<= {GOAL:g}", f"{ratio:.2f} {of}",
                      ratio <= GOAL)  # fmt: skip
            squares = (np.array(errors[BLEND][lead_s]) / told[lead_s]) ** 2
            hours = np.array_split(
                np.mean(squares, axis=1, keepdims=True), len(squares) // A_HOUR + 1
            )
            yield blocked_nees_row(3, name, hours, of)
