"""The ground's height under targets on terrain, by an interpolation of the judge's own."""

from collections.abc import Iterator
from dataclasses import dataclass

import erfa
import numpy as np

from planner.base.arrays import Array
from planner.verification.report import Finding
from planner.world.frames.time_scales import Instants
from planner.world.targets import GroundPathTarget
from planner.world.targets.terrain import Terrain

WGS84 = 1  # ERFA's number for the ellipsoid


@dataclass(frozen=True, kw_only=True)
class TerrainTolerances:
    """By how much a line's mean height may differ from the mean of the ground beneath it."""

    points: int = 2001  # of a line: two a cell of arcseconds over 30 km
    least_m: float = 1.0  # of heights told in metres
    relief_share: float = 0.1  # of what the ground rises and falls: corners are rounded


TOLERANCES = TerrainTolerances()


def terrain_height_m(terrain: Terrain, latitude_deg: Array, longitude_deg: Array) -> Array:
    """Above the ellipsoid, (n,); NaN where there is none.  The grid as it was read."""
    # SciPy's interpolators take 0.2 s to import, which only a plan should pay.
    from scipy.ndimage import map_coordinates

    grid = terrain.grid
    row = (grid.north_deg - latitude_deg) / grid.step_deg[0]
    column = (longitude_deg - grid.west_deg) % 360.0 / grid.step_deg[1]
    column = np.where(column > grid.values.shape[1], column - 360.0 / grid.step_deg[1], column)
    place = [row, column]
    held = np.asarray(map_coordinates(grid.values, place, np.float64, order=1, mode="nearest"))
    return held + (terrain.geoid_height_m or 0.0)


def terrain_findings(number: int, target: GroundPathTarget) -> Iterator[Finding]:
    """Whether the line of a session lies on the terrain, in the mean over its length."""
    if target.terrain is None or target.start is None:
        return
    t_s = np.linspace(0.0, target.duration_s, TOLERANCES.points)
    r_itrf_m = target.r_target_itrf_m(Instants(target.start, t_s))
    longitude_rad, latitude_rad, height_m = erfa.gc2gd(WGS84, r_itrf_m)
    ground_m = terrain_height_m(target.terrain, np.degrees(latitude_rad), np.degrees(longitude_rad))
    off_m = float(np.mean(height_m - ground_m))
    allowed_m = TOLERANCES.least_m + TOLERANCES.relief_share * float(np.ptp(ground_m))
    if not abs(off_m) <= allowed_m:
        yield Finding(
            limit="pointing",
            detail=f"session {number + 1}: the line that is scanned lies {off_m:+.1f} m off the "
            f"terrain in the mean, more than {allowed_m:.1f} m",
        )
