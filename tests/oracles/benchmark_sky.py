"""Satellites of public benchmarks over the ground, by frames and code of their own.

Satellites are python-sgp4's, turned by Greenwich mean sidereal time (IAU 1982); the Sun is the
Astronomical Almanac's low-precision one.
"""

import math
from datetime import UTC, datetime, timedelta

import numpy as np
from sgp4.api import jday

EARTH_M, FLATTENING = 6_378_137.0, 1 / 298.257223563


def orbit_at(orbit, start, at_s):
    """Position in the mean equator and equinox of date, and Greenwich's angle from that."""
    moment = start + timedelta(seconds=float(at_s))
    day, part = jday(
        moment.year,
        moment.month,
        moment.day,
        moment.hour,
        moment.minute,
        moment.second + moment.microsecond * 1e-6,
    )
    error, r_km, _ = orbit.sgp4(day, part)
    assert error == 0
    centuries = (day - 2451545.0 + part) / 36525.0
    gmst_s = 67310.54841 + (876600 * 3600 + 8640184.812866) * centuries
    gmst_s += 0.093104 * centuries**2 - 6.2e-6 * centuries**3
    return np.array(r_km) * 1e3, math.radians(gmst_s / 240.0 % 360.0)


def place_m(latitude_deg, longitude_deg, height_m, turned_rad=0.0):
    """Over the ellipsoid, in axes from which Greenwich has turned away."""
    latitude, angle = math.radians(latitude_deg), math.radians(longitude_deg) + turned_rad
    squared = FLATTENING * (2.0 - FLATTENING)
    normal_m = EARTH_M / math.sqrt(1.0 - squared * math.sin(latitude) ** 2)
    across_m = (normal_m + height_m) * math.cos(latitude)
    up_m = (normal_m * (1.0 - squared) + height_m) * math.sin(latitude)
    return np.array([across_m * math.cos(angle), across_m * math.sin(angle), up_m])


def sun_at(start, at_s):
    """Unit vector to the Sun, in the mean equator and equinox of date."""
    days = (start - datetime(2000, 1, 1, 12, tzinfo=UTC)).total_seconds() / 86400.0 + at_s / 86400.0
    mean = math.radians(357.528 + 0.9856003 * days)
    longitude = math.radians(280.460 + 0.9856474 * days)
    longitude += math.radians(1.915) * math.sin(mean) + math.radians(0.020) * math.sin(2.0 * mean)
    tilt = math.radians(23.439 - 4e-7 * days)
    return np.array(
        [
            math.cos(longitude),
            math.cos(tilt) * math.sin(longitude),
            math.sin(tilt) * math.sin(longitude),
        ]
    )


def is_lit(orbit, start, at_s):
    r_m, _ = orbit_at(orbit, start, at_s)
    sun = sun_at(start, at_s)
    along_m = r_m @ sun
    return along_m >= 0.0 or np.linalg.norm(r_m - along_m * sun) >= EARTH_M


def slew_s(angle_deg, attitude):
    """By hand: a triangle of rates, or a trapezium."""
    rate, acceleration = (
        attitude["max_slew_velocity_deg_per_s"],
        attitude["max_slew_acceleration_deg_per_s2"],
    )
    peak = min(rate, math.sqrt(angle_deg * acceleration))
    return angle_deg / peak + peak / acceleration if peak > 0.0 else 0.0


def between_deg(first, second):
    return math.degrees(
        math.atan2(np.linalg.norm(np.cross(first, second)), float(np.dot(first, second)))
    )


def utc(text):
    return datetime.fromisoformat(text)
