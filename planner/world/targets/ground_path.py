"""A target point that scans a line on the ground."""

import dataclasses
import math
from datetime import datetime
from functools import cached_property
from itertools import pairwise
from typing import Annotated, Literal, NamedTuple, Self

import numpy as np

from planner.base.arrays import Array
from planner.base.assumed import Assumed
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
from planner.world.targets.terrain import Terrain

POINTS_MAX = 1000
PathLine = Literal["geodesic", "plane"]
# A corner that keeps within 1 deg/s2 then bends by less than 0.1 arcsec between 0.2 s rows:
# the cubic's error 0.2^4/384 * 52.5 dv/T^3 at dv = T/2.19 * 1 deg/s2.
CORNER_MIN_S = 2.0


@spec
class PathPoint:
    """A point of the line, in WGS84 geodetic coordinates.

    height_m: above the WGS84 ellipsoid, not above sea level; unless given, the terrain's, 0 without
    one. E.g. `620.0`.
    """

    latitude_deg: LatitudeDeg
    longitude_deg: LongitudeDeg
    height_m: HeightM | None = None


class _Knot(NamedTuple):
    """Where the line's slope may change (rad, m); leg: number of the points' that ends there."""

    latitude_rad: float
    longitude_rad: float
    height_m: float
    leg: int


@dataclasses.dataclass(frozen=True, eq=False)
class _Line:
    """The knots, and with a terrain how far the ground is off the straight lines between them."""

    knots: tuple[_Knot, ...]
    off_m: float = 0.0


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

    Over terrain the line is made of straight ones, each of corner_s or somewhat more, whose ends
    have the terrain's mean height around them, weighted to the neighbouring ends.

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
    terrain: heights of the ground where no point has one; unless given, the request's.
    """

    mode: Literal["ground_path"] = "ground_path"
    points: tuple[PathPoint, ...]
    terrain: Terrain | None = None
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
        if self.terrain is not None and any(point.height_m is not None for point in self.points):
            raise ValueError(
                "points have heights beside a terrain, which tells others: leave them out of all "
                "points, or give one for each and no terrain"
            )
        if self.line == "plane":
            self._require_plane()
        knots = self._line.knots
        for knot, lasts_s in zip(knots[1:], np.diff(self._legs.passing_s), strict=True):
            leg = knot.leg
            if len(knots) > 2 and lasts_s < self.corner_s * (1.0 - 1e-9):
                raise ValueError(
                    f"points.{leg + 1} is reached {figures(lasts_s, self.corner_s)} s after "
                    f"points.{leg} at {self.speed_m_s} m/s, less than the {self.corner_s:g} s of a "
                    "corner; "
                    "lower corner_s or the speed, or leave out a point"
                )

    def _require_plane(self) -> None:
        if self.terrain is not None:
            raise ValueError(
                "line plane has one height and can't follow the terrain: give height_m, or the "
                "line geodesic"
            )
        heights_m = {point.height_m or 0.0 for point in self.points}
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

    def standing_on(self, terrain: Terrain) -> Self:
        """Unless a point has a height."""
        told = [point.height_m is not None for point in self.points]
        if self.terrain is not None or all(told):
            return self
        if any(told):
            raise ValueError(
                f"points.{told.index(False)}.height_m is left out and points.{told.index(True)}'s "
                "isn't: give all of them, or none for the terrain's"
            )
        return dataclasses.replace(self, terrain=terrain)

    def with_heights(self) -> Self:
        """With a point for each straight line's end, if it stands on terrain."""
        if self.terrain is None:
            return self
        points = tuple(
            PathPoint(
                latitude_deg=math.degrees(knot.latitude_rad),
                longitude_deg=math.degrees(knot.longitude_rad),
                height_m=knot.height_m,
            )
            for knot in self._line.knots
        )
        return dataclasses.replace(self, points=points, terrain=None)

    def assumed(self, field: str) -> Assumed | None:
        """The terrain's heights."""
        if self.terrain is None:
            return None
        knots = self._line.knots
        heights_m = [knot.height_m for knot in knots]
        return Assumed(
            field=f"{field}.points",
            detail=f"{min(heights_m):.0f} to {max(heights_m):.0f} m above the ellipsoid, of the "
            f"terrain around {len(knots)} points; between them the ground is up to "
            f"{self._line.off_m:.0f} m off",
            members={"points": [vars(point) for point in self.with_heights().points]},
        )

    @cached_property
    def duration_s(self) -> float:
        """Seconds from the first point to the last."""
        if self.plane_arc is not None:
            return self.plane_arc.length_m() / self.speed_m_s
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
        if self.plane_arc is not None:
            return self.plane_arc.point_itrf(t_s / self.duration_s)[0]
        legs = self._legs
        halfway_s = (legs.passing_s[1:] + legs.passing_s[:-1]) / 2.0
        nearest = np.searchsorted(halfway_s, t_s)
        r_itrf_m = np.empty((len(t_s), 3))
        for node in np.unique(nearest):
            here = nearest == node
            since_s = (t_s[here] - legs.passing_s[node])[:, None]
            turn_m_s = legs.leaving_m_s[node] - legs.arriving_m_s[node]
            offset_m = legs.arriving_m_s[node] * since_s + turn_m_s * ramp(since_s, self.corner_s)
            r_itrf_m[here] = _itrf_near(self._line.knots[node], offset_m)
        return r_itrf_m

    @cached_property
    def plane_arc(self) -> PlaneArc | None:
        """Of the line plane."""
        if self.line != "plane":
            return None
        a, b = self.points
        return PlaneArc(
            latitude_rad=(math.radians(a.latitude_deg), math.radians(b.latitude_deg)),
            longitude_rad=(math.radians(a.longitude_deg), math.radians(b.longitude_deg)),
            height_m=a.height_m or 0.0,
        )

    @cached_property
    def _line(self) -> _Line:
        places_rad = [
            (math.radians(point.latitude_deg), math.radians(point.longitude_deg))
            for point in self.points
        ]
        if self.terrain is not None:
            return _line_on(self.terrain, self._with_between(places_rad))
        knots = (
            _Knot(*place, point.height_m or 0.0, max(number - 1, 0))
            for number, (place, point) in enumerate(zip(places_rad, self.points, strict=True))
        )
        return _Line(tuple(knots))

    def _with_between(
        self, places_rad: list[tuple[float, float]]
    ) -> list[tuple[float, float, int]]:
        """The points with others evenly between them, `corner_s` apart or somewhat more."""
        most = POINTS_MAX // (len(places_rad) - 1)
        with_between = [(*places_rad[0], 0)]
        for leg, (a, b) in enumerate(pairwise(places_rad)):
            azimuth_rad, length_m = _course(leg, a, b)
            parts = min(max(math.floor(length_m / self.speed_m_s / self.corner_s), 1), most)
            between_rad = geodesic_end(*a, azimuth_rad, length_m * np.arange(1.0, parts) / parts)
            with_between += [(*place, leg) for place in np.transpose(between_rad).tolist()]
            with_between.append((*b, leg))
        return with_between

    @cached_property
    def _legs(self) -> _Legs:
        leaving, arriving, lasting_s = [], [], []
        for a, b in pairwise(self._line.knots):
            forth, distance_m = _course(b.leg, a[:2], b[:2])
            back, _ = _course(b.leg, b[:2], a[:2])
            climb = (b.height_m - a.height_m) / distance_m
            leaving.append([math.sin(forth), math.cos(forth), climb])
            arriving.append([-math.sin(back), -math.cos(back), climb])
            lasting_s.append(distance_m / self.speed_m_s)
        return _Legs(
            passing_s=np.concatenate([[0.0], np.cumsum(lasting_s)]),
            arriving_m_s=self.speed_m_s * np.array([leaving[0], *arriving]),
            leaving_m_s=self.speed_m_s * np.array([*leaving, arriving[-1]]),
        )


def _course(leg: int, a: tuple[float, float], b: tuple[float, float]) -> tuple[float, float]:
    """Azimuth at a (rad) and distance (m) of two places_rad of a leg."""
    try:
        azimuth_rad, distance_m = geodesic_between(*a, *b)
    except ValueError as error:
        raise ValueError(f"points.{leg + 1} can't follow points.{leg}: {error}") from None
    if distance_m == 0.0:
        raise ValueError(f"points.{leg + 1} is the same place as points.{leg}; leave one out")
    return azimuth_rad, distance_m


def _line_on(terrain: Terrain, places_rad: list[tuple[float, float, int]]) -> _Line:
    """Its mean height is the terrain's, however far apart its knots are."""
    reaches = [terrain.profile(a[:2], b[:2]) for a, b in pairwise(places_rad)]
    heights_m, lengths_m = np.zeros((2, len(places_rad)))
    for number, (length_m, ground_m) in enumerate(reaches):
        share = np.linspace(0.0, 1.0, len(ground_m))
        for end, weight in ((number, 1.0 - share), (number + 1, share)):
            weight[[0, -1]] *= 0.5  # by the trapezoidal rule
            heights_m[end] += length_m * (weight @ ground_m) / weight.sum()
            lengths_m[end] += length_m
    heights_m /= lengths_m
    off_m = max(
        float(np.abs(np.linspace(*ends_m, len(ground_m)) - ground_m).max())
        for (_, ground_m), ends_m in zip(reaches, pairwise(heights_m.tolist()), strict=True)
    )
    knots = (
        _Knot(latitude_rad, longitude_rad, height_m, leg)
        for (latitude_rad, longitude_rad, leg), height_m in zip(
            places_rad, heights_m.tolist(), strict=True
        )
    )
    return _Line(tuple(knots), off_m)


def _itrf_near(knot: _Knot, offset_m: Array) -> Array:
    """ITRF positions (n, 3) at offsets east, north and up measured along geodesics."""
    latitude_rad, longitude_rad = geodesic_end(
        knot.latitude_rad,
        knot.longitude_rad,
        np.arctan2(offset_m[:, 0], offset_m[:, 1]),
        np.hypot(offset_m[:, 0], offset_m[:, 1]),
    )
    return itrf_from_geodetic(latitude_rad, longitude_rad, knot.height_m + offset_m[:, 2])
