"""The geometry between many targets and the carrier, each at its own instants."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Array, Indices
from planner.planning.opportunities.carrier import Carrier
from planner.world.frames.earth_orientation import OMEGA_EARTH_RAD_S, c_itrf_from_eci
from planner.world.frames.geodesy import geodetic_from_itrf, up_itrf
from planner.world.frames.time_scales import Instants
from planner.world.orbits import OrbitStates
from planner.world.targets import EarthFixedTarget, SkyTarget, Target
from planner.world.targets.apparent import SPEED_OF_LIGHT_M_S, aberrate


@dataclass(frozen=True, eq=False)
class Sighting:
    """What the carrier sees of n targets.

    direction_itrf: unit vectors from the carrier, light time and aberration included, (n, 3).
    range_m: (n,).  elevation_rad: of the carrier in the target's sky; for a target in space its
    height above the limb raised by the grazing altitude, (n,).
    """

    direction_itrf: Array
    range_m: Array
    elevation_rad: Array


class FixedPlaces:
    """Points at rest on the ground, any number."""

    def __init__(self, carrier: Carrier, targets: Sequence[EarthFixedTarget]) -> None:
        at_start = Instants(carrier.start_utc, np.zeros(1))
        self.r_itrf_m = np.concatenate([target.r_target_itrf_m(at_start) for target in targets])
        latitude_rad, longitude_rad, _ = geodetic_from_itrf(self.r_itrf_m)
        self._up_itrf = up_itrf(latitude_rad, longitude_rad)

    def r_target_itrf_m(self, which: Indices, t_s: Array) -> Array:
        """Shape (n, 3)."""
        return self.r_itrf_m[which]

    def up_itrf(self, which: Indices, r_target_itrf_m: Array) -> Array:
        """Shape (n, 3)."""
        return self._up_itrf[which]


@dataclass(frozen=True, eq=False)
class MovingPlace:
    """One point that moves over the ground."""

    carrier: Carrier
    target: EarthFixedTarget

    def r_target_itrf_m(self, which: Indices, t_s: Array) -> Array:
        """Shape (n, 3)."""
        return self.target.r_target_itrf_m(Instants(self.carrier.start_utc, t_s))

    def up_itrf(self, which: Indices, r_target_itrf_m: Array) -> Array:
        """Shape (n, 3)."""
        latitude_rad, longitude_rad, _ = geodetic_from_itrf(r_target_itrf_m)
        return up_itrf(latitude_rad, longitude_rad)


@dataclass(frozen=True, eq=False)
class EarthSight:
    """Targets on the Earth.

    min_elevation_rad: one per target.  Directions leave out refraction also where a target asks for
    it: on the axes 8 arcsec at 30 deg elevation and 50 at 10.
    """

    carrier: Carrier
    places: FixedPlaces | MovingPlace
    min_elevation_rad: Array

    def clearance_rad(self, which: Indices, t_s: Array) -> Array:
        """Elevation above the plane of the ellipsoid, beyond the least one, (n,)."""
        r_target_m = self.places.r_target_itrf_m(which, t_s)
        return self._elevation_rad(which, t_s, r_target_m) - self.min_elevation_rad[which]

    def closeness(self, which: Indices, t_s: Array) -> Array:
        """The range, negative."""
        return -_norm(self.carrier.r_sat_itrf_m.at(t_s) - self.places.r_target_itrf_m(which, t_s))

    def sighting(self, which: Indices, t_s: Array) -> Sighting:
        """Light time with the Earth turning below, then aberration, as `EarthFixedTarget`."""
        r_sat_m = self.carrier.r_sat_itrf_m.at(t_s)
        r_target_m = self.places.r_target_itrf_m(which, t_s)
        range_m = _norm(r_target_m - r_sat_m)
        light_time_s = range_m / SPEED_OF_LIGHT_M_S
        r_emitting_m = self.places.r_target_itrf_m(which, t_s - light_time_s)
        turned_m = light_time_s[:, None] * _carried_m_s(r_emitting_m)
        los_m = r_emitting_m - turned_m - r_sat_m
        return Sighting(
            direction_itrf=aberrate(
                los_m / _norm(los_m)[:, None], self.carrier.v_sat_itrf_m_s.at(t_s)
            ),
            range_m=range_m,
            elevation_rad=self._elevation_rad(which, t_s, r_target_m),
        )

    def to_sun_itrf(self, which: Indices, t_s: Array) -> Array:
        """Where the target sees the Sun, unit vectors (n, 3); parallax, diurnal aberration
        included."""
        r_target_m = self.places.r_target_itrf_m(which, t_s)
        to_sun_m = self.carrier.r_sun_itrf_m.at(t_s) - r_target_m
        return aberrate(to_sun_m / _norm(to_sun_m)[:, None], _carried_m_s(r_target_m))

    def sun_elevation_rad(self, which: Indices, t_s: Array) -> Array:
        """Elevation of `to_sun_itrf`."""
        r_target_m = self.places.r_target_itrf_m(which, t_s)
        up_itrf = self.places.up_itrf(which, r_target_m)
        return _arcsin(_dot(self.to_sun_itrf(which, t_s), up_itrf))

    def nearest_passage(self, which: Indices, t_s: Array) -> tuple[Array, Array]:
        """Target and carrier on straight lines in ITRF."""
        apart_m = self.carrier.r_sat_itrf_m.at(t_s) - self.places.r_target_itrf_m(which, t_s)
        speed_m_s = self.carrier.r_sat_itrf_m.rate_at(t_s)
        square = _dot(speed_m_s, speed_m_s)
        nearest_s = -_dot(apart_m, speed_m_s) / square
        return nearest_s, np.sqrt(square) / _norm(apart_m + nearest_s[:, None] * speed_m_s)

    def _elevation_rad(self, which: Indices, t_s: Array, r_target_m: Array) -> Array:
        apart_m = self.carrier.r_sat_itrf_m.at(t_s) - r_target_m
        return _arcsin(_dot(apart_m, self.places.up_itrf(which, r_target_m)) / _norm(apart_m))


@dataclass(frozen=True, eq=False)
class SkySight:
    """One target in space.

    min_elevation_rad: above the limb raised by its grazing altitude.
    """

    carrier: Carrier
    target: SkyTarget
    min_elevation_rad: float

    def clearance_rad(self, which: Indices, t_s: Array) -> Array:
        """Height above the raised limb, beyond the least one, (n,)."""
        height_rad = self.target.apparent(*self._carrier_at(t_s)[:2]).clearance_rad
        return np.asarray(height_rad - self.min_elevation_rad)

    def closeness(self, which: Indices, t_s: Array) -> Array:
        """The carrier doesn't approach it: highest above the limb counts."""
        return self.clearance_rad(which, t_s)

    def sighting(self, which: Indices, t_s: Array) -> Sighting:
        """The sighting as `SkyTarget` has it."""
        instants, states, c_itrf = self._carrier_at(t_s)
        apparent = self.target.apparent(instants, states)
        return Sighting(
            direction_itrf=np.einsum("nij,nj->ni", c_itrf, apparent.direction_eci),
            range_m=apparent.range_m,
            elevation_rad=apparent.clearance_rad,
        )

    def sun_elevation_rad(self, which: Indices, t_s: Array) -> Array:
        """There is no ground."""
        return np.full(len(t_s), math.nan)

    def nearest_passage(self, which: Indices, t_s: Array) -> tuple[Array, Array]:
        """It stands still."""
        return np.zeros(len(t_s)), np.zeros(len(t_s))

    def _carrier_at(self, t_s: Array) -> tuple[Instants, OrbitStates, Array]:
        instants = Instants(self.carrier.start_utc, t_s)
        c_itrf = c_itrf_from_eci(instants)
        states = OrbitStates(
            np.einsum("nji,nj->ni", c_itrf, self.carrier.r_sat_itrf_m.at(t_s)),
            np.einsum("nji,nj->ni", c_itrf, self.carrier.v_sat_itrf_m_s.at(t_s)),
        )
        return instants, states, c_itrf


Sight = EarthSight | SkySight
"""Targets that are looked at alike; `which` (n,) numbers them, t_s (n,) is the carrier's.

clearance_rad: how far inside the region where it can be seen, `VisibleTarget`'s.  closeness:
greatest at the closest approach.  sun_elevation_rad: of the Sun's centre in the target's sky,
without refraction; NaN in space.  nearest_passage: when, from t_s, the straight course at t_s is
nearest, s, and how fast the line of sight then turns, rad/s.  Each (n,).
"""


def resting_places(targets: Sequence[Target]) -> dict[int, EarthFixedTarget]:
    """Targets that rest on the Earth, by their number."""
    return {
        number: target
        for number, target in enumerate(targets)
        if target.rests_on_earth and isinstance(target, EarthFixedTarget)
    }


def in_sights(
    target: Indices, targets: Sequence[Target], carrier: Carrier
) -> Iterator[tuple[Indices, Sight, Indices]]:
    """Group rows of one target each, (n,): those seen alike, how, and each one's number in it.

    Whatever elevation the targets ask for.
    """
    resting = resting_places(targets)
    if resting:
        number = np.full(len(targets), -1)
        number[list(resting)] = np.arange(len(resting))
        rows = np.flatnonzero(number[target] >= 0)
        places = FixedPlaces(carrier, list(resting.values()))
        yield rows, EarthSight(carrier, places, np.zeros(len(resting))), number[target[rows]]
    for n in np.unique(target).tolist():
        if n not in resting:
            rows = np.flatnonzero(target == n)
            yield rows, sight_of(carrier, targets[n], 0.0), np.zeros(len(rows), np.intp)


def sight_of(carrier: Carrier, target: Target, min_elevation_rad: float) -> Sight:
    """One target by itself."""
    if isinstance(target, EarthFixedTarget):
        return EarthSight(carrier, MovingPlace(carrier, target), np.array([min_elevation_rad]))
    assert isinstance(target, SkyTarget), f"a {target.mode} has no windows"
    return SkySight(carrier, target, min_elevation_rad)


def _carried_m_s(r_itrf_m: Array) -> Array:
    """Inertial velocity of points at rest on the Earth, shape (n, 3)."""
    x, y = r_itrf_m[:, 0], r_itrf_m[:, 1]
    return OMEGA_EARTH_RAD_S * np.stack([-y, x, np.zeros_like(x)], axis=1)


def _dot(a: Array, b: Array) -> Array:
    return np.asarray(np.einsum("nj,nj->n", a, b))


def _norm(a: Array) -> Array:
    return np.sqrt(_dot(a, a))


def _arcsin(sine: Array) -> Array:
    """Straight overhead a sine may round to more than 1."""
    return np.asarray(np.arcsin(np.clip(sine, -1.0, 1.0)))
