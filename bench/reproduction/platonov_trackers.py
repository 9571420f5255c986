"""Two of three star trackers while imaging: which of them can see stars, and how well two do.

The paper has three trackers, two of them at work while imaging, and says no more.  Here they look
up and aside from the camera, 45 deg from the zenith, 120 deg apart; each is blind near the Sun, the
Earth's limb and the Moon, and in a fast turn.
"""

from typing import NamedTuple

import numpy as np

from planner.base.arrays import Array
from planner.spacecraft.table import AttitudeTable
from planner.world.frames.geodesy import WGS84_A_M
from planner.world.frames.solar_system import r_moon_eci_m, r_sun_eci_m
from planner.world.frames.time_scales import Instants
from planner.world.orbits.ephemeris import OrbitStates

TILT_DEG = 45.0  # from +Y, the zenith in orbital orientation (the camera looks along -Y)
FIRST_DEG = 90.0  # of the first tracker's azimuth about +Y, from +Z towards +X: straight ahead
SUN_DEG, LIMB_DEG, MOON_DEG = 35.0, 20.0, 12.0  # assumed: of a common small tracker
RATE_MAX_DEG_S = 2.0
ACROSS_ARCSEC, ABOUT_ARCSEC = 5.0, 40.0  # 1 sigma of a fix, across and about the boresight


class Seen(NamedTuple):
    """At n rows: which of the three trackers see stars, (n, 3)."""

    usable: Array
    sun: Array
    limb: Array


def boresights_body() -> Array:
    """Unit vectors (3, 3), one a row."""
    azimuth = np.deg2rad(FIRST_DEG + 120.0 * np.arange(3))
    tilt = np.deg2rad(TILT_DEG)
    return np.column_stack(
        [
            np.sin(tilt) * np.sin(azimuth),
            np.full(3, np.cos(tilt)),
            np.sin(tilt) * np.cos(azimuth),
        ]
    )


def seen(table: AttitudeTable, states: OrbitStates, instants: Instants) -> Seen:
    """Which trackers are usable at each row of a table."""
    turned = table.q_body_from_eci.inv()
    eci = np.stack([turned.apply(one) for one in boresights_body()], axis=1)
    r = states.r_sat_eci_m
    distance_m = np.linalg.norm(r, axis=1, keepdims=True)
    limb_rad = np.arcsin(WGS84_A_M / distance_m)
    nadir_rad = np.arccos(np.clip(np.einsum("nij,nj->ni", eci, -r / distance_m), -1.0, 1.0))

    def off_deg(target_m: Array) -> Array:
        unit = target_m - r
        unit /= np.linalg.norm(unit, axis=1, keepdims=True)
        return np.rad2deg(np.arccos(np.clip(np.einsum("nij,nj->ni", eci, unit), -1.0, 1.0)))

    sun_m = r_sun_eci_m(instants)
    # Behind the Earth it does no harm.
    hidden = np.einsum("ij,ij->i", sun_m, -r) > np.cos(limb_rad[:, 0]) * (
        np.linalg.norm(sun_m, axis=1) * distance_m[:, 0]
    )
    sun = (off_deg(sun_m) < SUN_DEG) & ~hidden[:, None]
    limb = np.rad2deg(nadir_rad - limb_rad) < LIMB_DEG
    moon = off_deg(r_moon_eci_m(instants)) < MOON_DEG
    rate_deg_s = np.rad2deg(np.linalg.norm(table.omega_body_rad_s, axis=1))
    return Seen(~(sun | limb | moon) & (rate_deg_s < RATE_MAX_DEG_S)[:, None], sun, limb)


def sigma_arcsec(which: tuple[int, ...]) -> Array:
    """1-sigma of the attitude from trackers together, principal axes in order of size, (3,)."""
    information = np.zeros((3, 3))
    for one in boresights_body()[list(which)]:
        about = np.outer(one, one)
        information += (np.eye(3) - about) / ACROSS_ARCSEC**2 + about / ABOUT_ARCSEC**2
    return np.asarray(np.sqrt(1.0 / np.linalg.eigvalsh(information)[::-1]))
