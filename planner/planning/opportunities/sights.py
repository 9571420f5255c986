"""Targets as compiled code looks at them: those at rest together, any other by itself."""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Protocol

import numpy as np

from planner.base.arrays import Array, Indices
from planner.base.interpolation import NODES, UniformTable
from planner.planning.opportunities.carrier import Carrier
from planner.planning.opportunities.looks import Places
from planner.planning.opportunities.telling import look_each, places_each
from planner.world.frames.earth_orientation import c_itrf_from_eci
from planner.world.frames.geodesy import geodetic_from_itrf, up_itrf
from planner.world.frames.time_scales import Instants, shifted_utc
from planner.world.platforms import RollRule
from planner.world.targets import (
    ChosenTarget,
    EarthFixedTarget,
    GroundPathTarget,
    ImagingMode,
    SkyTarget,
    Target,
    VisibleTarget,
)
from planner.world.targets.refraction import bending_spline


@dataclass(frozen=True, kw_only=True)
class TrackOptions:
    """How finely what isn't at rest on the Earth is tabulated."""

    # by which every other row may fail to tell the rest; the table does so 64 times better
    place_error_m: float = 0.1
    direction_error_rad: float = 1e-8
    step_min_s: float = 1.0
    scan_step_s: float = 2.0  # of a line, which goes straight on


OPTIONS = TrackOptions()


class Wanted(Protocol):
    """A target of a request.

    roll: the rule by which a body lies on it, if not by the platform's.
    """

    @property
    def target(self) -> ChosenTarget: ...

    @property
    def roll(self) -> RollRule | None: ...


@dataclass(frozen=True, eq=False)
class Sighting:
    """What the carrier sees of n targets.

    direction_itrf, los_base: unit vectors from the carrier, light time and aberration included,
    (n, 3).  range_m: (n,).  elevation_rad: of the carrier in the target's sky; for a target in
    space its height above the limb raised by the grazing altitude, (n,).  sun_elevation_rad: of
    the Sun's centre in the target's sky, without refraction; NaN in space, (n,).
    """

    direction_itrf: Array
    los_base: Array
    range_m: Array
    elevation_rad: Array
    sun_elevation_rad: Array


@dataclass(frozen=True, eq=False)
class Sight:
    """Targets that are looked at alike, numbered by `which` (n,), at t_s (n,) of the carrier.

    roll: as of `Wanted`.
    """

    carrier: Carrier
    targets: Sequence[EarthFixedTarget | SkyTarget]
    places: Places
    roll: RollRule | None = None

    @property
    def on_earth(self) -> bool:
        return not self.places.in_space

    @cached_property
    def images(self) -> bool:
        """Whether they are looked at to be imaged."""
        return all(target.images for target in self.targets)

    def sighting(self, which: Indices, t_s: Array) -> Sighting:
        """What is seen of them."""
        directions, values = look_each(self.carrier.tables, self.places, which, t_s)
        return Sighting(directions[:, :3], directions[:, 3:], *np.ascontiguousarray(values.T))

    def r_target_itrf_m(self, which: Indices, t_s: Array) -> Array:
        """Where they are, (n, 3), on the Earth."""
        return places_each(self.places, which, t_s)


def sights_of(
    carrier: Carrier, targets: Sequence[Wanted], least_rad: Array, most: int
) -> Iterator[tuple[Indices, Sight]]:
    """All targets but imaging modes: rows of those seen alike, at most so many, and how.

    least_rad: (targets,), elevation or height above the limb.
    """
    at_rest: dict[tuple[RollRule | None, bool], list[int]] = {}
    for row, wanted in enumerate(targets):
        if _rests(wanted.target):
            at_rest.setdefault((wanted.roll, wanted.target.images), []).append(row)
    for (roll, _), alike in at_rest.items():
        for first in range(0, len(alike), most):
            rows = np.array(alike[first : first + most])
            sight = resting_sight(carrier, [targets[row].target for row in rows], least_rad[rows])
            yield rows, replace(sight, roll=roll)
    for row, wanted in enumerate(targets):
        if not (_rests(wanted.target) or isinstance(wanted.target, ImagingMode)):
            sight = _lone_sight(carrier, wanted.target, float(least_rad[row]))
            yield np.array([row]), replace(sight, roll=wanted.roll)


def in_sights(
    target: Indices, targets: Sequence[Wanted], carrier: Carrier
) -> Iterator[tuple[Indices, Sight, Indices]]:
    """Group rows of one target each, (n,): those seen alike, how, and each one's number in it.

    Whatever elevation the targets ask for.
    """
    asked, which = np.unique(target, return_inverse=True)
    chosen = [targets[n] for n in asked.tolist()]
    for numbers, sight in sights_of(carrier, chosen, np.zeros(len(asked)), max(len(asked), 1)):
        place = np.searchsorted(numbers, which)
        rows = np.flatnonzero(numbers[np.minimum(place, len(numbers) - 1)] == which)
        yield rows, sight, place[rows]


def resting_sight(carrier: Carrier, targets: Sequence[EarthFixedTarget], least_rad: Array) -> Sight:
    """Any number of points at rest on the ground."""
    at_start = Instants(carrier.start_utc, np.zeros(1))
    r_itrf_m = np.concatenate(
        [np.empty((0, 3)), *(target.r_target_itrf_m(at_start) for target in targets)]
    )
    resting = np.concatenate([r_itrf_m, _up_itrf(r_itrf_m), least_rad[:, None]], axis=1)
    return Sight(carrier, targets, _places(resting, 0.0, np.empty((0, 6, 6))))


def _rests(target: ChosenTarget) -> bool:
    return target.rests_on_earth and isinstance(target, EarthFixedTarget)


def _lone_sight(carrier: Carrier, target: Target, least_rad: float) -> Sight:
    resting = np.concatenate([np.zeros(6), [least_rad]])[None]
    if isinstance(target, EarthFixedTarget):

        def place(instants: Instants) -> Array:
            r_itrf_m = target.r_target_itrf_m(instants)
            return np.concatenate([r_itrf_m, _up_itrf(r_itrf_m)], axis=1)

        track = _track(carrier, place, OPTIONS.place_error_m)
        return Sight(carrier, [target], _places(resting, track.step_s, track.powers))
    assert isinstance(target, SkyTarget), f"a {target.mode} has no windows"

    def direction(instants: Instants) -> Array:
        c_itrf = c_itrf_from_eci(instants)
        direction_eci, range_m = target.arriving(instants, carrier.states(instants))
        direction_itrf = np.einsum("nij,nj->ni", c_itrf, direction_eci)
        return np.concatenate([direction_itrf, 1.0 / range_m[:, None]], axis=1)

    track = _track(carrier, direction, OPTIONS.direction_error_rad)
    places = _places(resting, track.step_s, track.powers)._replace(
        in_space=True, grazing_m=target.grazing_altitude_km * 1e3
    )
    if target.refraction == "standard":
        places = places._replace(bending_coefficients=bending_spline())
    return Sight(carrier, [target], places)


def scan_sight(
    carrier: Carrier,
    path: GroundPathTarget,
    roll: RollRule | None,
    begins_s: Array,
    around_s: float,
) -> Sight:
    """A line as it is scanned, numbered by when that begins (n,); it goes straight on for around_s
    before and after."""
    path = path.starting(shifted_utc(carrier.start_utc, around_s))
    span_s = path.duration_s + 2.0 * around_s
    cells = max(math.ceil(span_s / OPTIONS.scan_step_s), NODES + 1)
    r_itrf_m = path.r_target_itrf_m(
        Instants(carrier.start_utc, np.linspace(0.0, span_s, cells + 1))
    )
    track = UniformTable(span_s / cells, np.concatenate([r_itrf_m, _up_itrf(r_itrf_m)], axis=1))
    resting = np.concatenate([np.zeros(6), [math.radians(path.min_elevation_deg)]])[None]
    places = _places(resting, track.step_s, track.powers)._replace(begins_s=begins_s - around_s)
    return Sight(carrier, [path], places, roll)


def _places(resting_parameters: Array, step_s: float, track_coefficients: Array) -> Places:
    return Places(
        resting_parameters=np.ascontiguousarray(resting_parameters),
        in_space=False,
        step_s=step_s,
        track=np.ascontiguousarray(track_coefficients),
        grazing_m=0.0,
        bending_coefficients=np.empty((5, 0)),
        begins_s=np.zeros(1),
    )


def _track(carrier: Carrier, of: Callable[[Instants], Array], error: float) -> UniformTable:
    """Rows as fine as needed: every other row must predict the rest."""
    cells = 2 * math.ceil((len(carrier.orbit.powers) + 1) / 2)
    while True:
        t_s = np.linspace(0.0, carrier.span_s, cells + 1)
        rows = of(Instants(carrier.start_utc, t_s))
        off = UniformTable(2.0 * float(t_s[1]), rows[::2]).at(t_s)[:, :3] - rows[:, :3]
        if np.abs(off).max() <= error or t_s[1] <= OPTIONS.step_min_s:
            return UniformTable(float(t_s[1]), rows)
        cells *= 2


def _up_itrf(r_itrf_m: Array) -> Array:
    latitude_rad, longitude_rad, _ = geodetic_from_itrf(r_itrf_m)
    return up_itrf(latitude_rad, longitude_rad)


def visible_target(sight: Sight, which: Indices) -> VisibleTarget:
    """Targets `which` (n,) as one target, a place per instant."""
    if sight.on_earth and sight.places.step_s == 0.0:
        return _Places(sight.places.resting_parameters[which, :3])
    return sight.targets[0]


class _Places(EarthFixedTarget):
    """A place at rest for each instant, whose number may be asked for several times over."""

    min_elevation_deg = 0.0
    refraction = "none"

    def __init__(self, r_itrf_m: Array) -> None:
        self._r_itrf_m = r_itrf_m

    def r_target_itrf_m(self, instants: Instants) -> Array:
        """Shape (n, 3)."""
        return np.tile(self._r_itrf_m, (len(instants) // len(self._r_itrf_m), 1))
