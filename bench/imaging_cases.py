"""Cases of the spacecraft's paper: an orbit, lines and areas along its track, flights of them."""

import math
from datetime import UTC, datetime, timedelta

import numpy as np
from scipy.spatial.transform import Rotation

from planner.base.commands import BODY_CHANNELS, GIMBAL_CHANNELS, CommandTable, Motion
from planner.motion.attitude.problem import BodySlewProblem
from planner.motion.attitude.slew import solve_attitude_slew
from planner.motion.attitude.track import agility_limits
from planner.spacecraft.imaging.session import make_session
from planner.spacecraft.plan import ImagingPlan
from planner.spacecraft.requests import AreaRequest, GeoPolygon, ImagingPlanRequest
from planner.spacecraft.vehicle import AgileSpacecraft
from planner.world.frames.earth_orientation import itrf_from_eci_state
from planner.world.frames.geodesy import c_enu_from_itrf, geodetic_from_itrf, itrf_from_geodetic
from planner.world.frames.time_scales import Instants
from planner.world.orbits import StateVectorOrbit
from planner.world.orbits.ephemeris import OrbitStates

EPOCH = datetime(2024, 6, 1, 10, 0, tzinfo=UTC)
# The last is ours: so long after the paper's last, 1891 s, as its strips take before.
PAPER_TURNS_S = (
    600, 725, 756, 789, 821, 882, 914, 946, 979, 1040, 1071, 1104, 1136, 1197, 1229, 1261, 1294,
    1355, 1386, 1419, 1451, 1512, 1544, 1576, 1609, 1670, 1701, 1734, 1766, 1827, 1859, 1891, 1923,
)  # fmt: skip


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


def settle_table(spacecraft: AgileSpacecraft, angle_deg: float, seconds: float) -> CommandTable:
    """Rest, a smooth slew in pitch at 10 s, rest until 60 s."""
    still = np.zeros(3)
    axis = np.array([0.12, 0.05, 0.99])
    goal = Rotation.from_rotvec(math.radians(angle_deg) * axis / np.linalg.norm(axis))
    rows = round(5.0 * seconds)
    rest = (np.zeros((1, 3)), np.zeros((1, 3)))
    slew = solve_attitude_slew(
        BodySlewProblem(
            start=Motion(Rotation.identity().as_quat()[None], *rest),
            goal=Motion(goal.as_quat()[None], *rest),
            first_arrival_row=rows,
            limits=agility_limits(spacecraft.platform()),
        )
    )
    before, after = np.zeros((50, 3)), np.zeros((250 - rows, 3))
    position = np.vstack(
        [
            np.tile(Rotation.identity().as_quat(), (50, 1)),
            slew.motion.position,
            np.tile(goal.as_quat(), (250 - rows, 1)),
        ]
    )
    gimbal = np.tile(spacecraft.craft.array.gimbal_angles(still), (301, 1))
    return CommandTable(
        epoch_utc=EPOCH,
        channels=(*BODY_CHANNELS, *GIMBAL_CHANNELS),
        position=position,
        rate_rad_s=np.vstack([before, slew.motion.rate_rad_s, after]),
        acceleration_rad_s2=np.vstack([before, slew.motion.acceleration_rad_s2, after]),
        extra_rad=np.hstack([gimbal, np.zeros((301, 4))]),
    )


def orbit_states(plan: ImagingPlan) -> OrbitStates:
    """The orbit at the table's rows."""
    session = make_session(plan.request)
    return session.ephemeris.states(Instants(EPOCH, plan.table.t_s))
