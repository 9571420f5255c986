"""The spacecraft's ground track, and the swath of its scanned line."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from planner.base.arrays import Array, Indices
from planner.base.rotation import Rotation
from planner.output.export.ground import Sights, ends_on_ground, turned_rays
from planner.spacecraft.requests import ImagingPlanRequest
from planner.spacecraft.table import AttitudeTable, ImagingWindow
from planner.spacecraft.vehicle.definition import AgileSpacecraft
from planner.world.frames.earth_orientation import c_itrf_from_eci
from planner.world.frames.geodesy import geodetic_from_itrf
from planner.world.frames.local_orbital import q_lvlh_from_eci
from planner.world.frames.time_scales import Instants

AXIS, LEFT, RIGHT = 0, 1, 2  # rays: the optical axis, and the ends of the line
RING_ROWS_MAX = 60


@dataclass(frozen=True, kw_only=True)
class SessionTable:
    """What was asked, and the table that does it."""

    request: ImagingPlanRequest
    table: AttitudeTable

    @property
    def spacecraft(self) -> AgileSpacecraft:
        return self.request.definition()


class SessionGround:
    """The rows of an imaging session at which it is looked at, (n,); all unless given.

    Straight lines of sight, as the imaging is planned: without aberration (a 2e-5 rad that a
    pushbroom's image shifts with all of it) and refraction.
    """

    def __init__(self, plan: SessionTable, row: Indices | None = None) -> None:
        table = plan.table
        self.plan = plan
        self.row = np.arange(len(table.t_s)) if row is None else row
        self.instants = Instants(table.epoch_utc, table.t_s[self.row])
        ephemeris = plan.request.orbit.ephemeris(self.instants.utc(0), self.instants.utc(-1))
        self.states = ephemeris.states(self.instants)
        self.q_eci_from_body = Rotation.from_quat(table.eci_from_body_xyzw[self.row])

    @cached_property
    def c_itrf_from_eci(self) -> Array:
        """Shape (n, 3, 3)."""
        return c_itrf_from_eci(self.instants)

    @cached_property
    def r_sat_itrf_m(self) -> Array:
        """Shape (n, 3)."""
        return np.asarray(np.einsum("nij,nj->ni", self.c_itrf_from_eci, self.states.r_sat_eci_m))

    @cached_property
    def axis_eci(self) -> Array:
        """The optical axis, -Y of the body, unit vectors (n, 3)."""
        return np.asarray(self.q_eci_from_body.apply([0.0, -1.0, 0.0]))

    @cached_property
    def line(self) -> Sights:
        """Where the optical axis, and the line's left and right end, meet the ellipsoid.

        The line lies along the body's Z; its ends see the swath's width straight below the first
        row.
        """
        half = math.tan(self._half_width_rad)
        rays_body = np.array([[0.0, -1.0, 0.0], [0.0, -1.0, -half], [0.0, -1.0, half]])
        directions_eci = turned_rays(self.q_eci_from_body, rays_body)
        return ends_on_ground(self.instants, self.states.r_sat_eci_m, directions_eci)

    def look_angles_rad(self) -> tuple[Array, Array]:
        """Angles of the optical axis along and across the track from geocentric nadir, (n,) each.

        Ahead and to the right of flight are positive.
        """
        q_lvlh = q_lvlh_from_eci(self.states.r_sat_eci_m, self.states.v_sat_eci_m_s)
        x, y, z = q_lvlh.apply(self.axis_eci).T
        return np.arctan2(x, z), np.arctan2(y, z)

    def ring_rad(self, window: ImagingWindow) -> tuple[Array, Array] | None:
        """Latitudes and longitudes around what a window images; None beside the Earth.

        Only of all rows.
        """
        count = min(window.last_row - window.first_row + 1, RING_ROWS_MAX)
        rows = np.linspace(window.first_row, window.last_row, count).round().astype(np.intp)
        if not self.line.on_ground[rows].all():
            return None
        left_itrf_m, right_itrf_m = (self.line.end_itrf_m[rows, end] for end in (LEFT, RIGHT))
        latitude_rad, longitude_rad, _ = geodetic_from_itrf(
            np.concatenate([left_itrf_m, right_itrf_m[::-1]])
        )
        return latitude_rad, longitude_rad

    @cached_property
    def _half_width_rad(self) -> float:
        height_m = float(geodetic_from_itrf(self.r_sat_itrf_m[0])[2])
        return math.atan(0.5 * self.plan.spacecraft.camera.swath_m / height_m)
