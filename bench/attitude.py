"""How well is the ISS's attitude foretold?  Rms error by lead, for each law, on telemetry.

    python bench/attitude.py TELEMETRY_FOLDER TLE_FILE [--from HOURS] [--to HOURS]

TELEMETRY_FOLDER holds USLAB000018..21 (LVLH quaternion, 18 its scalar) and 25..27 (body rates,
deg/s) of 2018-10-12, .txt or .txt.gz, from ISS-Mimic/Mimic, Pi/RecordedData/Data/Archive.
Every 5 minutes the history of the last 3.3 orbits is cut off and what came after is foretold.
"""

import argparse
import gzip
from collections import Counter, defaultdict
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from planner.attitude.extrapolation import DESCRIPTIONS, Extrapolation, choose, fit_extrapolation
from planner.frames.local_orbital import q_lvlh_from_eci
from planner.frames.time_scales import Instants, elapsed_s, shifted_utc
from planner.orbits import TleOrbit

YEAR_UTC = datetime(2017, 12, 31, tzinfo=UTC)  # day 1 of the telemetry's hours is 1 January
PERIOD_S = 5560.0
HISTORY_S = 3.3 * PERIOD_S
LEADS_S = (60, 120, 300, 600, 900, 1200, 1800)
STEP_S = 10.0
HELD_MAX_S = 1.5
CUT_EVERY_S = 300.0


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


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("telemetry", type=Path)
    parser.add_argument("tles", type=Path)
    parser.add_argument("--from", dest="first_h", type=float, default=5.0)
    parser.add_argument("--to", dest="last_h", type=float, default=24.0)
    arguments = parser.parse_args()
    channels = {n: channel(arguments.telemetry, n) for n in (18, 19, 20, 21, 25, 26, 27)}
    start_s = channels[21][0][0]
    clock_s = channels[20][0]
    clock_s = clock_s[(clock_s >= start_s) & (np.diff(clock_s, prepend=-1.0) < HELD_MAX_S)]
    _, rows = np.unique(clock_s // STEP_S, return_index=True)
    t_s = clock_s[rows]
    q_xyzw = np.stack([held(channels, n, t_s) for n in (19, 20, 21, 18)], axis=1)
    q_body_from_lvlh = Rotation.from_quat(q_xyzw).inv()
    q_lvlh = lvlh(arguments.tles, t_s)

    cuts_s = start_s + np.arange(arguments.first_h * 3600.0, arguments.last_h * 3600.0, CUT_EVERY_S)
    errors: dict[str, dict[int, list[float]]] = defaultdict(lambda: defaultdict(list))
    choices: Counter[str] = Counter()
    for cut_s in cuts_s[cuts_s < t_s[-1] - LEADS_S[-1]]:
        known = np.flatnonzero((t_s <= cut_s) & (t_s > cut_s - HISTORY_S))
        if len(known) < HISTORY_S / STEP_S / 2 or cut_s - t_s[known[-1]] > 2.0 * STEP_S:
            continue
        now = known[-1]
        choice = choose(t_s[known], q_body_from_lvlh[known], PERIOD_S, 900.0).extrapolation
        choices[str(choice.description)] += 1
        laws: dict[str, Extrapolation | None] = {"chosen by hold-out": choice}
        for description in DESCRIPTIONS:
            laws[str(description)] = fit_extrapolation(
                description, t_s[known], q_body_from_lvlh[known], PERIOD_S
            )
        omegas_rad_s = {
            f"the paper's constant body rate, of {span_s} s": np.deg2rad(
                [
                    np.mean(held(channels, n, t_s[now] - np.arange(float(span_s))))
                    for n in (25, 26, 27)
                ]
            )
            for span_s in (1, 10)
        }
        for lead_s in LEADS_S:
            then = int(np.searchsorted(t_s, t_s[now] + lead_s - 0.5 * STEP_S))
            if then >= len(t_s) or abs(t_s[then] - t_s[now] - lead_s) > STEP_S:
                continue
            truth = q_body_from_lvlh[then]
            for name, law in laws.items():
                if law is not None:
                    foretold = law.at(t_s[then : then + 1])[0]
                    errors[name][lead_s].append((foretold * truth.inv()).magnitude())
            for name, omega_rad_s in omegas_rad_s.items():
                turned = Rotation.from_rotvec(-omega_rad_s * (t_s[then] - t_s[now]))
                foretold = turned * q_body_from_lvlh[now] * q_lvlh[now] * q_lvlh[then].inv()
                errors[name][lead_s].append((foretold * truth.inv()).magnitude())
    print("rms error (deg) by lead (s)\n" + " " * 46 + "".join(f"{lead:>9}" for lead in LEADS_S))
    for name, by_lead in errors.items():
        rms = [np.rad2deg(np.sqrt(np.mean(np.square(by_lead[lead])))) for lead in LEADS_S]
        print(f"{name:46}" + "".join(f"{value:9.4f}" for value in rms), len(by_lead[900]))
    print("chosen:", ", ".join(f"{name} {count}x" for name, count in choices.most_common()))


def lvlh(tles: Path, t_s: NDArray[np.float64]) -> Rotation:
    """LVLH from ECI, from the TLE nearest in time."""
    start_utc = shifted_utc(YEAR_UTC, float(t_s[0]))
    lines = [line.rstrip() for line in tles.read_text().splitlines()]
    sets = [
        TleOrbit(line1=one, line2=two)
        for one, two in zip(lines, lines[1:], strict=False)  # noqa: RUF007 (reads as pairs)
        if one.startswith("1 ") and two.startswith("2 ")
    ]
    nearest = min(sets, key=lambda tle: abs(elapsed_s(tle.epoch_utc, start_utc)))
    instants = Instants(YEAR_UTC, t_s)
    stop_utc = shifted_utc(YEAR_UTC, float(t_s[-1]))
    states = nearest.ephemeris(start_utc, stop_utc).states(instants)
    return q_lvlh_from_eci(states.r_sat_eci_m, states.v_sat_eci_m_s)


if __name__ == "__main__":
    main()
