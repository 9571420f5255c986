"""Windows as values: the opportunities found, and what is known of each."""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from datetime import datetime
from typing import Literal, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from planner.base.arrays import Array, Indices, Mask
from planner.base.assumed import Assumed
from planner.base.commands import ROWS_PER_S

T = TypeVar("T")
Cause = Literal[
    "interval",
    "elevation",
    "sun_elevation",
    "off_nadir",
    "sun_keep_out",
    "moon_keep_out",
    "reach",
    "across",
    "mask",
    "rate",
    "ground_sample",
    "glint",
    "carrier_light",
]
GRID_TOLERANCE_ROWS = 5e-5  # 10 us
SESSION_MAX_S = 21_600.0  # a plan of twice that takes more work than one request may make


@dataclass(frozen=True, kw_only=True, eq=False)
class Sightings:
    """A target seen at certain instants; every array of shape (windows,) or (windows, samples).

    t_s: since `Opportunities.start_utc`.  elevation_rad: of the carrier in the target's sky,
    without refraction; for a target in space its height above the raised limb.
    off_nadir_rad: from the geocentre's direction.
    ground_sample_*_m: of a pixel, across and along the direction in which the line of sight
    leans (infinite for stars, and along at the horizon).
    sun_elevation_rad: in the target's sky, NaN for a target in space.
    *_separation_rad: angle at the carrier between target and the body's centre.
    angle_rad, rate_rad_s: of the axes, shape (..., 2), on the window's branch; within the
    stops where these can be kept, NaN where no angles point there.
    """

    t_s: Array
    elevation_rad: Array
    range_m: Array
    off_nadir_rad: Array
    ground_sample_across_m: Array
    ground_sample_along_m: Array
    sun_elevation_rad: Array
    sun_separation_rad: Array
    moon_separation_rad: Array
    angle_rad: Array
    rate_rad_s: Array

    def select_samples(self, which: int | slice) -> "Sightings":
        """Those samples of (windows, samples)."""
        return Sightings(**{f.name: getattr(self, f.name)[:, which] for f in fields(self)})


@dataclass(frozen=True, kw_only=True, eq=False)
class TargetSky:
    """Every array of shape (windows, 3): at rise, culmination and set.

    t_s: since `Opportunities.start_utc`.
    azimuth_rad, elevation_rad: of the carrier, geometric: azimuth clockwise from north in 0..2 pi,
    elevation from the plane of the ellipsoid.
    sun_azimuth_rad, sun_elevation_rad: of the Sun's centre, without refraction.
    solar_time_s: local apparent: since the Sun stood north, half a day at its passage of the
    meridian in the south; in 0..86400.
    latitude_rad, longitude_rad, height_m: where the target is, geodetic.
    All but t_s are NaN for a target in space.
    """

    t_s: Array
    azimuth_rad: Array
    elevation_rad: Array
    sun_azimuth_rad: Array
    sun_elevation_rad: Array
    solar_time_s: Array
    latitude_rad: Array
    longitude_rad: Array
    height_m: Array


@dataclass(frozen=True, kw_only=True, eq=False)
class WindowEdges:
    """Windows as they are found, arrays of shape (windows,), by target and time.

    target: row of the request's targets.  rise_s, set_s: since the search's start.
    held_from_s, held_to_s: the longest part that a session can hold its target over, of a scan the
    longest span in which a session of it can begin, or NaN.
    opened_by, closed_by: which `Cause` made the edge, or the name of what the platform keeps;
    "interval" is the request's own start or stop, "look" the time at which a look of a stereo is to
    begin.
    scan_parameters: (windows, 7) of scans of imaging modes: part, counted from 1, of how many, how
    long its session lasts, longitude and latitude of its line's ends, degrees; NaN of any other.
    """

    target: NDArray[np.intp]
    rise_s: Array
    set_s: Array
    held_from_s: Array
    held_to_s: Array
    opened_by: NDArray[np.str_]
    closed_by: NDArray[np.str_]
    scan_parameters: Array

    def __len__(self) -> int:
        return len(self.target)

    @property
    def are_scans(self) -> Mask:
        """Which are of scans."""
        return ~np.isnan(self.scan_parameters[:, 0])

    def select(self, rows: NDArray[np.bool_] | Indices | slice) -> Self:
        """Select those at `rows`."""
        return _concatenate_sorted([self], rows)

    def sessions_s(self, start_utc: datetime) -> Array:
        """The longest session on rows of a command table in each window, (windows, 2).

        Since start_utc; tables begin on whole rows of a second.  Of a scan that which begins
        halfway through those that can.  NaN where no two rows fit, or a scan no row.
        """
        first_s, last_s = self.begins_s(start_utc).T
        lasts_s = self.scan_parameters[:, 2]
        middle_s = first_s + np.floor(0.5 * (last_s - first_s) * ROWS_PER_S) / ROWS_PER_S
        scan_s = np.where(last_s >= first_s, np.stack([middle_s, middle_s + lasts_s]), np.nan)
        longest_s = np.stack([first_s, np.minimum(last_s, first_s + SESSION_MAX_S)])
        longest_s = np.where(last_s > first_s, longest_s, np.nan)
        return np.asarray(np.where(np.isnan(lasts_s), longest_s, scan_s).T)

    def begins_s(self, start_utc: datetime) -> Array:
        """The first and the last row of what is held, (windows, 2), since start_utc."""
        before_s = start_utc.microsecond / 1e6
        first = np.ceil((self.held_from_s + before_s) * ROWS_PER_S - GRID_TOLERANCE_ROWS)
        last = np.floor((self.held_to_s + before_s) * ROWS_PER_S + GRID_TOLERANCE_ROWS)
        return np.stack([first, last], axis=1) / ROWS_PER_S - before_s


@dataclass(frozen=True, kw_only=True, eq=False)
class Windows(WindowEdges):
    """Windows and what is told of each, arrays of shape (windows,) unless said otherwise.

    highest_s, highest_rad: greatest elevation within the window.
    closest: at the least range (for a target in space, at the greatest height above the limb).
    through: at instants spread evenly from rise to set.
    sky: the carrier and the Sun in the target's sky at rise, greatest elevation and set.
    branches: (windows, 2), which rows of `axis_angles` stay within the stops, at the samples
    and the closest approach; none of them where the axes would have to change over.
    branch: the one reported, that with less turn of the inner axis (Sumarokov 2016, p. 88).
    clear_share: the probability that no cloud stands over the target at the window's middle; NaN
    where nothing is known of it.
    """

    highest_s: Array
    highest_rad: Array
    closest: Sightings
    through: Sightings
    sky: TargetSky
    branch: NDArray[np.intp]
    branches: NDArray[np.bool_]
    clear_share: Array


@dataclass(frozen=True, kw_only=True, eq=False)
class Opportunities:
    """Windows in order of the request's targets, each target's in order of time.

    ids: one per target.
    angle_names: of the angles told.  has_branches: whether two pairs of them point at a target.
    assumed: places of those given by name.
    """

    start_utc: datetime
    stop_utc: datetime
    ids: tuple[str, ...]
    angle_names: tuple[str, str]
    has_branches: bool
    warnings: tuple[str, ...]
    assumed: tuple[Assumed, ...]
    windows: Windows


Edges = TypeVar("Edges", bound=WindowEdges)


def in_order(parts: Sequence[Edges]) -> Edges:
    """All of the parts' windows, by target and time, as each part is."""
    if len(parts) == 1:
        return parts[0]
    order = np.lexsort(
        (
            np.concatenate([part.rise_s for part in parts]),
            np.concatenate([part.target for part in parts]),
        )
    )
    return _concatenate_sorted(parts, order)


def _concatenate_sorted(parts: Sequence[T], order: NDArray[np.bool_] | Indices | slice) -> T:
    """The arrays of like dataclasses, however deep, end to end and then put in order."""
    columns: dict[str, object] = {}
    for field in fields(parts[0]):  # type: ignore[arg-type]  # T is a dataclass
        values = [getattr(part, field.name) for part in parts]
        columns[field.name] = (
            np.concatenate(values)[order]
            if isinstance(values[0], np.ndarray)
            else _concatenate_sorted(values, order)
        )
    return type(parts[0])(**columns)
