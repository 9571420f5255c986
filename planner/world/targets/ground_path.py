"""A target point that scans a line on the ground."""

import dataclasses
import math
from datetime import datetime
from functools import cached_property
from typing import Annotated, Literal

import numpy as np

from planner.base.arrays import Array
from planner.base.commands import COMMAND_STEP_S
from planner.base.errors import InvalidInput, figures
from planner.base.spec import Within, spec
from planner.world.frames.geodesic import geodesic_between, geodesic_end
from planner.world.frames.geodesy import HeightM, LatitudeDeg, LongitudeDeg, itrf_from_geodetic
from planner.world.frames.time_scales import Instants, elapsed_s, utc_text
from planner.world.targets.earth_fixed import EarthFixedTarget, ElevationDeg, place_text
from planner.world.targets.plane_arc import PlaneArc
from planner.world.targets.refraction import Refraction
from planner.world.targets.session_target import TimedTarget
from planner.world.targets.smooth_step import ramp

POINTS_MAX = 1000
PathLine = Literal["geodesic", "plane"]
# A corner that keeps within 1 deg/s2 then bends by less than 0.1 arcsec between 0.2 s rows:
# the cubic's error 0.2^4/384 * 52.5 dv/T^3 at dv = T/2.19 * 1 deg/s2.
CORNER_MIN_S = 2.0


@spec
class PathPoint:
    """A point of the line, in WGS84 geodetic coordinates."""

    latitude_deg: LatitudeDeg
    longitude_deg: LongitudeDeg
    height_m: HeightM = 0.0


@dataclasses.dataclass(frozen=True, eq=False)
class _Legs:
    """passing_s: (m,), when the m points are passed.

    arriving_m_s, leaving_m_s: (m, 3), velocity east, north and up on the way to and from
    each point, in the plane that keeps distances and directions from the point.
    """

    passing_s: Array
    arriving_m_s: Array
    leaving_m_s: Array


@spec
class GroundPathTarget(TimedTarget, EarthFixedTarget):
    """A polyline of geodesics between two or more points, scanned from its first point on.

    Before its start and after its end the path goes straight on along its outer legs.

    points: two or more, in the order in which they are passed; heights change linearly between.
    speed_m_s: over the ellipsoid's surface, constant on the legs.
    start: time at which the first point is passed; UTC, the session's start unless given. E.g.
    `"2015-02-27T17:36:20Z"`.
    corner_s: duration of the turn from one leg to the next. The velocity turns over with
    continuous jerk, the timetable stays: halfway the speed has dropped to cos(turn/2) of itself and
    the point passes 0.14 corner_s speed sin(turn/2) inside the corner (70 m at right angles, 4 s
    and 180 m/s); the acceleration peaks at 4.4 speed sin(turn/2)/corner_s.
    line: of two points of one height, "plane" is the section by the plane through both and the
    Earth's centre, looked at without light time and aberration (16 m along the flight).
    """

    mode: Literal["ground_path"] = "ground_path"
    points: tuple[PathPoint, ...]
    line: PathLine = "geodesic"
    speed_m_s: Annotated[float, Within(1e-3, 12e3)]
    start: datetime | None = None
    corner_s: Annotated[float, Within(CORNER_MIN_S, 600.0)] = 4.0
    min_elevation_deg: ElevationDeg = 0.0
    refraction: Refraction = "none"

    def __post_init__(self) -> None:
        if not 2 <= len(self.points) <= POINTS_MAX:
            raise ValueError(f"points must hold 2 to {POINTS_MAX} points, not {len(self.points)}")
        super().__post_init__()
        if self.line == "plane":
            self._require_plane()
        for leg, lasts_s in enumerate(np.diff(self._legs.passing_s)):
            if len(self.points) > 2 and lasts_s < self.corner_s:
                raise ValueError(
                    f"points.{leg + 1} is reached {figures(lasts_s, self.corner_s)} s after "
                    f"points.{leg} at {self.speed_m_s} m/s, less than the {self.corner_s:g} s of a "
                    "corner; "
                    "lower corner_s or the speed, or leave out a point"
                )

    def _require_plane(self) -> None:
        heights_m = {point.height_m for point in self.points}
        if len(self.points) != 2 or len(heights_m) != 1:
            raise ValueError(
                f"line plane takes two points of one height, not {len(self.points)} with heights "
                f"{', '.join(f'{height_m:g}' for height_m in sorted(heights_m))} m: give each leg "
                "a session of its own, or the line geodesic"
            )
        if self.refraction != "none":
            raise ValueError(
                f"refraction {self.refraction!r} is not modelled for the line plane, which is "
                "looked at as if light were without delay: leave it out, or give the line geodesic"
            )

    @property
    def is_geometric(self) -> bool:
        """Of the line plane."""
        return self.line == "plane"

    @property
    def label(self) -> str:
        """Its ends."""
        first, last = (
            place_text(p.latitude_deg, p.longitude_deg)
            for p in self.points[:: len(self.points) - 1]
        )
        return f"path from {first} to {last}"

    @property
    def duration_s(self) -> float:
        """Seconds from the first point to the last."""
        if self._plane_arc is not None:
            return self._plane_arc.length_m() / self.speed_m_s
        return float(self._legs.passing_s[-1])

    def require_known(self, name: str, start_utc: datetime, stop_utc: datetime) -> None:
        """Refuse a session that goes on after the path's end."""
        over_s = elapsed_s(stop_utc, self.start or start_utc) - self.duration_s
        if over_s > COMMAND_STEP_S:
            raise ValueError(
                f"stop ({utc_text(stop_utc)}) comes {over_s:.1f} s after the path's end; end the "
                "session there, or give the path more points or less speed"
            )

    def r_target_itrf_m(self, instants: Instants) -> Array:
        """Shape (n, 3)."""
        if self.start is None:
            raise InvalidInput(
                "the path doesn't say when it starts; give its start, or plan it in a session",
                field="start",
            )
        t_s = instants.since_s(self.start)
        if self._plane_arc is not None:
            return self._plane_arc.point_itrf(t_s / self.duration_s)[0]
        legs = self._legs
        halfway_s = (legs.passing_s[1:] + legs.passing_s[:-1]) / 2.0
        nearest = np.searchsorted(halfway_s, t_s)
        r_itrf_m = np.empty((len(t_s), 3))
        for node in np.unique(nearest):
            here = nearest == node
            since_s = (t_s[here] - legs.passing_s[node])[:, None]
            turn_m_s = legs.leaving_m_s[node] - legs.arriving_m_s[node]
            offset_m = legs.arriving_m_s[node] * since_s + turn_m_s * ramp(since_s, self.corner_s)
            r_itrf_m[here] = _itrf_near(self.points[node], offset_m)
        return r_itrf_m

    @cached_property
    def _plane_arc(self) -> PlaneArc | None:
        if self.line != "plane":
            return None
        a, b = self.points
        return PlaneArc(
            latitude_rad=(math.radians(a.latitude_deg), math.radians(b.latitude_deg)),
            longitude_rad=(math.radians(a.longitude_deg), math.radians(b.longitude_deg)),
            height_m=a.height_m,
        )

    @cached_property
    def _legs(self) -> _Legs:
        leaving, arriving, lasting_s = [], [], []
        for leg, (a, b) in enumerate(zip(self.points[:-1], self.points[1:], strict=True)):
            try:
                forth, distance_m = _azimuth_between(a, b)
                back, _ = _azimuth_between(b, a)
            except ValueError as error:
                raise ValueError(f"points.{leg + 1} can't follow points.{leg}: {error}") from None
            if distance_m == 0.0:
                raise ValueError(
                    f"points.{leg + 1} is the same place as points.{leg}; leave one out"
                )
            climb = (b.height_m - a.height_m) / distance_m
            leaving.append([math.sin(forth), math.cos(forth), climb])
            arriving.append([-math.sin(back), -math.cos(back), climb])
            lasting_s.append(distance_m / self.speed_m_s)
        return _Legs(
            passing_s=np.concatenate([[0.0], np.cumsum(lasting_s)]),
            arriving_m_s=self.speed_m_s * np.array([leaving[0], *arriving]),
            leaving_m_s=self.speed_m_s * np.array([*leaving, arriving[-1]]),
        )


def _azimuth_between(a: PathPoint, b: PathPoint) -> tuple[float, float]:
    """Azimuth at a (rad) and distance (m)."""
    return geodesic_between(
        *(
            math.radians(angle_deg)
            for angle_deg in (a.latitude_deg, a.longitude_deg, b.latitude_deg, b.longitude_deg)
        )
    )


def _itrf_near(point: PathPoint, offset_m: Array) -> Array:
    """ITRF positions (n, 3) at offsets east, north and up measured along geodesics."""
    latitude_rad, longitude_rad = geodesic_end(
        math.radians(point.latitude_deg),
        math.radians(point.longitude_deg),
        np.arctan2(offset_m[:, 0], offset_m[:, 1]),
        np.hypot(offset_m[:, 0], offset_m[:, 1]),
    )
    return itrf_from_geodetic(latitude_rad, longitude_rad, point.height_m + offset_m[:, 2])
