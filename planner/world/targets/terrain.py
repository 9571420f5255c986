"""Heights of the ground from a grid that the request holds."""

import base64
import binascii
import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Annotated, Literal

import numpy as np

from planner.base.arrays import Array
from planner.base.errors import InvalidMessage
from planner.base.spec import Within, spec
from planner.world.frames.geodesic import geodesic_between, geodesic_end
from planner.world.frames.geodesy import WGS84_A_M
from planner.world.messages.geographic_grid import (
    GeographicGrid,
    read_ascii_grid,
    read_geotiff,
)


@dataclass(frozen=True, kw_only=True)
class TerrainOptions:
    """What is taken for ground, and how closely it is looked at along a line."""

    # the Dead Sea's shore lies at -430 m, Everest at 8849 m; undeclared marks of no data far off
    ground_m: tuple[float, float] = (-1000.0, 10_000.0)
    sampled_a_cell: float = 2.0  # bilinear between: straight or nearly so
    sampled: tuple[int, int] = (9, 257)  # of a straight part, the least and the most


OPTIONS = TerrainOptions()


@spec
class Terrain:
    """Heights of the ground as a grid in degrees of WGS84, bilinear between cells' centres.

    Ground targets and paths without heights of their own stand on it. Mountains between the carrier
    and a target are not looked for.

    format: "geotiff" of one band, or "ascii_grid" (ESRI).
    content: the text of an ASCII grid, or the bytes of a GeoTIFF in base64; at most 16 million
    cells.
    height_datum: zero of the grid's heights, in metres: the WGS84 ellipsoid, or the geoid (mean sea
    level), as most elevation models have it.
    geoid_height_m: height of the geoid above the ellipsoid, which is added everywhere; it changes
    by some centimetres a kilometre. Required of the geoid. E.g. `-28.5`.
    """

    format: Literal["geotiff", "ascii_grid"]
    content: str
    height_datum: Literal["ellipsoid", "geoid"]
    geoid_height_m: Annotated[float, Within(-110.0, 90.0)] | None = None

    def __post_init__(self) -> None:
        above_ellipsoid = self.height_datum == "ellipsoid"
        if above_ellipsoid != (self.geoid_height_m is None):
            raise ValueError(
                "geoid_height_m must be left out of heights above the ellipsoid"
                if above_ellipsoid
                else "geoid_height_m is required of heights above the geoid: the geoid's height "
                "above the ellipsoid in the middle of the grid, e.g. by EGM2008; or give a grid of "
                "heights above the ellipsoid (`gdalwarp -t_srs EPSG:4979`)"
            )
        try:
            said = self.grid.above_ellipsoid
        except InvalidMessage as refusal:
            raise ValueError(f"content: {refusal.detail}") from None
        if said not in (None, above_ellipsoid):
            raise ValueError(
                f"height_datum is {self.height_datum!r}, but the GeoTIFF says that its heights are "
                f"above the {'ellipsoid' if said else 'geoid'}: give that"
            )

    @cached_property
    def grid(self) -> GeographicGrid:
        """Read once; what no ground is as high or low as is no value.  Raises InvalidMessage."""
        grid = self._read()
        low_m, high_m = OPTIONS.ground_m
        is_ground = (grid.values >= low_m) & (grid.values <= high_m)
        return replace(grid, values=np.where(is_ground, grid.values, np.float32(np.nan)))

    def _read(self) -> GeographicGrid:
        if self.format == "ascii_grid":
            return read_ascii_grid(self.content)
        try:
            content = base64.b64decode("".join(self.content.split()), validate=True)
        except (binascii.Error, ValueError):
            raise InvalidMessage("a GeoTIFF is given in base64, which this isn't") from None
        return read_geotiff(content)

    def heights_m(self, latitude_deg: Array, longitude_deg: Array) -> Array:
        """Above the ellipsoid, (n,); raises ValueError where the grid has none."""
        try:
            found_m = self.grid.at(latitude_deg, longitude_deg)
        except ValueError as error:
            raise ValueError(
                f"the terrain {error}: give a grid that holds it, or height_m"
            ) from None
        return found_m + (self.geoid_height_m or 0.0)

    def height_m(self, latitude_deg: float, longitude_deg: float) -> float:
        """Of one place."""
        return float(self.heights_m(np.array([latitude_deg]), np.array([longitude_deg]))[0])

    def profile(
        self, start_rad: tuple[float, float], end_rad: tuple[float, float]
    ) -> tuple[float, Array]:
        """Length (m) of the geodesic between two places (latitude, longitude), and heights along.

        At even steps, its ends included; raises ValueError.
        """
        azimuth_rad, length_m = geodesic_between(*start_rad, *end_rad)
        cells = math.degrees(length_m / WGS84_A_M) / min(self.grid.step_deg)
        count = int(np.clip(OPTIONS.sampled_a_cell * cells + 2.0, *OPTIONS.sampled))
        latitude_rad, longitude_rad = geodesic_end(
            *start_rad, azimuth_rad, np.linspace(0.0, length_m, count)
        )
        return length_m, self.heights_m(np.degrees(latitude_rad), np.degrees(longitude_rad))


def require_one_height(height_m: float | None, terrain: Terrain | None) -> None:
    """Refuse a height beside a terrain, which tells another; raises ValueError."""
    if height_m is not None and terrain is not None:
        raise ValueError(
            f"height_m ({height_m:g}) and terrain both say how high the ground is: leave one out"
        )
