"""Stated errors against data that nothing was made with: one table, goal and seen.

    OMP_NUM_THREADS=1 python bench/truth.py DATA_FOLDER [--only 1 2] [--quick]

DATA_FOLDER holds `attitude` (telemetry as bench/truth_pointing.py reads it), `tle` and `oem`
(NASA's ephemerides).  Point 1: stated probabilities and sigmas.  2: warnings of likely misses.
What was tuned on which data each truth_*.py says.  About 10 minutes of a core; --quick takes
fewer sessions.
"""

import argparse
from collections.abc import Iterator
from pathlib import Path

import truth_attitude
import truth_orbits
import truth_pointing
from truth_rows import Row

VERDICTS = {True: "met", False: "MISSED", None: "-"}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("data", type=Path)
    parser.add_argument("--only", type=int, nargs="*", default=(1, 2), metavar="POINT")
    parser.add_argument("--quick", action="store_true")
    asked = parser.parse_args()
    print(f"{'':2} {'what':62} {'goal':24} {'':7} seen")
    missed = 0
    for row in rows(asked.data, set(asked.only), asked.quick):
        if row.point in asked.only:
            missed += row.is_met is False
            print(
                f"{row.point:2} {row.what:62} {row.goal:24} {VERDICTS[row.is_met]:7} {row.seen}",
                flush=True,
            )
    print(f"{missed} missed")


def rows(data: Path, points: set[int], quick: bool) -> Iterator[Row]:
    """In the order of what they are measured with."""
    attitude = data / "attitude"
    if points & {1, 2}:
        yield from truth_pointing.rows(data, sessions=40 if quick else 200)
    if 1 in points:
        yield from truth_attitude.swing_rows(attitude)
        yield from truth_attitude.settling_rows(attitude)
        yield from truth_orbits.rows(data)


if __name__ == "__main__":
    main()
