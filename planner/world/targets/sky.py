"""Targets in the sky beyond the Earth, and how they are seen."""

import math
from abc import abstractmethod
from typing import Annotated

import numpy as np

from planner.base.arrays import Array
from planner.base.spec import Within
from planner.world.frames.earth_orientation import c_itrf_from_eci
from planner.world.frames.solar_system import earth_bary_state
from planner.world.frames.time_scales import Instants
from planner.world.orbits import OrbitStates
from planner.world.targets.apparent import ApparentDirection, VisibleTarget, aberrate
from planner.world.targets.deflection import deflect
from planner.world.targets.earth_limb import limb_clearance_rad, refract
from planner.world.targets.refraction import Refraction

GRAZING_ALTITUDE_KM = 80.0  # refraction bends by 0.1 arcsec there, and by 8 times more 15 km lower
GrazingAltitudeKm = Annotated[float, Within(0.0, 300.0)]
LOWEST_SEEN_KM = 2.0  # a ray that grazes the sea seems to pass at 1.77 km


class SkyTarget(VisibleTarget):
    """A target given by its place in the solar system or among the stars.

    grazing_altitude_km: the line of sight must pass at least this high above the ellipsoid
    over the whole session.
    refraction: "standard" lifts targets seen through the limb by the standard atmosphere's
    bending (150 arcsec at 25 km, a degree near the ground); the height is then that of the
    line as seen, which the ray itself undercuts by 0.1 km at 20 km and 0.6 km at 8 km.
    """

    grazing_altitude_km: float
    refraction: Refraction

    def __post_init__(self) -> None:
        if self.refraction == "standard" and self.grazing_altitude_km < LOWEST_SEEN_KM:
            raise ValueError(
                f"grazing_altitude_km must be at least {LOWEST_SEEN_KM:g} with refraction "
                f"'standard', not {self.grazing_altitude_km:g}: lower rays end on the ground"
            )

    @abstractmethod
    def seen_from(self, instants: Instants, r_observer_bary_m: Array) -> tuple[Array, Array]:
        """Astrometric directions, unit vectors (n, 3), and range, (n,), infinite for a star.

        r_observer_bary_m: the observer from the solar system's barycentre, (n, 3), GCRF axes.
        Light time included, deflection and aberration not.
        """

    def body_seen(self) -> str | None:
        """Which of the ephemeris's bodies this is, if any."""
        return None

    def apparent(self, instants: Instants, states: OrbitStates) -> ApparentDirection:
        """Light time, gravitational deflection, aberration; clearance is from the raised limb.

        Aberration is applied twice, by the Earth's velocity and by the carrier's about the
        Earth, since refraction and limb belong to the geocentric frame in between (their order
        matters by 0.3 mas).  Neglects the offset of the platform from the carrier's reference
        point.  Source: IAU 2000 resolutions, as in USNO Circular 179, chapter 1 and 6.
        """
        direction_eci, range_m = self.arriving(instants, states)
        c_itrf_from_eci_ = c_itrf_from_eci(instants)
        direction_itrf = np.einsum("nij,nj->ni", c_itrf_from_eci_, direction_eci)
        r_sat_itrf_m = np.einsum("nij,nj->ni", c_itrf_from_eci_, states.r_sat_eci_m)
        if self.refraction == "standard":
            direction_itrf = refract(direction_itrf, r_sat_itrf_m)
            direction_eci = np.einsum("nji,nj->ni", c_itrf_from_eci_, direction_itrf)
        return ApparentDirection(
            direction_eci=aberrate(direction_eci, states.v_sat_eci_m_s),
            range_m=range_m,
            clearance_rad=limb_clearance_rad(
                direction_itrf, r_sat_itrf_m, self.grazing_altitude_km * 1e3
            ),
        )

    def arriving(self, instants: Instants, states: OrbitStates) -> tuple[Array, Array]:
        """Direction in which its light arrives where the carrier is, for who rests there beside the
        Earth, unit vectors (n, 3), and range, (n,); without refraction."""
        r_earth_bary_m, v_earth_bary_m_s = earth_bary_state(instants)
        r_observer_bary_m = r_earth_bary_m + states.r_sat_eci_m
        direction, range_m = self.seen_from(instants, r_observer_bary_m)
        direction = deflect(
            direction, range_m, instants, r_observer_bary_m, states.r_sat_eci_m, self.body_seen()
        )
        return aberrate(direction, v_earth_bary_m_s), range_m

    def hidden_because(self, clearance_rad: float) -> str:
        """Says how far behind the limb."""
        return (
            f"the Earth hides the target: it stands {-math.degrees(clearance_rad):.2f} deg below "
            f"the limb, {self.grazing_altitude_km:g} km above the ellipsoid"
        )
