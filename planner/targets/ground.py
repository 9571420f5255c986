"""Where is a point on the ground?"""

import math
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from planner.frames.geodesy import itrf_from_geodetic
from planner.frames.time_scales import Instants
from planner.spec import spec


@spec
class GroundTarget:
    """A point fixed to the Earth, in WGS84 geodetic coordinates.

    height_m: above the ellipsoid, not above sea level.
    min_elevation_deg: the carrier must stand at least this high in the target's sky over
    the whole session, measured from the plane of the ellipsoid, without refraction.
    Source: Sumarokov 2016, eq. 8.
    """

    mode: Literal["ground"] = "ground"
    latitude_deg: float
    longitude_deg: float
    height_m: float = 0.0
    min_elevation_deg: float = 0.0

    def __post_init__(self) -> None:
        if not -90.0 <= self.latitude_deg <= 90.0:
            raise ValueError(f"latitude_deg must lie in -90..90, not {self.latitude_deg}")
        if not -180.0 <= self.longitude_deg <= 360.0:
            raise ValueError(f"longitude_deg must lie in -180..360, not {self.longitude_deg}")
        if not -1000.0 <= self.height_m <= 100e3:
            raise ValueError(f"height_m must lie in -1000..100000 m, not {self.height_m}")
        if not 0.0 <= self.min_elevation_deg < 90.0:
            raise ValueError(f"min_elevation_deg must lie in [0, 90), not {self.min_elevation_deg}")

    def r_target_itrf_m(self, instants: Instants) -> NDArray[np.float64]:
        """Shape (n, 3), the same point n times."""
        r_itrf_m = itrf_from_geodetic(
            math.radians(self.latitude_deg), math.radians(self.longitude_deg), self.height_m
        )
        return np.broadcast_to(r_itrf_m, (len(instants.t_s), 3))
