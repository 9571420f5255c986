"""Do elements go wrong as told?  Archives of elements against later ones of the same satellite.

    python bench/orbit_growth.py [--every 5] iss_tles_2017.txt more_tles.txt ...

Of each archive and age: NEES along the track (what is beyond 6 sigma counted apart), and the shares
of all that lie within what is told of 50, 80 and 95 %, Laplace's.  The later elements are near
their epoch, where both share what is wrong with SGP4; so the growth alone is seen, plus the noise
of both fits.  Pairs with a reboost between them are left out.
Figures so far, with their archives' sources: docs/decisions/orbit_growth.md.
"""

import argparse
from collections import defaultdict
from collections.abc import Iterator
from itertools import product
from pathlib import Path
from typing import NamedTuple

import numpy as np
from orbit_age import differences, read_tles

from planner.frames.time_scales import DAY_S, Instants, elapsed_s, shifted_utc
from planner.orbits import TleOrbit
from planner.orbits.accuracy import orbit_sigma

AGES_DAYS = (1.0, 2.0, 3.0, 5.0, 7.0, 10.0)
SPREAD = 0.15  # of the age
REBOOST_REV_DAY = -3e-4  # of the mean motion, from elements to the next
BEYOND_SIGMA = 6.0
WEEK_DAYS = 7.0  # elements of a week share their tracking and their air
SHARES = (0.5, 0.8, 0.95)


class Pair(NamedTuple):
    """day: of the earlier set's epoch.  sigmas: its error along the track at the later's epoch."""

    day: float
    sigmas: float


def pairs(tles: list[TleOrbit], every: int = 1) -> dict[float, list[Pair]]:
    """By age; of each `every`-th set against the one nearest to that much later."""
    tles = sorted(tles, key=lambda tle: tle.epoch_utc)
    days = np.array([elapsed_s(tle.epoch_utc, tles[0].epoch_utc) / DAY_S for tle in tles])
    raised = np.diff([float(tle.line2[52:63]) for tle in tles]) < REBOOST_REV_DAY
    found: dict[float, list[Pair]] = defaultdict(list)
    for first, age in product(range(0, len(tles), every), AGES_DAYS):
        later = int(np.argmin(np.abs(days - days[first] - age)))
        apart = float(days[later] - days[first])
        if abs(apart - age) > SPREAD * age or raised[first:later].any():
            continue
        off_m = differences(tles[later], tles[first], tles[first].epoch_utc, apart)
        if len(off_m):
            told_m = _told_along_m(tles[first], apart)
            found[age].append(Pair(float(days[first]), float(np.mean(off_m[:, 1])) / told_m))
    return found


def _told_along_m(tle: TleOrbit, age_days: float) -> float:
    at_utc = shifted_utc(tle.epoch_utc, age_days * DAY_S)
    ephemeris = tle.ephemeris(at_utc, shifted_utc(at_utc, 1.0))
    return float(orbit_sigma(ephemeris, Instants(at_utc, np.zeros(1))).along_m[0])


def lines(found: dict[float, list[Pair]]) -> Iterator[str]:
    for age, of_age in sorted(found.items()):
        day, sigmas = np.abs(np.array(of_age)).T
        sound = sigmas < BEYOND_SIGMA
        within = [np.mean(sigmas < -np.log(1.0 - share) / np.sqrt(2.0)) for share in SHARES]
        yield (
            f"{age:5.1f} {len(of_age):6d} {len(np.unique(day // WEEK_DAYS)):6d} "
            f"{np.mean(sigmas[sound] ** 2):6.2f} {100.0 * np.mean(~sound):6.1f} "
            + " ".join(f"{share:6.2f}" for share in within)
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--every", type=int, default=1)
    parser.add_argument("archives", nargs="+", type=Path)
    arguments = parser.parse_args()
    for archive in arguments.archives:
        print(f"\n{archive.name}\n age d  pairs  weeks   NEES beyond% within 50, 80, 95 % told")
        for line in lines(pairs(list(read_tles(archive)), arguments.every)):
            print(line)


if __name__ == "__main__":
    main()
