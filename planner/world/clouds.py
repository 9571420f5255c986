"""Clouds as the user gives them: a forecast in time, or a climatology."""

import base64
import binascii
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np

from planner.base.arrays import Array
from planner.base.errors import InvalidMessage
from planner.base.spec import spec
from planner.world.frames.geodesy import geodetic_from_itrf
from planner.world.frames.time_scales import Instants, elapsed_s
from planner.world.messages.cloud_netcdf import GridsOverTime, read_cloud_netcdf
from planner.world.messages.geographic_grid import read_ascii_grid, read_geotiff


@dataclass(frozen=True, kw_only=True)
class CloudOptions:
    """What is taken for a cloud fraction."""

    rounding: float = 1e-3  # beyond 0 and 1, of packed fractions


OPTIONS = CloudOptions()


@spec
class Clouds:
    """Cloud fraction over the ground, bilinear between cells' centres and linear in time.

    The probability of a clear look is what the clouds leave free over the target. Where and when
    the grid says nothing, nothing is said of it. The line of sight's lean is neglected.

    format: "netcdf", classic, of time, latitude and longitude as the CF conventions have it; or a
    grid that holds at all times, "geotiff" of one band or "ascii_grid" (ESRI). E.g. `"netcdf"`.
    content: the text of an ASCII grid, else the file's bytes in base64; at most 16 million values.
    E.g. `"Q0RGAQAAAAAAAAAKAAAAAw=="`.
    variable: of NetCDF, name of the cloud fraction; left out where it is the only variable of
    latitude and longitude. E.g. `"tcc"`.
    unit: of the values; unless given as NetCDF says it, else a fraction from 0 to 1. E.g.
    `"percent"`.
    """

    format: Literal["netcdf", "geotiff", "ascii_grid"]
    content: str
    variable: str | None = None
    unit: Literal["fraction", "percent"] | None = None

    def __post_init__(self) -> None:
        if self.variable is not None and self.format != "netcdf":
            raise ValueError(f"variable must be left out of {self.format}, which has but one")
        try:
            grids = self._grids
        except InvalidMessage as refusal:
            raise ValueError(f"content: {refusal.detail}") from None
        for grid in grids.grids:
            least, most = (
                float(find(grid.values, initial=0.0, where=~np.isnan(grid.values)))
                for find in (np.min, np.max)
            )
            if not (least >= -OPTIONS.rounding and most * self._scale <= 1.0 + OPTIONS.rounding):
                raise ValueError(
                    f"content: a cloud fraction lies between 0 and {1.0 / self._scale:g}, not "
                    f"{least:.4g} to {most:.4g}: give unit, or another variable"
                )

    def clear(self, latitude_deg: Array, longitude_deg: Array, instants: Instants) -> Array:
        """The share of sky without clouds at n places and instants, (n,), NaN where not known."""
        times_utc, grids = self._grids.times_utc, self._grids.grids
        if not times_utc:
            return self._clear_of(0, latitude_deg, longitude_deg)
        at_s = np.array([elapsed_s(time, instants.epoch_utc) for time in times_utc])
        last = len(grids) - 1
        after = np.clip(np.searchsorted(at_s, instants.t_s), 1 if last else 0, last)
        before = np.maximum(after - 1, 0)
        found = np.full((2, len(instants.t_s)), np.nan)
        for end, numbers in enumerate((before, after)):
            for number in np.unique(numbers).tolist():
                rows = numbers == number
                found[end, rows] = self._clear_of(number, latitude_deg[rows], longitude_deg[rows])
        span_s = np.maximum(at_s[after] - at_s[before], 1e-9)
        share = (instants.t_s - at_s[before]) / span_s
        is_known = (instants.t_s >= at_s[0]) & (instants.t_s <= at_s[-1])
        clear = np.where(share > 0.0, share * found[1], 0.0)
        clear += np.where(share < 1.0, (1.0 - share) * found[0], 0.0)
        return np.where(is_known, clear, np.nan)

    def clear_over(self, r_itrf_m: Array, instants: Instants) -> Array:
        """The same over places in ITRF, (n, 3)."""
        latitude_rad, longitude_rad, _ = geodetic_from_itrf(r_itrf_m)
        return self.clear(np.degrees(latitude_rad), np.degrees(longitude_rad), instants)

    def _clear_of(self, number: int, latitude_deg: Array, longitude_deg: Array) -> Array:
        cloudy = self._scale * self._grids.grids[number].known(latitude_deg, longitude_deg)
        return np.asarray(np.clip(1.0 - cloudy, 0.0, 1.0))

    @property
    def _scale(self) -> float:
        unit = self.unit or ("percent" if self._grids.unit == "%" else "fraction")
        return 0.01 if unit == "percent" else 1.0

    @cached_property
    def _grids(self) -> GridsOverTime:
        """Read once; raises InvalidMessage."""
        if self.format == "ascii_grid":
            return GridsOverTime(times_utc=(), grids=(read_ascii_grid(self.content),))
        try:
            content = base64.b64decode("".join(self.content.split()), validate=True)
        except (binascii.Error, ValueError):
            raise InvalidMessage(f"a {self.format} is given in base64, which this isn't") from None
        if self.format == "netcdf":
            return read_cloud_netcdf(content, self.variable)
        return GridsOverTime(times_utc=(), grids=(read_geotiff(content),))
