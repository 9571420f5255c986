"""How fast do orbit predictions go wrong?  The figures behind `planner/sessions/uncertainty.py`.

    python bench/orbit_age.py --tles iss_tles.txt [--tles more.txt] ephemeris.oem.xml.gz ...

Prints radial, along-track and cross-track differences by age, each as the 1-sigma that the
median over the cases stands for (so that the few with a reboost between don't count): TLEs
against the first two days of OEMs; TLEs against later ones of the same list, which shows the
growth alone; and each OEM against the next, from the earlier one's creation on.
"""

import argparse
import gzip
from collections import defaultdict
from collections.abc import Iterator
from contextlib import suppress
from datetime import datetime
from itertools import pairwise, product
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from planner.errors import OutsideCoverage
from planner.frames.time_scales import Instants, elapsed_s, shifted_utc
from planner.orbits import OemOrbit, Orbit, OrbitStates, TleOrbit

AGES_DAYS = (0.1, 0.25, 0.5, 1.0, 2.0, 3.0, 5.0, 7.0, 10.0)
SPREAD = 0.15  # of the age
CASES_MAX = 40
OEM_TRUSTED_DAYS = (-0.2, 2.0)  # from its creation
MEDIAN_OF_GAUSSIAN = 0.6745

Cases = defaultdict[float, list[NDArray[np.float64]]]


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


def show(title: str, by_age: Cases) -> None:
    print(
        f"\n{title}\n{'age d':>7} {'cases':>6} {'radial':>9} {'along':>9} {'cross':>9}  km, 1 sigma"
    )
    for age, cases in sorted(by_age.items()):
        found = [case for case in cases if len(case)]
        if not found:
            continue
        per_case = [np.sqrt(np.mean(case**2, axis=0)) for case in found]
        rms = np.median(per_case, axis=0) / MEDIAN_OF_GAUSSIAN / 1e3
        print(f"{age:7.2f} {len(found):6d} " + " ".join(f"{value:9.3f}" for value in rms))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--tles", action="append", type=Path, default=[])
    parser.add_argument("oems", nargs="*", type=Path)
    arguments = parser.parse_args()
    oems = sorted(map(read_oem_file, arguments.oems), key=created)
    tles = sorted(
        (tle for path in arguments.tles for tle in read_tles(path)), key=lambda tle: tle.epoch_utc
    )
    show("TLE against OEM", tles_against_oems(tles, oems))
    show("TLE against a later TLE at that one's epoch", tles_against_tles(tles))
    show("OEM against the next OEM, by time since its creation", oems_against_next(oems))


def read_oem_file(path: Path) -> OemOrbit:
    opener = gzip.open if path.suffix == ".gz" else open
    with opener(path, "rt") as file:
        return OemOrbit(content=file.read())


def read_tles(path: Path) -> Iterator[TleOrbit]:
    for one, two in pairwise(line.rstrip() for line in path.read_text().splitlines()):
        if one.startswith("1 ") and two.startswith("2 "):
            with suppress(ValueError):  # a line damaged in the archive
                yield TleOrbit(line1=one, line2=two)


def tles_against_oems(tles: list[TleOrbit], oems: list[OemOrbit]) -> Cases:
    cases: Cases = defaultdict(list)
    for tle, oem, age in product(tles, oems, AGES_DAYS):
        at_utc = shifted_utc(tle.epoch_utc, age * 86400.0)
        oem_age_days = elapsed_s(at_utc, created(oem)) / 86400.0
        if OEM_TRUSTED_DAYS[0] < oem_age_days < OEM_TRUSTED_DAYS[1]:
            cases[age].append(differences(oem, tle, tle.epoch_utc, age))
    return cases


def tles_against_tles(tles: list[TleOrbit]) -> Cases:
    cases: Cases = defaultdict(list)
    for index in range(0, len(tles), 3):
        tle = tles[index]
        for later, age in product(tles[index + 1 : index + 60], AGES_DAYS):
            apart = elapsed_s(later.epoch_utc, tle.epoch_utc) / 86400.0
            if abs(apart - age) < SPREAD * age and len(cases[age]) < CASES_MAX:
                cases[age].append(differences(later, tle, tle.epoch_utc, apart))
    return cases


def oems_against_next(oems: list[OemOrbit]) -> Cases:
    cases: Cases = defaultdict(list)
    for (first, second), age in product(pairwise(oems), AGES_DAYS):
        cases[age].append(differences(second, first, created(first), age))
    return cases


if __name__ == "__main__":
    main()
