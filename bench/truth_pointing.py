"""Attitude errors and frequencies against what is stated: of bench/truth.py.

The attitude is the telemetry's second half, its mean stated from the first half and wrong by as
much as is assumed; the orbit is known (attitude alone), or predicted by elements and truly what
elements of later days say.  The telemetry's folder holds USLAB000018..21 (LVLH quaternion, 18 its
scalar) of 2018-10-12, .txt or .txt.gz, from ISS-Mimic/Mimic, Pi/RecordedData/Data/Archive.
"""

import gzip
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation, Slerp
from truth_orbits import (
    ARCHIVE,
    HELD_OUT_MONTH,
    created,
    read_oem_file,
    read_tles,
)
from truth_rows import Row, nees_row, share_row

from planner.motion.pointing.angles import axis_angles
from planner.motion.pointing.line_of_sight import line_of_sight
from planner.planning.sessions.budget import LIKELY, PointingBudget
from planner.planning.sessions.platforms.two_axis.budget import pointing_budget
from planner.world.attitude import LvlhAttitude
from planner.world.attitude.errors import MEAN_SIGMA_DEG
from planner.world.frames.earth_orientation import c_itrf_from_eci
from planner.world.frames.geodesy import geodetic_from_itrf
from planner.world.frames.time_scales import DAY_S, Instants, elapsed_s, shifted_utc
from planner.world.orbits import OemOrbit, Orbit, StateVectorOrbit, TleOrbit
from planner.world.platforms.iss_hrc import ISS_HRC
from planner.world.targets.ground import GroundTarget

SESSION_S = np.arange(0.0, 90.1, 9.0)
ASIDE_DEG = 3.0  # of latitude and longitude, from below the carrier
SIZES = (0.3, 0.5, 0.7, 0.9, 1.1, 1.5, 2.5, 4.0, 8.0, 16.0, 32.0)  # of the HRC's frame
STARTS = 60  # moments of the telemetry for each session
STALE_S = 2.5  # since a value changed
STEP_S = 10.0
BINS = 5
LEAST = 20  # sessions in a bin
GOAL = 0.05
TLE_AGES_DAYS = (3.0, 7.0)  # where the growth, all that later elements show, is most of the error
OEM_AGES_DAYS = (2.0, 14.0)
PERIOD_S = 5560.0
NOON_UTC = datetime(2018, 10, 12, 12, tzinfo=UTC)


class Pair(NamedTuple):
    """An orbit predicted, what it truly was, and when; predictions of one set share their error."""

    predicted: Orbit
    true: Orbit
    start_utc: datetime
    of_set: int


def rows(data: Path, sessions: int) -> Iterator[Row]:
    budgets: list[PointingBudget] = []
    for what, pairs in (
        ("attitude alone", _known(data)),
        ("and a TLE of 3 to 7 days", _later_elements(data)),
        ("and an OEM of 2 to 14 days", _ephemerides(data)),
    ):
        told, kept, sets = reliability(data / "attitude", pairs, sessions, budgets)
        for edge in np.arange(BINS) / BINS:
            inside = (told >= edge) & (told <= edge + 1.0 / BINS)
            if inside.sum() >= LEAST:
                name = f"probability {edge:.1f}-{edge + 1.0 / BINS:.1f}, {what}"
                yield share_row(name, told[inside].mean(), kept[inside], sets[inside], GOAL)
    likely = [b for b in budgets if b.probability_in_frame < LIKELY]
    warned = sum(b.warning() is not None for b in likely)
    yield Row("likely misses that carry the warning", "all", f"{warned} of {len(likely)}",
              warned == len(likely))  # fmt: skip


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
        yield nees_row(f"attitude lvlh about body {axis}", sets, "")


def reliability(
    folder: Path, pairs: list[Pair], sessions: int, budgets: list[PointingBudget]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Told and kept probabilities of staying in frames of several sizes, and of which set.

    Every set's predictions are drawn as often, however many of them there are.
    """
    t_s, q_body_from_lvlh = telemetry(folder)
    middle_s = t_s[len(t_s) // 2]
    mean = q_body_from_lvlh[t_s < middle_s].mean()
    yaw_deg, pitch_deg, roll_deg = mean.inv().as_euler("ZYX", degrees=True)
    law = LvlhAttitude(yaw_deg=yaw_deg, pitch_deg=pitch_deg, roll_deg=roll_deg)
    swing = Slerp(t_s, q_body_from_lvlh)
    rng = np.random.default_rng(2)
    by_set: dict[int, list[Pair]] = defaultdict(list)
    for pair in pairs:
        by_set[pair.of_set].append(pair)
    sets = list(by_set.values())
    told, kept, of_sets = [], [], []
    for _ in range(sessions):
        one_set = sets[rng.integers(len(sets))]
        pair = one_set[rng.integers(len(one_set))]
        found, true_sight, sides = _session(pair, law, rng)
        budgets.extend(budget for _, budget in found)
        starts_s = rng.uniform(middle_s, t_s[-1] - SESSION_S[-1], STARTS)
        true = swing((starts_s[:, None] + SESSION_S).ravel())
        wrong = Rotation.from_rotvec(np.deg2rad(rng.normal(0.0, MEAN_SIGMA_DEG, (STARTS, 3))))
        stated = wrong[np.repeat(np.arange(STARTS), len(SESSION_S))] * mean
        q_platform = ISS_HRC.q_platform_from_body
        turned = q_platform * (true * stated.inv()) * q_platform.inv()
        seen = turned.apply(np.tile(true_sight, (STARTS, 1))).reshape(STARTS, -1, 3)
        off_rad = np.einsum("nij,knj->kni", sides, seen)
        for half_rad, budget in found:
            told.append(budget.probability_in_frame)
            kept.append(np.mean(np.all(np.abs(off_rad) <= half_rad, axis=(1, 2))))
            of_sets.append(pair.of_set)
    return np.array(told), np.array(kept), np.array(of_sets)


def _session(
    pair: Pair, law: LvlhAttitude, rng: np.random.Generator
) -> tuple[list[tuple[tuple[float, float], PointingBudget]], np.ndarray, np.ndarray]:
    """A target near the predicted track: frames with their budgets; where it truly is, in the
    platform, and the directions of the frame's sides, as the table is flown."""
    stop_utc = shifted_utc(pair.start_utc, 95.0)
    instants = Instants(pair.start_utc, SESSION_S)
    ephemeris = pair.predicted.ephemeris(pair.start_utc, stop_utc)
    middle = Instants(pair.start_utc, SESSION_S[5:6])
    r_eci_m = ephemeris.states(middle).r_sat_eci_m
    r_itrf_m = np.einsum("nij,nj->ni", c_itrf_from_eci(middle), r_eci_m)
    latitude_rad, longitude_rad, _ = geodetic_from_itrf(r_itrf_m)
    aside_deg = rng.uniform(-ASIDE_DEG, ASIDE_DEG, 2)
    longitude_deg = np.rad2deg(longitude_rad[0]) + aside_deg[1]
    target = GroundTarget(
        latitude_deg=float(np.clip(np.rad2deg(latitude_rad[0]) + aside_deg[0], -89.0, 89.0)),
        longitude_deg=float((longitude_deg + 540.0) % 360.0 - 180.0),
        height_m=0.0,
    )
    q_platform = ISS_HRC.q_platform_from_body
    los = line_of_sight(instants, ephemeris, law, q_platform, target)
    truth = pair.true.ephemeris(pair.start_utc, stop_utc)
    true_sight = line_of_sight(instants, truth, law, q_platform, target).los_base
    along = np.cross(ISS_HRC.axes_platform[0], los.los_base)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    sides = np.stack([along, np.cross(los.los_base, along)], axis=1)
    angle_rad = axis_angles(ISS_HRC, los.los_base).angle_rad[0]
    found = []
    for size in SIZES:
        half_rad = tuple(size * np.array(ISS_HRC.frame_half_rad))
        frame = replace(ISS_HRC, frame_half_rad=half_rad)
        budget = pointing_budget(
            los, ephemeris, law, target, frame, angle_rad, session=0, clock_s=0.0
        )
        found.append((half_rad, budget))
    return found, true_sight, sides


def _known(data: Path) -> list[Pair]:
    """States without age, so that the orbit is hardly an error."""
    pairs = []
    for tle in read_tles(data / "tle" / "iss_tles.txt"):
        for hours in (1, 5, 9):
            start_utc = tle.epoch_utc + timedelta(hours=hours)
            states = tle.ephemeris(start_utc, start_utc).states(Instants(start_utc, np.zeros(1)))
            state = StateVectorOrbit(
                frame="GCRF",
                epoch=start_utc,
                position_km=tuple(states.r_sat_eci_m[0] / 1e3),
                velocity_km_s=tuple(states.v_sat_eci_m_s[0] / 1e3),
            )
            pairs.append(Pair(state, state, start_utc, len(pairs)))
    return pairs


def _later_elements(data: Path) -> list[Pair]:
    """Of the archive's held-out months, reboosts included; truth near the later ones' epoch."""
    tles = sorted(read_tles(data / "tle" / ARCHIVE), key=lambda tle: tle.epoch_utc)
    tles = [tle for tle in tles if tle.epoch_utc.month >= HELD_OUT_MONTH]
    return [
        Pair(first, later, later.epoch_utc, _week(first.epoch_utc))
        for k, first in enumerate(tles)
        for later in tles[k + 1 :]
        if _within(elapsed_s(later.epoch_utc, first.epoch_utc), TLE_AGES_DAYS)
    ]


def _ephemerides(data: Path) -> list[Pair]:
    """Truth from elements at their epoch."""
    oems = [read_oem_file(path) for path in sorted((data / "oem").glob("*.xml.gz"))]
    return [
        Pair(oem, tle, tle.epoch_utc, _week(created(oem)))
        for oem in oems
        for tle in read_tles(data / "tle" / "iss_tles.txt")
        if _within(elapsed_s(tle.epoch_utc, created(oem)), OEM_AGES_DAYS) and _covers(oem, tle)
    ]


def _covers(oem: OemOrbit, tle: TleOrbit) -> bool:
    segment = oem.message.segments[-1]
    return elapsed_s(tle.epoch_utc, segment.epoch_utc) < segment.t_s[-1] - 200.0


def _week(made_utc: datetime) -> int:
    """The Monday before, by its number: predictions of a week share tracking, air and burns."""
    return made_utc.toordinal() - made_utc.weekday()


def _within(age_s: float, days: tuple[float, float]) -> bool:
    return days[0] * DAY_S < age_s < days[1] * DAY_S


def telemetry(folder: Path) -> tuple[np.ndarray, Rotation]:
    """Every 10 s where values are fresh: seconds of the year, body from LVLH."""
    channels = {number: channel(folder, number) for number in (18, 19, 20, 21)}
    changes_s = channels[20][0]
    t_s = np.arange(channels[21][0][0], changes_s[-1], STEP_S)
    latest_s = changes_s[np.searchsorted(changes_s, t_s, side="right") - 1]
    t_s = t_s[t_s - latest_s < STALE_S]
    xyzw = np.stack([held(channels, number, t_s) for number in (19, 20, 21, 18)], axis=1)
    return t_s, Rotation.from_quat(xyzw).inv()


def channel(folder: Path, number: int) -> tuple[np.ndarray, np.ndarray]:
    """Seconds of the year and values, in order."""
    (path,) = folder.glob(f"USLAB0000{number}.txt*")
    opener = gzip.open if path.suffix == ".gz" else open
    with opener(path, "rt") as file:
        table = np.loadtxt(file)
    table = table[np.argsort(table[:, 0], kind="stable")]
    return table[:, 0] * 3600.0, table[:, 1]


def held(
    number_of: dict[int, tuple[np.ndarray, np.ndarray]], number: int, t_s: np.ndarray
) -> np.ndarray:
    """The last value recorded: only changes are."""
    at_s, values = number_of[number]
    return values[np.clip(np.searchsorted(at_s, t_s + 1e-3, side="right") - 1, 0, None)]
