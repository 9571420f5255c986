"""Conditions of light and view that a look must meet, and by how much it meets them."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, Literal, NamedTuple

import numpy as np

from planner.base.arrays import Array, angle_rad, cross
from planner.base.errors import figures
from planner.base.rotation import Rotation
from planner.base.spec import Within, spec
from planner.world.exclusions import TITLES, Surroundings
from planner.world.frames.earth_orientation import OMEGA_EARTH_RAD_S, c_itrf_from_eci
from planner.world.frames.geodesy import geodetic_from_itrf, up_itrf
from planner.world.frames.time_scales import Instants
from planner.world.orbits import OrbitStates
from planner.world.orbits.period import period_s
from planner.world.platforms.kept_direction import KeptDirection, unit_vector
from planner.world.targets.apparent import VisibleTarget, aberrate
from planner.world.targets.body import HIDDEN_RAD, BodyTarget
from planner.world.targets.earth_fixed import EarthFixedTarget
from planner.world.targets.ground_sample import sample_along_m
from planner.world.targets.session_target import SessionTarget

_SUN, _MOON = (BodyTarget(name=name, grazing_altitude_km=0.0) for name in ("sun", "moon"))


@dataclass(frozen=True, kw_only=True)
class ConditionOptions:
    """How nearly a condition is kept."""

    tolerance: float = 2e-5  # deg or m: what the fastest of them changes by in 20 us
    span_max_s: float = 604_800.0  # of a duty cycle: a week
    directions_max: int = 16  # as many as a body has exclusions


OPTIONS = ConditionOptions()
CadenceName = Literal["min_gap", "duty_cycle"]
ConditionName = Literal[
    "elevation",
    "off_nadir",
    "ground_sample",
    "sun_elevation",
    "glint",
    "sun_keep_out",
    "moon_keep_out",
    "carrier_light",
    "direction",
]


@spec
class DutyCycle:
    """A limit on imaging in any span of time that lasts so long, wherever it begins.

    imaging_max_s: the most that sessions which look somewhere may last in it, together. E.g.
    `600.0`.
    span_s: of the span; unless given one revolution, by the orbit's energy. E.g. `5560.0`.
    """

    imaging_max_s: Annotated[float, Within(0.2, OPTIONS.span_max_s)]
    span_s: Annotated[float, Within(1.0, OPTIONS.span_max_s)] | None = None

    def __post_init__(self) -> None:
        if self.span_s is not None and self.imaging_max_s > self.span_s:
            raise ValueError(
                f"imaging_max_s must be span_s, {self.span_s:g}, or less, not "
                f"{self.imaging_max_s:g}: no more fits into it"
            )

    def lasts_s(self, instants: Instants, states: OrbitStates) -> float:
        """Its span, on an orbit as it is at one instant."""
        if self.span_s is not None:
            return self.span_s
        return min(float(period_s(instants, states)[0]), OPTIONS.span_max_s)


@spec
class Conditions:
    """Conditions that hold throughout a look, and among looks.

    Those of off nadir, ground sample, the Sun's elevation and glint apply to targets on the Earth
    only.

    min_elevation_deg: of the carrier in the target's sky, on top of the target's own least
    elevation (the greater counts); without refraction.  Of a target in space above the limb. E.g.
    `30.0`.
    max_off_nadir_deg: largest angle of the line of sight from the geocentric nadir; any unless
    given. E.g. `45.0`.
    max_ground_sample_m: largest ground sample distance, along the lean of the line of sight; any
    unless given. E.g. `2.0`.
    sun_elevation_min_deg: least elevation of the Sun's centre at the target, without refraction:
    daylight. E.g. `10.0`.
    sun_elevation_max_deg: greatest elevation of the Sun's centre at the target, without refraction:
    night. E.g. `-6.0`.
    glint_keep_out_deg: least angle, at the target, between the direction to the carrier and the one
    in which level water mirrors the Sun, while that is up. E.g. `25.0`.
    sun_keep_out_deg: least angle between line of sight and the Sun's centre, wherever the Earth
    doesn't hide it. E.g. `20.0`.
    moon_keep_out_deg: least angle between line of sight and the Moon's centre, wherever the Earth
    doesn't hide it. E.g. `10.0`.
    carrier_light: `sunlit` while the carrier sees the Sun's centre above the limb, `eclipsed` while
    it doesn't; without air. Either unless given. E.g. `"sunlit"`.
    directions: up to 16 directions of the body, or of the carrier that two axes stand on, or of
    the line of sight (`of` camera), that keep away from something or stay near it.
    min_gap_s: least time from the end of one look to the start of the next.
    duty_cycle: limit on imaging in any span of time.
    """

    min_elevation_deg: Annotated[float, Within(0.0, 90.0)] = 0.0
    max_off_nadir_deg: Annotated[float, Within(0.0, 180.0)] | None = None
    max_ground_sample_m: Annotated[float, Within(1e-3, 1e5)] | None = None
    sun_elevation_min_deg: Annotated[float, Within(-90.0, 90.0)] | None = None
    sun_elevation_max_deg: Annotated[float, Within(-90.0, 90.0)] | None = None
    glint_keep_out_deg: Annotated[float, Within(0.0, 180.0)] | None = None
    sun_keep_out_deg: Annotated[float, Within(0.0, 180.0)] | None = None
    moon_keep_out_deg: Annotated[float, Within(0.0, 180.0)] | None = None
    carrier_light: Literal["sunlit", "eclipsed"] | None = None
    directions: tuple[KeptDirection, ...] = ()
    min_gap_s: Annotated[float, Within(0.0, 86_400.0)] = 0.0
    duty_cycle: DutyCycle | None = None

    def __post_init__(self) -> None:
        low, high = self.sun_elevation_min_deg, self.sun_elevation_max_deg
        if low is not None and high is not None and not low < high:
            raise ValueError(
                f"sun_elevation_min_deg ({low:g}) must be less than sun_elevation_max_deg "
                f"({high:g}), or the Sun never stands between them"
            )
        names = [one.name for one in self.directions]
        if len(names) > OPTIONS.directions_max:
            raise ValueError(
                f"directions must hold at most {OPTIONS.directions_max} directions, not "
                f"{len(names)}"
            )
        for number, name in enumerate(names):
            if name in names[:number]:
                raise ValueError(f"directions.{number}.name must be of its own, not {name!r} again")

    @property
    def bounds(self) -> tuple["ConditionBound", ...]:
        """Each that is asked for, in the order of the fields."""
        named: tuple[tuple[ConditionName, str, float | None, bool], ...] = (
            ("elevation", "min_elevation_deg", self.min_elevation_deg or None, True),
            ("off_nadir", "max_off_nadir_deg", self.max_off_nadir_deg, False),
            ("ground_sample", "max_ground_sample_m", self.max_ground_sample_m, False),
            ("sun_elevation", "sun_elevation_min_deg", self.sun_elevation_min_deg, True),
            ("sun_elevation", "sun_elevation_max_deg", self.sun_elevation_max_deg, False),
            ("glint", "glint_keep_out_deg", self.glint_keep_out_deg, True),
            ("sun_keep_out", "sun_keep_out_deg", self.sun_keep_out_deg, True),
            ("moon_keep_out", "moon_keep_out_deg", self.moon_keep_out_deg, True),
            (
                "carrier_light",
                "carrier_light",
                None if self.carrier_light is None else 0.0,
                self.carrier_light == "sunlit",
            ),
        )
        plain = (
            ConditionBound(name, field, limit, is_least)
            for name, field, limit, is_least in named
            if limit is not None
        )
        directed = (
            ConditionBound(
                "direction",
                f"directions.{one.name}",
                (one.max_deg if one.min_deg is None else one.min_deg) or 0.0,
                one.min_deg is not None,
                one,
            )
            for one in self.directions
        )
        return (*plain, *directed)


# The value of each, for a sentence.
_TOLD: dict[ConditionName, str] = {
    "elevation": "the elevation",
    "off_nadir": "the angle off nadir",
    "ground_sample": "the ground sample",
    "sun_elevation": "the Sun's elevation at the target",
    "glint": "the angle from sunglint",
    "sun_keep_out": "the angle from the Sun",
    "moon_keep_out": "the angle from the Moon",
}
_ON_EARTH_ONLY = frozenset({"off_nadir", "ground_sample", "sun_elevation", "glint"})


class ConditionBound(NamedTuple):
    """One condition that is asked for.

    field: of `Conditions`.  limit: in deg or m, of the Sun above the limb 0.
    is_least: whether the value may not be below it, else not above.  kept: of a direction.
    """

    name: ConditionName
    field: str
    limit: float
    is_least: bool
    kept: KeptDirection | None = None

    @property
    def unit(self) -> str:
        return "m" if self.name == "ground_sample" else "deg"

    def applies_to(self, target: SessionTarget) -> bool:
        """Whether it says anything of such a target."""
        is_on_earth = isinstance(target, EarthFixedTarget)
        return target.images and (is_on_earth or self.name not in _ON_EARTH_ONLY)

    def margin(self, value: Array) -> Array:
        """By how much values (n,) keep it, in its unit."""
        return value - self.limit if self.is_least else self.limit - value

    def unmet_because(self, value: float) -> str:
        """Why a value doesn't keep it, for a refusal."""
        if self.name == "carrier_light":
            light = "eclipsed" if self.is_least else "in sunlight"
            return f"the carrier is {light}, which carrier_light rules out"
        told, side = figures(value, self.limit), "below" if self.is_least else "above"
        what = _TOLD.get(self.name, "the angle")
        if self.kept is not None:
            what = f"the angle of {self.kept.name} from {TITLES[self.kept.body]}"
        return (
            f"{what} is {told} {self.unit}, {side} the {self.limit:g} {self.unit} of {self.field}"
        )


class ConditionSeen(NamedTuple):
    """A condition at n instants: its value (n,), and its margin (n,), in its unit."""

    bound: ConditionBound
    value: Array
    margin: Array


def conditions_seen(
    conditions: Conditions,
    target: VisibleTarget,
    instants: Instants,
    states: OrbitStates,
    pixel_rad: float,
    q_carrier_from_eci: Rotation | None,
) -> Iterator[ConditionSeen]:
    """Each that applies to a target, at n instants; pixel_rad: angle that a pixel sees.

    q_carrier_from_eci: of the carrier that two axes stand on, n rotations; None of a body, whose
    directions its attitude keeps as exclusions.
    """
    bounds = [
        bound
        for bound in conditions.bounds
        if bound.applies_to(target) and (bound.kept is None or q_carrier_from_eci is not None)
    ]
    if not bounds:
        return
    view = _View(target, instants, states)
    for bound in bounds:
        if bound.kept is not None and q_carrier_from_eci is not None:
            margin = np.rad2deg(view.kept_margin_rad(bound.kept, q_carrier_from_eci))
            value = bound.limit + margin if bound.is_least else bound.limit - margin
            yield ConditionSeen(bound, value, margin)
            continue
        value, counts = view.value(bound.name, pixel_rad)
        margin = bound.margin(value)
        yield ConditionSeen(bound, value, margin if counts is None else np.maximum(margin, counts))


class _View:
    """A target, seen from the orbit's states at the same n instants."""

    def __init__(self, target: VisibleTarget, instants: Instants, states: OrbitStates) -> None:
        self.target, self.instants, self.states = target, instants, states
        self.seen = target.apparent(instants, states)

    def kept_margin_rad(self, kept: KeptDirection, q_carrier_from_eci: Rotation) -> Array:
        direction_eci = self.seen.direction_eci
        if kept.direction_body is not None:
            direction_eci = q_carrier_from_eci.inv().apply(unit_vector(kept.direction_body))
        return Surroundings(self.instants, self.states).kept_margin_rad(kept, direction_eci)

    def value(self, name: ConditionName, pixel_rad: float) -> tuple[Array, Array | None]:
        """In deg or m, and the least margin that it has anyway, since it may not count."""
        if name in ("sun_keep_out", "moon_keep_out"):
            body = _SUN if name == "sun_keep_out" else _MOON
            there = body.apparent(self.instants, self.states)
            away_rad = angle_rad(self.seen.direction_eci, there.direction_eci)
            return np.rad2deg(away_rad), np.rad2deg(-HIDDEN_RAD - there.clearance_rad)
        if name == "carrier_light":
            return np.rad2deg(_SUN.apparent(self.instants, self.states).clearance_rad), None
        if name == "off_nadir":
            return np.rad2deg(angle_rad(self.seen.direction_eci, -self.states.r_sat_eci_m)), None
        if not isinstance(self.target, EarthFixedTarget):  # its height above the limb
            return np.rad2deg(self.seen.clearance_rad), None
        return self._on_earth(self.target, name, pixel_rad)

    def _on_earth(
        self, target: EarthFixedTarget, name: ConditionName, pixel_rad: float
    ) -> tuple[Array, Array | None]:
        least_rad = math.radians(target.min_elevation_deg)
        elevation_rad = self.seen.clearance_rad + least_rad
        if name == "elevation":
            return np.rad2deg(elevation_rad), None
        if name == "ground_sample":
            sample_m = sample_along_m(np.sin(elevation_rad), self.seen.range_m, pixel_rad)
            return np.nan_to_num(sample_m, nan=math.inf), None
        c = c_itrf_from_eci(self.instants)
        r_itrf_m = target.r_target_itrf_m(self.instants)
        latitude_rad, longitude_rad, _ = geodetic_from_itrf(r_itrf_m)
        r_eci_m, up_eci = (
            np.einsum("nji,nj->ni", c, vector)
            for vector in (r_itrf_m, up_itrf(latitude_rad, longitude_rad))
        )
        v_eci_m_s = cross(OMEGA_EARTH_RAD_S * c[:, 2, :], r_eci_m)
        arriving, _ = _SUN.arriving(self.instants, OrbitStates(r_eci_m, v_eci_m_s))
        sun_eci = aberrate(arriving, v_eci_m_s)
        sine = np.sum(sun_eci * up_eci, axis=1)
        sun_deg = np.rad2deg(np.arcsin(np.clip(sine, -1.0, 1.0)))
        if name == "sun_elevation":
            return sun_deg, None
        mirrored_eci = 2.0 * sine[:, None] * up_eci - sun_eci
        return np.rad2deg(angle_rad(mirrored_eci, self.states.r_sat_eci_m - r_eci_m)), -sun_deg
