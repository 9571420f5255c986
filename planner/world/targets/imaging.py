"""Imaging modes: what becomes several sessions, each of which scans a line on the ground."""

import math
from abc import abstractmethod
from collections.abc import Iterable
from dataclasses import dataclass, replace
from datetime import datetime
from functools import cached_property
from itertools import pairwise
from typing import Annotated, ClassVar, Literal, NamedTuple, Self

import numpy as np
from pydantic import Field

from planner.base.arrays import Array
from planner.base.commands import COMMAND_STEP_S, ROWS_PER_S
from planner.base.errors import figures
from planner.base.spec import Within, spec
from planner.world.frames.geodesy import HeightM, geodetic_from_itrf
from planner.world.frames.time_scales import elapsed_s, shifted_utc, utc_text
from planner.world.orbits import Orbit
from planner.world.platforms.geometry import Scanning
from planner.world.targets.earth_fixed import ElevationDeg
from planner.world.targets.geojson import (
    GeoLineString,
    GeoMultiLineString,
    GeoMultiPolygon,
    GeoPolygon,
    Position,
)
from planner.world.targets.ground import GroundTarget
from planner.world.targets.ground_path import GroundPathTarget, PathLine, PathPoint
from planner.world.targets.passing import Passing
from planner.world.targets.refraction import Refraction
from planner.world.targets.session_target import SessionTarget
from planner.world.targets.strips import middle_itrf_m, places_itrf_m, strip_pattern, strip_pieces
from planner.world.targets.terrain import Terrain, require_one_height


@dataclass(frozen=True, kw_only=True)
class ImagingOptions:
    """Bounds of what one target may become."""

    scans_most: int = 50  # sessions of one target: each is a slew to be solved
    window_most_s: float = 7200.0  # from start to stop: the pass is looked at row by row
    region_most_km: float = 500.0  # across: in a plane that touches the ground there
    scan_least_s: float = 1.0  # of a strip's piece, however little of the region it holds
    look_angle_deg: float = 24.0  # of stereo looks, unless they say otherwise
    off_look_angle_deg: float = 1.0  # of a look: two seconds of a low orbit


OPTIONS = ImagingOptions()


class ScannedLine(NamedTuple):
    """A line that is scanned.

    start_utc: None for as soon as the one before lets it.  slack_s: by so much a campaign may begin
    it sooner or later, where it has a start.
    """

    target: GroundPathTarget
    start_utc: datetime | None
    slack_s: float = 0.0

    @property
    def duration_s(self) -> float:
        """In whole rows of a table."""
        return math.ceil(self.target.duration_s * ROWS_PER_S - 1e-6) / ROWS_PER_S


@dataclass(frozen=True, kw_only=True)
class ScanWindow:
    """The time in which a target's scans are to be, and with what."""

    orbit: Orbit
    scanning: Scanning
    start_utc: datetime
    stop_utc: datetime

    @property
    def duration_s(self) -> float:
        """Of the window."""
        return elapsed_s(self.stop_utc, self.start_utc)

    @cached_property
    def passing(self) -> Passing:
        """The orbit over the window; raises OutsideCoverage."""
        after_utc = shifted_utc(self.stop_utc, 10.0)
        return Passing(
            ephemeris=self.orbit.ephemeris(self.start_utc, after_utc),
            start_utc=self.start_utc,
            duration_s=self.duration_s,
        )


@spec
class ImagingMode(SessionTarget):
    """What every imaging mode has.

    speed_m_s: of the scanned line over the ground.
    height_m: of the ground above the ellipsoid; unless given, the terrain's, 0 without one. E.g.
    `620.0`.
    terrain: heights of the ground, which the lines then follow; unless given, the request's.
    line: shape of each line between its ends, as of a ground_path.
    min_elevation_deg: the carrier must stand at least this high in the sky of what is scanned.
    refraction: "standard" aims where the standard atmosphere makes the ground appear.
    """

    has_windows: ClassVar[bool] = False

    speed_m_s: Annotated[float, Within(1.0, 12e3)] = 60e3 / 11.0
    height_m: HeightM | None = None
    terrain: Terrain | None = None
    line: PathLine = "geodesic"
    min_elevation_deg: ElevationDeg = 0.0
    refraction: Refraction = "none"

    def __post_init__(self) -> None:
        require_one_height(self.height_m, self.terrain)

    def standing_on(self, terrain: Terrain) -> Self:
        """Unless it says its height."""
        is_told = self.height_m is not None or self.terrain is not None
        return self if is_told else replace(self, terrain=terrain)

    def _level_m(self, positions: Iterable[Position]) -> float:
        """One height of the ground, for the layout of lines: the terrain's mean at positions."""
        if self.terrain is None:
            return self.height_m or 0.0
        longitude_deg, latitude_deg = np.array([position[:2] for position in positions]).T
        try:
            return float(self.terrain.heights_m(latitude_deg, longitude_deg).mean())
        except ValueError as error:
            raise ValueError(f"target: {error}") from None

    def scans(self, window: ScanWindow) -> tuple[ScannedLine, ...]:
        """Its scans in order; raises ValueError with the field at fault, OutsideCoverage."""
        if window.duration_s > OPTIONS.window_most_s:
            raise ValueError(
                f"stop must come at most {OPTIONS.window_most_s:g} s after start, within which "
                f"the scans are laid, not {window.duration_s:g} s: give each pass a session"
            )
        found = self._scans(window)
        if len(found) > OPTIONS.scans_most:
            raise ValueError(
                f"target.geometry: it takes {len(found)} scans, more than {OPTIONS.scans_most} of "
                "one session: split it, or give a wider swath_m or less overlap"
            )
        least_s = 0.0
        for scan in found:
            if scan.start_utc is None:
                least_s += max(window.scanning.settle_s, COMMAND_STEP_S)
            else:
                start_s = elapsed_s(scan.start_utc, window.start_utc)
                if start_s < least_s + COMMAND_STEP_S and scan is not found[0]:
                    raise ValueError(
                        f"target: a look lasts {scan.duration_s:g} s, and the next one would begin "
                        f"{start_s - least_s + scan.duration_s:.1f} s after it began: give looks "
                        "further apart, more speed_m_s or a shorter line"
                    )
                least_s = start_s
            least_s += scan.duration_s
        if least_s > window.duration_s + 1e-6:
            until_utc = shifted_utc(window.start_utc, least_s)
            raise ValueError(
                f"stop ({utc_text(window.stop_utc)}) comes before {len(found)} scans and the "
                f"settling between them can be over, {utc_text(until_utc, 1)} at the soonest: give "
                "a later stop, more speed_m_s or a smaller geometry"
            )
        return found

    @property
    @abstractmethod
    def lines(self) -> tuple[tuple[Position, ...], ...]:
        """Its lines, or outlines of what is to be covered."""

    @property
    def middle(self) -> GroundTarget:
        """Of all its positions, as a place."""
        places = list({place[:2] for line in self.lines for place in line})
        level_m = self._level_m(places)
        latitude_rad, longitude_rad, _ = geodetic_from_itrf(
            places_itrf_m(places, level_m).mean(axis=0)
        )
        return GroundTarget(
            latitude_deg=math.degrees(latitude_rad),
            longitude_deg=math.degrees(longitude_rad),
            height_m=level_m,
            min_elevation_deg=self.min_elevation_deg,
        )

    @property
    def first_path(self) -> GroundPathTarget:
        """Of its first line."""
        return self._path(*self.lines[0][:2])

    def path_between(self, first: Position, last: Position) -> GroundPathTarget:
        """A line of its scans, by longitude and latitude of its ends, degrees."""
        return self._path(first, last)

    def in_pass(self, window: ScanWindow) -> ScanWindow:
        """The window of its scans in a pass during which it can be seen."""
        return window

    @abstractmethod
    def _scans(self, window: ScanWindow) -> tuple[ScannedLine, ...]: ...

    def _path(self, start: Position, end: Position) -> GroundPathTarget:
        # GeoJSON may go on to 360 deg and beyond the antimeridian.
        points = tuple(
            PathPoint(
                latitude_deg=float(latitude_deg),
                longitude_deg=math.remainder(longitude_deg, 360.0),
                height_m=self.height_m,
            )
            for longitude_deg, latitude_deg in (start[:2], end[:2])
        )
        try:
            return GroundPathTarget(
                points=points,
                terrain=self.terrain,
                line=self.line,
                speed_m_s=self.speed_m_s,
                min_elevation_deg=self.min_elevation_deg,
                refraction=self.refraction,
            )
        except ValueError as error:
            raise ValueError(f"target: {error}") from None

    def in_sense(
        self, ends: tuple[Position, Position], passing: Passing
    ) -> tuple[Position, Position]:
        """The ends in the sense of the flight."""
        start_itrf_m, end_itrf_m = places_itrf_m(ends, self._level_m(ends))
        v_itrf_m_s = passing.velocity_passing(start_itrf_m)
        return ends if (end_itrf_m - start_itrf_m) @ v_itrf_m_s >= 0.0 else ends[::-1]


@spec
class _LineMode(ImagingMode):
    """A line of two positions.

    geometry: the line, scanned in the sense of the flight; where the camera images both ways, from
    its first position to its second.
    """

    geometry: GeoLineString

    def __post_init__(self) -> None:
        super().__post_init__()
        if len(self.geometry.coordinates) != 2:
            raise ValueError(
                f"geometry must have two positions in this mode, not "
                f"{len(self.geometry.coordinates)}: a corridor has more"
            )

    @property
    def lines(self) -> tuple[tuple[Position, ...], ...]:
        return (self.geometry.coordinates,)

    def _ends(self, window: ScanWindow) -> tuple[Position, Position]:
        first, last = self.geometry.coordinates
        if window.scanning.both_ways:
            return first, last
        return self.in_sense((first, last), window.passing)


@spec
class StripMode(_LineMode):
    """One strip."""

    mode: Literal["strip"] = "strip"

    @property
    def label(self) -> str:
        return "strip"

    def _scans(self, window: ScanWindow) -> tuple[ScannedLine, ...]:
        return (ScannedLine(self._path(*self._ends(window)), window.start_utc),)


@spec
class CorridorMode(ImagingMode):
    """A line of one or more legs at any angle to the track, each leg a session.

    geometry: the line or lines, scanned as they are given.
    """

    mode: Literal["corridor"] = "corridor"
    geometry: Annotated[GeoLineString | GeoMultiLineString, Field(discriminator="type")]

    @property
    def lines(self) -> tuple[tuple[Position, ...], ...]:
        if isinstance(self.geometry, GeoLineString):
            return (self.geometry.coordinates,)
        return self.geometry.coordinates

    def _scans(self, window: ScanWindow) -> tuple[ScannedLine, ...]:
        legs = [leg for line in self.lines for leg in pairwise(line)]
        return _one_after_another([self._path(*leg) for leg in legs], window)


def _one_after_another(
    paths: list[GroundPathTarget], window: ScanWindow
) -> tuple[ScannedLine, ...]:
    return tuple(
        ScannedLine(path, None if number else window.start_utc) for number, path in enumerate(paths)
    )


@spec
class AreaMode(ImagingMode):
    """A region covered by parallel strips, each a session, cut to the region.

    Strips are scanned in the sense of the flight, to and fro where the camera images both ways.

    geometry: the region. Holes that are passed before the camera would have settled are imaged.
    azimuth_deg: of the strips, clockwise from north; unless given, along the ground track, or along
    a side of the region within 10 deg of it. E.g. `15.0`.
    overlap: of neighbouring strips, as a share of the swath.
    swath_m: width of a strip on the ground; unless given, what the camera sees from where it
    passes the region's middle nearest between start and stop. E.g. `6000.0`.
    """

    mode: Literal["area"] = "area"
    geometry: Annotated[GeoPolygon | GeoMultiPolygon, Field(discriminator="type")]
    azimuth_deg: Annotated[float, Within(-360.0, 360.0)] | None = None
    overlap: Annotated[float, Within(0.0, 0.9)] = 0.05
    swath_m: Annotated[float, Within(1.0, 1e6)] | None = None

    @property
    def _polygons(self) -> tuple[tuple[tuple[Position, ...], ...], ...]:
        if isinstance(self.geometry, GeoPolygon):
            return (self.geometry.coordinates,)
        return self.geometry.coordinates

    @property
    def lines(self) -> tuple[tuple[Position, ...], ...]:
        return tuple(polygon[0] for polygon in self._polygons)

    def _scans(self, window: ScanWindow) -> tuple[ScannedLine, ...]:
        polygons, outlines = self._polygons, self.lines
        self._require_size(outlines)
        level_m = self._level_m(position for ring in outlines for position in ring)
        swath_m = self._swath_m(outlines, level_m, window)
        pattern = strip_pattern(
            outlines,
            level_m,
            self.azimuth_deg,
            lambda r_itrf_m: window.passing.velocity_passing(r_itrf_m),
            swath_m,
            swath_m * (1.0 - self.overlap),
        )
        if pattern.count > OPTIONS.scans_most:
            raise ValueError(
                f"target.geometry: it takes {pattern.count} strips of {swath_m:.0f} m, more than "
                f"{OPTIONS.scans_most} of one session: split it, or give a wider swath_m or less "
                "overlap"
            )
        strips = strip_pieces(
            pattern,
            polygons,
            level_m,
            swath_m,
            gap_m=self.speed_m_s * max(window.scanning.settle_s, COMMAND_STEP_S),
            least_m=self.speed_m_s * OPTIONS.scan_least_s,
        )
        paths: list[GroundPathTarget] = []
        for number, pieces in enumerate(filter(None, strips)):
            forth = self.in_sense(pieces[0], window.passing) == pieces[0]
            if window.scanning.both_ways and number % 2:
                forth = not forth
            in_order = pieces if forth else [piece[::-1] for piece in reversed(pieces)]
            paths += [self._path(*piece) for piece in in_order]
        return _one_after_another(paths, window)

    def _require_size(self, outlines: tuple[tuple[Position, ...], ...]) -> None:
        corners_itrf_m = np.concatenate([places_itrf_m(ring, 0.0) for ring in outlines])
        apart_m = corners_itrf_m - middle_itrf_m(outlines, 0.0)
        across_km = 2.0 * float(np.linalg.norm(apart_m, axis=1).max()) / 1e3
        if across_km > OPTIONS.region_most_km:
            raise ValueError(
                f"target.geometry: it is {figures(across_km, OPTIONS.region_most_km)} km across, "
                f"more than {OPTIONS.region_most_km:g}: split it"
            )

    def _swath_m(
        self, outlines: tuple[tuple[Position, ...], ...], level_m: float, window: ScanWindow
    ) -> float:
        if self.swath_m is not None:
            return self.swath_m
        range_m = window.passing.range_passing_m(middle_itrf_m(outlines, level_m))
        if range_m is None:
            raise ValueError(
                "target.swath_m is required: the region's middle can't be seen between start and "
                "stop, so that nothing tells how wide the camera sees there; or give other times"
            )
        return 2.0 * range_m * math.tan(window.scanning.half_width_rad)


@spec
class StereoMode(_LineMode):
    """Two looks at one strip, from ahead and behind, both in the sense of its scan.

    look_angle_deg: from nadir along the track, ahead in the first look and behind in the last; 24
    where gap_s isn't given either. The looks are between start and stop. E.g. `24.0`.
    gap_s: from a look's start to the next one's, the first at start. E.g. `110.0`.
    """

    looks: ClassVar[tuple[float, ...]] = (1.0, -1.0)  # shares of the look angle

    mode: Literal["stereo"] = "stereo"
    look_angle_deg: Annotated[float, Within(2.0, 60.0)] | None = None
    gap_s: Annotated[float, Within(1.0, 3600.0)] | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.look_angle_deg is not None and self.gap_s is not None:
            raise ValueError(
                f"look_angle_deg ({self.look_angle_deg:g}) and gap_s ({self.gap_s:g}) both say "
                "when the looks are: leave one out"
            )

    def _scans(self, window: ScanWindow) -> tuple[ScannedLine, ...]:
        path = self._path(*self._ends(window))
        if self.gap_s is not None:
            starts_s = [(self.gap_s * number, 0.0) for number in range(len(self.looks))]
        else:
            starts_s = self.look_starts_s(path, window, self.looks)
        return tuple(
            ScannedLine(
                path,
                shifted_utc(window.start_utc, round(start_s * ROWS_PER_S) / ROWS_PER_S),
                slack_s,
            )
            for start_s, slack_s in starts_s
        )

    def in_pass(self, window: ScanWindow) -> ScanWindow:
        """With a gap the looks lie evenly about the instant at which the middle is abeam."""
        if self.gap_s is None:
            return window
        path = self._path(*self._ends(window))
        t_s, along_rad = self._along_rad(window)
        lasts_s = self.gap_s * (len(self.looks) - 1) + path.duration_s
        begins_s = float(t_s[np.argmin(np.abs(along_rad))]) - 0.5 * lasts_s
        return replace(
            window,
            start_utc=shifted_utc(window.start_utc, round(begins_s * ROWS_PER_S) / ROWS_PER_S),
            stop_utc=shifted_utc(window.start_utc, max(begins_s + lasts_s + 1.0, 1.0)),
        )

    def _along_rad(self, window: ScanWindow) -> tuple[Array, Array]:
        """How far ahead the strip's middle stands over the window, and when, (n,) each."""
        ends = self.geometry.coordinates
        r_middle_itrf_m = places_itrf_m(ends, self._level_m(ends)).mean(axis=0)
        t_s = np.arange(0.0, window.duration_s, COMMAND_STEP_S)
        return t_s, window.passing.look_angles(r_middle_itrf_m, t_s)[0]

    def look_starts_s(
        self, path: GroundPathTarget, window: ScanWindow, shares: tuple[float, ...]
    ) -> list[tuple[float, float]]:
        """When the strip's middle stands at shares of the angle from nadir, half a scan before, and
        how long it stands near them, to either side.  Raises ValueError where it doesn't."""
        t_s, along_rad = self._along_rad(window)
        near_rad = math.radians(OPTIONS.off_look_angle_deg)
        most_deg = OPTIONS.look_angle_deg if self.look_angle_deg is None else self.look_angle_deg
        starts_s: list[tuple[float, float]] = []
        for share in shares:
            angle_rad = math.radians(share * most_deg)
            off_rad = np.abs(along_rad - angle_rad)
            nearest = int(np.argmin(off_rad))
            start_s = float(t_s[nearest]) - 0.5 * path.duration_s
            if off_rad[nearest] > near_rad or start_s < 0.0:
                seen = along_rad[np.abs(along_rad) < math.pi / 2.0]
                told = (
                    f"{math.degrees(seen.max()):.1f} to {math.degrees(seen.min()):.1f} deg"
                    if len(seen)
                    else "below the horizon"
                )
                raise ValueError(
                    f"target.look_angle_deg: the strip's middle isn't {share * most_deg:g} deg "
                    f"ahead with half a scan before it between start and stop, where it stands "
                    f"{told} ahead: give times around its pass"
                )
            near_rows = np.count_nonzero(off_rad < near_rad) - 1
            starts_s.append((start_s, 0.5 * COMMAND_STEP_S * float(near_rows)))
        return starts_s


@spec
class TriStereoMode(StereoMode):
    """Three looks at one strip, from ahead, above and behind, all in the sense of its scan."""

    looks: ClassVar[tuple[float, ...]] = (1.0, 0.0, -1.0)

    mode: Literal["tri_stereo"] = "tri_stereo"  # type: ignore[assignment]  # it is another one


IMAGING_MODES: dict[str, type[ImagingMode]] = {
    mode.mode: mode for mode in (StripMode, CorridorMode, AreaMode, StereoMode, TriStereoMode)
}
