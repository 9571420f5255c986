"""Ground points on the ellipsoid: the payload's boresight and its frame's corners."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from planner.base.arrays import Array
from planner.base.rotation import Rotation
from planner.output.export.table_states import TableStates
from planner.world.frames.earth_orientation import c_itrf_from_eci
from planner.world.frames.geodesy import WGS84_A_M, WGS84_F
from planner.world.frames.time_scales import Instants
from planner.world.platforms import AnyPlatform
from planner.world.targets.apparent import aberrate

BORESIGHT_PAYLOAD = np.array([[0.0, 0.0, 1.0]])
FRAME_CORNERS = ((1, 1), (-1, 1), (-1, -1), (1, -1))

_SPHERE = np.array([1.0, 1.0, 1.0 / (1.0 - WGS84_F)]) / WGS84_A_M  # the ellipsoid as unit sphere


class Sights(NamedTuple):
    """k rays at n instants, ITRF: where each ends, shape (n, k, 3), and whether on the ground.

    A ray that misses the Earth ends at the distance of the horizon.
    """

    end_itrf_m: Array
    on_ground: NDArray[np.bool_]


def sights(rows: TableStates, rays_payload: Array) -> Sights:
    """Rays fixed to the payload, shape (k, 3), to the WGS84 ellipsoid.

    Aberration is taken off, so that the boresight ends at the target it sees.  Neglects
    refraction and the Earth's turning during the light time (1.4 m).
    """
    n, k = len(rows.instants), len(rays_payload)
    q_eci_from_payload = Rotation.from_quat(rows.q_payload_from_eci_xyzw).inv()
    seen_eci = turned_rays(q_eci_from_payload, rays_payload)
    v_eci_m_s = np.repeat(rows.states.v_sat_eci_m_s, k, axis=0)
    natural_eci = aberrate(seen_eci.reshape(-1, 3), -v_eci_m_s).reshape(n, k, 3)
    return ends_on_ground(rows.instants, rows.states.r_sat_eci_m, natural_eci)


def turned_rays(q: Rotation, ray_directions: Array) -> Array:
    """Unit vectors along k rays (k, 3), turned by n rotations, shape (n, k, 3)."""
    unit = ray_directions / np.linalg.norm(ray_directions, axis=1, keepdims=True)
    return np.stack([q.apply(ray) for ray in unit], axis=1)


def ends_on_ground(instants: Instants, r_sat_eci_m: Array, direction_eci: Array) -> Sights:
    """Where straight lines from the carrier, (n, 3), along directions, (n, k, 3), end."""
    c_itrf = c_itrf_from_eci(instants)
    direction_itrf = np.einsum("nij,nkj->nki", c_itrf, direction_eci)
    r_sat_itrf_m = np.einsum("nij,nj->ni", c_itrf, r_sat_eci_m)
    return _on_ellipsoid(r_sat_itrf_m[:, None, :], direction_itrf)


def frame_corner_rays(platform: AnyPlatform) -> Array:
    """Corners of the camera's frame in payload axes, shape (4, 3), counter-clockwise from +X +Y."""
    x, y = np.tan(platform.frame_half_rad)
    corners = np.array([[i * x, j * y, 1.0] for i, j in FRAME_CORNERS])
    return np.asarray(Rotation.from_rotvec([0.0, 0.0, platform.frame_turn_rad]).apply(corners))


def _on_ellipsoid(r_itrf_m: Array, direction_itrf: Array) -> Sights:
    """Nearest intersection, by the quadratic of the ray in axes where the ellipsoid is round."""
    start, along = r_itrf_m * _SPHERE, direction_itrf * _SPHERE
    a = np.sum(along**2, axis=-1)
    b = np.sum(start * along, axis=-1)
    c = np.sum(start**2, axis=-1) - 1.0
    discriminant = b**2 - a * c
    on_ground = (discriminant >= 0.0) & (b < 0.0)
    root = np.sqrt(np.where(on_ground, discriminant, 0.0))
    hit_m = c / np.where(on_ground, root - b, 1.0)  # no digits lost, as in (-b - root) / a
    distance_m = np.where(on_ground, hit_m, np.sqrt(c) * WGS84_A_M)
    return Sights(r_itrf_m + distance_m[..., None] * direction_itrf, on_ground)
