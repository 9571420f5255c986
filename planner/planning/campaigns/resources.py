"""Battery and memory over a campaign: rows of its programmes, and what is chosen, simulated.

A resource is told as the room that is left: of a battery its charge above the least, of a memory
what may still be written.  Room that comes and finds no place is lost, so that at t there is the
least of `begin + came(0, t) - used(0, t)` and, for every s before, of `most + came(s, t) - used(s,
t)`.  It never ends where no stretch uses more than it has: each stretch is a row of the programmes,
linear in what passes use.  Rows join as a choice breaks them.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from functools import cached_property
from typing import NamedTuple

import numpy as np

from planner.base.arrays import Array, Indices
from planner.base.errors import ResourceRunsOut, figures
from planner.base.reporting import Reporter
from planner.base.rotation import Rotation
from planner.motion.attitude.idle import idle_attitude
from planner.planning.campaigns.candidates import LookCandidate
from planner.planning.campaigns.choice import (
    OPTIONS,
    CampaignChoice,
    ChoiceOptions,
    FirstUnheld,
    Looking,
    Mixture,
    Passes,
    Proposal,
    Rows,
    Search,
    best_mixture,
    best_together,
    bound_at,
    choose,
    worth_of,
)
from planner.planning.campaigns.displaced import Displaced
from planner.planning.campaigns.network import NO_COST, Network
from planner.planning.campaigns.path import Look, Path, Worth
from planner.planning.campaigns.request import CampaignRequest
from planner.planning.campaigns.ways import Ways
from planner.planning.resources import LightAndContacts, panels_w, sun_eci
from planner.world.frames.earth_orientation import c_itrf_from_eci
from planner.world.frames.time_scales import Instants, shifted_utc, utc_text
from planner.world.orbits import Ephemeris
from planner.world.platforms import BodyPlatform
from planner.world.resources import Battery, ResourceName, Resources


@dataclass(frozen=True, kw_only=True)
class KeepingOptions:
    """How resources are followed over a campaign, and a choice that keeps them is sought."""

    step_s: float = 10.0  # of charge by panels, linear between: the Sun's cosine errs by 2e-5
    tick_s: float = 30.0  # between looks at a level within a pass, where panels charge
    slew_parts: int = 4  # of a slew, in which the charge of panels is linear
    rounding: float = 1e-9  # of a capacity
    rows_a_round: int = 20  # of each resource, the most broken first
    rounds: int = 12  # of rows that a programme's answer breaks
    dearer: int = 10  # halvings of what a second costs, until a pass's path fits
    fill_every: int = 5  # mixtures between whole choices at the prices reached


KEEPING = KeepingOptions()


class _Stretch(NamedTuple):
    """A row: what passes use of one resource over it is at most `room`, a share of the capacity.

    store: number of the resource.  from_s, to_s: on the carrier's clock.
    """

    store: int
    from_s: float
    to_s: float
    room: float


class _Curve(NamedTuple):
    """What a pass uses of a resource from its start to its stop, linear in between, (m,)."""

    t_s: Array
    used: Array


@dataclass(frozen=True, kw_only=True, eq=False)
class _Store:
    """One resource, all in shares of its capacity.

    begins, most: the room at first, and at most.  t_s, came: what comes while the platform rests,
    less what it takes then, since the campaign's start, linear in between, (n,).  looking, moving:
    used in a second of a look, and of any other of a pass.  extra: what panels would have brought
    at their best attitude beyond the idle one, as `came`; None where no attitude counts.
    """

    name: ResourceName
    unit: str
    capacity: float
    limit: float
    begins: float
    most: float
    t_s: Array
    came: Array
    looking: float
    moving: float
    extra: Array | None = None

    @cached_property
    def turns(self) -> tuple[Array, Array]:
        """When what came is greatest or least, and the ends, with it: no room is less between."""
        rises = np.sign(np.diff(self.came))
        at = np.flatnonzero(rises[1:] != rises[:-1]) + 1
        rows = np.concatenate([[0], at, [len(self.t_s) - 1]])
        return self.t_s[rows], self.came[rows]

    def came_by(self, t_s: Array) -> Array:
        return np.interp(t_s, self.t_s, self.came)

    def level(self, room: Array) -> Array:
        """What it holds, in its unit."""
        if self.name == "memory":
            return np.clip(self.limit - room * self.capacity, 0.0, self.capacity)
        return np.clip(self.limit + room * self.capacity, self.limit, self.capacity)


class _Room(NamedTuple):
    """The room left of a resource, (m,), and what it would be if none were lost."""

    t_s: Array
    left: Array
    whole: Array


@dataclass(frozen=True, kw_only=True)
class RunsOut:
    """The resource that a choice would take too much of.

    at_s: when it passes its limit.  short: by how much in the end, in its unit.
    """

    name: ResourceName
    unit: str
    limit: float
    at_s: float
    short: float

    @property
    def told(self) -> str:
        return f"the {self.name} would pass its limit of {self.limit:g} {self.unit}"


class _Charging(LightAndContacts):
    """Light and contacts of a campaign, and what panels give at rest or at any attitude."""

    def __init__(self, request: CampaignRequest, ephemeris: Ephemeris) -> None:
        assert request.resources is not None
        self.epoch_utc, self.last_s = request.start, request.span_s
        self.ephemeris, self.resources = ephemeris, request.resources

    def power_w(self, t_s: Array, q_body_from_eci: Rotation) -> Array:
        """What panels would give in sunlight, (n,)."""
        return self._charge_w(*self.at(t_s), q_body_from_eci)


class Keeping:
    """The resources of a campaign: what passes use of each, and whether there is so much.

    A pass moves from its start to its stop wherever it does not look: its plan may wait meanwhile,
    and use less.  What panels give on a body's slews is that of the shortest turn.
    """

    def __init__(
        self,
        request: CampaignRequest,
        candidates: Sequence[LookCandidate],
        ways: Ways,
        networks: Sequence[Network],
        looking: Looking,
        ephemeris: Ephemeris,
        grid_s: float,
        rest_s: float,
    ) -> None:
        """Raises ResourceRunsOut where a resource does without any look."""
        assert request.resources is not None
        self._request, self._candidates, self._ways = request, candidates, ways
        self._looking, self._grid_s, self._rest_s = looking, grid_s, rest_s
        self._resources: Resources = request.resources
        self._around = _Charging(request, ephemeris)
        self._spans_s = [
            (
                grid_s + one.first_step * request.step_s - rest_s,
                grid_s + (one.first_step + one.stop_step) * request.step_s + rest_s,
            )
            for one in networks
        ]
        self._attitudes: _Attitudes | None = None
        self._stores = tuple(self._stores_of())
        self._curves: dict[Proposal, tuple[_Curve, ...]] = {}
        self._fixed_known: dict[tuple[int, _Stretch], float] = {}
        if (out := self.runs_out([])) is not None:
            raise ResourceRunsOut(
                f"the {out.name} passes its limit of {out.limit:g} {out.unit} at "
                f"{utc_text(self.utc(out.at_s), 1)}, in the end by {figures(out.short)} "
                f"{out.unit}, without any look; {_IDLE_WAYS[out.name]}, or let the campaign stop "
                "sooner",
                field=f"resources.{out.name}",
                limit=out.name,
                at_utc=self.utc(out.at_s),
            )

    def utc(self, t_s: float) -> datetime:
        return shifted_utc(self._request.start, t_s)

    def _stores_of(self) -> Iterator[_Store]:
        battery, memory = self._resources.battery, self._resources.memory
        around, last_s = self._around, self._around.last_s
        if battery is not None:
            yield self._battery(battery)
        if memory is not None:
            contacts = tuple(span for _, span in around.contacts)
            t_s = np.unique([0.0, last_s, *(end for span in contacts for end in span)])
            sends = np.array([_inside(at_s, contacts) for at_s in 0.5 * (t_s[1:] + t_s[:-1])])
            sent = np.diff(t_s) * sends * memory.downlink_gbit_s / memory.capacity_gbit
            yield _Store(
                name="memory",
                unit="Gbit",
                capacity=memory.capacity_gbit,
                limit=memory.capacity_gbit,
                begins=1.0 - memory.start_gbit / memory.capacity_gbit,
                most=1.0,
                t_s=t_s,
                came=np.append(0.0, np.cumsum(sent)),
                looking=memory.imaging_gbit_s / memory.capacity_gbit,
                moving=0.0,
            )

    def _battery(self, battery: Battery) -> _Store:
        around, platform = self._around, self._request.platform
        edges_s = [end for span in around.lit for end in span]
        t_s = np.unique(np.concatenate([[0.0, around.last_s], edges_s]))
        charge_w, best_w = np.full(len(t_s), battery.sunlight_w or 0.0), 0.0
        if battery.panels:
            count = max(math.ceil(around.last_s / KEEPING.step_s), 8)
            t_s = np.unique(np.concatenate([np.linspace(0.0, around.last_s, count + 1), edges_s]))
            if isinstance(platform, BodyPlatform):
                self._attitudes = _Attitudes.of(platform, around)
                best_w = _most_w(battery)
                charge_w = self._attitudes.idle_w(t_s)
            else:
                instants, states = around.at(t_s)
                law = self._request.opportunities().law
                charge_w = around.power_w(t_s, law.q_body_from_eci(instants, states))
        middle_s = 0.5 * (t_s[1:] + t_s[:-1])
        starts, stops = np.array(around.lit).reshape(-1, 2).T
        row = np.searchsorted(starts, middle_s) - 1
        is_lit = (row >= 0) & (middle_s < np.append(stops, 0.0)[row])
        lit_s = np.diff(t_s) * is_lit
        scale = 1.0 / (3600.0 * battery.capacity_wh)
        mean_w = 0.5 * (charge_w[1:] + charge_w[:-1])
        came = mean_w * lit_s - battery.idle_w * np.diff(t_s)
        if self._attitudes is not None:
            self._attitudes.lit = t_s, np.append(0.0, np.cumsum(lit_s))
        return _Store(
            name="battery",
            unit="Wh",
            capacity=battery.capacity_wh,
            limit=battery.least_wh,
            begins=(battery.begins_wh - battery.least_wh) / battery.capacity_wh,
            most=1.0 - battery.least_wh / battery.capacity_wh,
            t_s=t_s,
            came=np.append(0.0, np.cumsum(scale * came)),
            looking=scale * battery.imaging_w,
            moving=scale * battery.slew_w,
            extra=(
                np.append(0.0, np.cumsum(scale * np.maximum(best_w - mean_w, 0.0) * lit_s))
                if self._attitudes is not None
                else None
            ),
        )

    def curves(self, number: int, looks: tuple[Look, ...]) -> tuple[_Curve, ...]:
        """What a pass with these looks uses of each resource."""
        known = self._curves.get((number, looks))
        if known is None:
            known = self._curves[number, looks] = self._curves_of(looks)
        return known

    def ends_s(self, look: Look) -> tuple[float, float]:
        begin_s = self._grid_s + look.first_step * self._request.step_s
        return begin_s, begin_s + self._candidates[look.target].lengths_s[look.length]

    def _curves_of(self, looks: tuple[Look, ...]) -> tuple[_Curve, ...]:
        if not looks:
            return tuple(_Curve(np.zeros(0), np.zeros(0)) for _ in self._stores)
        ends_s = np.array([end for look in looks for end in self.ends_s(look)])
        t_s = np.concatenate([[ends_s[0] - self._rest_s], ends_s, [ends_s[-1] + self._rest_s]])
        found = []
        for store in self._stores:
            rates = np.full(len(t_s) - 1, store.moving)
            rates[1::2] = store.looking
            curve = _Curve(t_s, np.append(0.0, np.cumsum(rates * np.diff(t_s))))
            if store.name == "battery" and self._attitudes is not None:
                curve = self._turned(store, curve, looks)
            found.append(curve)
        return tuple(found)

    def _turned(self, store: _Store, rested: _Curve, looks: tuple[Look, ...]) -> _Curve:
        """With what panels bring more, or less, than in the idle attitude."""
        assert self._attitudes is not None
        states = []
        for look in looks:
            begin_s, stop_s = self.ends_s(look)
            row = int(self._ways.offset[look.way] - self._ways.first_step[look.way])
            step = look.first_step + math.ceil((stop_s - begin_s) / self._request.step_s - 1e-9)
            begin = self._ways.begin_states[row + look.first_step, :4]
            states += [(begin_s, begin), (stop_s, self._ways.states[row + step, :4])]
        t_s, brought_ws = self._attitudes.brought_ws(
            states, float(rested.t_s[0]), float(rested.t_s[-1])
        )
        scale = 1.0 / (3600.0 * store.capacity)
        idle_w = self._resources.battery.idle_w if self._resources.battery else 0.0
        at_rest = store.came_by(t_s) - store.came_by(t_s[:1])
        at_rest += scale * idle_w * (t_s - t_s[0])
        used = np.interp(t_s, *rested) + at_rest - scale * brought_ws
        return _Curve(t_s, used)

    def _room(self, number: int, curves: Sequence[_Curve]) -> _Room:
        """curves: of all passes, in order of time."""
        store = self._stores[number]
        given = [one for one in curves if len(one.t_s)]
        fixed_s, fixed = store.turns
        if given:
            knots_s = np.concatenate([one.t_s for one in given])
            before = np.cumsum([0.0, *(one.used[-1] for one in given)])
            used = np.concatenate(
                [one.used + more for one, more in zip(given, before, strict=False)]
            )
            ticks_s = knots_s[:0]
            if self._resources.battery and self._resources.battery.panels:
                ticks_s = np.concatenate(
                    [np.arange(one.t_s[0], one.t_s[-1], KEEPING.tick_s) for one in given]
                )
            t_s = np.concatenate([fixed_s, knots_s, ticks_s])
            came = np.concatenate([fixed, store.came_by(knots_s), store.came_by(ticks_s)])
            order = np.argsort(t_s, kind="stable")
            t_s = t_s[order]
            whole = store.begins + came[order] - np.interp(t_s, knots_s, used, left=0.0)
        else:
            t_s, whole = fixed_s, store.begins + fixed
        lost = np.maximum.accumulate(np.maximum(whole - store.most, 0.0))
        return _Room(t_s, whole - lost, whole)

    def _all_curves(
        self, passes: Sequence[tuple[Look, ...]], number: int = -1, looks: tuple[Look, ...] = ()
    ) -> list[tuple[_Curve, ...]]:
        return [self.curves(n, looks if n == number else one) for n, one in enumerate(passes)]

    def keeps(
        self, passes: Sequence[tuple[Look, ...]], number: int = -1, looks: tuple[Look, ...] = ()
    ) -> bool:
        """Whether no resource runs out, with other looks in one pass."""
        curves = self._all_curves(passes, number, looks)
        return all(
            self._room(n, [one[n] for one in curves]).left.min() >= -KEEPING.rounding
            for n in range(len(self._stores))
        )

    def runs_out(self, passes: Sequence[tuple[Look, ...]]) -> RunsOut | None:
        """The first resource that does."""
        curves, found = self._all_curves(passes), []
        for n, store in enumerate(self._stores):
            room = self._room(n, [one[n] for one in curves])
            beyond = np.flatnonzero(room.left < -KEEPING.rounding)
            if len(beyond):
                k = max(int(beyond[0]), 1)
                before, after = room.left[k - 1], room.left[k]
                share = min(max(before / (before - after), 0.0), 1.0) if before != after else 0.0
                found.append(
                    RunsOut(
                        name=store.name,
                        unit=store.unit,
                        limit=store.limit,
                        at_s=float(room.t_s[k - 1] + share * (room.t_s[k] - room.t_s[k - 1])),
                        short=-float(room.left.min()) * store.capacity,
                    )
                )
        return min(found, key=lambda one: one.at_s, default=None)

    def lacks(self, passes: Sequence[tuple[Look, ...]], left_out: Displaced) -> RunsOut | None:
        """The resource that a look would take too much of in the place of those it displaces, which
        are worth less."""
        if left_out.value <= sum(look.value for look in left_out.by):
            return None
        look = Look(
            target=left_out.target,
            way=left_out.way,
            first_step=left_out.first_step,
            length=left_out.length,
            value=left_out.value,
        )
        kept = [one for one in passes[left_out.pass_number] if one not in left_out.by]
        passes = list(passes)
        own = sorted([*kept, look], key=lambda one: one.first_step)
        passes[left_out.pass_number] = tuple(own)
        return self.runs_out(passes)

    def broken(
        self, mixed: Sequence[Sequence[tuple[float, tuple[_Curve, ...]]]]
    ) -> Iterator[_Stretch]:
        """Stretches over which more is used than there is, the worst first, of each resource.

        mixed: of each pass, shares of what it uses.
        """
        for n, store in enumerate(self._stores):
            room = self._room(n, [_mixed([(share, of[n]) for share, of in one]) for one in mixed])
            below = room.left < -KEEPING.rounding
            ends = np.flatnonzero(
                below
                & (room.left <= np.append(room.left[1:], np.inf))
                & (room.left < np.append(np.inf, room.left[:-1]))
            )
            for end in ends[np.argsort(room.left[ends], kind="stable")][: KEEPING.rows_a_round]:
                begin = int(np.argmax(room.whole[: end + 1]))
                is_full = room.whole[begin] > store.most
                from_s = float(room.t_s[begin]) if is_full else 0.0
                yield self._stretch(n, from_s, float(room.t_s[end]))

    @property
    def step_s(self) -> float:
        """Of the grid on which looks begin."""
        return self._request.step_s

    def is_in(self, number: int, row: _Stretch) -> bool:
        """Whether a pass may use anything in a stretch."""
        start_s, stop_s = self._spans_s[number]
        return stop_s > row.from_s and start_s < row.to_s

    def _stretch(self, n: int, from_s: float, to_s: float) -> _Stretch:
        store = self._stores[n]
        came = store.came_by(np.array([from_s, to_s]))
        room = (store.most if from_s > 0.0 else store.begins) + float(came[1] - came[0])
        return _Stretch(n, from_s, to_s, room)

    def used(self, proposals: Sequence[Proposal], rows: Sequence[_Stretch]) -> Array:
        """What each takes over each stretch, as simulated, (rows, proposals)."""
        taken = np.zeros((len(rows), len(proposals)))
        ends_s = np.array([(one.from_s, one.to_s) for one in rows]).reshape(-1, 2)
        for column, proposal in enumerate(proposals):
            curves = self.curves(*proposal)
            for n, curve in enumerate(curves):
                own = np.flatnonzero([one.store == n for one in rows])
                if len(own) and len(curve.t_s):
                    at = np.interp(ends_s[own], curve.t_s, curve.used)
                    taken[own, column] = at[:, 1] - at[:, 0]
        return taken

    def used_at_least(self, proposals: Sequence[Proposal], rows: Sequence[_Stretch]) -> Array:
        """As `used`, by whole steps of looks alone, and of each pass what any of its paths uses."""
        taken = np.zeros((len(rows), len(proposals)))
        step_s, held = self._request.step_s, self._looking.held_steps
        from_s, to_s = np.array([(one.from_s, one.to_s) for one in rows]).reshape(-1, 2).T
        rate = np.array([self._stores[one.store].looking for one in rows])
        for column, (number, looks) in enumerate(proposals):
            begin_s = self._grid_s + step_s * np.array([[look.first_step] for look in looks])
            held_steps = [[held[look.target, look.length]] for look in looks]
            end_s = begin_s + step_s * np.array(held_steps)
            within_s = np.minimum(end_s, to_s) - np.maximum(begin_s, from_s)
            taken[:, column] = rate * np.maximum(within_s, 0.0).sum(axis=0)
            taken[:, column] += [self._fixed(number, one) for one in rows]
        return taken

    def _fixed(self, number: int, row: _Stretch) -> float:
        """What a pass with any look uses beside them at least; negative where panels may bring more
        than at rest."""
        if (known := self._fixed_known.get((number, row))) is None:
            known = self._fixed_known[number, row] = self._fixed_of(number, row)
        return known

    def _fixed_of(self, number: int, row: _Stretch) -> float:
        store, (start_s, stop_s) = self._stores[row.store], self._spans_s[number]
        if stop_s <= row.from_s or start_s >= row.to_s:
            return 0.0
        is_whole = row.from_s <= start_s and stop_s <= row.to_s
        moved = 2.0 * self._rest_s * store.moving if is_whole else 0.0
        if store.extra is None:
            return moved
        more = np.interp([start_s, stop_s], store.t_s, store.extra)
        return moved - float(more[1] - more[0])

    def priced(
        self, networks: Sequence[Network], rows: Sequence[_Stretch], row_price: Array
    ) -> tuple[list[Network], list[float], float]:
        """The networks with what looks pay, what each pass with any look pays beside, and the worth
        of all room."""
        rate = row_price * [self._stores[one.store].looking for one in rows]
        rents = [
            sum(
                price * self._fixed(number, one)
                for price, one in zip(row_price.tolist(), rows, strict=True)
            )
            for number in range(len(networks))
        ]
        dear = []
        for network in networks:
            steps = network.first_step + np.arange(network.stop_step + 1)
            t_s = self._grid_s + self._request.step_s * steps
            cost = np.zeros(len(t_s))
            for price, one in zip(rate.tolist(), rows, strict=True):
                if price > 0.0 and one.from_s < t_s[-1] and t_s[0] < one.to_s:
                    cost += price * np.clip(t_s - one.from_s, 0.0, one.to_s - one.from_s)
            dear.append(network._replace(cost=cost))
        return dear, rents, float(row_price @ [one.room for one in rows])

    def dear(self, network: Network, price_s: float) -> Network:
        """A network whose looks pay for each second."""
        seconds = self._request.step_s * np.arange(network.stop_step + 1)
        return network._replace(cost=np.asarray(price_s * seconds + _cost_of(network)))

    def levels(self, passes: Sequence[tuple[Look, ...]], t_s: Array) -> dict[ResourceName, Array]:
        """What each resource holds at instants, (n,), in its unit, as simulated."""
        curves = self._all_curves(passes)
        rooms = [self._room(n, [one[n] for one in curves]) for n in range(len(self._stores))]
        return {
            store.name: store.level(np.interp(t_s, room.t_s, room.left))
            for store, room in zip(self._stores, rooms, strict=True)
        }

    def begins(self, passes: Sequence[tuple[Look, ...]]) -> list[Resources]:
        """What each pass with looks begins with."""
        starts_s = [self.ends_s(looks[0])[0] - self._rest_s for looks in passes if looks]
        levels = self.levels(passes, np.array(starts_s))
        found = []
        for number in range(len(starts_s)):
            begins = self._resources
            if begins.battery is not None:
                level = float(levels["battery"][number])
                begins = replace(begins, battery=replace(begins.battery, start_wh=level))
            if begins.memory is not None:
                level = float(levels["memory"][number])
                begins = replace(begins, memory=replace(begins.memory, start_gbit=level))
            found.append(begins)
        return found


_IDLE_WAYS = {
    "battery": "begin with more, or take less while idle",
    "memory": "begin with less",
}


def _inside(at_s: float, spans: Sequence[tuple[float, float]]) -> bool:
    return any(start_s < at_s < stop_s for start_s, stop_s in spans)


def _cost_of(network: Network) -> Array:
    return network.cost if len(network.cost) else np.zeros(network.stop_step + 1)


def _mixed(shares: Sequence[tuple[float, _Curve]]) -> _Curve:
    """The sum of shares."""
    shares = [(share, curve) for share, curve in shares if len(curve.t_s)]
    if not shares:
        return _Curve(np.zeros(0), np.zeros(0))
    t_s = np.unique(np.concatenate([curve.t_s for _, curve in shares]))
    used = sum(share * np.interp(t_s, *curve) for share, curve in shares)
    return _Curve(t_s, np.asarray(used))


def _most_w(battery: Battery) -> float:
    """No attitude's panels give more in sunlight: all sets of them that the Sun may shine on."""
    powers = np.array([panel.power_w * panel.normal for panel in battery.panels])
    sums = np.zeros((1, 3))
    for power in powers:
        sums = np.concatenate([sums, sums + power])
    return float(np.linalg.norm(sums, axis=1).max())


@dataclass(kw_only=True, eq=False)
class _Attitudes:
    """A body's attitudes in a campaign, and what its panels give there.

    In the axes of ways, which stand still.  lit: seconds of sunlight since the start, by time.
    """

    around: _Charging
    t_s: Array
    q_still_from_body: Rotation
    sun_still: Array
    at_rest_w: Array
    lit: tuple[Array, Array]

    @classmethod
    def of(cls, platform: BodyPlatform, around: _Charging) -> "_Attitudes":
        count = max(math.ceil(around.last_s / KEEPING.step_s), 8)
        t_s = np.linspace(0.0, around.last_s, count + 1)
        instants, states = around.at(t_s)
        q_eci_from_body = Rotation.from_quat(
            idle_attitude(platform.idle, instants, states).position
        )
        # Precession and the pole move by some arcseconds in a month.
        still_from_eci = Rotation.from_matrix(
            c_itrf_from_eci(Instants(around.epoch_utc, np.zeros(1)))[0]
        )
        return cls(
            around=around,
            t_s=t_s,
            q_still_from_body=still_from_eci * q_eci_from_body,
            sun_still=still_from_eci.apply(sun_eci(instants, states)),
            at_rest_w=around.power_w(t_s, q_eci_from_body.inv()),
            lit=(t_s, t_s),
        )

    def idle_w(self, t_s: Array) -> Array:
        return np.interp(t_s, self.t_s, self.at_rest_w)

    def brought_ws(
        self, states: Sequence[tuple[float, Array]], start_s: float, stop_s: float
    ) -> tuple[Array, Array]:
        """What panels bring from a pass's start to its stop, by time.

        states: when, and the attitude, at each begin and end of a look.
        """
        known_s = np.array([start_s, *(at_s for at_s, _ in states), stop_s])
        ends = self.q_still_from_body[self._nearest(known_s[[0, -1]])].as_quat()
        turned = Rotation.from_quat(np.concatenate([ends[:1], [q for _, q in states], ends[1:]]))
        whole = (turned[:-1].inv() * turned[1:]).as_rotvec()
        parts = np.arange(KEEPING.slew_parts) / KEEPING.slew_parts
        smooth = parts**3 * (10.0 - 15.0 * parts + 6.0 * parts**2)
        t_s = (known_s[:-1, None] + np.diff(known_s)[:, None] * parts).ravel()
        flown = np.repeat(np.arange(len(whole)), len(parts))
        # A look follows its target evenly, and slews go smoothly from rest to rest.
        share = np.where((np.arange(len(whole)) % 2 == 1)[:, None], parts, smooth).ravel()
        q_still_from_body = turned[flown] * Rotation.from_rotvec(share[:, None] * whole[flown])
        q_still_from_body = Rotation.concatenate([q_still_from_body, turned[-1:]])
        t_s = np.append(t_s, known_s[-1])
        sun = np.stack([np.interp(t_s, self.t_s, axis) for axis in self.sun_still.T], axis=1)
        sun_body = q_still_from_body.inv().apply(sun / np.linalg.norm(sun, axis=1, keepdims=True))
        assert self.around.resources.battery is not None
        power_w = panels_w(self.around.resources.battery, sun_body)
        lit_s = np.diff(np.interp(t_s, *self.lit))
        return t_s, np.append(0.0, np.cumsum(0.5 * (power_w[1:] + power_w[:-1]) * lit_s))

    def _nearest(self, t_s: Array) -> list[int]:
        step_s = float(self.t_s[1] - self.t_s[0])
        return [round(min(max(at_s / step_s, 0.0), len(self.t_s) - 1.0)) for at_s in t_s.tolist()]


def choose_keeping(
    keeping: Keeping | None,
    networks: Sequence[Network],
    looking: Looking,
    tell: Reporter,
    first_unheld: FirstUnheld,
    options: ChoiceOptions = OPTIONS,
) -> tuple[CampaignChoice, tuple[_Stretch, ...]]:
    """As `choose`, and the rows that its `row_price` is of.

    A choice that keeps all resources without being asked to stays as it is.  Else passes are filled
    by their best paths at a price for each second of a look, as low as lets all resources keep;
    prices of stretches come from the programmes' rows, with those of targets.
    """
    free = choose(networks, looking, tell, first_unheld, options)
    if keeping is None or keeping.keeps(free.passes):
        return free, ()
    search = _KeepingSearch(networks, looking, first_unheld, options, keeping, free)
    greedy = search.fill_passes([()] * len(networks), np.zeros(len(looking.look_limit)))
    search.refill_passes(greedy)
    search.refill_passes(list(free.passes))
    search.take_groups()
    mixture = search.mix_prices(tell)
    if mixture is not None:
        search.make_whole(mixture, tell)
    search.put_together(tell)
    search.take_groups()
    search.fill_exactly()
    priced = search
    if search.was_barred:
        # The bound's networks are not: its prices are found without.
        priced = _KeepingSearch(networks, looking, lambda looks: None, options, keeping, free)
        priced.mix_prices(tell)
    choice = CampaignChoice(
        passes=tuple(search.best),
        value=search.value,
        greedy_value=worth_of(greedy),
        price=priced.price,
        row_price=priced.row_price,
    )
    return choice, tuple(priced.rows[: len(priced.row_price)])


def bound_keeping(
    keeping: Keeping | None,
    networks: Sequence[Network],
    looking: Looking,
    choice: CampaignChoice,
    rows: Sequence[_Stretch],
) -> float:
    """As `bound_at`, of choices that keep all resources.

    No such choice uses more over a stretch than there is; each pass is taken to use what its looks
    do for their whole steps, and the ways from rest and back, with panels of a body at their best
    all the while: no more than it does.
    """
    if keeping is None or not rows:
        return bound_at(networks, looking, choice.price)
    dear, rents, room_value = keeping.priced(networks, rows, choice.row_price)
    return bound_at(dear, looking, choice.price, rents=rents, room_value=room_value)


class _KeepingSearch(Search):
    """A search among choices that keep all resources.

    rows: stretches that were ever broken.  row_price: of the first ones, at which the bound is
    least as far as known.
    """

    def __init__(
        self,
        networks: Sequence[Network],
        looking: Looking,
        first_unheld: FirstUnheld,
        options: ChoiceOptions,
        keeping: Keeping,
        free: CampaignChoice,
    ) -> None:
        super().__init__(networks, looking, first_unheld, options)
        self._keeping = keeping
        self.rows: list[_Stretch] = []
        self.row_price: Array = np.zeros(0)
        self.price = free.price
        self._rented: Array | None = None
        self._proposed.update(
            ((number, looks), None) for number, looks in enumerate(free.passes) if looks
        )

    def keeps(self, passes: Passes, number: int, looks: tuple[Look, ...]) -> bool:
        return self._keeping.keeps(passes, number, looks)

    def fill_passes(self, start: Passes, price: Array) -> Passes:
        """At prices of targets those of rows count, too."""
        self._rented = self.row_price if price.any() and len(self.row_price) else None
        return super().fill_passes(start, price)

    def refill_passes(self, passes: Passes) -> None:
        super().refill_passes(self._repaired(passes))

    def mix_prices(self, tell: Reporter) -> tuple[Mixture, list[Proposal]] | None:
        """Prices of targets and rows by mixtures, and choices at them; the last mixture."""
        options, found = self._options, None
        most = max(options.proposals_a_pass * len(self._networks), options.proposals_least)
        self._answer(self.price, self.row_price)
        for done in range(options.mixtures_max):
            if self._is_near() or not self._proposed:
                break
            tell("mixing", done, options.mixtures_max)
            proposals = list(dict.fromkeys([*list(self._proposed)[-most:], *self._own_proposals()]))
            mixture = self._mixed(proposals, self._looking.look_limit, ())
            if mixture is None:
                break
            found = mixture, proposals
            known, bound = len(self._proposed), self._bound
            row_price = _as_long(self.row_price, mixture.row_price)
            self._answer(0.5 * (self.price + mixture.price), 0.5 * (row_price + mixture.row_price))
            if self._bound - mixture.value > options.mixture_enough * self._bound:
                self._answer(mixture.price, mixture.row_price)
            if done % KEEPING.fill_every == 0:
                self.refill_passes(self.fill_passes([()] * len(self._networks), self.price))
            enough = options.mixture_enough * self._bound
            is_still = len(self._proposed) == known and bound - self._bound < enough
            if self._bound - mixture.value <= enough or is_still:
                break
        return found

    def _answer(self, price: Array, row_price: Array) -> None:
        """What the passes would take at these prices, and what the Lagrangian then is."""
        rows = self.rows[: len(row_price)]
        dear, rents, room_value = self._keeping.priced(self._free, rows, row_price)
        worth = self._looking.less_prices(price)
        lagrangian = float(self._looking.allowed(price) @ price) + room_value
        for number, (network, rent) in enumerate(zip(dear, rents, strict=True)):
            path = self._at(number, network.cost, worth)
            lagrangian += max(path.value - rent, 0.0)
            if path.looks:
                self._proposed.pop((number, path.looks), None)  # the latest come last
                self._proposed[number, path.looks] = None
        if lagrangian < self._bound:
            self._bound, self.price, self.row_price = lagrangian, price, row_price

    def _at(self, number: int, cost: Array, worth: Worth) -> Path:
        """The best path of a pass whose looks pay."""
        self._networks[number] = self._networks[number]._replace(cost=cost)
        path = self._held_path(number, worth)
        self._networks[number] = self._networks[number]._replace(cost=NO_COST)
        return path

    def _mixed(
        self, proposals: Sequence[Proposal], left_limit: Array, fixed: Passes | tuple[()]
    ) -> Mixture | None:
        """Rows that the mixture breaks join, until it breaks none."""
        own = [(number, looks) for number, looks in enumerate(fixed) if looks]
        mixture = None
        for _ in range(KEEPING.rounds):
            rows = self._further(self._keeping.used_at_least, proposals, own)
            mixture = best_mixture(proposals, len(self._networks), self._looking, left_limit, rows)
            if mixture is None or not self._joined(proposals, mixture.share, own):
                break
        if mixture is None or len(mixture.row_price) == len(self.rows):
            return mixture
        return replace(mixture, row_price=_as_long(mixture.row_price, np.zeros(len(self.rows))))

    def _further(
        self,
        used: Callable[[Sequence[Proposal], Sequence[_Stretch]], Array],
        proposals: Sequence[Proposal],
        own: Sequence[Proposal],
    ) -> Rows:
        room = np.array([one.room for one in self.rows])
        return used(proposals, self.rows), room - used(own, self.rows).sum(axis=1)

    def _joined(self, proposals: Sequence[Proposal], share: Array, own: Sequence[Proposal]) -> bool:
        """Whether rows joined that these shares break."""
        mixed: list[list[tuple[float, tuple[_Curve, ...]]]] = [[] for _ in self._networks]
        for (number, looks), part in zip(
            [*proposals, *own], [*share.tolist(), *([1.0] * len(own))], strict=True
        ):
            if part > self._options.worthless:
                mixed[number].append((part, self._keeping.curves(number, looks)))
        known = set(self.rows)
        new = [one for one in self._keeping.broken(mixed) if one not in known]
        self.rows += new
        return bool(new)

    def _together(self, proposals: Sequence[Proposal]) -> list[Proposal]:
        """By what is used as simulated, with rows that the answer breaks, until it breaks none."""
        found: list[Proposal] = []
        for _ in range(KEEPING.rounds):
            used, room = self._further(self._keeping.used, proposals, ())
            scale = np.maximum(np.abs(used).max(axis=1, initial=0.0), self._options.worthless)
            rows = used / scale[:, None], room / scale
            found = best_together(
                proposals, len(self._networks), self._looking, self._options, rows
            )
            if not self._joined(found, np.ones(len(found)), ()):
                break
        return found

    def _gain(self, proposal: Proposal) -> float:
        rows = self.rows[: len(self.row_price)]
        used = self._keeping.used_at_least([proposal], rows)[:, 0]
        return super()._gain(proposal) - float(self.row_price @ used)

    def _fitting_path(self, number: int, worth: Worth, passes: Passes) -> Path:
        """At the least price of a second at which all resources keep beside what others use."""
        network = self._free[number]
        cost = NO_COST
        if self._rented is not None:
            rows = self.rows[: len(self._rented)]
            [dear], _, _ = self._keeping.priced([network], rows, self._rented)
            cost = dear.cost
        path = self._at(number, cost, worth)
        own = sum(look.value - worth.price[look.target] for look in passes[number])
        if path.value <= own + self._options.worthless:
            return path
        if self._keeping.keeps(passes, number, path.looks):
            return _unpaid(path, worth)
        found = [Path(value=0.0, looks=())]
        low, high = 0.0, self._most_a_second(network)
        for _ in range(KEEPING.dearer):
            middle = 0.5 * (low + high)
            dearer = self._keeping.dear(network._replace(cost=cost), middle)
            path = self._at(number, dearer.cost, worth)
            if path.looks:
                self._proposed[number, path.looks] = None
            if self._keeping.keeps(passes, number, path.looks):
                found.append(_unpaid(path, worth))
                high = middle
                continue
            low = middle
            found += self._fewer(number, path, worth, passes)
        return max(found, key=lambda one: one.value)

    def _most_a_second(self, network: Network) -> float:
        """No look of a pass is worth more in a second."""
        targets, looking = network.target, self._looking
        held = looking.held_steps[targets]
        worths = np.where(held > 0, looking.look_value[targets] / np.maximum(held, 1), 0.0)
        return float(worths.max()) / self._keeping.step_s

    def _wanted_proposals(self, part: Indices, price: Array, left_limit: Array) -> list[Proposal]:
        rows = self.rows[: len(self.row_price)]
        dear, _, _ = self._keeping.priced(self._free, rows, self.row_price)
        worth = self._looking.less_prices(np.where(left_limit > 0.0, price, np.inf))
        paths = [(number, self._at(number, dear[number].cost, worth)) for number in part.tolist()]
        return [(number, path.looks) for number, path in paths if path.looks]

    def _fewer(self, number: int, path: Path, worth: Worth, passes: Passes) -> Iterator[Path]:
        """A path that uses too much, without the looks that are worth least for their time."""
        looks = list(path.looks)
        gain = {
            look: (look.value - worth.price[look.target]) / worth.steps[look.target, look.length]
            for look in looks
        }
        for worst in sorted(looks, key=lambda look: gain[look])[:-1]:
            looks.remove(worst)
            if self._looking.group[worst.target] >= 0:
                return
            fewer = self._with_only(number, [look.target for look in looks])
            if self._first_unheld(fewer) is None and self._keeping.keeps(passes, number, fewer):
                self._proposed[number, fewer] = None
                yield _unpaid(Path(value=0.0, looks=fewer), worth)
                return

    def _repaired(self, passes: Passes) -> Passes:
        """Without looks that are worth least for what they use, until all resources keep."""
        passes = list(passes)
        while (row := self._first_broken(passes)) is not None:
            rows = [row]
            taken = [
                (look.value / max(float(used), self._options.worthless), number, look)
                for number, looks in enumerate(passes)
                for look in looks
                for used in self._keeping.used_at_least([(number, (look,))], rows)[:, 0]
                if self._keeping.is_in(number, row)
            ]
            _, number, look = min(taken, key=lambda one: (one[0], one[1], one[2].first_step))
            rest = [one.target for one in passes[number] if one is not look]
            passes[number] = self._with_only(number, rest) if rest else ()
        return passes

    def _first_broken(self, passes: Passes) -> _Stretch | None:
        mixed = [[(1.0, self._keeping.curves(number, one))] for number, one in enumerate(passes)]
        return min(self._keeping.broken(mixed), key=lambda one: one.to_s, default=None)


def _as_long(price: Array, other: Array) -> Array:
    """Prices of rows, none of those that joined since."""
    return np.append(price, np.zeros(max(len(other) - len(price), 0)))


def _unpaid(path: Path, worth: Worth) -> Path:
    """Worth what it is less the prices of targets alone."""
    value = sum(look.value - float(worth.price[look.target]) for look in path.looks)
    return replace(path, value=value)
