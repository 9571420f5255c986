"""Is the attitude off by as much as told where measurements corrected it?  Point 4 of truth.py.

The shapes of a constant rate's error (inertial.py) were chosen on hours 10.75 to 16.5 of the
recording, swing and rest (REST_RAD, REST_MEMORY_S) on its 16.2 hours in torque equilibrium
(bench/attitude_figures.py, which leaves out four hours at a time, too); what is tried here is the
telemetry of its first 10.74 hours.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from attitude import HISTORY_S, YEAR_UTC, channel, held, lvlh
from closed_loop import SIZES, loops
from scipy.spatial.transform import Rotation, Slerp
from scipy.stats import chi2
from truth_pointing import STEP_S, telemetry
from truth_rows import Row, nees_row, share_row

from planner.attitude import (
    Attitude,
    AttitudeCorrection,
    HarmonicAttitude,
    InertialAttitude,
    LvlhAttitude,
)
from planner.attitude.errors import KNOWLEDGE_RAD, MEAN_SIGMA_DEG
from planner.errors import InvalidInput
from planner.frames.time_scales import Instants, shifted_utc

FIRST_LOOK_S = 300.0  # after the law's epoch or the history's end
LOOKS_S = (0.0, 420.0, 840.0)  # a day side's worth of frames
LEADS_S = {  # from the last look
    "lvlh": (120.0, 900.0, 2700.0, 5400.0, 10800.0),
    "inertial": (120.0, 900.0, 2700.0, 5400.0),
    "harmonic": (120.0, 900.0, 2700.0, 5400.0),
}
LOOK_SIGMA_DEG = 0.02
COVERED = (0.5, 0.9, 0.99)
TRIALS = 200  # at each lead, evenly over the telemetry
HISTORY_STEP_ROWS = 3
LOOP_GOAL = 0.05


class Case(NamedTuple):
    """A law whose looks and sessions begin from begin_s, seconds of the year, on.

    foretold: body from LVLH without corrections.
    """

    law: Attitude
    begin_s: float
    foretold: Callable[[np.ndarray], Rotation]


def corrected_rows(folder: Path, tles: Path) -> Iterator[Row]:
    """What looks at the telemetry, of a horizon's kind, leave of a law's errors later."""
    t_s, q_body_from_lvlh = telemetry(folder)
    true = Slerp(t_s, q_body_from_lvlh)
    for name, cases in (
        ("lvlh", _stated(t_s, q_body_from_lvlh)),
        ("inertial", _constant_rates(folder, tles, t_s, q_body_from_lvlh)),
        ("harmonic", _histories(t_s, q_body_from_lvlh)),
    ):
        rng = np.random.default_rng(4)
        for lead_s in LEADS_S[name]:
            span_s = LOOKS_S[-1] + lead_s
            usable = [case for case in cases if case.begin_s + span_s < t_s[-1]]
            rows = np.linspace(0, len(usable) - 1, TRIALS).astype(int)
            tried = [_left_and_told_deg(usable[k], true, lead_s, rng) for k in rows]
            found = np.array([one for one in tried if one is not None])
            squares = (found[:, 0] / found[:, 1]) ** 2
            left_deg = np.sqrt(np.mean(found[:, 0] ** 2, axis=0))
            covered_s = usable[-1].begin_s - usable[0].begin_s + span_s
            for axis, about in enumerate("xy"):
                yield nees_row(
                    4,
                    f"{name}, {lead_s:g} s after three looks, about {about}",
                    np.array_split(squares[:, axis : axis + 1], round(covered_s / span_s)),
                    f"{_halves_and_kept(squares[:, axis])} of {len(found)}, "
                    f"{len(tried) - len(found)} refused, {left_deg[axis]:.3f} deg left",
                )


def _halves_and_kept(squares: np.ndarray) -> str:
    first, second = (half.mean() for half in np.array_split(squares, 2))
    kept = [f"{np.mean(squares < quantile):.0%}" for quantile in chi2.ppf(COVERED, 1)]
    return f"(halves {first:.2f}, {second:.2f}; within 50, 90, 99 %: {', '.join(kept)})"


def _left_and_told_deg(
    case: Case, true: Slerp, lead_s: float, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray] | None:
    """About x and y, what is left of the error, and its told 1-sigma; None where the looks are
    refused.
    """
    looks_s = case.begin_s + np.array(LOOKS_S)
    noise_deg = rng.normal(0.0, LOOK_SIGMA_DEG, (len(LOOKS_S), 3)) * [1.0, 1.0, 0.0]
    variances = np.diag([LOOK_SIGMA_DEG**2, LOOK_SIGMA_DEG**2, 180.0**2])

    # the telemetry is itself off by as much as is told of it
    wrong = Rotation.from_rotvec(rng.normal(0.0, KNOWLEDGE_RAD, 3))

    def error_deg(at_s: np.ndarray) -> np.ndarray:
        return (wrong * true(at_s) * case.foretold(at_s).inv()).as_rotvec(degrees=True)

    law = replace(
        case.law,
        corrections=tuple(
            AttitudeCorrection(
                epoch=shifted_utc(YEAR_UTC, float(at_s)),
                turn_body_deg=tuple(turn_deg.tolist()),
                covariance_deg2=tuple(tuple(row) for row in variances.tolist()),
            )
            for at_s, turn_deg in zip(looks_s, error_deg(looks_s) + noise_deg, strict=True)
        ),
    )
    then_s = looks_s[-1:] + lead_s
    at = Instants(YEAR_UTC, then_s)
    try:
        turn_deg = np.rad2deg(law.turn_rad(at))
    except InvalidInput:
        return None
    left_deg = error_deg(then_s) - turn_deg
    told_deg = np.rad2deg(np.sqrt(np.sum(law.errors_each(at).modes_body_rad ** 2, axis=0)))
    return left_deg[0, :2], told_deg[0, :2]


def _stated(t_s: np.ndarray, q_body_from_lvlh: Rotation) -> list[Case]:
    """The telemetry's mean, wrong by as much as is assumed of what a request states."""
    rng = np.random.default_rng(5)
    mean = q_body_from_lvlh.mean()
    cases = []
    for begin_s in t_s[::6]:
        stated = Rotation.from_rotvec(np.deg2rad(rng.normal(0.0, MEAN_SIGMA_DEG, 3))) * mean
        cases.append(
            Case(LvlhAttitude(), begin_s, lambda at_s, q=stated: q * Rotation.identity(len(at_s)))
        )
    return cases


def _constant_rates(
    folder: Path, tles: Path, t_s: np.ndarray, q_body_from_lvlh: Rotation
) -> list[Case]:
    """The telemetry's attitude and body rate at an instant."""
    grid_s = np.arange(t_s[0], t_s[-1] + STEP_S, STEP_S)
    q_lvlh = Slerp(grid_s, lvlh(tles, grid_s))
    channels = {number: channel(folder, number) for number in (25, 26, 27)}
    cases = []
    for row in range(0, len(t_s), 6):
        at_s = t_s[row]
        rate_deg_s = np.array([held(channels, n, np.array([at_s]))[0] for n in (25, 26, 27)])
        q_body = q_body_from_lvlh[row] * q_lvlh(at_s)
        law = InertialAttitude(
            epoch=shifted_utc(YEAR_UTC, float(at_s)),
            q_body_from_eci_xyzw=tuple(q_body.as_quat().tolist()),
            omega_body_deg_s=tuple(rate_deg_s.tolist()),
        )

        def foretold(
            then_s: np.ndarray,
            at_s: float = at_s,
            rate_deg_s: np.ndarray = rate_deg_s,
            q_body: Rotation = q_body,
        ) -> Rotation:
            turned = Rotation.from_rotvec(-np.outer(then_s - at_s, rate_deg_s), degrees=True)
            return turned * q_body * q_lvlh(then_s).inv()

        cases.append(Case(law, at_s + FIRST_LOOK_S, foretold))
    return cases


def _histories(t_s: np.ndarray, q_body_from_lvlh: Rotation) -> list[Case]:
    """What came before an instant, from two hours of it on."""
    cases = []
    for row in np.flatnonzero(t_s > t_s[0] + 7200.0)[::20]:
        rows = np.flatnonzero((t_s <= t_s[row]) & (t_s > t_s[row] - HISTORY_S))
        rows = rows[::-HISTORY_STEP_ROWS][::-1]
        law = HarmonicAttitude(content=_message(t_s[rows], q_body_from_lvlh[rows]))

        def foretold(
            then_s: np.ndarray, law: HarmonicAttitude = law, end_s: float = t_s[row]
        ) -> Rotation:
            return law.carried_on.at(then_s - end_s + law.carried_on.end_s)

        cases.append(Case(law, t_s[row] + FIRST_LOOK_S, foretold))
    return cases


def _message(t_s: np.ndarray, q_body_from_lvlh: Rotation) -> str:
    """As a CCSDS AEM."""
    times = [shifted_utc(YEAR_UTC, float(at_s)).isoformat()[:-6] for at_s in t_s]
    rows = [
        f"{at} " + " ".join(f"{part:.9f}" for part in xyzw)
        for at, xyzw in zip(times, q_body_from_lvlh.inv().as_quat(), strict=True)
    ]
    return "\n".join(
        [
            "CCSDS_AEM_VERS = 1.0",
            f"CREATION_DATE = {times[-1]}",
            "ORIGINATOR = BENCH",
            "META_START",
            "OBJECT_NAME = ISS",
            "OBJECT_ID = 1998-067-A",
            "CENTER_NAME = EARTH",
            "REF_FRAME_A = LVLH",
            "REF_FRAME_B = SC_BODY_1",
            "ATTITUDE_DIR = A2B",
            "TIME_SYSTEM = UTC",
            f"START_TIME = {times[0]}",
            f"STOP_TIME = {times[-1]}",
            "ATTITUDE_TYPE = QUATERNION",
            "QUATERNION_TYPE = LAST",
            "META_STOP",
            "DATA_START",
            *rows,
            "DATA_STOP",
        ]
    )


def loop_rows(truths: int) -> Iterator[Row]:
    """Two horizon cameras' rendered frames, corrections, and a second plan."""
    before, plain, told, kept, _ = loops(truths, seed=11)
    for k, size in enumerate(SIZES):
        name = f"closed loop, frame x {size:g} (before {before[k]:.2f}, {plain[k]:.2f})"
        yield share_row(4, name, float(told[k]), float(kept[k]), truths, LOOP_GOAL)
