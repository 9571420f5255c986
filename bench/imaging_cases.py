"""Cases of the spacecraft's benchmark: an orbit, and lines and areas along its track."""

import math
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from planner.spacecraft.requests import AreaRequest, GeoPolygon, ImagingPlanRequest
from planner.world.frames.earth_orientation import itrf_from_eci_state
from planner.world.frames.geodesy import c_enu_from_itrf, geodetic_from_itrf, itrf_from_geodetic
from planner.world.frames.time_scales import Instants
from planner.world.orbits import StateVectorOrbit

DATA = Path(__file__).parents[1] / "tests" / "data" / "spacecraft"
EPOCH = datetime(2024, 6, 1, 10, 0, tzinfo=UTC)


def sun_synchronous(altitude_km: float) -> StateVectorOrbit:
    """Circular orbit whose plane turns with the Sun, northbound at 15 deg."""
    r = 6378.137 + altitude_km
    i, v = math.acos(-((r / 12352.0) ** 3.5)), math.sqrt(398600.4418 / r)
    node, u = math.radians(30.0), math.radians(15.0)
    turned = Rotation.from_euler("ZXZ", [node, i, u])
    position, velocity = turned.apply([r, 0.0, 0.0]), turned.apply([0.0, v, 0.0])
    return StateVectorOrbit(
        frame="GCRF",
        epoch=EPOCH,
        position_km=tuple(position.tolist()),
        velocity_km_s=tuple(velocity.tolist()),
    )


def local_axes(orbit: StateVectorOrbit, t_s: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Sub-satellite point (ITRF, m) with unit vectors along and across (right of) the track."""
    ephemeris = orbit.ephemeris(EPOCH - timedelta(seconds=500), EPOCH + timedelta(seconds=3000))
    instants = Instants(EPOCH, np.array([t_s]))
    states = ephemeris.states(instants)
    r, v = itrf_from_eci_state(states.r_sat_eci_m, states.v_sat_eci_m_s, instants)
    latitude, longitude, _ = geodetic_from_itrf(r[0])
    east, north, _ = enu = c_enu_from_itrf(latitude, longitude)
    along = (v[0] @ east) * east + (v[0] @ north) * north
    along /= np.linalg.norm(along)
    return itrf_from_geodetic(latitude, longitude, 0.0), along, np.cross(along, enu[2])


def positions(points_itrf: np.ndarray) -> tuple[tuple[float, float], ...]:
    """GeoJSON positions."""
    latitude, longitude, _ = geodetic_from_itrf(np.asarray(points_itrf))
    return tuple(zip(np.rad2deg(longitude).tolist(), np.rad2deg(latitude).tolist(), strict=True))


def line(
    orbit: StateVectorOrbit, t_s: float, half_km: float, across_km: float, azimuth_deg: float = 0.0
) -> tuple[tuple[float, float], ...]:
    """A line through a point beside the track at t_s, at an angle to the track."""
    origin, along, across = local_axes(orbit, t_s)
    c, s = math.cos(math.radians(azimuth_deg)), math.sin(math.radians(azimuth_deg))
    middle, direction = origin + 1e3 * across_km * across, c * along + s * across
    return positions([middle - 1e3 * half_km * direction, middle + 1e3 * half_km * direction])


def area(orbit: StateVectorOrbit, t_s: float, name: str, across_km: float = 0.0) -> AreaRequest:
    """48 x 60 km around a point beside the track."""
    origin, along, across = local_axes(orbit, t_s)
    corners = [
        origin + 1e3 * (a * along + (c + across_km) * across)
        for a, c in ((-30, -24), (30, -24), (30, 24), (-30, 24))
    ]
    ring = positions(corners)
    return AreaRequest(name=name, geometry=GeoPolygon(coordinates=((*ring, ring[0]),)))


def session_request(
    orbit: StateVectorOrbit, seconds: float, requests: tuple, **more: object
) -> ImagingPlanRequest:
    return ImagingPlanRequest(
        orbit=orbit,
        start=EPOCH,
        stop=EPOCH + timedelta(seconds=seconds),
        requests=requests,
        **more,
    )
