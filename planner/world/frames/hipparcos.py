"""Stars by Hipparcos number: Hipparcos, the New Reduction.

Source: van Leeuwen 2007, Hipparcos, the New Reduction of the Raw Data; CDS catalogue I/311.
data/hipparcos.npy holds its numbers, sorted, as the integers that its decimals are.
"""

import math
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

_STARS = Path(__file__).parent / "data" / "hipparcos.npy"
_RAD, _MAS = 1e10, 1e2  # the integers' units are a 1e10th of a radian and a 100th of a mas
COLUMNS = np.dtype(
    [
        ("hip", "<i4"),
        ("ra", "<i8"),
        ("dec", "<i8"),
        ("parallax", "<i4"),
        ("pm_ra_cosdec", "<i4"),
        ("pm_dec", "<i4"),
    ]
)


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
    stars = np.load(_STARS, mmap_mode="r")
    row = int(np.searchsorted(stars["hip"], number))
    if row == len(stars) or stars["hip"][row] != number:
        return None
    _, ra, dec, parallax, pm_ra_cosdec, pm_dec = stars[row].item()
    return CatalogueStar(
        epoch_jyear=1991.25,
        ra_deg=math.degrees(ra / _RAD),
        dec_deg=math.degrees(dec / _RAD),
        # The noise of a distant star's may be negative.
        parallax_mas=max(0.0, parallax / _MAS),
        pm_ra_cosdec_mas_yr=pm_ra_cosdec / _MAS,
        pm_dec_mas_yr=pm_dec / _MAS,
    )
