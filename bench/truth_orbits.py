"""Orbit errors against the stated ones: of bench/truth.py.

The constants of planner/world/orbits/accuracy.py were chosen on elements of 1998 to 2004, 2017
and 2024-25 (docs/decisions/orbit_growth.md), reboosts on those of 2017 and 2024-25, those near the
epoch on ephemerides of 2021 to 2025, unplanned burns on 23 of these, and what is wrong past planned
burns on the eight of these that tell it.  Of elements April to June 2017 are tried apart, 1 % of
those of the growth.

Element sets against later ones of the same satellite share near their epoch what is wrong with
SGP4: the growth alone is seen, plus the noise of both fits.
"""

import gzip
from collections import defaultdict
from collections.abc import Iterator
from contextlib import suppress
from datetime import datetime
from itertools import pairwise, product
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.stats import norm
from truth_rows import GAUSS, USUAL, Row, nees_row, share_row

from planner.base.errors import OutsideCoverage
from planner.world.frames.time_scales import DAY_S, Instants, elapsed_s, shifted_utc
from planner.world.orbits import OemOrbit, Orbit, OrbitStates, StateVectorOrbit, TleOrbit
from planner.world.orbits.accuracy import (
    FIGURES as ORBIT_ERROR_FIGURES,
)
from planner.world.orbits.accuracy import (
    NormalMixture,
    OrbitSigma,
    oem_sigma,
    state_sigma,
)

AGES_DAYS = (1.0, 2.0, 3.0, 5.0, 7.0, 10.0)
SPREAD = 0.15  # of the age
REBOOST_REV_DAY = -3e-4  # of the mean motion, from elements to the next
WEEK_DAYS = 7.0  # elements of a week share their tracking and their air
AXES = ("radial", "along", "across")
TUNED_OEMS = ("2022-038", "2022-042")
ARCHIVE = "iss_tle_25544_20170101-20170630.txt"
HELD_OUT_MONTH = 4  # of the archive, and later
TLE_AGES_DAYS = (0.04, 0.5, 1.0, 2.0, 3.0, 5.0)
OEM_AGE_MAX_DAYS = 10.0  # as truth for elements
NEAR_EPOCH_DAYS = 0.04
OEM_AGE_MIN_DAYS = 1.5  # where it is worse than the elements it is tried on
OEM_YOUNG_DAYS = 0.3  # as truth for an older one
BURN_MOVED_S = 3600.0  # a burn moved by more is another
HELD_OUT_DAY = 90.0  # of the archive
TOLD_SHARES = (0.5, 0.9)
SHARE_GOAL = 0.05

BURN_STEP_S = 60.0  # nodes crowd where an engine burns
STATE_LEADS_S = (900.0, 2700.0, 5400.0, 10800.0, 21600.0)
STATE_DAYS = (0.5, 1.6, 4.3)
STATE_DRAWS = 12
STATE_M, STATE_M_S = 10.0, 0.01  # what is assumed of a state


def rows(data: Path) -> Iterator[Row]:
    oems = {path.name[-15:-7]: path for path in sorted((data / "oem").glob("*.xml.gz"))}
    read = {day: read_oem_file(path) for day, path in oems.items()}
    tles = list(read_tles(data / "tle" / "iss_tles.txt"))
    held_out = [oem for day, oem in read.items() if day not in TUNED_OEMS]
    for which, few in (("held out", held_out), ("all", list(read.values()))):
        yield from _tle_rows(tles, few, which)
    yield from _oem_rows(tles, list(read.values()))
    yield from growth_rows(data / "tle" / ARCHIVE)
    yield from _state_rows(list(read.values()))


def _tle_rows(tles: list[TleOrbit], oems: list[OemOrbit], which: str) -> Iterator[Row]:
    found: dict[str, list[np.ndarray]] = defaultdict(list)
    for tle, oem, age in product(tles, oems, TLE_AGES_DAYS):
        at_utc = shifted_utc(tle.epoch_utc, age * DAY_S)
        old_days = elapsed_s(at_utc, created(oem)) / DAY_S
        if not -0.5 < old_days < OEM_AGE_MAX_DAYS or _burns(oems, tle, age):
            continue
        normalised2 = _normalised2(oem, tle, tle, age)
        if normalised2 is not None:
            found[tle.line1].append(normalised2)
    of = f"of {sum(map(len, found.values()))} cases, {len(found)} element sets, to 5 days of age"
    for k, axis in enumerate(AXES):
        sets = [np.array(cases)[:, k : k + 1] for cases in found.values()]
        spread = USUAL if axis == "along" else GAUSS
        yield nees_row(f"TLE against ephemerides, {which}, {axis}", sets, of, spread)


def growth_rows(archive: Path) -> Iterator[Row]:
    """Along the track, where the elements' own error at the epoch is small against the growth."""
    found = pairs(list(read_tles(archive)))
    for age, all_of in found.items():
        weeks = np.array([int(pair.day // WEEK_DAYS) for pair in all_of])
        for share in TOLD_SHARES:
            kept = np.array([pair.within(share) for pair in all_of], dtype=float)
            what = f"TLE against a later one, reboosts included, along, {age:g} d"
            yield share_row(what, share, kept, weeks, SHARE_GOAL)
        held_out = [pair for pair in all_of if pair.day >= HELD_OUT_DAY and not pair.reboosted]
        day, sigmas = np.array([(pair.day, pair.sigmas) for pair in held_out]).T
        week = day // WEEK_DAYS
        by_week = [sigmas[week == one, None] ** 2 for one in np.unique(week)]
        of = f"of {len(held_out)} pairs"
        yield nees_row(f"TLE against a later one, no reboost, along, {age:g} d", by_week, of,
                       USUAL)  # fmt: skip


def _oem_rows(tles: list[TleOrbit], oems: list[OemOrbit]) -> Iterator[Row]:
    """Against elements at their epoch and younger ephemerides."""
    by_oem = [cases for oem in oems if (cases := _oem_cases(oem, tles, oems))]
    told = [np.mean(cases, keepdims=True)[:, None] for cases in by_oem]
    yield nees_row("OEM as told, along", told, f"of {sum(map(len, by_oem))} cases", USUAL)


def _oem_cases(oem: OemOrbit, tles: list[TleOrbit], oems: list[OemOrbit]) -> list[float]:
    """Squares of errors along the track over what is told; at several ages they are one error."""
    begin_utc, cases = created(oem), []
    drag_in_a_day_m = oem.ephemeris(begin_utc, shifted_utc(begin_utc, 1.0)).drag_in_a_day_m
    for truth in (*tles, *oems):
        epoch_utc = truth.epoch_utc if isinstance(truth, TleOrbit) else created(truth)
        later_days = NEAR_EPOCH_DAYS if isinstance(truth, TleOrbit) else OEM_YOUNG_DAYS
        age_days = elapsed_s(epoch_utc, created(oem)) / DAY_S + later_days
        if age_days > OEM_AGE_MIN_DAYS and not _surprised(oem, oems, age_days):
            found_m = differences(truth, oem, epoch_utc, later_days)
            if len(found_m):
                drag_m = ORBIT_ERROR_FIGURES.oem_drag_wrong * drag_in_a_day_m * age_days**2
                told_m = oem_sigma(np.array([age_days * DAY_S]), 0.0).along_m[0]
                of_truth = _sigma(truth, shifted_utc(epoch_utc, later_days * DAY_S))
                told_m = np.hypot(np.hypot(told_m, drag_m), of_truth.along_m[0])
                cases.append(float(np.mean(found_m[:, 1] ** 2) / told_m**2))
    return cases


def _surprised(oem: OemOrbit, oems: list[OemOrbit], age_days: float) -> bool:
    """Whether until then one of it and a younger ephemeris holds a burn that the other hasn't."""
    mine_s = _burning_s(oem, created(oem))
    end_s = age_days * DAY_S
    for other in (one for one in oems if created(one) > created(oem)):
        segment = other.message.segments[0]
        first_s = elapsed_s(segment.epoch_utc, created(oem))
        last_s = min(end_s, first_s + float(segment.t_s[-1]))
        both = [
            one[(one > max(first_s, 0.0)) & (one < last_s)]
            for one in (mine_s, _burning_s(other, created(oem)))
        ]
        for one, two in (both, both[::-1]):
            if any(not np.any(np.abs(two - at_s) < BURN_MOVED_S) for at_s in one):
                return True
    return False


def _burning_s(oem: OemOrbit, epoch_utc: datetime) -> np.ndarray:
    """Moments of burns, from an epoch on."""
    segment = oem.message.segments[0]
    burning_s = segment.t_s[:-1][np.diff(segment.t_s) < BURN_STEP_S]
    return burning_s + elapsed_s(segment.epoch_utc, epoch_utc)


def _burns(oems: list[OemOrbit], tle: TleOrbit, age_days: float) -> bool:
    """Whether an ephemeris holds a burn between the elements' epoch and then."""
    since_s = np.concatenate([_burning_s(oem, tle.epoch_utc) for oem in oems])
    return bool(np.any((since_s > 0.0) & (since_s < age_days * DAY_S)))


def _normalised2(truth: Orbit, other: Orbit, tle: TleOrbit, age_days: float) -> np.ndarray | None:
    """Mean squares over an orbit over what both are told to be off by, (3,)."""
    found_m = differences(truth, other, tle.epoch_utc, age_days)
    if not len(found_m):
        return None
    variances = sum(_told_m(orbit, tle, age_days) ** 2 for orbit in (truth, other))
    return np.mean(found_m**2, axis=0) / variances


def _told_m(orbit: Orbit, tle: TleOrbit, age_days: float) -> np.ndarray:
    """1-sigma radial, along, across, (3,); of elements at their own epoch the growth alone."""
    if isinstance(orbit, TleOrbit) and orbit is not tle:
        return np.zeros(3)  # the same tracking's error, in both sets
    return _axes_m(_sigma(orbit, shifted_utc(tle.epoch_utc, age_days * DAY_S)))[0]


def _axes_m(sigma: OrbitSigma) -> np.ndarray:
    return np.stack([sigma.radial_m, sigma.along_m, sigma.cross_m], axis=1)


def _state_rows(oems: list[OemOrbit]) -> Iterator[Row]:
    """States with the error that is assumed of them, propagated, against NASA's ephemerides."""
    rng = np.random.default_rng(5)
    errors_m, model_m = [], []
    for oem, days in product(oems, STATE_DAYS):
        epoch_utc = shifted_utc(oem.message.segments[0].epoch_utc, days * DAY_S)
        stop_utc = shifted_utc(epoch_utc, STATE_LEADS_S[-1] + 60.0)
        truth = oem.ephemeris(epoch_utc, stop_utc)
        instants = Instants(epoch_utc, np.array(STATE_LEADS_S))
        first = truth.states(Instants(epoch_utc, np.zeros(1)))
        for draw in range(STATE_DRAWS + 1):
            wrong = rng.normal(0.0, 1.0, (2, 3)) * (draw > 0)
            position_m = first.r_sat_eci_m[0] + STATE_M * wrong[0]
            velocity_m_s = first.v_sat_eci_m_s[0] + STATE_M_S * wrong[1]
            state = StateVectorOrbit(
                frame="GCRF",
                epoch=epoch_utc,
                position_km=tuple(position_m / 1e3),
                velocity_km_s=tuple(velocity_m_s / 1e3),
            )
            found = state.ephemeris(epoch_utc, stop_utc).states(instants)
            (errors_m if draw else model_m).append(ric_m(truth.states(instants), found))
    told = _axes_m(state_sigma(np.array(STATE_LEADS_S), paper_model=False))
    squares = np.square(errors_m) / told**2
    model_rms_m = np.sqrt(np.mean(np.square(model_m), axis=0))
    for k, lead_s in enumerate(STATE_LEADS_S):
        of = f"of {len(errors_m)}; the force model's part {model_rms_m[k, 1]:.1f} m along"
        what = f"state propagated {lead_s:.0f} s: radial, along, across"
        yield nees_row(what, np.split(squares[:, k], len(squares)), of)


def ric_m(truth: OrbitStates, other: OrbitStates) -> NDArray[np.float64]:
    """Radial, along-track and cross-track differences, (n, 3); along and cross are arcs."""
    x = truth.r_sat_eci_m / np.linalg.norm(truth.r_sat_eci_m, axis=1, keepdims=True)
    z = np.cross(truth.r_sat_eci_m, truth.v_sat_eci_m_s)
    z /= np.linalg.norm(z, axis=1, keepdims=True)
    towards = [np.sum(other.r_sat_eci_m * axis, axis=1) for axis in (x, np.cross(z, x), z)]
    radius_m = np.linalg.norm(other.r_sat_eci_m, axis=1)
    radial_m = radius_m - np.linalg.norm(truth.r_sat_eci_m, axis=1)
    along_m = radius_m * np.arctan2(towards[1], towards[0])
    return np.stack([radial_m, along_m, radius_m * np.arcsin(towards[2] / radius_m)], axis=1)


def differences(
    truth: Orbit, other: Orbit, epoch_utc: datetime, age_days: float
) -> NDArray[np.float64]:
    """Over one orbit about the age; empty where either doesn't reach."""
    start_utc = shifted_utc(epoch_utc, age_days * 86400.0 - 2780.0)
    instants = Instants(start_utc, np.arange(0.0, 5561.0, 139.0))
    stop_utc = shifted_utc(start_utc, 5561.0)
    try:
        states = [o.ephemeris(start_utc, stop_utc).states(instants) for o in (truth, other)]
    except OutsideCoverage:
        return np.empty((0, 3))
    return ric_m(*states)


def created(oem: OemOrbit) -> datetime:
    return oem.message.creation_utc or oem.message.segments[0].epoch_utc


def read_oem_file(path: Path) -> OemOrbit:
    opener = gzip.open if path.suffix == ".gz" else open
    with opener(path, "rt") as file:
        return OemOrbit(content=file.read())


def read_tles(path: Path) -> Iterator[TleOrbit]:
    for one, two in pairwise(line.rstrip() for line in path.read_text().splitlines()):
        if one.startswith("1 ") and two.startswith("2 "):
            with suppress(ValueError):  # a line damaged in the archive
                yield TleOrbit(line1=one, line2=two)


class Pair(NamedTuple):
    """day: of the earlier set's epoch.  sigmas: its error along the track at the later's epoch.

    along: how that is told to be distributed.  reboosted: whether it was in between.
    """

    day: float
    sigmas: float
    along: NormalMixture
    reboosted: bool

    def within(self, share: float) -> bool:
        """Whether it lies in the interval that so many errors are told to lie in."""
        edge = float(self.along.scores(np.array(norm.ppf(0.5 + 0.5 * share))))
        return abs(self.sigmas) <= edge


def pairs(tles: list[TleOrbit], every: int = 1) -> dict[float, list[Pair]]:
    """By age; of each `every`-th set against the one nearest to that much later."""
    tles = sorted(tles, key=lambda tle: tle.epoch_utc)
    days = np.array([elapsed_s(tle.epoch_utc, tles[0].epoch_utc) / DAY_S for tle in tles])
    raised = np.diff([float(tle.line2[52:63]) for tle in tles]) < REBOOST_REV_DAY
    found: dict[float, list[Pair]] = defaultdict(list)
    for first, age in product(range(0, len(tles), every), AGES_DAYS):
        later = int(np.argmin(np.abs(days - days[first] - age)))
        apart = float(days[later] - days[first])
        if abs(apart - age) > SPREAD * age:
            continue
        off_m = differences(tles[later], tles[first], tles[first].epoch_utc, apart)
        if len(off_m):
            told = _sigma(tles[first], tles[later].epoch_utc)
            sigmas = float(np.mean(off_m[:, 1]) / told.along_m[0])
            reboosted = bool(raised[first:later].any())
            found[age].append(Pair(float(days[first]), sigmas, told.along, reboosted))
    return found


def _sigma(orbit: Orbit, at_utc: datetime) -> OrbitSigma:
    ephemeris = orbit.ephemeris(at_utc, shifted_utc(at_utc, 1.0))
    return ephemeris.sigma(Instants(at_utc, np.zeros(1)))
