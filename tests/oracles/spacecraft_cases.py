"""Cases of the spacecraft tests: a Sun-synchronous orbit and requests along its track."""

import math
from datetime import UTC, datetime, timedelta

import numpy as np
from scipy.spatial.transform import Rotation

from planner.spacecraft.requests import (
    AreaRequest,
    CorridorRequest,
    GeoLineString,
    GeoPolygon,
    ImagingPlanRequest,
    StereoRequest,
    StripRequest,
)
from planner.world.frames.earth_orientation import itrf_from_eci_state
from planner.world.frames.geodesy import c_enu_from_itrf, geodetic_from_itrf, itrf_from_geodetic
from planner.world.frames.time_scales import Instants
from planner.world.orbits import StateVectorOrbit

EPOCH = datetime(2024, 6, 1, 10, 0, tzinfo=UTC)


def sun_synchronous(altitude_km=640.0):
    r = 6378.137 + altitude_km
    i, v = math.acos(-((r / 12352.0) ** 3.5)), math.sqrt(398600.4418 / r)
    turned = Rotation.from_euler("ZXZ", [math.radians(30.0), i, math.radians(15.0)])
    return StateVectorOrbit(
        frame="GCRF",
        epoch=EPOCH,
        position_km=tuple(turned.apply([r, 0.0, 0.0]).tolist()),
        velocity_km_s=tuple(turned.apply([0.0, v, 0.0]).tolist()),
    )


ORBIT = sun_synchronous()


def track_axes(t_s):
    """Sub-satellite point with unit vectors along and to the right of the track, ITRF."""
    ephemeris = ORBIT.ephemeris(EPOCH - timedelta(seconds=300), EPOCH + timedelta(seconds=1500))
    instants = Instants(EPOCH, np.array([float(t_s)]))
    states = ephemeris.states(instants)
    r, v = itrf_from_eci_state(states.r_sat_eci_m, states.v_sat_eci_m_s, instants)
    latitude, longitude, _ = geodetic_from_itrf(r[0])
    east, north, up = c_enu_from_itrf(latitude, longitude)
    along = (v[0] @ east) * east + (v[0] @ north) * north
    along /= np.linalg.norm(along)
    return itrf_from_geodetic(latitude, longitude, 0.0), along, np.cross(along, up)


def positions(points):
    latitude, longitude, _ = geodetic_from_itrf(np.asarray(points))
    return tuple(zip(np.rad2deg(longitude).tolist(), np.rad2deg(latitude).tolist(), strict=True))


def line(t_s, half_km=30.0, across_km=0.0, azimuth_deg=0.0):
    origin, along, across = track_axes(t_s)
    c, s = math.cos(math.radians(azimuth_deg)), math.sin(math.radians(azimuth_deg))
    middle = origin + 1e3 * across_km * across
    direction = c * along + s * across
    ends = [middle - 1e3 * half_km * direction, middle + 1e3 * half_km * direction]
    return GeoLineString(coordinates=positions(ends))


def area(t_s, name="area"):
    origin, along, across = track_axes(t_s)
    box = ((-30, -24), (30, -24), (30, 24), (-30, 24))
    ring = positions([origin + 1e3 * (a * along + c * across) for a, c in box])
    return AreaRequest(name=name, geometry=GeoPolygon(coordinates=((*ring, ring[0]),)))


def four_modes():
    return (
        StripRequest(name="strip", priority=2.0, geometry=line(90.0, across_km=100.0)),
        StereoRequest(name="stereo", priority=4.0, geometry=line(230.0, across_km=-40.0)),
        CorridorRequest(name="corridor", priority=2.0, geometry=line(360.0, azimuth_deg=45.0)),
        area(480.0),
    )


def session(requests, seconds, **more):
    return ImagingPlanRequest(
        orbit=ORBIT,
        start=EPOCH,
        stop=EPOCH + timedelta(seconds=seconds),
        requests=tuple(requests),
        **more,
    )
