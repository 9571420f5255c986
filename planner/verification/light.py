"""Light on its way to a moving observer: bending at the Sun, aberration."""

import numpy as np

from planner.base.arrays import Array

SPEED_OF_LIGHT_M_S = 299792458.0  # exact, BIPM

_SUN_SCHWARZSCHILD_M = 2953.25  # 2 GM/c^2 with GM = 1.32712440041e20 m3/s2, DE421
_BEHIND_THE_SUN = 6e-6  # 1 + cos of the angle at the Sun; SOFA's value for it, 0.2 deg off centre


def aberrate(source_eci: Array, v_observer_m_s: Array) -> Array:
    """Direction to the source in the rest frame of a moving observer, unit vectors (n, 3).

    The photon's four-momentum is boosted: its energy and momentum along and across the motion.
    Source: Lorentz transformation, Jackson 1999, eq. 11.19.
    """
    beta = v_observer_m_s / SPEED_OF_LIGHT_M_S
    beta2 = np.sum(beta * beta, axis=1, keepdims=True)
    gamma = 1.0 / np.sqrt(1.0 - beta2)
    photon = -source_eci
    along = np.sum(photon * beta, axis=1, keepdims=True)
    boosted = photon + (gamma**2 / (gamma + 1.0) * along - gamma) * beta
    return np.asarray(-boosted / np.sqrt(np.sum(boosted * boosted, axis=1, keepdims=True)))


def bend_by_sun(source_eci: Array, range_m: Array, r_observer_sun_m: Array) -> Array:
    """Direction in which light from a source beside the Sun arrives, unit vectors (n, 3).

    range_m: (n,), infinite for a star.  r_observer_sun_m: the observer from the Sun's centre.
    The light is turned by 2 GM/(c^2 R) tan(phi/2), phi being the angle at the Sun between
    observer and source, R the observer's distance: 1.75 arcsec at the limb.
    Neglects Jupiter (0.017 arcsec at its limb), Saturn (0.006) and the Earth (0.0006).
    Source: Murray 1983, Vectorial Astrometry, 1.5; tan(phi/2) = sin(phi)/(1 + cos(phi)).
    """
    distance_m = np.sqrt(np.sum(r_observer_sun_m * r_observer_sun_m, axis=1, keepdims=True))
    observer = r_observer_sun_m / distance_m
    source = source_eci + r_observer_sun_m / range_m[:, None]
    source /= np.sqrt(np.sum(source * source, axis=1, keepdims=True))
    cos_phi = np.sum(observer * source, axis=1, keepdims=True)
    away = observer - np.sum(observer * source_eci, axis=1, keepdims=True) * source_eci
    size = np.sqrt(np.sum(away * away, axis=1, keepdims=True))
    cross = np.cross(observer, source)
    sin_phi = np.sqrt(np.sum(cross * cross, axis=1, keepdims=True))
    turn_rad = _SUN_SCHWARZSCHILD_M / distance_m * sin_phi
    turn_rad /= np.maximum(1.0 + cos_phi, _BEHIND_THE_SUN)
    way = np.divide(away, size, out=np.zeros_like(away), where=size > 0.0)
    arriving_eci = source_eci + turn_rad * way
    return np.asarray(
        arriving_eci / np.sqrt(np.sum(arriving_eci * arriving_eci, axis=1, keepdims=True))
    )
