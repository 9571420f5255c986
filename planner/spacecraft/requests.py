"""What can be asked of the imaging spacecraft?  The request's fields, in degrees and GeoJSON."""

import math
from datetime import datetime
from itertools import combinations, pairwise
from typing import Annotated, Literal

from pydantic import Field

from planner.frames.time_scales import elapsed_s, require_offset, utc_text
from planner.orbits import Orbit
from planner.spacecraft.vehicle.definition import (
    OFF_NADIR_DEG,
    SETTLE_S,
    SPACECRAFT,
    SWATH_M,
    AgileSpacecraft,
    Camera,
    SlewLimits,
    TurnObjective,
)
from planner.spec import UnitPart, Within, spec

# Longitude, latitude and, if given, height in metres: no use is made of it.
Position = tuple[Annotated[float, Within(-1000.0, 100e3)], ...]
_MomentumPart = Annotated[float, Within(-240.0, 240.0)]  # four gyros of 60 in one direction
SESSION_MAX_S = 3600.0
LEG_MAX_KM = 2000.0
SCAN_SPEED_M_S = 60e3 / 11.0  # Platonov, Sumarokov 2019: a strip of 60 km in about 11 s


def _check_positions(positions: tuple[Position, ...]) -> None:
    for position in positions:
        if len(position) not in (2, 3) or not all(math.isfinite(x) for x in position):
            raise ValueError(f"a position is [longitude, latitude] in degrees, not {position}")
        if not (-180.0 <= position[0] <= 360.0 and -89.0 <= position[1] <= 89.0):
            raise ValueError(
                f"position {position} is off the map: longitude -180..360, latitude -89..89, "
                "in this order"
            )


@spec
class GeoLineString:
    """A GeoJSON line: positions [longitude, latitude], degrees."""

    type: Literal["LineString"] = "LineString"
    coordinates: tuple[Position, ...]

    def __post_init__(self) -> None:
        if not 2 <= len(self.coordinates) <= 64:
            raise ValueError(f"a line has 2 to 64 positions, not {len(self.coordinates)}")
        _check_positions(self.coordinates)
        for number, (a, b) in enumerate(pairwise(self.coordinates)):
            apart_km = _apart_km(a, b)
            if apart_km < 1.0:
                raise ValueError(f"positions {number} and {number + 1} are less than 1 km apart")
            if apart_km > LEG_MAX_KM:
                raise ValueError(
                    f"positions {number} and {number + 1} are {apart_km:.0f} km apart; a leg has "
                    f"at most {LEG_MAX_KM:.0f} km: put positions between"
                )
        self._refuse_crossing()

    def _refuse_crossing(self) -> None:
        last = len(self.coordinates) - 1
        legs = list(pairwise(_unwrapped(self.coordinates)))
        for (i, (a, b)), (j, (c, d)) in combinations(enumerate(legs), 2):
            if j > i + 1 and _cross(a, b, c, d):
                raise ValueError(
                    f"the line crosses itself: leg {i} and leg {j} meet; split it into two "
                    f"requests, positions 0 to {j} and {j} to {last}"
                )


def _apart_km(a: Position, b: Position) -> float:
    """Great circle on a sphere of 6371 km."""
    north = math.radians(b[1] - a[1])
    east = math.radians(b[0] - a[0])
    cosines = math.cos(math.radians(a[1])) * math.cos(math.radians(b[1]))
    half = math.sin(north / 2.0) ** 2 + cosines * math.sin(east / 2.0) ** 2
    return 2.0 * 6371.0 * math.asin(math.sqrt(min(half, 1.0)))


def _unwrapped(line: tuple[Position, ...]) -> list[Position]:
    """The same positions, none more than half a turn of longitude from the one before."""
    found = [line[0]]
    for position in line[1:]:
        turns = round((position[0] - found[-1][0]) / 360.0)
        found.append((position[0] - 360.0 * turns, position[1]))
    return found


def _cross(a: Position, b: Position, c: Position, d: Position) -> bool:
    def side(p: Position, q: Position, r: Position) -> float:
        return (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])

    return side(a, b, c) * side(a, b, d) <= 0.0 and side(c, d, a) * side(c, d, b) <= 0.0


@spec
class GeoPolygon:
    """A GeoJSON polygon without holes: one closed ring of positions, degrees."""

    type: Literal["Polygon"] = "Polygon"
    coordinates: tuple[tuple[Position, ...], ...]

    def __post_init__(self) -> None:
        if len(self.coordinates) != 1:
            raise ValueError(f"a polygon has one ring and no holes, not {len(self.coordinates)}")
        ring = self.coordinates[0]
        if not 4 <= len(ring) <= 64 or ring[0] != ring[-1]:
            raise ValueError("a ring has 4 to 64 positions and ends where it begins")
        _check_positions(ring)


@spec
class ImagingRequest:
    """What every mode has.

    priority: worth of the whole request.  start: fixes the first look (else it is chosen).
    window_start, window_stop: the looks must lie inside.  height_m: of the ground above the
    ellipsoid.
    """

    name: str
    priority: Annotated[float, Within(1e-6, 1e6)] = 1.0
    scan_speed_m_s: Annotated[float, Within(500.0, 12e3)] = SCAN_SPEED_M_S
    height_m: Annotated[float, Within(-500.0, 9000.0)] = 0.0
    start: datetime | None = None
    window_start: datetime | None = None
    window_stop: datetime | None = None

    def __post_init__(self) -> None:
        if not self.name:
            raise ValueError("name must not be empty: the table's windows refer to it")
        for field in ("start", "window_start", "window_stop"):
            moment = getattr(self, field)
            if moment is not None:
                require_offset(field, moment)
        if self.window_start is not None and self.window_stop is not None:
            seconds = elapsed_s(self.window_stop, self.window_start)
            if seconds <= 0.0:
                raise ValueError(
                    f"window_stop ({utc_text(self.window_stop)}) must come after window_start "
                    f"({utc_text(self.window_start)})"
                )


@spec
class StripRequest(ImagingRequest):
    """One strip from the line's first to its last position (the sense is the planner's)."""

    mode: Literal["strip"] = "strip"
    geometry: GeoLineString

    def __post_init__(self) -> None:
        super().__post_init__()
        _two_positions(self.geometry)


@spec
class StereoRequest(ImagingRequest):
    """Two looks at one strip, from look_angle_deg ahead and behind."""

    mode: Literal["stereo"] = "stereo"
    geometry: GeoLineString
    look_angle_deg: Annotated[float, Within(2.0, 45.0)] = 24.0

    def __post_init__(self) -> None:
        super().__post_init__()
        _two_positions(self.geometry)


@spec
class AreaRequest(ImagingRequest):
    """A polygon covered by parallel strips of the camera's swath.

    azimuth_deg: of the strips, clockwise from north; None: along the ground track, or along a
    side of the polygon within 10 deg of it.
    """

    mode: Literal["area"] = "area"
    geometry: GeoPolygon
    azimuth_deg: Annotated[float, Within(-360.0, 360.0)] | None = None


@spec
class CorridorRequest(ImagingRequest):
    """A line of one or more legs at any angle to the track, each leg a look of its own."""

    mode: Literal["corridor"] = "corridor"
    geometry: GeoLineString


def _two_positions(line: GeoLineString) -> None:
    if len(line.coordinates) != 2:
        raise ValueError(
            f"this mode takes a line of two positions, not {len(line.coordinates)}; use a corridor"
        )


Request = Annotated[
    StripRequest | StereoRequest | AreaRequest | CorridorRequest, Field(discriminator="mode")
]
MODES = {"strip": StripRequest, "stereo": StereoRequest, "area": AreaRequest}
MODES["corridor"] = CorridorRequest


@spec
class SpacecraftSettings:
    """What a session may change about the spacecraft; the rest is its definition.

    rate_axis_max_deg_s: of each body axis in turns (the gyro reads 1.6).  torque_max_n_m: four
    gyros give 30 in every direction whatever they store; torque_rate_max_n_m_s: they can change
    that once in a control cycle of 0.2 s.  settle_s: on the profile before imaging.
    reversible_scan: the detector scans in both senses.
    momentum_n_m_s: stored in the gyros at the start, body axes.
    """

    rate_axis_max_deg_s: Annotated[float, Within(0.1, 3.5)] = 1.58
    torque_max_n_m: Annotated[float, Within(1.0, 30.0)] = 15.0
    torque_rate_max_n_m_s: Annotated[float, Within(1.0, 150.0)] = 40.0
    settle_s: Annotated[float, Within(*SETTLE_S)] = 2.6
    reversible_scan: bool = False
    swath_m: Annotated[float, Within(*SWATH_M)] = 12e3
    across_max_deg: Annotated[float, Within(*OFF_NADIR_DEG)] = 45.0
    along_max_deg: Annotated[float, Within(*OFF_NADIR_DEG)] = 30.0
    momentum_n_m_s: tuple[_MomentumPart, _MomentumPart, _MomentumPart] = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        self._slew()
        self._camera(Camera())

    def _slew(self) -> SlewLimits:
        return SlewLimits(
            rate_axis_rad_s=math.radians(self.rate_axis_max_deg_s),
            torque_n_m=self.torque_max_n_m,
            torque_rate_n_m_s=self.torque_rate_max_n_m_s,
            settle_s=self.settle_s,
        )

    def _camera(self, of: Camera) -> Camera:
        return Camera(
            pixel_rad=of.pixel_rad,
            tdi_lines=of.tdi_lines,
            swath_m=self.swath_m,
            reversible=self.reversible_scan,
            across_max_deg=self.across_max_deg,
            along_max_deg=self.along_max_deg,
        )

    def applied_to(self, spacecraft: AgileSpacecraft) -> AgileSpacecraft:
        """The spacecraft with these settings."""
        return AgileSpacecraft(
            name=spacecraft.name,
            inertia_kg_m2=spacecraft.inertia_kg_m2,
            array=spacecraft.array,
            modes=spacecraft.modes,
            sensors=spacecraft.sensors,
            gains=spacecraft.gains,
            slew=self._slew(),
            camera=self._camera(spacecraft.camera),
        )


@spec
class ImagingPlanRequest:
    """A session of the imaging spacecraft.

    Row 0 of the table is at `start` (a multiple of 0.2 s after its UTC second), in orbital
    orientation, or at rest in the inertial attitude `initial_q_body_from_eci_xyzw`, which is
    left for orbital orientation at once; the session ends by `stop`, in orbital orientation.
    simulation_runs: dispersed closed-loop runs behind the stabilisation report; seed: theirs.
    """

    name: str = ""
    orbit: Orbit
    spacecraft: str = "agile-cmg"
    settings: SpacecraftSettings = SpacecraftSettings()
    start: datetime
    stop: datetime
    initial_q_body_from_eci_xyzw: tuple[UnitPart, UnitPart, UnitPart, UnitPart] | None = None
    requests: tuple[Request, ...]
    objective: TurnObjective = "smooth"
    simulation_runs: Annotated[int, Within(0, 100)] = 4
    seed: Annotated[int, Within(0, 2**32 - 1)] = 0

    def __post_init__(self) -> None:
        if self.spacecraft not in SPACECRAFT:
            raise ValueError(
                f"spacecraft {self.spacecraft!r} is unknown; there is {', '.join(SPACECRAFT)}"
            )
        require_offset("start", self.start)
        require_offset("stop", self.stop)
        seconds = elapsed_s(self.stop, self.start)
        if not 10.0 <= seconds <= SESSION_MAX_S:
            raise ValueError(
                f"a session lasts 10 to {SESSION_MAX_S:.0f} s from start to stop, not "
                f"{seconds:.1f} s; split it"
            )
        if self.start.microsecond % 200_000:
            raise ValueError(
                f"start ({utc_text(self.start, 6)}) must be a multiple of 0.2 s after its second"
            )
        q = self.initial_q_body_from_eci_xyzw
        if q is not None and abs(math.hypot(*q) - 1.0) > 1e-4:
            raise ValueError(
                f"initial_q_body_from_eci_xyzw must have unit length, not {math.hypot(*q):.6g}"
            )
        self._check_requests()

    def _check_requests(self) -> None:
        if not 1 <= len(self.requests) <= 200:
            raise ValueError(f"requests must hold 1 to 200 of them, not {len(self.requests)}")
        names = [request.name for request in self.requests]
        twice = next((name for name in names if names.count(name) > 1), None)
        if twice is not None:
            raise ValueError(f"two requests are named {twice!r}; names must differ")

    def definition(self) -> AgileSpacecraft:
        """The spacecraft with the session's settings."""
        return self.settings.applied_to(SPACECRAFT[self.spacecraft])
