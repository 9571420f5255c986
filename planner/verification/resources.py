"""Battery, memory and wheels by the judge: its own Sun, stations and attitude between rows."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from datetime import datetime
from functools import partial
from typing import NamedTuple

import erfa
import numpy as np

from planner.base.arrays import Array, Indices, Mask, cross
from planner.base.commands import COMMAND_STEP_S, ROWS_PER_S, CommandTable
from planner.base.rotation import Rotation
from planner.verification.clock import elapsed_us, tt_s
from planner.verification.earth import earth_orientation, interpolate_evenly
from planner.verification.earth_fixed import vertical
from planner.verification.platforms.judge import FlownInstants, Judge
from planner.verification.report import Finding, Limit, Reserve
from planner.verification.sky import EARTH, SUN, limb_clearance_rad, r_body_bary_m, tdb_s
from planner.verification.terrain import WGS84
from planner.world.frames.geodesy import MU_EARTH_M3_S2
from planner.world.frames.time_scales import Instants, shifted_utc
from planner.world.orbits import Ephemeris, OrbitStates
from planner.world.resources import MOMENTA, ResourceName, Station, resource_told
from planner.world.rules.body import inertia_of
from planner.world.scenario import Scenario
from planner.world.targets import BenchMotionTarget, StationTarget

Times = Callable[[Array], Array]  # of a condition at instants, (n,): how far it is fulfilled
Waits = tuple[tuple[datetime, datetime], ...]  # as the plan tells them; UTC


@dataclass(frozen=True, kw_only=True)
class JudgedResourceOptions:
    """How densely the judge looks, and what it lets pass."""

    look_s: float = 1.0  # less than light or a contact lasts that isn't grazing
    looks: int = 16  # as far between those from which neither can come or go before the next
    rate_rad_s: float = 0.06  # at most of an elevation or a height above the limb: 130 km overhead
    finer: int = 32  # per pass
    passes: int = 6  # of a second: to a nanosecond
    wait_rows: int = 50  # between looks at whether the platform waits: no slew is so short
    rows_at_once: int = 20_000
    rounding: float = 1e-6  # of a row, of times that lie on one
    sun_s: float = 600.0  # between looks at the Sun: a cubic through them is off by micrometres
    tolerance: float = 1e-6  # of the capacity


OPTIONS = JudgedResourceOptions()
_LIMITS: dict[ResourceName, Limit] = {
    "battery": "battery",
    "memory": "memory",
    "momentum_x": "momentum",
    "momentum_y": "momentum",
    "momentum_z": "momentum",
}


def resource_margins(
    table: CommandTable, scenario: Scenario, judge: Judge, waits: Waits
) -> tuple[Reserve, ...]:
    """The least that each resource keeps from its limit.  waits: when the platform idles."""
    return tuple(_margin(found, table) for found in resource_levels(table, scenario, judge, waits))


def wait_findings(
    table: CommandTable, scenario: Scenario, judge: Judge, waits: Waits
) -> Iterator[Finding]:
    """Where the plan says that the platform waits, and it does not."""
    resources = scenario.resources
    limit: Limit = "battery" if resources and resources.battery else "momentum"
    for wait in waits:
        first, last = (
            round(elapsed_us(end_utc, table.epoch_utc) / 1e6 * ROWS_PER_S) for end_utc in wait
        )
        rows = np.unique(np.append(np.arange(first, last, OPTIONS.wait_rows), last))
        moving = rows[~judge.is_idle_at(rows)]
        if moving.size:
            t_s = float(moving[0]) / ROWS_PER_S
            yield Finding(
                limit=limit,
                t_s=t_s,
                at_utc=shifted_utc(table.epoch_utc, t_s),
                detail=f"the platform doesn't wait in row {moving[0]}, as its segment says",
            )


def resource_findings(margins: tuple[Reserve, ...], scenario: Scenario) -> Iterator[Finding]:
    """One error for each resource that runs out."""
    resources = scenario.resources
    for margin in margins:
        assert resources is not None  # else it had no margins
        capacity = margin.limit
        if margin.name == "battery" and resources.battery is not None:
            capacity = resources.battery.capacity_wh
        if margin.margin < -OPTIONS.tolerance * capacity:
            yield Finding(
                limit=_LIMITS[margin.name],
                t_s=margin.t_s,
                at_utc=margin.at_utc,
                detail=(
                    f"the {resource_told(margin.name)} holds {margin.extreme:.6g} {margin.unit}, "
                    f"{-margin.margin:.3g} {margin.unit} past its limit of {margin.limit:.6g} "
                    f"{margin.unit}, {margin.t_s:.1f} s after the table's epoch"
                ),
            )


class Levels(NamedTuple):
    """Of one resource.  t_s: instants, (m,).  level: (m,).  margin: to the limit, (m,)."""

    name: ResourceName
    unit: str
    limit: float
    t_s: Array
    level: Array
    margin: Array


def resource_levels(
    table: CommandTable, scenario: Scenario, judge: Judge, waits: Waits
) -> Iterator[Levels]:
    """Of each resource of the request."""
    resources, epoch_utc = scenario.resources, table.epoch_utc
    if resources is None:
        return
    # Numba takes 0.2 s to import, which only work should pay.
    from planner.verification.unloading import held_by_store

    last_s = float(table.t_s[-1])
    ephemeris = scenario.orbit.ephemeris(epoch_utc, shifted_utc(epoch_utc, last_s))
    sessions, idle = (
        [tuple(elapsed_us(end, epoch_utc) / 1e6 for end in span) for span in spans]
        for spans in ([(one.start, one.stop) for one in scenario.sessions], waits)
    )
    at_stations = [
        (span, one.target)
        for span, one in zip(sessions, scenario.sessions, strict=True)
        if isinstance(one.target, StationTarget)
    ]
    imaging = [
        span
        for span, one in zip(sessions, scenario.sessions, strict=True)
        if not isinstance(one.target, StationTarget | BenchMotionTarget)
    ]
    memory, battery = resources.memory, resources.battery
    contacts = [
        _above(partial(_elevation_rad, station, epoch_utc, ephemeris), last_s)
        for station in (memory.stations if memory else ())
    ]
    lit = _above(partial(_sun_above_limb_rad, epoch_utc, ephemeris), last_s)
    cuts = np.concatenate([*contacts, lit, *map(np.array, sessions)])
    cuts = cuts[(cuts > 0.0) & (cuts < last_s)]
    t_s = np.unique(np.append(table.t_s, cuts))
    middle_s, long_s = 0.5 * (t_s[1:] + t_s[:-1]), np.diff(t_s)
    images = np.any([_between(middle_s, *one) for one in [(0.0, 0.0), *imaging]], axis=0)
    heard, pointed = (np.zeros(len(middle_s), dtype=bool) for _ in range(2))
    for ends in contacts:
        heard |= np.searchsorted(ends, middle_s) % 2 == 1
    for span, station in at_stations:
        held = np.flatnonzero(_between(middle_s, *span))
        at_s = np.concatenate([[0.0], middle_s[held], [last_s]])  # never a single instant
        above_rad = _elevation_rad(station, epoch_utc, ephemeris, at_s)[1:-1]
        pointed[held[above_rad >= 0.0]] = True
    if battery is not None:
        idles = np.any([_between(middle_s, *one) for one in [(0.0, 0.0), *idle]], axis=0)
        charge_w = np.zeros(len(middle_s))
        sunny = np.flatnonzero(np.searchsorted(lit, middle_s) % 2 == 1)
        for part, at in _parts(table, middle_s[sunny]):
            states = ephemeris.dense_states(at.instants)
            charge_w[sunny[part]] = _charge_w(scenario, judge, at, states)
        net_w = charge_w - battery.idle_w - battery.imaging_w * images
        net_w -= battery.slew_w * ~(images | idles) + battery.downlink_w * (heard | pointed)
        least_wh = battery.least_wh
        steps_wh = net_w * long_s / 3600.0
        charge_wh = held_by_store(battery.begins_wh, steps_wh, -math.inf, battery.capacity_wh)
        yield Levels("battery", "Wh", least_wh, t_s, charge_wh, charge_wh - least_wh)
    if memory is not None:
        sent = np.maximum(memory.downlink_gbit_s * heard, memory.pointed_gbit_s * pointed)
        rate = memory.imaging_gbit_s * images - sent
        data_gbit = held_by_store(memory.start_gbit, rate * long_s, 0.0, math.inf)
        most_gbit = memory.capacity_gbit
        yield Levels("memory", "Gbit", most_gbit, t_s, data_gbit, most_gbit - data_gbit)
    if resources.momentum is not None:
        yield from _momenta(table, scenario, judge, ephemeris, [(0.0, 0.0), *idle])


def _momenta(
    table: CommandTable,
    scenario: Scenario,
    judge: Judge,
    ephemeris: Ephemeris,
    idle_s: list[tuple[float, ...]],
) -> Iterator[Levels]:
    """Of the wheels about the body's axes, on rows.

    idle_s: spans after the epoch.  The torque from outside is that half way between two rows.
    """
    # Numba takes 0.2 s to import, which only work should pay.
    from planner.verification.unloading import held_by_wheels

    assert scenario.resources is not None
    momentum = scenario.resources.momentum
    assert momentum is not None  # who asks has wheels
    inertia_kg_m2 = inertia_of(scenario)
    count = len(table.t_s)
    middle_s = 0.5 * (table.t_s[1:] + table.t_s[:-1])
    # Only a body has wheels, and its rows are its attitude.
    rows_eci = Rotation.from_quat(table.position).as_matrix().swapaxes(1, 2)
    middle_eci, r_eci_m = np.empty((count - 1, 3, 3)), np.empty((count - 1, 3))
    for part, at in _parts(table, middle_s):
        states = ephemeris.dense_states(at.instants)
        for number, axis in enumerate(np.eye(3)):
            middle_eci[part, number] = judge.direction_eci(axis, at, states)
        r_eci_m[part] = states.r_sat_eci_m
    distance_m = np.linalg.norm(r_eci_m, axis=1)[:, None]
    up = np.einsum("nij,nj->ni", middle_eci, r_eci_m / distance_m)
    torque_n_m = 3.0 * MU_EARTH_M3_S2 / distance_m**3 * cross(up, up @ inertia_kg_m2)
    torque_n_m += momentum.torque_body_n_m
    impulse = np.zeros((count, 3))
    impulse[1:] = np.einsum("nij,ni->nj", middle_eci, torque_n_m) * COMMAND_STEP_S
    held = -table.rate_rad_s @ inertia_kg_m2
    impulse[0] = (momentum.start_n_m_s - held[0]) @ rows_eci[0]
    held[0] = momentum.start_n_m_s
    unloads = np.any([_between(middle_s, *one) for one in idle_s], axis=0)
    unloading = np.where(unloads, momentum.unload_n_m * COMMAND_STEP_S, 0.0)
    held_by_wheels(rows_eci, middle_eci, impulse, unloading, held)
    for name, level, limit in zip(MOMENTA, held.T, momentum.capacity_n_m_s, strict=True):
        yield Levels(name, "N m s", limit, table.t_s, level, limit - np.abs(level))


def _margin(found: Levels, table: CommandTable) -> Reserve:
    worst = int(np.argmin(found.margin))
    at_s = float(found.t_s[worst])
    return Reserve(
        name=found.name,
        unit=found.unit,
        limit=found.limit,
        extreme=float(found.level[worst]),
        margin=float(found.margin[worst]),
        last=float(found.level[-1]),
        t_s=at_s,
        at_utc=shifted_utc(table.epoch_utc, at_s),
    )


def _between(at_s: Array, start_s: float, stop_s: float) -> Mask:
    return (at_s > start_s) & (at_s < stop_s)


def _above(value: Times, last_s: float) -> Array:
    """When it rises above zero and falls below, in turns, from a rise on.

    Looks are far apart where it is too far from zero to be there before the next.
    """
    count = max(math.ceil(last_s / OPTIONS.look_s / OPTIONS.looks), 3) * OPTIONS.looks
    grid_s = np.linspace(0.0, last_s, count + 1)
    far_s = grid_s[:: OPTIONS.looks]
    off_rad = np.abs(value(far_s))
    is_near = off_rad[1:] + off_rad[:-1] <= OPTIONS.rate_rad_s * np.diff(far_s)
    is_looked_at = np.append(np.repeat(is_near, OPTIONS.looks), True)
    is_looked_at[:: OPTIONS.looks] = True
    grid_s = grid_s[is_looked_at]
    is_above = value(grid_s) >= 0.0
    first = np.flatnonzero(is_above[1:] != is_above[:-1])
    low_s, high_s, rises = grid_s[first], grid_s[first + 1], ~is_above[first]
    for _ in range(OPTIONS.passes if first.size else 0):
        within_s = np.linspace(low_s, high_s, OPTIONS.finer + 1, axis=1)
        # The ends keep the Earth's orientation apart from a single instant.
        at = value(np.concatenate([[0.0], within_s.ravel(), [last_s]]))[1:-1]
        is_past = (at.reshape(within_s.shape) >= 0.0) == rises[:, None]
        is_past[:, 0], is_past[:, -1] = False, True
        past = np.argmax(is_past, axis=1)
        crossing = np.arange(first.size)
        low_s, high_s = within_s[crossing, past - 1], within_s[crossing, past]
    return np.append([-1.0] if is_above[0] else [], high_s)


def _sun_eci_m(instants: Instants, states: OrbitStates) -> Array:
    """From the spacecraft at instants in order of time, geometric, (n, 3)."""
    at_s = tdb_s(tt_s(instants.epoch_utc, instants.t_s))
    count = max(math.ceil((at_s[-1] - at_s[0]) / OPTIONS.sun_s) + 1, 4)
    node_s = np.linspace(at_s[0], at_s[-1] + 1.0, count)
    r_sun_m = r_body_bary_m(SUN, node_s) - r_body_bary_m(EARTH, node_s)
    return interpolate_evenly(node_s, r_sun_m, at_s) - states.r_sat_eci_m


def _sun_above_limb_rad(epoch_utc: datetime, ephemeris: Ephemeris, t_s: Array) -> Array:
    instants = Instants(epoch_utc, t_s)
    states = ephemeris.states(instants)
    to_sun_m = _sun_eci_m(instants, states)
    earth = earth_orientation(instants.epoch_utc, t_s)
    sight_itrf = earth.itrf_from_eci(to_sun_m / np.linalg.norm(to_sun_m, axis=1, keepdims=True))
    return limb_clearance_rad(sight_itrf, earth.itrf_from_eci(states.r_sat_eci_m), 0.0)


def _elevation_rad(
    station: Station | StationTarget, epoch_utc: datetime, ephemeris: Ephemeris, t_s: Array
) -> Array:
    """Above the least elevation that it takes data from, (n,)."""
    instants = Instants(epoch_utc, t_s)
    r_sat_itrf_m = earth_orientation(instants.epoch_utc, t_s).itrf_from_eci(
        ephemeris.states(instants).r_sat_eci_m
    )
    longitude_rad, latitude_rad = np.deg2rad([station.longitude_deg, station.latitude_deg])
    r_m = erfa.gd2gc(WGS84, longitude_rad, latitude_rad, station.height_m)
    to_sat_m = r_sat_itrf_m - r_m
    up = vertical(r_m[None])[0][0]
    across_m = np.linalg.norm(np.cross(to_sat_m, up), axis=1)
    above_rad = np.arctan2(to_sat_m @ up, across_m) - math.radians(station.min_elevation_deg)
    return np.asarray(above_rad)


def _parts(table: CommandTable, t_s: Array) -> Iterator[tuple[Indices, FlownInstants]]:
    """Instants in order of time, some at once: which of them, and where in the table."""
    for part in np.array_split(np.arange(len(t_s)), len(t_s) // OPTIONS.rows_at_once + 1):
        if part.size:
            cell = (t_s[part] * ROWS_PER_S + OPTIONS.rounding).astype(np.intp)
            cell = np.minimum(cell, len(table.t_s) - 2)
            instants = Instants(table.epoch_utc, t_s[part])
            yield part, FlownInstants(cell, t_s[part] - cell * COMMAND_STEP_S, instants)


def _charge_w(scenario: Scenario, judge: Judge, at: FlownInstants, states: OrbitStates) -> Array:
    """Of the panels at instants in sunlight, (n,)."""
    assert scenario.resources is not None
    battery = scenario.resources.battery
    assert battery is not None  # who asks has one
    if battery.sunlight_w is not None:
        return np.full(len(at.cell), battery.sunlight_w)
    to_sun_m = _sun_eci_m(at.instants, states)
    distance_m = np.linalg.norm(to_sun_m, axis=1)
    total_w = np.zeros(len(at.cell))
    for panel in battery.panels:
        normal = np.asarray(panel.normal_body) / np.linalg.norm(panel.normal_body)
        on_base = scenario.platform.q_base_from_carrier.apply(normal)
        towards = np.sum(judge.direction_eci(on_base, at, states) * to_sun_m, axis=1) / distance_m
        total_w += panel.power_w * np.clip(towards, 0.0, None)
    return total_w
