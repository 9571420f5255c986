"""The carrier and the Sun in the target's sky, as pass tables tell them."""

import math
from dataclasses import dataclass, fields

import numpy as np

from planner.base.arrays import Array, Indices
from planner.planning.opportunities.sights import EarthSight, Sight
from planner.world.frames.geodesy import c_enu_from_itrf, geodetic_from_itrf
from planner.world.frames.time_scales import DAY_S


@dataclass(frozen=True, kw_only=True, eq=False)
class TargetSky:
    """Every array of shape (windows, 3): at rise, culmination and set.

    t_s: since `Opportunities.start_utc`.
    azimuth_rad, elevation_rad: of the carrier, geometric: azimuth clockwise from north in 0..2 pi,
    elevation from the plane of the ellipsoid.
    sun_azimuth_rad, sun_elevation_rad: of the Sun's centre, without refraction.
    solar_time_s: local apparent: since the Sun stood north, half a day at its passage of the
    meridian in the south; in 0..86400.
    latitude_rad, longitude_rad, height_m: where the target is, geodetic.
    All but t_s are NaN for a target in space.
    """

    t_s: Array
    azimuth_rad: Array
    elevation_rad: Array
    sun_azimuth_rad: Array
    sun_elevation_rad: Array
    solar_time_s: Array
    latitude_rad: Array
    longitude_rad: Array
    height_m: Array


def target_sky(sight: Sight, target: Indices, at_s: Array) -> TargetSky:
    """target: (m,); at_s: (m, 3)."""
    if not isinstance(sight, EarthSight):
        nothing = np.full(at_s.shape, math.nan)
        return TargetSky(**{f.name: nothing for f in fields(TargetSky)} | {"t_s": at_s})
    t_s, which = at_s.ravel(), np.repeat(target, at_s.shape[1])
    r_target_m = sight.places.r_target_itrf_m(which, t_s)
    latitude_rad, longitude_rad, height_m = geodetic_from_itrf(r_target_m)
    c_enu = c_enu_from_itrf(latitude_rad, longitude_rad)
    to_sun = sight.to_sun_itrf(which, t_s)
    azimuth_rad, elevation_rad = _on_horizon(c_enu, sight.carrier.r_sat_itrf_m.at(t_s) - r_target_m)
    sun_azimuth_rad, sun_elevation_rad = _on_horizon(c_enu, to_sun)
    ahead_rad = longitude_rad - np.arctan2(to_sun[:, 1], to_sun[:, 0])
    columns = {
        "t_s": t_s,
        "azimuth_rad": azimuth_rad,
        "elevation_rad": elevation_rad,
        "sun_azimuth_rad": sun_azimuth_rad,
        "sun_elevation_rad": sun_elevation_rad,
        "solar_time_s": (ahead_rad / (2.0 * math.pi) + 0.5) % 1.0 * DAY_S,
        "latitude_rad": latitude_rad,
        "longitude_rad": longitude_rad,
        "height_m": height_m,
    }
    return TargetSky(**{name: values.reshape(at_s.shape) for name, values in columns.items()})


def _on_horizon(c_enu: Array, direction_itrf: Array) -> tuple[Array, Array]:
    """Azimuth and elevation, (n,) each, of vectors (n, 3) of any length."""
    east, north, up = np.einsum("nij,nj->in", c_enu, direction_itrf)
    return np.arctan2(east, north) % (2.0 * math.pi), np.arctan2(up, np.hypot(east, north))
