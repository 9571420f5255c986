"""Stated errors against data that nothing was made with: one table, goal and seen.

    OMP_NUM_THREADS=1 python bench/truth.py DATA_FOLDER [--quick]

DATA_FOLDER holds `attitude` (telemetry as bench/truth_pointing.py reads it), `tle` and `oem`
(NASA's ephemerides): stated probabilities and sigmas, and warnings of likely misses.  What was
tuned on which data each truth_*.py says.  About 10 minutes of a core; --quick takes fewer sessions.
"""

import argparse
from itertools import chain
from pathlib import Path

import truth_orbits
import truth_pointing

VERDICTS = {True: "met", False: "MISSED", None: "-"}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("data", type=Path)
    parser.add_argument("--quick", action="store_true")
    asked = parser.parse_args()
    print(f"{'what':62} {'goal':24} {'':7} seen")
    missed = 0
    for row in chain(
        truth_pointing.rows(asked.data, sessions=40 if asked.quick else 200),
        truth_pointing.swing_rows(asked.data / "attitude"),
        truth_orbits.rows(asked.data),
    ):
        missed += row.is_met is False
        print(f"{row.what:62} {row.goal:24} {VERDICTS[row.is_met]:7} {row.seen}", flush=True)
    print(f"{missed} missed")


if __name__ == "__main__":
    main()
