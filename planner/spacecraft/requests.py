"""Requests to the imaging spacecraft: their fields, in degrees and GeoJSON."""

import math
from dataclasses import dataclass, replace
from datetime import datetime
from typing import Annotated, Any, Literal

from pydantic import Field

from planner.base.answer_members import Count
from planner.base.commands import COMMAND_STEP_S
from planner.base.errors import figures
from planner.base.spec import UnitPart, Within, spec
from planner.spacecraft.vehicle import OPTIONS, SPACECRAFT, AgileSpacecraft, SlewObjective
from planner.world.frames.time_scales import elapsed_s, utc_text
from planner.world.orbits import Orbit
from planner.world.platforms.cmg_array import Positive
from planner.world.targets.geojson import GeoLineString, GeoPolygon
from planner.world.targets.imaging import IMAGING_MODES, ImagingMode

_OffNadirDeg = Annotated[float, Within(0.1, 60.0)]
_MomentumPart = Annotated[float, Within(-1e9, 1e9)]  # the spacecraft's sphere decides
SESSION_MAX_S = 3600.0
_OF_LOOKS = ("swath_m", "across_max_deg", "along_max_deg")
_OF_MODES = ("geometry", "azimuth_deg", "look_angle_deg", "gap_s")
SCAN_SPEED_M_S = 60e3 / 11.0  # Platonov, Sumarokov 2019: a strip of 60 km in about 11 s


@spec
class ImagingRequest:
    """What every mode has.

    name: your name for it, different from the others'; the answer uses it.
    priority: worth of the whole request.
    scan_speed_m_s: of the scanned line over the ground.
    height_m: of the ground above the ellipsoid.
    start: of the first look, to the nearest 0.2 s; UTC, chosen unless given.
        E.g. `"2024-06-01T10:01:26Z"`.
    window_start: the looks must not begin earlier; UTC. E.g. `"2024-06-01T10:01:00Z"`.
    window_stop: the looks must not end later; UTC. E.g. `"2024-06-01T10:03:00Z"`.
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
        begin, end = self.window_start, self.window_stop
        if begin is not None and end is not None and elapsed_s(end, begin) <= 0.0:
            raise ValueError(
                f"window_stop ({utc_text(end)}) must come after window_start ({utc_text(begin)})"
            )
        self.as_mode()

    def as_mode(self) -> ImagingMode:
        """What says the same of a session of any platform.  Raises ValueError."""
        own = vars(self)
        return IMAGING_MODES[own["mode"]](
            speed_m_s=self.scan_speed_m_s,
            height_m=self.height_m,
            line="plane",
            **{name: own[name] for name in _OF_MODES if name in own},
        )


@spec
class StripRequest(ImagingRequest):
    """One strip from the line's first to its last position (the sense is the planner's)."""

    mode: Literal["strip"] = "strip"
    geometry: GeoLineString


@spec
class StereoRequest(ImagingRequest):
    """Two looks at one strip, from ahead and behind.

    look_angle_deg: from nadir along the track, ahead in the first look and behind in the second;
        24 where gap_s isn't given either.  E.g. `24.0`.
    gap_s: from the first look's start to the second's, to the nearest 0.2 s; half of it before and
        half after the strip is passed, or all of it from `start` on.  E.g. `110.0`.
    """

    mode: Literal["stereo"] = "stereo"
    geometry: GeoLineString
    look_angle_deg: Annotated[float, Within(2.0, 45.0)] | None = None
    gap_s: Annotated[float, Within(1.0, 600.0)] | None = None


@spec
class AreaRequest(ImagingRequest):
    """A polygon covered by parallel strips of the camera's swath.

    azimuth_deg: of the strips, clockwise from north; null: along the ground track, or along a side
    of the polygon within 10 deg of it. E.g. `15.0`.
    """

    mode: Literal["area"] = "area"
    geometry: GeoPolygon
    azimuth_deg: Annotated[float, Within(-360.0, 360.0)] | None = None


@spec
class CorridorRequest(ImagingRequest):
    """A line of one or more legs at any angle to the track, each leg a look of its own."""

    mode: Literal["corridor"] = "corridor"
    geometry: GeoLineString


@dataclass(frozen=True, kw_only=True)
class LeftOut:
    """A request that isn't imaged, and why.

    name: the request's. E.g. `"strip"`.
    reason: the obstacle. E.g. `"others are worth more"`.
    """

    name: str
    reason: str


@dataclass(frozen=True, kw_only=True)
class ImagingWindow:
    """One stretch of imaging, with the camera on at both rows.

    request: name of the request it belongs to.
    look: number of the strip, look or leg within the request, from 0.
    first_row: its number, from 0.
    last_row: its number, from 0.
    """

    request: str
    look: Count
    first_row: Count
    last_row: Count


Request = Annotated[
    StripRequest | StereoRequest | AreaRequest | CorridorRequest, Field(discriminator="mode")
]


@spec
class SpacecraftSettings:
    """Settings of the spacecraft that a session may change; the rest is its definition.

    What isn't given is the spacecraft's own; of `agile-cmg` 1.58 deg/s, 15 N m, 40 N m/s, 2.6 s, no
    reversible scan, 12 km, 45 and 30 deg.

    rate_axis_max_deg_s: of each body axis in slews (the gyro of `agile-cmg` reads 1.6).
    E.g. `1.58`.
    torque_max_n_m: in slews; the gyros of `agile-cmg` give 30 in every direction. E.g. `15.0`.
    torque_rate_max_n_m_s: in slews; the gyros can change their torque once in a control cycle of
    0.2 s. E.g. `40.0`.
    settle_s: between the end of a slew and imaging, on the profile already. E.g. `2.6`.
    reversible_scan: the detector scans in both senses.
    swath_m: ground width imaged at nadir. E.g. `12000.0`.
    across_max_deg: farthest the camera looks to the side of the track. E.g. `45.0`.
    along_max_deg: farthest the camera looks ahead and behind. E.g. `30.0`.
    momentum_n_m_s: stored in the gyros at the start, body axes.
    """

    rate_axis_max_deg_s: Annotated[float, Within(1e-3, 180.0)] | None = None
    torque_max_n_m: Positive | None = None
    torque_rate_max_n_m_s: Positive | None = None
    settle_s: Annotated[float, Within(0.0, 60.0)] | None = None
    reversible_scan: bool | None = None
    swath_m: Annotated[float, Within(100.0, 500e3)] | None = None
    across_max_deg: _OffNadirDeg | None = None
    along_max_deg: _OffNadirDeg | None = None
    momentum_n_m_s: tuple[_MomentumPart, _MomentumPart, _MomentumPart] = (0.0, 0.0, 0.0)

    def applied_to(self, spacecraft: AgileSpacecraft) -> AgileSpacecraft:
        """The spacecraft with these settings.  Raises ValueError where it can't keep one."""
        torque_n_m = spacecraft.gyros.array.cmg_array.torque_n_m
        for name, least, most in (
            ("rate_axis_max_deg_s", OPTIONS.rate_least_deg_s, spacecraft.rate_max_deg_s),
            ("torque_max_n_m", 0.0, torque_n_m),
            ("torque_rate_max_n_m_s", 0.0, torque_n_m / COMMAND_STEP_S),
        ):
            value = getattr(self, name)
            if value is not None and not least <= value <= most * (1.0 + 1e-9):  # rounding
                raise ValueError(
                    f"settings.{name} ({figures(value, most)}) is less than the {least:.4g} that "
                    f"orbital orientation needs or more than the {most:.4g} that "
                    f"{spacecraft.name!r} can do; ask for another, or leave it out"
                )
        rate_deg_s = self.rate_axis_max_deg_s
        asked = _given(
            rate_max_deg_s=None if rate_deg_s is None else spacecraft.rate_deg_s(rate_deg_s),
            torque_max_n_m=self.torque_max_n_m,
            torque_rate_max_n_m_s=self.torque_rate_max_n_m_s,
            settle_s=self.settle_s,
        )
        turns = replace(spacecraft.gyros.turns, **asked)
        line = replace(spacecraft.body.camera, **_given(both_ways=self.reversible_scan))
        try:
            gyros = replace(spacecraft.gyros, turns=turns)
            body = replace(spacecraft.body, camera=line, gyros=gyros)
        except ValueError:
            raise ValueError(
                f"settings.torque_max_n_m ({turns.torque_max_n_m:g}) and torque_rate_max_n_m_s "
                f"({turns.torque_rate_max_n_m_s:g}) leave no torque for a turn while the momentum "
                f"of the gyros is turned at {turns.rate_max_deg_s:g} deg/s: ask for more, or for a "
                "lower rate_axis_max_deg_s"
            ) from None
        looks = {name: getattr(self, name) for name in _OF_LOOKS}
        return replace(spacecraft, body=body, **_given(**looks))


def _given(**asked: float | None) -> dict[str, Any]:
    """Of what is asked, that which isn't None."""
    return {name: value for name, value in asked.items() if value is not None}


@spec
class ImagingPlanRequest:
    """A session of the imaging spacecraft.

    Row 0 of the table is at `start`, in orbital orientation, or at rest in the inertial attitude
    `initial_q_body_from_eci_xyzw`, which is left at once; the session ends by `stop`, in orbital
    orientation.

    name: your name for it, repeated in the plan and its files.
    spacecraft: by its registered name.
    start: row 0 of the table; UTC, a whole multiple of 0.2 s after its second.
    stop: by when the spacecraft is back in orbital orientation; UTC.
    initial_q_body_from_eci_xyzw: attitude at rest at the start, scalar last, as SciPy's `Rotation`
    that carries ECI onto body axes; orbital orientation unless given. E.g. `[0.0, 0.0, 0.0, 1.0]`.
    requests: the requests to be imaged; those that don't fit are left out.
    objective: of slews: `smooth` spends the least torque rate in the time there is, `minimum_time`
    takes the quickest found within the limits.
    simulation_runs: dispersed closed-loop runs behind the stabilisation report.
    seed: of the dispersions; the same gives the same runs.
    """

    name: str = ""
    orbit: Orbit
    spacecraft: str = "agile-cmg"
    settings: SpacecraftSettings = SpacecraftSettings()
    start: datetime
    stop: datetime
    initial_q_body_from_eci_xyzw: tuple[UnitPart, UnitPart, UnitPart, UnitPart] | None = None
    requests: tuple[Request, ...]
    objective: SlewObjective = "smooth"
    simulation_runs: Annotated[int, Within(0, 100)] = 4
    seed: Annotated[int, Within(0, 2**32 - 1)] = 0

    def __post_init__(self) -> None:
        if self.spacecraft not in SPACECRAFT:
            raise ValueError(
                f"spacecraft {self.spacecraft!r} is unknown; there is {', '.join(SPACECRAFT)}"
            )
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
        if not 1 <= len(self.requests) <= 200:
            raise ValueError(f"requests must hold 1 to 200 of them, not {len(self.requests)}")
        names = [request.name for request in self.requests]
        twice = next((name for name in names if names.count(name) > 1), None)
        if twice is not None:
            raise ValueError(f"two requests are named {twice!r}; names must differ")
        self.definition()

    def definition(self) -> AgileSpacecraft:
        """The spacecraft with the session's settings."""
        return self.settings.applied_to(SPACECRAFT[self.spacecraft])
