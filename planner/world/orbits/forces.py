"""The accelerations of a satellite by Earth, Sun, Moon and air, at many instants at once."""

from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Array
from planner.world.frames.earth_orientation import OMEGA_EARTH_RAD_S, c_itrf_from_eci
from planner.world.frames.geodesy import geodetic_from_itrf
from planner.world.frames.solar_system import r_moon_eci_m, r_sun_eci_m
from planner.world.frames.time_scales import Instants
from planner.world.orbits.atmosphere import density_kg_m3
from planner.world.orbits.gravity import earth_gravity

GM_SUN_M3_S2 = 1.32712440041e20  # DE421
GM_MOON_M3_S2 = 4.902800076e12  # DE421


@dataclass(frozen=True, eq=False)
class Forces:
    """Everything about the forces that depends on time alone, at n instants.

    ballistic_m2_kg: drag coefficient times area over mass, all that matters of how the air
    resists the satellite.  c_itrf_from_eci: shape (n, 3, 3).  r_sun_eci_m, r_moon_eci_m: (n, 3).
    """

    ballistic_m2_kg: float
    c_itrf_from_eci: Array
    r_sun_eci_m: Array
    r_moon_eci_m: Array

    def acceleration_eci_m_s2(self, r_eci_m: Array, v_eci_m_s: Array) -> Array:
        """Total acceleration, shape (n, 3), the k-th state at the k-th instant.

        Leaves out tides (3e-7 m/s^2), relativity (2e-8) and sunlight (2e-8 for the ISS).
        """
        c = self.c_itrf_from_eci
        r_itrf_m = np.einsum("nij,nj->ni", c, r_eci_m)
        attraction = earth_gravity().acceleration_itrf_m_s2(r_itrf_m)
        return np.asarray(
            np.einsum("nji,nj->ni", c, attraction)
            + _third_body(GM_SUN_M3_S2, self.r_sun_eci_m, r_eci_m)
            + _third_body(GM_MOON_M3_S2, self.r_moon_eci_m, r_eci_m)
            + self._drag_acceleration(r_eci_m, v_eci_m_s, r_itrf_m)
        )

    def _drag_acceleration(self, r_eci_m: Array, v_eci_m_s: Array, r_itrf_m: Array) -> Array:
        """The air turns with the Earth; its axis is taken from the third row of the matrix."""
        omega_eci_rad_s = OMEGA_EARTH_RAD_S * self.c_itrf_from_eci[:, 2]
        v_air_m_s = v_eci_m_s - np.cross(omega_eci_rad_s, r_eci_m)
        _, _, height_m = geodetic_from_itrf(r_itrf_m)
        density = density_kg_m3(r_eci_m, height_m, self.r_sun_eci_m)
        speed_m_s = np.linalg.norm(v_air_m_s, axis=1)
        return np.asarray(-0.5 * self.ballistic_m2_kg * (density * speed_m_s)[:, None] * v_air_m_s)


def forces_at(instants: Instants, ballistic_m2_kg: float) -> Forces:
    """Forces at n instants."""
    return Forces(
        ballistic_m2_kg=ballistic_m2_kg,
        c_itrf_from_eci=c_itrf_from_eci(instants),
        r_sun_eci_m=r_sun_eci_m(instants),
        r_moon_eci_m=r_moon_eci_m(instants),
    )


def _third_body(gm_m3_s2: float, r_body_m: Array, r_sat_m: Array) -> Array:
    """Pull on the satellite less the pull on the Earth, shape (n, 3)."""

    def per_gm(r_m: Array) -> Array:
        return np.asarray(r_m / np.linalg.norm(r_m, axis=1, keepdims=True) ** 3)

    return gm_m3_s2 * (per_gm(r_body_m - r_sat_m) - per_gm(r_body_m))
