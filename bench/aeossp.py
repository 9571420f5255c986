"""The public benchmark aeossp_standard: a fleet's looks by the chooser of campaigns, with a bound.

Twenty to thirty satellites with real TLEs, some 2,000 point targets in 12 h on a 5 s grid, scalar
agility, a cone about nadir, a battery; the value is the share of weight observed (WCR).

    python bench/aeossp.py [CASE [OUT.json]]

CASE: a folder with mission.yaml, satellites.yaml and tasks.yaml; without, the small one of our
tests.  OUT.json: the solution, in the
benchmark's own format.  Orbits, Earth orientation and the Sun are slewtrack's; the passes of every
satellite between idle times are networks of one campaign, in which each target counts once.
Slews are the benchmark's: of the angle, in an inertial frame, between the lines of sight at
the end of a look and the begin of the next, by a constant acceleration up to a constant rate; the
first from nadir.  The bound is of the Lagrangian relaxation and knows no battery.

The benchmark's frames are without Earth orientation parameters: its satellites stand up to 20 m
from ours over the ground, which `OFF_NADIR_MARGIN_DEG` covers.
Source: Mtrya, astro-reason (MIT), benchmarks/aeossp_standard.
"""

import functools
import json
import math
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from datetime import datetime, timedelta
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import yaml
from agility import Agility, between_s, slew_s

from planner.base.arrays import Array, Indices, Mask
from planner.base.compiled import compiled
from planner.base.reporting import tell_nobody
from planner.planning.campaigns.choice import (
    OPTIONS,
    Passes,
    bound_at,
    choose,
    refill,
)
from planner.planning.campaigns.displaced import Exchanged, displaced_by
from planner.planning.campaigns.looking import Looking
from planner.planning.campaigns.network import NEVER, Network, edges_between
from planner.planning.campaigns.path import Look, Worth
from planner.planning.campaigns.pricing import PricedPasses
from planner.world.frames.earth_orientation import c_itrf_from_eci
from planner.world.frames.geodesy import WGS84_A_M, itrf_from_geodetic
from planner.world.frames.solar_system import r_sun_eci_m
from planner.world.frames.time_scales import Instants
from planner.world.orbits import TleOrbit

SMALL = Path(__file__).parents[1] / "tests" / "data" / "aeossp_small"
OFF_NADIR_MARGIN_DEG = 0.003  # 20 m from 500 km
BATTERY_MARGIN_WH = (
    2.0  # sunlight is told at the nearest step, by the benchmark at middles of parts
)
CLEAR_DEG = 8.0  # the attitude's turn between two looks beyond twice the cone, while idle
# Weights are multiples of 0.5 among some thousands: the usual thousandth of the bound is coarse.
FLEET = replace(OPTIONS, gap_enough=2e-5, mixture_enough=2e-5, priced_labels_max=20_000)


class Battery(NamedTuple):
    """Capacity and level at the start (Wh); loads and charge (W)."""

    capacity_wh: float
    initial_wh: float
    idle_w: float
    imaging_w: float
    slew_w: float
    charge_w: float


@dataclass(frozen=True, kw_only=True, eq=False)
class Tasks:
    """Targets in the case's order: (n,), r_itrf_m (n, 3); rows of the time grid."""

    ids: Sequence[str]
    sensors: Sequence[str]
    weight: Array
    r_itrf_m: Array
    release: Indices
    due: Indices
    steps: Indices


@dataclass(frozen=True, kw_only=True, eq=False)
class Satellite:
    """r_itrf_m, nadir_eci: (rows, 3) on the grid.  is_lit: (rows,)."""

    id: str
    sensor: str
    off_nadir_max_deg: float
    agility: Agility
    battery: Battery
    r_itrf_m: Array
    nadir_eci: Array
    is_lit: Mask


@dataclass(frozen=True, kw_only=True, eq=False)
class Case:
    """start_utc: of the grid's first row.  c_itrf_from_eci: (rows, 3, 3)."""

    start_utc: datetime
    step_s: int
    c_itrf_from_eci: Array
    tasks: Tasks
    satellites: Sequence[Satellite]


@dataclass(frozen=True, kw_only=True, eq=False)
class Pass:
    """los_eci: of every step of every way of a network, (network.size, 3)."""

    satellite: Satellite
    network: Network
    los_eci: Array


def read_case(folder: Path) -> Case:
    """The case's files, its satellites propagated over the grid."""
    mission, satellites, tasks = (
        yaml.load((folder / f"{name}.yaml").read_text(), yaml.CSafeLoader)[name]
        for name in ("mission", "satellites", "tasks")
    )
    start, stop = (_utc(mission[f"horizon_{end}"]) for end in ("start", "end"))
    step_s = int(mission["action_time_step_s"])
    rows = int((stop - start).total_seconds()) // step_s + 1
    instants = Instants(start, step_s * np.arange(rows, dtype=np.float64))

    def row(task: dict[str, Any], name: str) -> int:
        return int((_utc(task[name]) - start).total_seconds()) // step_s

    latitude_deg, longitude_deg, height_m = np.array(
        [
            [task[f"{name}"] for name in ("latitude_deg", "longitude_deg", "altitude_m")]
            for task in tasks
        ]
    ).T
    turn = c_itrf_from_eci(instants)
    return Case(
        start_utc=start,
        step_s=step_s,
        c_itrf_from_eci=turn,
        tasks=Tasks(
            ids=[task["task_id"] for task in tasks],
            sensors=[task["required_sensor_type"] for task in tasks],
            weight=np.array([float(task["weight"]) for task in tasks]),
            r_itrf_m=itrf_from_geodetic(
                np.radians(latitude_deg), np.radians(longitude_deg), height_m
            ),
            release=np.array([row(task, "release_time") for task in tasks]),
            due=np.array([min(row(task, "due_time"), rows - 1) for task in tasks]),
            steps=np.array([int(task["required_duration_s"]) // step_s for task in tasks]),
        ),
        satellites=[_satellite(one, start, stop, instants, turn) for one in satellites],
    )


def _utc(moment: str | datetime) -> datetime:
    return moment if isinstance(moment, datetime) else datetime.fromisoformat(moment)


def _satellite(
    told: dict[str, Any], start: datetime, stop: datetime, instants: Instants, turn: Array
) -> Satellite:
    orbit = TleOrbit(line1=told["tle_line1"], line2=told["tle_line2"])
    r_eci_m = orbit.ephemeris(start, stop).states(instants).r_sat_eci_m
    to_sun = r_sun_eci_m(instants)
    to_sun /= np.linalg.norm(to_sun, axis=1)[:, None]
    along_m = np.einsum("ki,ki->k", r_eci_m, to_sun)
    across_m = np.linalg.norm(r_eci_m - along_m[:, None] * to_sun, axis=1)
    attitude, power = told["attitude_model"], told["resource_model"]
    return Satellite(
        id=told["satellite_id"],
        sensor=told["sensor"]["sensor_type"],
        off_nadir_max_deg=attitude["max_off_nadir_deg"],
        agility=Agility.told(attitude),
        battery=Battery(
            power["battery_capacity_wh"],
            power["initial_battery_wh"],
            power["idle_power_w"],
            power["imaging_power_w"],
            power["slew_power_w"],
            power["sunlit_charge_power_w"],
        ),
        r_itrf_m=np.ascontiguousarray(np.einsum("kij,kj->ki", turn, r_eci_m)),
        nadir_eci=-r_eci_m / np.linalg.norm(r_eci_m, axis=1)[:, None],
        is_lit=(along_m >= 0.0) | (across_m >= WGS84_A_M),
    )


def passes_of(case: Case) -> list[Pass]:
    """Of each satellite the times with targets in view, cut where it idles long enough to slew
    anywhere."""
    found: list[Pass] = []
    for satellite in case.satellites:
        ways = _ways(case, satellite)
        widest_deg = 2.0 * satellite.off_nadir_max_deg + CLEAR_DEG
        longest_s = slew_s(widest_deg, satellite.agility) + satellite.agility.settle_s
        reach = math.ceil(longest_s / case.step_s)
        latest = np.maximum.accumulate(ways[:, 2])
        cuts = np.flatnonzero(ways[1:, 1] - latest[:-1] >= reach) + 1
        parts = [part for part in np.split(np.arange(len(ways)), cuts) if len(part)]
        known = sum(len(one.network.way) for one in found)
        found += [
            _one_pass(case, satellite, ways[part], known + int(part[0]), reach) for part in parts
        ]
    return found


def _ways(case: Case, satellite: Satellite) -> Indices:
    """Target, first and last row of each time in view, (n, 3), by their first."""
    tasks = case.tasks
    off_nadir_rad = math.radians(satellite.off_nadir_max_deg - OFF_NADIR_MARGIN_DEG)
    target = np.flatnonzero(np.array(tasks.sensors) == satellite.sensor)
    found = []
    for number in target.tolist():
        begin, end = int(tasks.release[number]), int(tasks.due[number]) + 1
        r_m = satellite.r_itrf_m[begin:end]
        los_m = tasks.r_itrf_m[number] - r_m
        down = -np.einsum("ki,ki->k", los_m, r_m)
        is_seen = down >= math.cos(off_nadir_rad) * np.linalg.norm(los_m, axis=1) * np.linalg.norm(
            r_m, axis=1
        )
        is_seen &= los_m @ tasks.r_itrf_m[number] < 0.0
        edges = np.flatnonzero(np.diff(np.concatenate([[False], is_seen, [False]]).astype(np.int8)))
        first, last = begin + edges[::2], begin + edges[1::2] - 1
        lasts = last - first >= tasks.steps[number]
        found += [(number, a, b) for a, b in zip(first[lasts], last[lasts], strict=True)]
    ways = np.array(found, np.intp).reshape(-1, 3)
    return ways[np.argsort(ways[:, 1], kind="stable")]


def _one_pass(case: Case, satellite: Satellite, ways: Indices, number: int, reach: int) -> Pass:
    start = int(ways[0, 1])
    target, first, last = ways[:, 0].copy(), ways[:, 1] - start, ways[:, 2] - start
    steps, least = last - first + 1, case.tasks.steps[target]
    rows = np.concatenate([np.arange(one[1], one[2] + 1) for one in ways])
    los_itrf_m = case.tasks.r_itrf_m[np.repeat(target, steps)] - satellite.r_itrf_m[rows]
    los_eci = np.einsum("kji,kj->ki", case.c_itrf_from_eci[rows], los_itrf_m)
    los_eci /= np.linalg.norm(los_eci, axis=1)[:, None]
    network = edges_between(
        first_step=start,
        way=np.arange(number, number + len(ways)),
        target=target,
        first=first,
        last=last,
        least=least,
        quality_sum=np.concatenate([np.arange(count, dtype=np.float64) for count in steps]),
        reach=reach,
        scanned=np.ones(len(ways), np.bool_),  # who has looked leaves at once
    )
    _fill_arrivals(network, least, los_eci, satellite.agility, float(case.step_s))
    # No look fits before these: they begin from nadir.
    early = rows * case.step_s < 2.0 * satellite.agility.settle_s + case.step_s * int(
        case.tasks.steps.min()
    )
    for cell in np.flatnonzero(early).tolist():
        nadir = satellite.nadir_eci[rows[cell]]
        needs_s = between_s(nadir, los_eci[cell], satellite.agility)
        network.begins[cell] = rows[cell] * case.step_s >= needs_s
    return Pass(satellite=satellite, network=network, los_eci=los_eci)


@compiled
def _fill_arrivals(
    network: Network, least: Indices, los_eci: Array, agility: Agility, step_s: float
) -> None:
    """The first step at which the look by an edge's way may begin, for every step a look ends."""
    first, last, offset, arrival = network.first, network.last, network.offset, network.arrival
    for source in range(len(first)):
        begin, end = network.edge_from[source], network.edge_from[source + 1]
        for leave in range(first[source], last[source] + 1):
            place = network.arrival_offset[source] + (leave - first[source]) * (end - begin)
            los = los_eci[offset[source] + leave - first[source]]
            for edge in range(begin, end):
                arrival[place + edge - begin] = NEVER
                to = network.edge_to[edge]
                if leave - first[source] < least[source]:
                    continue
                for step in range(max(leave, first[to]), last[to] - least[to] + 1):
                    cell = offset[to] + step - first[to]
                    if (step - leave) * step_s >= between_s(los, los_eci[cell], agility):
                        arrival[place + edge - begin] = cell
                        break


class Checker:
    """Whether a pass's looks may follow each other, look by look: one that can begin may be in
    reach no more some steps later, while its line of sight turns away."""

    def __init__(self, case: Case, passes: Sequence[Pass]) -> None:
        self._step_s, self._steps = case.step_s, case.tasks.steps
        self._pass_of = {way: one for one in passes for way in one.network.way.tolist()}
        self.first_unheld = functools.cache(self._first_unheld)

    def _first_unheld(self, looks: tuple[Look, ...]) -> tuple[int, int] | None:
        for place in range(1, len(looks)):
            before, look = looks[place - 1], looks[place]
            network = self._pass_of[look.way].network
            way = look.way - int(network.way[0])
            latest = network.first_step + int(network.last[way] - self._steps[look.target])
            step = look.first_step
            while step <= latest and self.spare_s(before, look, step) < 0.0:
                step += 1
            if step > look.first_step:
                return place, step - 1
        return None

    def spare_s(self, before: Look, look: Look, step: int) -> float:
        """Time left of a gap beside the slew, were the later look to begin at a step."""
        ends = before.first_step + int(self._steps[before.target])
        return (step - ends) * self._step_s - self.needs_s(before, look, step)

    def needs_s(self, before: Look, look: Look, step: int) -> float:
        """Slew and settling from the end of a look to the next, which begins at a step."""
        ends = before.first_step + int(self._steps[before.target])
        agility = self._pass_of[look.way].satellite.agility
        return between_s(self.los_eci(before, ends), self.los_eci(look, step), agility)

    def los_eci(self, look: Look, step: int) -> Array:
        one = self._pass_of[look.way]
        network, way = one.network, look.way - int(one.network.way[0])
        row = network.offset[way] + step - network.first_step - network.first[way]
        return np.asarray(one.los_eci[row])


def least_charge(
    case: Case, satellite: Satellite, looks: Sequence[Look], checker: Checker
) -> tuple[float, float]:
    """The least level of its battery over the horizon (Wh), and when (s since the start)."""
    battery, step_s = satellite.battery, case.step_s
    end_s = float((len(satellite.is_lit) - 1) * step_s)
    edges_s = [np.arange(0.0, end_s + step_s, step_s)]
    spans = []
    for before, look in zip([None, *looks], looks, strict=False):
        start_s = float(look.first_step * step_s)
        if before is None:
            from_eci = satellite.nadir_eci[look.first_step]
            needs_s = between_s(from_eci, checker.los_eci(look, look.first_step), satellite.agility)
        else:
            needs_s = checker.needs_s(before, look, look.first_step)
        stop_s = start_s + float(case.tasks.steps[look.target] * step_s)
        spans += [
            (start_s - needs_s, start_s, battery.slew_w),
            (start_s, stop_s, battery.imaging_w),
        ]
        edges_s.append(np.array([start_s - needs_s]))
    t_s = np.unique(np.concatenate(edges_s))
    middle_s = 0.5 * (t_s[1:] + t_s[:-1])
    load_w = np.full(len(middle_s), battery.idle_w)
    for start_s, stop_s, power_w in spans:
        load_w[slice(*np.searchsorted(middle_s, [start_s, stop_s]))] += power_w
    lit = satellite.is_lit[np.rint(middle_s / step_s).astype(np.intp)]
    gained_wh = (np.where(lit, battery.charge_w, 0.0) - load_w) * np.diff(t_s) / 3600.0
    level_wh, least_wh, least_s = battery.initial_wh, battery.initial_wh, 0.0
    for gain_wh, at_s in zip(gained_wh.tolist(), t_s[1:].tolist(), strict=True):
        level_wh = min(battery.capacity_wh, level_wh + gain_wh)
        if level_wh < least_wh:
            least_wh, least_s = level_wh, at_s
    return least_wh, least_s


def spare_batteries(
    case: Case, passes: Sequence[Pass], chosen: Passes, looking: Looking, checker: Checker
) -> Passes:
    """Looks worth least for their time are given up by a satellite whose battery they would empty,
    and taken by others where they can."""
    passes, chosen = list(passes), list(chosen)
    is_short = False
    for satellite in case.satellites:
        own = [number for number, one in enumerate(passes) if one.satellite is satellite]
        while True:
            looks = [look for number in own for look in chosen[number]]
            least_wh, at_s = least_charge(case, satellite, looks, checker)
            if least_wh >= BATTERY_MARGIN_WH:
                break
            before = [look for look in looks if look.first_step * case.step_s < at_s]
            least = min(before, key=lambda look: look.value / case.tasks.steps[look.target])
            for number in own:
                chosen[number] = tuple(look for look in chosen[number] if look is not least)
                passes[number] = _kept_to(passes[number], chosen[number])
            is_short = True
    if not is_short:
        return chosen
    networks = [one.network for one in passes]
    given = PricedPasses(networks, networks, looking, checker.first_unheld)
    refilled = refill(given, chosen, FLEET)
    # What the others took may be too much for one of them: it gives up, too, and nobody takes.
    return spare_batteries(case, passes, refilled, looking, checker)


def _kept_to(one: Pass, looks: Sequence[Look]) -> Pass:
    """A pass that may look at nothing else than it does."""
    network = one.network
    way = np.array([look.way for look in looks], np.intp) - int(network.way[0])
    step = np.array([look.first_step for look in looks], np.intp) - network.first_step
    begins = np.zeros_like(network.begins)
    begins[network.offset[way] + step - network.first[way]] = True
    return replace(one, network=network._replace(begins=begins))


class Solution(NamedTuple):
    """Looks of every pass, the passes, the looks before batteries were spared, and the bound."""

    chosen: Passes
    passes: list[Pass]
    unspared: Passes
    greedy_value: float
    bound: float


def solve(case: Case, tell: Callable[[str], None]) -> Solution:
    """Choose looks as a campaign does, then spare batteries."""
    passes = passes_of(case)
    tasks = case.tasks
    looking = Looking(
        length_steps=tasks.steps[:, None],
        look_value=tasks.weight[:, None],
        look_limit=np.ones(len(tasks.weight)),
        group=np.full(len(tasks.weight), -1),
        way_to=np.empty(0, np.intp),
        way_limit=np.empty(0),
        settle_steps=np.zeros(len(passes), np.intp),
    )
    tell(f"{len(passes)} passes, {sum(len(one.network.way) for one in passes)} times in view")
    checker = Checker(case, passes)
    networks = [one.network for one in passes]
    priced = PricedPasses(networks, networks, looking, checker.first_unheld)
    choice = choose(priced, tell_nobody, FLEET)
    bound = bound_at(priced, choice.price, FLEET)
    tell(f"chosen: {choice.value:g} of at most {bound:.1f}, greedy {choice.greedy_value:g}")
    unspared = list(choice.passes)
    return Solution(
        chosen=spare_batteries(case, passes, unspared, looking, checker),
        passes=passes,
        unspared=unspared,
        greedy_value=choice.greedy_value,
        bound=bound,
    )


def actions_of(case: Case, passes: Sequence[Pass], chosen: Passes) -> list[dict[str, str]]:
    """In the benchmark's format."""

    def utc(step: int) -> str:
        moment = case.start_utc + timedelta(seconds=step * case.step_s)
        return moment.strftime("%Y-%m-%dT%H:%M:%SZ")

    return [
        {
            "type": "observation",
            "satellite_id": one.satellite.id,
            "task_id": case.tasks.ids[look.target],
            "start_time": utc(look.first_step),
            "end_time": utc(look.first_step + int(case.tasks.steps[look.target])),
        }
        for one, looks in zip(passes, chosen, strict=True)
        for look in looks
    ]


def stage_clock() -> Callable[[str], None]:
    """Tells a stage as it ends, with the processor's seconds since the one before."""
    last = time.process_time()

    def tell(what: str) -> None:
        nonlocal last
        now = time.process_time()
        print(f"{now - last:6.1f} s  {what}")
        last = now

    return tell


def main() -> None:
    folder, *out = map(Path, sys.argv[1:] or [SMALL])
    begun, tell = time.process_time(), stage_clock()
    case = read_case(folder)
    tell(f"{folder.name}: {len(case.satellites)} satellites, {len(case.tasks.ids)} targets")
    chosen, passes, _, _, bound = solve(case, tell)
    weight = case.tasks.weight
    value = sum(look.value for looks in chosen for look in looks)
    tell(f"batteries spared: {value:g}")
    grain = 0.5 if not (weight % 0.5).any() else 0.0
    gap = bound - value
    whole = float(weight.sum())
    proof = "optimal" if gap < grain else f"at most {gap:.2f} of weight more, {gap / whole:.3%}"
    print(f"WCR {value / whole:.5f}, bound {bound / whole:.5f}: {proof}")
    _print_left_out(case, passes, chosen)
    if out:
        out[0].write_text(json.dumps({"actions": actions_of(case, passes, chosen)}, indent=1))
    print(f"{time.process_time() - begun:.1f} s of the processor")


def _print_left_out(case: Case, passes: Sequence[Pass], chosen: Passes) -> None:
    tasks = case.tasks
    taken = {look.target for looks in chosen for look in looks}
    seen = {target for one in passes for target in one.network.target.tolist()}
    left = np.array(sorted(seen - taken), np.intp)
    worth = Worth(tasks.steps[:, None], tasks.weight[:, None], np.zeros(len(tasks.ids)))
    exchanged = [
        Exchanged(number, one.network, looks, worth)
        for number, (one, looks) in enumerate(zip(passes, chosen, strict=True))
    ]
    found = displaced_by(exchanged, left)
    costs = np.array([sum(look.value for look in one.by) - one.look.value for one in found])
    counts = [int(np.count_nonzero(costs <= most)) for most in (0.0, 0.5, 1.0, 2.0)]
    print(
        f"left out {len(tasks.ids) - len(taken)}: {len(tasks.ids) - len(seen)} never in reach, "
        f"{len(found)} displaced; forced in, they cost at most 0, 0.5, 1 and 2 of weight: "
        f"{', '.join(map(str, counts))}"
    )


if __name__ == "__main__":
    main()
