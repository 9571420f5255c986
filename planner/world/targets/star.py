"""A star as a target."""

import math
from typing import Annotated, Literal

import erfa
import numpy as np

from planner.base.arrays import Array
from planner.base.assumed import Assumed
from planner.base.spec import Within, spec
from planner.world.frames.hipparcos import CatalogueStar, hipparcos_star
from planner.world.frames.time_scales import Instants
from planner.world.targets.deflection import AU_M
from planner.world.targets.refraction import Refraction
from planner.world.targets.sky import GRAZING_ALTITUDE_KM, GrazingAltitudeKm, SkyTarget
from planner.world.targets.star_names import hipparcos_number

_J2000_JD = 2451545.0
_J2000_JYEAR = 2000.0
_MAS_RAD = float(erfa.DMAS2R)


@spec
class StarTarget(SkyTarget):
    """A star by its name, its Hipparcos number, or its ICRS coordinates at an epoch.

    ra_deg, dec_deg: right ascension and declination at Julian year `epoch_jyear`.
    epoch_jyear: of the coordinates, TDB; 2000.0 unless given. Gaia DR3 lists positions at 2016.0,
    Hipparcos at 1991.25. E.g. `2016.0`.
    pm_ra_cosdec_mas_yr: proper motion in right ascension, cos(dec) included, as catalogues list it.
    pm_dec_mas_yr: proper motion in declination.
    parallax_mas: 0 for a star too far to measure.
    radial_velocity_km_s: positive receding; moves nearby stars only (Barnard's star by 0.7 arcsec
    since 1991).
    hip: Hipparcos number. Everything but the radial velocity then comes from Hipparcos, the New
    Reduction; stars with a companion may stray from its uniform motion by some 0.1 arcsec.
    name: its proper name, instead of the number, in either case. E.g. `"Sirius"`.
    """

    mode: Literal["star"] = "star"
    ra_deg: Annotated[float, Within(0.0, 360.0)] | None = None
    dec_deg: Annotated[float, Within(-90.0, 90.0)] | None = None
    epoch_jyear: Annotated[float, Within(1800.0, 2200.0)] | None = None
    pm_ra_cosdec_mas_yr: Annotated[float, Within(-20e3, 20e3)] | None = None
    pm_dec_mas_yr: Annotated[float, Within(-20e3, 20e3)] | None = None
    parallax_mas: Annotated[float, Within(0.0, 1000.0)] | None = None
    radial_velocity_km_s: Annotated[float, Within(-1000.0, 1000.0)] = 0.0
    hip: Annotated[int, Within(1, 999_999)] | None = None
    name: str | None = None
    grazing_altitude_km: GrazingAltitudeKm = GRAZING_ALTITUDE_KM
    refraction: Refraction = "none"

    def __post_init__(self) -> None:
        coordinates = (
            "ra_deg",
            "dec_deg",
            "epoch_jyear",
            "pm_ra_cosdec_mas_yr",
            "pm_dec_mas_yr",
            "parallax_mas",
        )
        given = [name for name in coordinates if getattr(self, name) is not None]
        if self.name is not None:
            given = [*given, *(["hip"] if self.hip is not None else [])]
            if given:
                raise ValueError(
                    f"name {self.name!r} already says {', '.join(given)}; give one of name, hip "
                    "and coordinates"
                )
            hipparcos_number(self.name)
        elif self.hip is None and (self.ra_deg is None or self.dec_deg is None):
            raise ValueError(
                "a star needs its name, its Hipparcos number as hip, or ra_deg and dec_deg"
            )
        if self.hip is not None and given:
            raise ValueError(
                f"hip {self.hip} already says {', '.join(given)}; give coordinates or hip, not both"
            )
        if self.hip is not None and hipparcos_star(self.hip) is None:
            raise ValueError(
                f"hip {self.hip} is not in the Hipparcos catalogue (numbers 1 to 120404, with "
                "gaps); give the star's ra_deg and dec_deg instead"
            )
        super().__post_init__()

    @property
    def label(self) -> str:
        """Its name, its number, or its place among the stars."""
        if self.name is not None:
            return self.name
        if self.hip is not None:
            return f"HIP {self.hip}"
        return f"RA {self.ra_deg:.4f}, Dec {self.dec_deg:.4f}"

    @property
    def catalogue_number(self) -> int | None:
        """Its Hipparcos number, given or looked up; None for coordinates."""
        return self.hip if self.name is None else hipparcos_number(self.name)

    def assumed(self, field: str) -> Assumed | None:
        """Which star a name means."""
        if self.name is None:
            return None
        number = self.catalogue_number
        return Assumed(
            field=f"{field}.name",
            detail=f"{self.name} is Hipparcos {number}",
            members={"mode": "star", "hip": number},
        )

    def seen_from(self, instants: Instants, r_observer_bary_m: Array) -> tuple[Array, Array]:
        """Uniform motion in space, parallax and Roemer delay; see `SkyTarget`.

        TT stands for TDB.  Source: ESA 1997, The Hipparcos and Tycho Catalogues, vol. 1,
        eq. 1.2.16 and 1.5.5, as ERFA's `pmpx`.
        """
        star = self._catalogue_star()
        ra, dec = math.radians(star.ra_deg), math.radians(star.dec_deg)
        day, fraction = instants.tt_jd()
        since_days = (day - _J2000_JD) + fraction
        direction = erfa.pmpx(
            ra,
            dec,
            star.pm_ra_cosdec_mas_yr * _MAS_RAD / math.cos(dec),
            star.pm_dec_mas_yr * _MAS_RAD,
            star.parallax_mas / 1e3,
            self.radial_velocity_km_s,
            since_days / erfa.DJY + (_J2000_JYEAR - star.epoch_jyear),
            r_observer_bary_m / AU_M,
        )
        return np.asarray(direction), np.full(len(direction), np.inf)

    def _catalogue_star(self) -> CatalogueStar:
        number = self.catalogue_number
        if number is not None and (star := hipparcos_star(number)) is not None:
            return star
        assert self.ra_deg is not None and self.dec_deg is not None  # noqa: PT018 (checked at birth)
        return CatalogueStar(
            ra_deg=self.ra_deg,
            dec_deg=self.dec_deg,
            epoch_jyear=_J2000_JYEAR if self.epoch_jyear is None else self.epoch_jyear,
            pm_ra_cosdec_mas_yr=self.pm_ra_cosdec_mas_yr or 0.0,
            pm_dec_mas_yr=self.pm_dec_mas_yr or 0.0,
            parallax_mas=self.parallax_mas or 0.0,
        )
