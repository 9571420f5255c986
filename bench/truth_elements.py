"""Elements and ephemerides, read and differenced, for bench/truth.py.

Element sets against later ones of the same satellite share near their epoch what is wrong with
SGP4: the growth alone is seen, plus the noise of both fits.  Figures with their archives' sources:
docs/decisions/orbit_growth.md.
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

from planner.base.errors import OutsideCoverage
from planner.world.frames.time_scales import DAY_S, Instants, elapsed_s, shifted_utc
from planner.world.orbits import OemOrbit, Orbit, OrbitStates, TleOrbit
from planner.world.orbits.accuracy import NormalMixture, OrbitSigma

AGES_DAYS = (1.0, 2.0, 3.0, 5.0, 7.0, 10.0)
SPREAD = 0.15  # of the age
REBOOST_REV_DAY = -3e-4  # of the mean motion, from elements to the next
WEEK_DAYS = 7.0  # elements of a week share their tracking and their air


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
            told = _told(tles[first], apart)
            sigmas = float(np.mean(off_m[:, 1]) / told.along_m[0])
            reboosted = bool(raised[first:later].any())
            found[age].append(Pair(float(days[first]), sigmas, told.along, reboosted))
    return found


def _told(tle: TleOrbit, age_days: float) -> OrbitSigma:
    at_utc = shifted_utc(tle.epoch_utc, age_days * DAY_S)
    ephemeris = tle.ephemeris(at_utc, shifted_utc(at_utc, 1.0))
    return ephemeris.sigma(Instants(at_utc, np.zeros(1)))
