"""Battery, memory and wheels along a plan: linear between rows, eclipse edges and contacts."""

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from datetime import datetime
from functools import cached_property, partial
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from planner.base.arrays import Array, Mask
from planner.base.commands import Motion
from planner.base.rotation import Rotation
from planner.world.frames.earth_orientation import c_itrf_from_eci
from planner.world.frames.geodesy import itrf_from_geodetic, up_itrf
from planner.world.frames.solar_system import r_sun_eci_m
from planner.world.frames.time_scales import Instants, elapsed_s, shifted_utc
from planner.world.orbits import Ephemeris, OrbitStates
from planner.world.plan import FlightPlan
from planner.world.platforms.gravity_gradient import gradient_torque_body_n_m
from planner.world.resources import (
    MOMENTA,
    Battery,
    Memory,
    Momentum,
    ResourceName,
    Resources,
    Station,
    resource_told,
)
from planner.world.rules.body import inertia_of
from planner.world.scenario import Scenario
from planner.world.targets import SessionTarget, StationTarget
from planner.world.targets.earth_limb import limb_clearance_rad

Span = tuple[float, float]  # s after the epoch


@dataclass(frozen=True, kw_only=True)
class EdgeOptions:
    """How edges of light and of contacts are found."""

    step_s: float = 10.0  # low orbits pass a station in minutes; extremes in between are sought
    finer: int = 64  # per pass
    passes: int = 3  # 10 s to 20 us, and then along the chord


OPTIONS = EdgeOptions()


@dataclass(frozen=True, kw_only=True, eq=False)
class ResourceCurve:
    """The level of one resource, linear between its instants.

    name: which resource, and about which axis of the body.  unit: of what follows.  limit: that may
    not be passed, downwards by a battery, upwards by a memory, either way by a momentum.
    t_s: since the table's epoch, (m,).  level: (m,).
    """

    name: ResourceName
    unit: str
    capacity: float
    limit: float
    t_s: Array
    level: Array

    @property
    def room(self) -> Array:
        """How far it is from its limit, negative beyond, (m,)."""
        if self.name == "battery":
            return self.level - self.limit
        return self.limit - (np.abs(self.level) if self.resource == "momentum" else self.level)

    @property
    def resource(self) -> str:
        """The member of `resources`."""
        return self.name.partition("_")[0]

    @property
    def told(self) -> str:
        """Its name in words."""
        return resource_told(self.name)

    @property
    def first_beyond_s(self) -> float | None:
        """When it first passes its limit by more than a billionth of its capacity."""
        beyond = np.flatnonzero(self.room < -1e-9 * self.capacity)
        if not beyond.size:
            return None
        k = max(int(beyond[0]), 1)
        before, after = self.room[k - 1], self.room[k]
        share = min(max(before / (before - after), 0.0), 1.0) if before != after else 0.0
        return float(self.t_s[k - 1] + share * (self.t_s[k] - self.t_s[k - 1]))


class Along(NamedTuple):
    """What an attitude gives at n instants.

    charge_w: what panels would give in sunlight, (n,).  With a momentum of wheels also
    c_body_from_eci, (n, 3, 3); turning_body_n_m_s: what the body turns with, (n, 3);
    torque_eci_n_m: from outside, (n, 3).
    """

    charge_w: Array
    c_body_from_eci: Array
    turning_body_n_m_s: Array
    torque_eci_n_m: Array


@dataclass(frozen=True, kw_only=True, eq=False)
class Uses:
    """When what draws on resources happens, in s after the epoch.

    sessions: of each.  targets: theirs.  idle: waits, over which only the idle power is drawn.
    """

    sessions: tuple[Span, ...]
    targets: tuple[SessionTarget, ...]
    idle: tuple[Span, ...]

    @property
    def imaging(self) -> tuple[Span, ...]:
        """Sessions in which the camera images."""
        return tuple(span for span, one in self._each if one.images)

    @property
    def pointed(self) -> tuple[Span, ...]:
        """Sessions that point at a station."""
        return tuple(span for span, one in self._each if isinstance(one, StationTarget))

    @property
    def _each(self) -> Iterator[tuple[Span, SessionTarget]]:
        return zip(self.sessions, self.targets, strict=True)


def uses_of(plan: FlightPlan) -> Uses:
    """As the plan's sessions and segments say."""
    epoch_utc, sessions = plan.table.epoch_utc, plan.scenario.sessions

    def spans(ends_utc: Iterable[tuple[datetime, datetime]]) -> tuple[Span, ...]:
        return tuple(
            (elapsed_s(start, epoch_utc), elapsed_s(stop, epoch_utc)) for start, stop in ends_utc
        )

    return Uses(
        sessions=spans((one.start, one.stop) for one in sessions),
        targets=tuple(one.target for one in sessions),
        idle=spans(plan.waits),
    )


class LightAndContacts:
    """Sunlight and contacts of a scenario from row 0 to last_s, whatever the platform does."""

    def __init__(self, scenario: Scenario, last_s: float) -> None:
        """Raises OutsideCoverage where the orbit isn't known for so long."""
        self.scenario, self.last_s = scenario, last_s
        self.epoch_utc = scenario.initial_state.epoch
        self.ephemeris: Ephemeris = scenario.orbit.ephemeris(
            self.epoch_utc, shifted_utc(self.epoch_utc, last_s)
        )
        assert scenario.resources is not None  # who asks has some
        self.resources: Resources = scenario.resources

    def at(self, t_s: Array) -> tuple[Instants, OrbitStates]:
        instants = Instants(self.epoch_utc, t_s)
        return instants, self.ephemeris.dense_states(instants)

    @cached_property
    def lit(self) -> tuple[Span, ...]:
        """When the Sun's centre stands above the ellipsoid's limb."""

        def above_rad(t_s: Array) -> Array:
            instants, states = self.at(t_s)
            c = c_itrf_from_eci(instants)
            sun = np.einsum("nij,nj->ni", c, sun_eci(instants, states))
            return limb_clearance_rad(sun, np.einsum("nij,nj->ni", c, states.r_sat_eci_m), 0.0)

        return tuple(spans_above(above_rad, self.last_s))

    @cached_property
    def contacts(self) -> tuple[tuple[str, Span], ...]:
        """Name of the station, and when it takes data."""
        memory = self.resources.memory
        stations = memory.stations if memory is not None else ()
        return tuple(
            (station.id, span) for station in stations for span in self.contacts_with(station)
        )

    def contacts_with(self, station: Station | StationTarget) -> Iterator[Span]:
        """When it takes data."""
        return spans_above(partial(self._above_rad, station), self.last_s)

    def _above_rad(self, station: Station | StationTarget, t_s: Array) -> Array:
        """The elevation less the least, geometric, (n,)."""
        instants, states = self.at(t_s)
        r_itrf_m = np.einsum("nij,nj->ni", c_itrf_from_eci(instants), states.r_sat_eci_m)
        place = math.radians(station.latitude_deg), math.radians(station.longitude_deg)
        to_sat_m = r_itrf_m - itrf_from_geodetic(*place, station.height_m)
        sine = to_sat_m @ up_itrf(*place) / np.linalg.norm(to_sat_m, axis=1)
        least_rad = math.radians(station.min_elevation_deg)
        return np.asarray(np.arcsin(np.clip(sine, -1.0, 1.0)) - least_rad)

    def along(self, t_s: Array, motion: Motion) -> Along:
        """Of the platform's motion at n instants."""
        instants, states = self.at(t_s)
        q_body_from_eci = self.scenario.q_body_from_eci(instants, states, motion.position)
        charge_w = self._charge_w(instants, states, q_body_from_eci)
        if (momentum := self.resources.momentum) is None:
            return Along(charge_w, *(np.zeros(0) for _ in range(3)))
        inertia_kg_m2 = inertia_of(self.scenario)
        torque_n_m = gradient_torque_body_n_m(q_body_from_eci, states.r_sat_eci_m, inertia_kg_m2)
        return Along(
            charge_w=charge_w,
            c_body_from_eci=q_body_from_eci.as_matrix(),
            turning_body_n_m_s=motion.rate_rad_s @ inertia_kg_m2,
            torque_eci_n_m=q_body_from_eci.inv().apply(torque_n_m + momentum.torque_body_n_m),
        )

    def _charge_w(
        self, instants: Instants, states: OrbitStates, q_body_from_eci: Rotation
    ) -> Array:
        """What panels would give in sunlight at n instants, (n,)."""
        battery = self.resources.battery
        if battery is None or battery.sunlight_w is not None:
            return np.full(len(instants), 0.0 if battery is None else battery.sunlight_w)
        return panels_w(battery, q_body_from_eci.apply(sun_eci(instants, states)))

    def curves(
        self, t_s: Array, along: Along, uses: Uses, *, with_wheels: bool = True
    ) -> tuple[ResourceCurve, ...]:
        """t_s: from row 0, (n,).  along: the attitude then; charge is taken as linear between."""
        contacts = tuple(span for _, span in self.contacts)
        edges = [
            end for spans in (self.lit, contacts, uses.sessions) for one in spans for end in one
        ]
        inside = [edge for edge in edges if t_s[0] < edge < t_s[-1]]
        grid_s = np.unique(np.concatenate([t_s, inside]))
        imaging, idle = _within(grid_s, uses.imaging), _within(grid_s, uses.idle)
        pointed, heard = _within(grid_s, uses.pointed), _within(grid_s, contacts)
        step_s, found = np.diff(grid_s), []
        if (battery := self.resources.battery) is not None:
            at_w = np.interp(grid_s, t_s, along.charge_w)
            mean_w = np.where(_within(grid_s, self.lit), 0.5 * (at_w[1:] + at_w[:-1]), 0.0)
            moving_w = np.where(imaging | idle, 0.0, battery.slew_w)
            drawn_w = battery.idle_w + moving_w + np.where(imaging, battery.imaging_w, 0.0)
            drawn_w += np.where(pointed | heard, battery.downlink_w, 0.0)
            found.append(_battery_curve(battery, grid_s, (mean_w - drawn_w) * step_s / 3600.0))
        if (memory := self.resources.memory) is not None:
            sent = np.where(heard, memory.downlink_gbit_s, 0.0)
            sent = np.maximum(sent, np.where(pointed, memory.pointed_gbit_s, 0.0))
            written = np.where(imaging, memory.imaging_gbit_s, 0.0)
            found.append(_memory_curve(memory, grid_s, (written - sent) * step_s))
        if with_wheels and (momentum := self.resources.momentum) is not None:
            found.extend(_momentum_curves(momentum, t_s, along, _within(t_s, uses.idle)))
        return tuple(found)


def resource_curves(plan: FlightPlan) -> tuple[ResourceCurve, ...]:
    """Of each resource of the request, over the whole table.

    Between rows the charge of panels is taken as linear: of a turn of 1.5 deg/s it errs by 3e-8 of
    what they give in a row.  Likewise the torques from outside; a momentum is known on rows alone.
    """
    if plan.scenario.resources is None:
        return ()
    around, along = attitude_along(plan)
    return around.curves(plan.table.t_s, along, uses_of(plan))


def attitude_along(plan: FlightPlan) -> tuple[LightAndContacts, Along]:
    """Light and contacts of a plan that has resources, and what its attitude gives on its rows."""
    table = plan.table
    around = LightAndContacts(plan.scenario, float(table.t_s[-1]))
    motion = Motion(table.position, table.rate_rad_s, np.zeros_like(table.rate_rad_s))
    return around, around.along(table.t_s, motion)


def panels_w(battery: Battery, sun_body: Array) -> Array:
    """What panels give with the Sun in these directions, unit vectors (n, 3)."""
    powers_w = [
        panel.power_w * np.maximum(sun_body @ panel.normal, 0.0) for panel in battery.panels
    ]
    return np.asarray(np.sum(powers_w, axis=0)) if powers_w else np.zeros(len(sun_body))


def sun_eci(instants: Instants, states: OrbitStates) -> Array:
    """Geometric directions of the Sun from the spacecraft, unit vectors (n, 3).

    instants: in order of time.  The Sun's way over 10 s is taken as straight: 0.1 m off.
    """
    t_s = instants.t_s
    node_s = np.append(np.arange(t_s[0], t_s[-1], OPTIONS.step_s), t_s[-1])
    node_s = t_s if len(t_s) < len(node_s) else node_s
    r_sun_m = r_sun_eci_m(Instants(instants.epoch_utc, node_s))
    to_sun_m = np.stack([np.interp(t_s, node_s, x_m) for x_m in r_sun_m.T], axis=1)
    to_sun_m -= states.r_sat_eci_m
    return np.asarray(to_sun_m / np.linalg.norm(to_sun_m, axis=1, keepdims=True))


def _battery_curve(battery: Battery, t_s: Array, steps_wh: Array) -> ResourceCurve:
    """Charge beyond the capacity is lost where it comes: all that was lost so far is the most by
    which the sum without losses ever stood above the capacity."""
    whole = battery.begins_wh + np.append(0.0, np.cumsum(steps_wh))
    lost = np.maximum.accumulate(np.maximum(whole - battery.capacity_wh, 0.0))
    return ResourceCurve(
        name="battery",
        unit="Wh",
        capacity=battery.capacity_wh,
        limit=battery.least_wh,
        t_s=t_s,
        level=whole - lost,
    )


def _memory_curve(memory: Memory, t_s: Array, steps_gbit: Array) -> ResourceCurve:
    """Nothing is sent of what isn't there, by the same rule."""
    whole = memory.start_gbit + np.append(0.0, np.cumsum(steps_gbit))
    unsent = np.maximum.accumulate(np.maximum(-whole, 0.0))
    return ResourceCurve(
        name="memory",
        unit="Gbit",
        capacity=memory.capacity_gbit,
        limit=memory.capacity_gbit,
        t_s=t_s,
        level=whole + unsent,
    )


def _momentum_curves(
    momentum: Momentum, t_s: Array, along: Along, idle: Mask
) -> Iterator[ResourceCurve]:
    """About each axis of the body.  idle: in which steps it unloads, (n - 1,)."""
    # Numba takes 0.2 s to import, which only work should pay.
    from planner.world.platforms.wheels import wheel_momentum

    step_s, torque_n_m = np.diff(t_s), along.torque_eci_n_m
    held_n_m_s = wheel_momentum(
        np.ascontiguousarray(along.c_body_from_eci),
        along.turning_body_n_m_s,
        0.5 * step_s[:, None] * (torque_n_m[1:] + torque_n_m[:-1]),
        momentum.unload_n_m * step_s * idle,
        np.array(momentum.start_n_m_s),
    )
    for name, level, most in zip(MOMENTA, held_n_m_s.T, momentum.capacity_n_m_s, strict=True):
        yield ResourceCurve(
            name=name, unit="N m s", capacity=most, limit=most, t_s=t_s, level=level
        )


def _within(grid_s: Array, spans: tuple[Span, ...]) -> Mask:
    """Which intervals of the grid lie in any of the spans, whose ends are on it, (m - 1,)."""
    middle_s = 0.5 * (grid_s[1:] + grid_s[:-1])
    found = np.zeros(len(middle_s), dtype=bool)
    for start_s, stop_s in spans:
        found |= (middle_s > start_s) & (middle_s < stop_s)
    return found


def spans_above(value: Callable[[Array], Array], last_s: float) -> Iterator[Span]:
    """Spans of 0 to last_s in which a smooth function isn't negative, their ends to a microsecond.

    Where it may come to zero and back between two samples, its extreme is sought first.
    """
    t_s = np.linspace(0.0, last_s, max(math.ceil(last_s / OPTIONS.step_s), 2) + 1)
    at = value(t_s)
    sign = np.where(at >= 0.0, -1.0, 1.0)[1:-1]
    rises = sign * np.diff(at)[:-1], sign * np.diff(at)[1:]
    may_cross = np.abs(at[1:-1]) <= np.maximum(np.abs(rises[0]), np.abs(rises[1]))
    turns = np.flatnonzero((rises[0] >= 0.0) & (rises[1] <= 0.0) & may_cross) + 1
    extremes = [_extreme_s(value, t_s[k - 1], t_s[k + 1], float(sign[k - 1])) for k in turns]
    if extremes:
        t_s = np.unique(np.concatenate([t_s, extremes]))
        at = value(t_s)
    is_above = at >= 0.0
    edges = [
        _crossing_s(value, t_s[k], t_s[k + 1])
        for k in np.flatnonzero(is_above[1:] != is_above[:-1])
    ]
    ends = [*([0.0] if is_above[0] else []), *edges, *([last_s] if is_above[-1] else [])]
    yield from (
        (start, stop) for number, (start, stop) in enumerate(pairwise(ends)) if number % 2 == 0
    )


def _extreme_s(value: Callable[[Array], Array], low_s: float, high_s: float, sign: float) -> float:
    for _ in range(OPTIONS.passes):
        t_s = np.linspace(low_s, high_s, OPTIONS.finer + 1)
        k = int(np.clip(np.argmax(sign * value(t_s)), 1, OPTIONS.finer - 1))
        low_s, high_s = float(t_s[k - 1]), float(t_s[k + 1])
    return 0.5 * (low_s + high_s)


def _crossing_s(value: Callable[[Array], Array], low_s: float, high_s: float) -> float:
    for _ in range(OPTIONS.passes):
        t_s = np.linspace(low_s, high_s, OPTIONS.finer + 1)
        at = value(t_s)
        k = int(np.flatnonzero((at[1:] >= 0.0) != (at[:-1] >= 0.0))[0])
        low_s, high_s = float(t_s[k]), float(t_s[k + 1])
    return low_s + (high_s - low_s) * float(at[k] / (at[k] - at[k + 1]))
