"""Is the attitude off by as much as told?  Points 1, 3 and 4 of bench/truth.py.

The law lvlh's mean is of the telemetry's first half, tried on its second; the law harmonic's
constants were chosen on the parts that bench/attitude.py says.
"""

from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
from attitude import GOAL, channel, forecasts, held, nees, of_the_best
from closed_loop import SIZES, loops
from scipy.spatial.transform import Rotation, Slerp
from truth_pointing import STEP_S, telemetry
from truth_rows import NEES_GOAL, Row, nees_row

from planner.attitude import AttitudeCorrection, LvlhAttitude
from planner.attitude.errors import MEAN_SIGMA_DEG
from planner.frames.time_scales import Instants, shifted_utc

LOOKS_S = (0.0, 420.0, 840.0)  # a day side's worth of frames
CORRECTED_LEADS_S = (120.0, 900.0, 2700.0, 5400.0, 10800.0)
LOOK_SIGMA_DEG = 0.02
LOOK_TRIALS = 200
NOON_UTC = datetime(2018, 10, 12, 12, tzinfo=UTC)
PERIOD_S = 5560.0
RATE_LEADS_S = (60.0, 120.0, 300.0, 600.0, 900.0, 1200.0, 1800.0)
ASKED_LEADS_S = (300, 900, 1800, 5400)  # of the law harmonic
COUNT_SIGMA = 2.0  # by which a kept share may be off for its number alone


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
        for lead_s in ASKED_LEADS_S:
            ratio = of_the_best(errors, told, lead_s)
            spread = nees(errors, told, lead_s)
            seen = f"{ratio:.2f}; NEES {spread:.2f} of {len(told[lead_s])}"
            name = f"harmonic, {part}, {lead_s} s: of the best law"
            yield Row(3, name, f"<= {GOAL:g}", seen, ratio <= GOAL)


def loop_rows(truths: int) -> Iterator[Row]:
    """Two horizon cameras' rendered frames, corrections, and a second plan."""
    before, plain, told, kept, _ = loops(truths, seed=11)
    by_count = COUNT_SIGMA * np.sqrt(0.25 / truths)
    for k, size in enumerate(SIZES):
        off = abs(told[k] - kept[k])
        seen = f"{told[k]:.2f}, {kept[k]:.2f}; before {before[k]:.2f}, {plain[k]:.2f}"
        goal = f"within 0.05 + {by_count:.2f} (number)"
        yield Row(4, f"closed loop, frame x {size:g}: told, kept", goal, seen,
                  bool(off <= 0.05 + by_count))  # fmt: skip


def corrected_rows(folder: Path) -> Iterator[Row]:
    """What looks at the telemetry's second half, of a horizon's kind, leave of its errors later."""
    t_s, q_body_from_lvlh = telemetry(folder)
    middle_s = t_s[len(t_s) // 2]
    mean = q_body_from_lvlh[t_s < middle_s].mean()
    swing = Slerp(t_s, q_body_from_lvlh)
    rng = np.random.default_rng(4)
    variances = np.diag([LOOK_SIGMA_DEG**2, LOOK_SIGMA_DEG**2, 180.0**2])
    seen, told = [], []
    for _ in range(LOOK_TRIALS):
        wrong = Rotation.from_rotvec(np.deg2rad(rng.normal(0.0, MEAN_SIGMA_DEG, 3)))
        first_s = rng.uniform(middle_s, t_s[-1] - LOOKS_S[-1] - CORRECTED_LEADS_S[-1])
        last_s = first_s + LOOKS_S[-1]

        def error_deg(at_s: np.ndarray, wrong: Rotation = wrong) -> np.ndarray:
            return (swing(at_s) * (wrong * mean).inv()).as_rotvec(degrees=True)

        noise_deg = rng.normal(0.0, LOOK_SIGMA_DEG, (len(LOOKS_S), 3)) * [1.0, 1.0, 0.0]
        law = LvlhAttitude(
            corrections=tuple(
                AttitudeCorrection(
                    epoch=shifted_utc(NOON_UTC, at_s),
                    turn_body_deg=tuple(turn_deg.tolist()),
                    covariance_deg2=tuple(tuple(row) for row in variances.tolist()),
                )
                for at_s, turn_deg in zip(
                    LOOKS_S, error_deg(first_s + np.array(LOOKS_S)) + noise_deg, strict=True
                )
            )
        )
        at = Instants(NOON_UTC, LOOKS_S[-1] + np.array(CORRECTED_LEADS_S))
        left_deg = error_deg(last_s + np.array(CORRECTED_LEADS_S)) - np.rad2deg(law.turn_rad(at))
        seen.append(left_deg)
        told.append(np.rad2deg(np.sqrt(np.sum(law.errors(at).modes_body_rad ** 2, axis=0))))
    for k, lead_s in enumerate(CORRECTED_LEADS_S):
        left, sigma = np.array(seen)[:, k, :2], np.array(told)[:, k, :2]
        nees = np.mean((left / sigma) ** 2, axis=0)
        rms = np.sqrt(np.mean(left**2, axis=0))
        yield Row(
            4,
            f"telemetry, {lead_s:g} s after three looks, about x and y",
            "NEES 0.8-1.3",
            f"{nees[0]:.2f}, {nees[1]:.2f}; {rms[0]:.3f} and {rms[1]:.3f} deg left",
            bool(np.all((nees >= NEES_GOAL[0]) & (nees <= NEES_GOAL[1]))),
        )


def print_figures(folder: Path) -> None:
    """What constants of planner/attitude rest on: the swing, and a constant body rate's error."""
    t_s, q_body_from_lvlh = telemetry(folder)
    turn_deg = (q_body_from_lvlh * q_body_from_lvlh.mean().inv()).as_rotvec(degrees=True)
    print(f"swing about body x, y, z: rms {np.std(turn_deg, axis=0).round(3)} deg")
    # LVLH turns about -Y once an orbit; from which direction doesn't matter.
    q_lvlh = Rotation.from_rotvec(np.outer(2.0 * np.pi / PERIOD_S * t_s, [0.0, 1.0, 0.0]))
    q_body = q_body_from_lvlh * q_lvlh
    rates = {number: channel(folder, number) for number in (25, 26, 27)}
    omega_deg_s = np.stack([held(rates, number, t_s) for number in (25, 26, 27)], axis=1)
    row_of = {round(at_s / STEP_S): row for row, at_s in enumerate(t_s)}
    print("constant body rate: rms about body x, y, z")
    for lead_s in RATE_LEADS_S:
        ahead = [row_of.get(round((at_s + lead_s) / STEP_S), -1) for at_s in t_s]
        now = np.flatnonzero(np.array(ahead) >= 0)
        later = q_body[np.array(ahead)[now]]
        turned = Rotation.from_rotvec(-np.deg2rad(omega_deg_s[now]) * lead_s) * q_body[now]
        miss_deg = (turned * later.inv()).as_rotvec(degrees=True)
        print(f"  {lead_s:6.0f} s: {np.sqrt(np.mean(miss_deg**2, axis=0)).round(3)} deg")
