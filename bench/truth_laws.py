"""Errors of the ISS's predicted attitude by lead, for each law, for bench/truth.py.

The telemetry's folder holds USLAB000018..21 (LVLH quaternion, 18 its scalar) and 25..27 (body
rates, deg/s) of 2018-10-12, .txt or .txt.gz, from ISS-Mimic/Mimic, Pi/RecordedData/Data/Archive.
Every 5 minutes the history so far is cut off and what came after is predicted.  Parts of the day
apart: the constants of the attitude's `blend`, `extrapolation` and `manoeuvre` were chosen on
those that say so.
"""

import gzip
from collections import defaultdict
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation
from truth_elements import read_tles

from planner.world.attitude.blend import Blend, blend
from planner.world.attitude.extrapolation import (
    DESCRIPTIONS,
    TAIL_S,
    Extrapolation,
    fit_extrapolation,
)
from planner.world.attitude.harmonic import OPTIONS as HARMONIC_OPTIONS
from planner.world.frames.local_orbital import q_lvlh_from_eci
from planner.world.frames.time_scales import Instants, elapsed_s, shifted_utc

YEAR_UTC = datetime(2017, 12, 31, tzinfo=UTC)  # day 1 of the telemetry's hours is 1 January
PERIOD_S = 5560.0
HISTORY_S = HARMONIC_OPTIONS.history_orbits * PERIOD_S
PLAIN_HISTORY_S = 3.3 * PERIOD_S  # of the descriptions by themselves
LEADS_S = (60, 300, 900, 1800, 5400)
GOAL = 1.1
BLEND = "what the law harmonic does"
OWN = tuple(str(d) for d in DESCRIPTIONS if d.has_rate)  # not of the three it's compared with
STEP_S = 10.0
HELD_MAX_S = 1.5
CUT_EVERY_S = 300.0
TUNED = "tuned on"
# Hours since the recording's begin; in torque equilibrium what is predicted lies within them, too.
PARTS_H = {
    f"torque equilibrium, {TUNED}": (2.0, 8.0),
    "torque equilibrium": (8.0, 16.7),
    "in the yaw manoeuvre (nothing predicts its begin and end)": (16.75, 19.5),
    "its first 45 minutes after": (19.5, 20.25),
    f"after it, {TUNED}": (20.25, 21.75),
    "after it": (21.75, 24.0),
}


def channel(folder: Path, number: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Seconds of the year and values, in order."""
    (path,) = folder.glob(f"USLAB0000{number}.txt*")
    opener = gzip.open if path.suffix == ".gz" else open
    with opener(path, "rt") as file:
        table = np.loadtxt(file)
    table = table[np.argsort(table[:, 0], kind="stable")]
    return table[:, 0] * 3600.0, table[:, 1]


def held(number_of: dict[int, tuple[NDArray, NDArray]], number: int, t_s: NDArray) -> NDArray:
    """The last value recorded: only changes are."""
    at_s, values = number_of[number]
    return values[np.clip(np.searchsorted(at_s, t_s + 1e-3, side="right") - 1, 0, None)]


Errors = dict[str, dict[int, list]]  # rotation vectors, rad, by law and lead
Told = dict[int, list]  # 1-sigma of BLEND, rad, by lead
Found = dict[int, list]  # whether BLEND knew of a manoeuvre, by lead


def forecasts(telemetry: Path, tles: Path) -> Iterator[tuple[str, Errors, Told, Found]]:
    """By part of the day that the telemetry holds."""
    channels = {n: channel(telemetry, n) for n in (18, 19, 20, 21, 25, 26, 27)}
    start_s = channels[21][0][0]
    clock_s = channels[20][0]
    clock_s = clock_s[(clock_s >= start_s) & (np.diff(clock_s, prepend=-1.0) < HELD_MAX_S)]
    _, rows = np.unique(clock_s // STEP_S, return_index=True)
    t_s = clock_s[rows]
    q_xyzw = np.stack([held(channels, n, t_s) for n in (19, 20, 21, 18)], axis=1)
    q_body_from_lvlh = Rotation.from_quat(q_xyzw).inv()
    q_lvlh = lvlh(tles, t_s)
    for part, (first_h, last_h) in PARTS_H.items():
        quiet = part.startswith("torque")
        until_s = start_s + last_h * 3600.0 if quiet else np.inf
        errors: Errors = defaultdict(lambda: defaultdict(list))
        told: Told = defaultdict(list)
        found: Found = defaultdict(list)
        for cut_s in start_s + np.arange(first_h * 3600.0, last_h * 3600.0, CUT_EVERY_S):
            known = np.flatnonzero((t_s <= cut_s) & (t_s > cut_s - HISTORY_S))
            if not len(known) or cut_s - t_s[known[-1]] > 2.0 * STEP_S:
                continue
            now = known[-1]
            laws = _laws(t_s[known], q_body_from_lvlh[known])
            body_rate_rad_s = np.deg2rad(
                [np.mean(held(channels, n, t_s[now] - np.arange(10.0))) for n in (25, 26, 27)]
            )
            for lead_s in LEADS_S:
                then = int(np.searchsorted(t_s, t_s[now] + lead_s - 0.5 * STEP_S))
                if (
                    then >= len(t_s)
                    or abs(t_s[then] - t_s[now] - lead_s) > STEP_S
                    or t_s[then] > until_s
                ):
                    continue
                truth = q_body_from_lvlh[then]
                for name, law in laws.items():
                    predicted = law.at(t_s[then : then + 1])[0]
                    errors[name][lead_s].append((predicted * truth.inv()).as_rotvec())
                turned = Rotation.from_rotvec(-body_rate_rad_s * (t_s[then] - t_s[now]))
                predicted = turned * q_body_from_lvlh[now] * q_lvlh[now] * q_lvlh[then].inv()
                errors["the paper's constant body rate, of 10 s"][lead_s].append(
                    (predicted * truth.inv()).as_rotvec()
                )
                found[lead_s].append(laws[BLEND].changed_s is not None)
                told[lead_s].append(laws[BLEND].error_rms_at(np.array([float(lead_s)]))[0])
        if told:
            yield part, errors, told, found


def of_the_best(errors: Errors, told: Told, lead_s: int) -> float:
    """Rms error of BLEND over that of the best law not of OWN that had history enough."""
    others = [
        _rms(by_lead[lead_s])
        for name, by_lead in errors.items()
        if name != BLEND and name not in OWN and len(by_lead[lead_s]) > 0.7 * len(told[lead_s])
    ]
    return _rms(errors[BLEND][lead_s]) / min(others)


class ConstantRate(NamedTuple):
    """Relative to LVLH, fitted to the last minute."""

    end_s: float
    q_end: Rotation
    coefficients_rad: NDArray[np.float64]

    def at(self, t_s: NDArray[np.float64]) -> Rotation:
        since_end_s = t_s[:, None] - self.end_s
        turn_rad = self.coefficients_rad[1] + self.coefficients_rad[0] * since_end_s
        return Rotation.from_rotvec(turn_rad) * self.q_end


def _constant_rate(t_s: NDArray[np.float64], q_body_from_lvlh: Rotation) -> ConstantRate:
    used = np.flatnonzero(t_s >= t_s[-1] - TAIL_S)
    used = used if len(used) > 2 else np.arange(-3, 0)
    turn_rad = (q_body_from_lvlh[used] * q_body_from_lvlh[-1].inv()).as_rotvec()
    fitted = np.polyfit(t_s[used] - t_s[-1], turn_rad, 1)
    return ConstantRate(float(t_s[-1]), q_body_from_lvlh[-1], fitted)


def _laws(
    t_s: NDArray[np.float64], q_body_from_lvlh: Rotation
) -> dict[str, Extrapolation | Blend | ConstantRate]:
    """By name; a description whose history is too short is left out."""
    recent = t_s > t_s[-1] - PLAIN_HISTORY_S
    fits = {
        str(d): fit_extrapolation(d, t_s[recent], q_body_from_lvlh[recent], PERIOD_S)
        for d in DESCRIPTIONS
    }
    known = {name: fit for name, fit in fits.items() if fit is not None}
    known["constant rate relative to LVLH"] = _constant_rate(t_s, q_body_from_lvlh)
    return {BLEND: blend(t_s, q_body_from_lvlh, PERIOD_S), **known}


def _rms(turns: list) -> float:
    return float(np.sqrt(np.mean(np.sum(np.square(turns), axis=1))))


def lvlh(tles: Path, t_s: NDArray[np.float64]) -> Rotation:
    """LVLH from ECI, from the TLE nearest in time."""
    start_utc = shifted_utc(YEAR_UTC, float(t_s[0]))
    nearest = min(read_tles(tles), key=lambda tle: abs(elapsed_s(tle.epoch_utc, start_utc)))
    instants = Instants(YEAR_UTC, t_s)
    stop_utc = shifted_utc(YEAR_UTC, float(t_s[-1]))
    states = nearest.ephemeris(start_utc, stop_utc).states(instants)
    return q_lvlh_from_eci(states.r_sat_eci_m, states.v_sat_eci_m_s)
