"""Resources that looks of a campaign use up: rows of its programmes, and the choice simulated.

A resource is told as the room that is left: of a battery its charge above the least, of a memory
what may still be written.  Room that comes and finds no place is lost, so that at t there is the
least of `begin + came(0, t) - used(0, t)` and, for every s before, of `most + came(s, t) - used(s,
t)`.  It never ends where no stretch uses more than it has: each stretch is a row of the programmes,
linear in what passes use.  Rows join as a choice breaks them.  The imaging of a duty cycle is one
more resource, whose room at t is what no look since `t - span` used.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from functools import cached_property
from typing import NamedTuple

import numpy as np

from planner.base.arrays import Array
from planner.base.errors import ResourceRunsOut, figures
from planner.planning.campaigns.carrier_looks import CarrierLooks, last_row_s
from planner.planning.campaigns.charging import CHARGING, Attitudes, Charging, most_w
from planner.planning.campaigns.choice import Looking
from planner.planning.campaigns.chosen import KeptResource
from planner.planning.campaigns.displaced import Displaced
from planner.planning.campaigns.network import Network
from planner.planning.campaigns.path import Look
from planner.planning.campaigns.programmes import Proposal
from planner.world.frames.time_scales import shifted_utc, utc_text
from planner.world.resources import Battery, Resources


@dataclass(frozen=True, kw_only=True)
class RoomOptions:
    """When a resource is said to run out, and how many stretches in which it does are told."""

    rounding: float = 1e-9  # of a capacity
    rows_a_round: int = 20  # of each resource, the most broken first


OPTIONS = RoomOptions()


class RoomStretch(NamedTuple):
    """A row: what passes use of one resource over it is at most `room`, a share of the capacity.

    store: number of the resource.  from_s, to_s: on the carrier's clock.
    """

    store: int
    from_s: float
    to_s: float
    room_share: float


class Curve(NamedTuple):
    """What a pass uses of a resource from its start to its stop, linear in between, (m,)."""

    t_s: Array
    used_share: Array


@dataclass(frozen=True, kw_only=True, eq=False)
class _Store:
    """One resource, all in shares of its capacity.

    begin, most: the room at first, and at most.  t_s, came: what comes while the platform rests,
    less what it takes then, since the campaign's start, linear in between, (n,).  looking, moving:
    used in a second of a look, and of any other of a pass.  span: after which what was used is
    there again; None: never.  charged: what panels bring of that.
    extra: what they would have brought at their best attitude beyond the idle one; None where no
    attitude counts.
    """

    name: KeptResource
    unit: str
    capacity: float
    limit: float
    begin_share: float
    most_share: float
    t_s: Array
    came_share: Array
    looking_per_s: float
    moving_per_s: float
    span_s: float | None = None
    charged_share: Array | None = None
    extra_share: Array | None = None

    @cached_property
    def turns(self) -> tuple[Array, Array]:
        """When what came is greatest or least, and the ends, with it: no room is less between."""
        rises = np.sign(np.diff(self.came_share))
        at = np.flatnonzero(rises[1:] != rises[:-1]) + 1
        rows = np.concatenate([[0], at, [len(self.t_s) - 1]])
        return self.t_s[rows], self.came_share[rows]

    def came_by(self, t_s: Array) -> Array:
        return np.interp(t_s, self.t_s, self.came_share)

    def level(self, room_share: Array) -> Array:
        """What it holds, in its unit."""
        if self.name == "memory":
            return np.clip(self.limit - room_share * self.capacity, 0.0, self.capacity)
        return np.clip(self.limit + room_share * self.capacity, self.limit, self.capacity)


class _Room(NamedTuple):
    """The room left of a resource, (m,), and what it would be if none were lost."""

    t_s: Array
    left_share: Array
    whole_share: Array


@dataclass(frozen=True, kw_only=True)
class RunsOut:
    """The resource that a choice would take too much of.

    at_s: when it passes its limit.  short: by how much in the end, in its unit.
    """

    name: KeptResource
    unit: str
    limit: float
    at_s: float
    short_value: float

    @property
    def told(self) -> str:
        return (
            f"the {self.name.replace('_', ' ')} would pass its limit of {self.limit:g} {self.unit}"
        )


class Keeping:
    """The resources of a campaign: what passes use of each, and whether there is so much.

    A pass moves from its start to its stop wherever it does not look: its plan may wait meanwhile,
    and use less.  What panels give on a body's slews is that of the motion of least jerk.
    """

    def __init__(
        self,
        looks: CarrierLooks,
        networks: Sequence[Network],
        looking: Looking,
    ) -> None:
        """Raises ResourceRunsOut where a resource does without any look."""
        request = looks.request
        self._request, self._looks, self._looking = request, looks, looking
        self._candidates, self._ways = looks.candidates, looks.ways
        self._grid_s, self._follower = looks.grid_s, looks.follower
        self._resources = request.resources
        self._spans_s = [
            looks.pass_span_s(
                looks.grid_s + one.first_step * request.step_s,
                looks.grid_s + (one.first_step + one.stop_step) * request.step_s,
            )
            for one in networks
        ]
        self._attitudes: Attitudes | None = None
        self._stores = tuple(self._stores_of())
        self._curves: dict[Proposal, tuple[Curve, ...]] = {}
        self._fixed_known: dict[tuple[int, RoomStretch], float] = {}
        if (out := self.runs_out([])) is not None:
            raise ResourceRunsOut(
                f"the {out.name} passes its limit of {out.limit:g} {out.unit} at "
                f"{utc_text(self.utc(out.at_s), 1)}, in the end by {figures(out.short_value)} "
                f"{out.unit}, without any look; {_IDLE_WAYS[out.name]}, or let the campaign stop "
                "sooner",
                field=f"resources.{out.name}",
                limit=out.name,
                at_utc=self.utc(out.at_s),
            )

    def utc(self, t_s: float) -> datetime:
        return shifted_utc(self._request.start, t_s)

    def _stores_of(self) -> Iterator[_Store]:
        last_s = self._request.span_s
        if (duty := self._request.duty_cycle) is not None:
            yield _Store(
                name="duty_cycle",
                unit="s",
                capacity=duty.imaging_max_s,
                limit=duty.imaging_max_s,
                begin_share=1.0,
                most_share=1.0,
                t_s=np.array([0.0, last_s]),
                came_share=np.zeros(2),
                looking_per_s=1.0 / duty.imaging_max_s,
                moving_per_s=0.0,
                span_s=duty.span_s,
            )
        if self._resources is None:
            return
        around = Charging(self._request, self._looks.viewing.ephemeris)
        battery, memory = self._resources.battery, self._resources.memory
        if battery is not None:
            yield self._battery(battery, around)
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
                begin_share=1.0 - memory.start_gbit / memory.capacity_gbit,
                most_share=1.0,
                t_s=t_s,
                came_share=np.append(0.0, np.cumsum(sent)),
                looking_per_s=memory.imaging_gbit_s / memory.capacity_gbit,
                moving_per_s=0.0,
            )

    def _battery(self, battery: Battery, around: Charging) -> _Store:
        contacts = tuple(span for _, span in around.contacts)
        edges_s = [end for span in (*around.lit, *contacts) for end in span]
        t_s = np.unique(np.concatenate([[0.0, around.last_s], edges_s]))
        charge_w, best_w = np.full(len(t_s), battery.sunlight_w or 0.0), 0.0
        if battery.panels:
            count = max(math.ceil(around.last_s / CHARGING.step_s), 8)
            t_s = np.unique(np.concatenate([np.linspace(0.0, around.last_s, count + 1), edges_s]))
            self._attitudes = Attitudes.of(self._follower, around)
            if self._attitudes is not None:
                best_w = most_w(battery)
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
        sends = np.array([_inside(at_s, contacts) for at_s in middle_s])
        came = mean_w * lit_s - (battery.idle_w + battery.downlink_w * sends) * np.diff(t_s)
        if self._attitudes is not None:
            self._attitudes.lit_s = t_s, np.append(0.0, np.cumsum(lit_s))
        return _Store(
            name="battery",
            unit="Wh",
            capacity=battery.capacity_wh,
            limit=battery.least_wh,
            begin_share=(battery.begins_wh - battery.least_wh) / battery.capacity_wh,
            most_share=1.0 - battery.least_wh / battery.capacity_wh,
            t_s=t_s,
            came_share=np.append(0.0, np.cumsum(scale * came)),
            looking_per_s=scale * battery.imaging_w,
            moving_per_s=scale * battery.slew_w,
            charged_share=np.append(0.0, np.cumsum(scale * mean_w * lit_s)),
            extra_share=(
                np.append(0.0, np.cumsum(scale * np.maximum(best_w - mean_w, 0.0) * lit_s))
                if self._attitudes is not None
                else None
            ),
        )

    def curves(self, number: int, looks: tuple[Look, ...]) -> tuple[Curve, ...]:
        """What a pass with these looks uses of each resource."""
        known = self._curves.get((number, looks))
        if known is None:
            known = self._curves[number, looks] = self._curves_of(looks)
        return known

    def ends_s(self, look: Look) -> tuple[float, float]:
        begin_s = self._grid_s + look.first_step * self._request.step_s
        return begin_s, begin_s + self._candidates[look.target].lengths_s[look.length]

    def _curves_of(self, looks: tuple[Look, ...]) -> tuple[Curve, ...]:
        if not looks:
            return tuple(Curve(np.zeros(0), np.zeros(0)) for _ in self._stores)
        ends_s = np.array([end for look in looks for end in self.ends_s(look)])
        start_s, stop_s = self._looks.pass_span_s(float(ends_s[0]), float(ends_s[-1]))
        t_s = np.concatenate([[start_s], ends_s, [stop_s]])
        found = []
        for store in self._stores:
            rates = np.full(len(t_s) - 1, store.moving_per_s)
            rates[1::2] = store.looking_per_s
            curve = Curve(t_s, np.append(0.0, np.cumsum(rates * np.diff(t_s))))
            if store.name == "battery" and self._attitudes is not None:
                curve = self._turned(store, curve, looks)
            found.append(curve)
        return tuple(found)

    def _turned(self, store: _Store, rested: Curve, looks: tuple[Look, ...]) -> Curve:
        """With what panels bring more, or less, than in the idle attitude."""
        assert self._attitudes is not None
        assert store.charged_share is not None
        states = []
        for look in looks:
            begin_s, stop_s = self.ends_s(look)
            row = int(self._ways.offset[look.way] - self._ways.first_step[look.way])
            step = look.first_step + math.ceil((stop_s - begin_s) / self._request.step_s - 1e-9)
            begin = self._ways.begin_states[row + look.first_step, :7]
            states += [(begin_s, begin), (stop_s, self._ways.states[row + step, :7])]
        t_s, brought_ws = self._attitudes.brought_ws(
            states, float(rested.t_s[0]), float(rested.t_s[-1])
        )
        scale = 1.0 / (3600.0 * store.capacity)
        at_rest = np.interp(t_s, store.t_s, store.charged_share)
        at_rest -= at_rest[0]
        used = np.interp(t_s, *rested) + at_rest - scale * brought_ws
        return Curve(t_s, used)

    def _room(self, number: int, curves: Sequence[Curve]) -> _Room:
        """curves: of all passes, in order of time."""
        store = self._stores[number]
        given = [one for one in curves if len(one.t_s)]
        t_s, came = store.turns
        if given:
            knots_s = np.concatenate([one.t_s for one in given])
            before = np.cumsum([0.0, *(one.used_share[-1] for one in given)])
            used = np.concatenate(
                [one.used_share + more for one, more in zip(given, before, strict=False)]
            )
            further_s = [knots_s]
            if store.charged_share is not None:
                further_s += [np.arange(x.t_s[0], x.t_s[-1], CHARGING.tick_s) for x in given]
            if store.span_s is not None:
                further_s.append(knots_s + store.span_s)
            at_s = np.concatenate(further_s)
            t_s, came = np.append(t_s, at_s), np.append(came, store.came_by(at_s))
            order = np.argsort(t_s, kind="stable")
            t_s = t_s[order]
            taken = np.interp(t_s, knots_s, used, left=0.0)
            if store.span_s is not None:
                taken -= np.interp(t_s - store.span_s, knots_s, used, left=0.0)
            whole = store.begin_share + came[order] - taken
        else:
            whole = store.begin_share + came
        lost = np.maximum.accumulate(np.maximum(whole - store.most_share, 0.0))
        return _Room(t_s, whole - lost, whole)

    def _all_curves(
        self, passes: Sequence[tuple[Look, ...]], number: int = -1, looks: tuple[Look, ...] = ()
    ) -> list[tuple[Curve, ...]]:
        return [self.curves(n, looks if n == number else one) for n, one in enumerate(passes)]

    def keeps(
        self, passes: Sequence[tuple[Look, ...]], number: int = -1, looks: tuple[Look, ...] = ()
    ) -> bool:
        """Whether no resource runs out, with other looks in one pass."""
        curves = self._all_curves(passes, number, looks)
        return all(
            self._room(n, [one[n] for one in curves]).left_share.min() >= -OPTIONS.rounding
            for n in range(len(self._stores))
        )

    def runs_out(self, passes: Sequence[tuple[Look, ...]]) -> RunsOut | None:
        """The first resource that does."""
        curves, found = self._all_curves(passes), []
        for n, store in enumerate(self._stores):
            room = self._room(n, [one[n] for one in curves])
            beyond = np.flatnonzero(room.left_share < -OPTIONS.rounding)
            if len(beyond):
                k = max(int(beyond[0]), 1)
                before, after = room.left_share[k - 1], room.left_share[k]
                share = min(max(before / (before - after), 0.0), 1.0) if before != after else 0.0
                found.append(
                    RunsOut(
                        name=store.name,
                        unit=store.unit,
                        limit=store.limit,
                        at_s=float(room.t_s[k - 1] + share * (room.t_s[k] - room.t_s[k - 1])),
                        short_value=-float(room.left_share.min()) * store.capacity,
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
        self, mixed_shares: Sequence[Sequence[tuple[float, tuple[Curve, ...]]]]
    ) -> Iterator[RoomStretch]:
        """Stretches over which more is used than there is, the worst first, of each resource.

        mixed_shares: of each pass, shares of what it uses.
        """
        for n in range(len(self._stores)):
            room = self._room(
                n, [_mixed([(share, of[n]) for share, of in one]) for one in mixed_shares]
            )
            below = room.left_share < -OPTIONS.rounding
            ends = np.flatnonzero(
                below
                & (room.left_share <= np.append(room.left_share[1:], np.inf))
                & (room.left_share < np.append(np.inf, room.left_share[:-1]))
            )
            for end in ends[np.argsort(room.left_share[ends], kind="stable")][
                : OPTIONS.rows_a_round
            ]:
                yield self._stretch(n, room, int(end))

    @property
    def step_s(self) -> float:
        """Of the grid on which looks begin."""
        return self._request.step_s

    def is_in(self, number: int, row: RoomStretch) -> bool:
        """Whether a pass may use anything in a stretch."""
        start_s, stop_s = self._spans_s[number]
        return stop_s > row.from_s and start_s < row.to_s

    def _stretch(self, n: int, left: _Room, end: int) -> RoomStretch:
        """Since it was full, or the campaign began, or as long as its span."""
        store, to_s = self._stores[n], float(left.t_s[end])
        if store.span_s is not None:
            return RoomStretch(n, to_s - store.span_s, to_s, store.most_share)
        begin = int(np.argmax(left.whole_share[: end + 1]))
        from_s = float(left.t_s[begin]) if left.whole_share[begin] > store.most_share else 0.0
        came = store.came_by(np.array([from_s, to_s]))
        room = (store.most_share if from_s > 0.0 else store.begin_share) + float(came[1] - came[0])
        return RoomStretch(n, from_s, to_s, room)

    def used(self, proposals: Sequence[Proposal], rows: Sequence[RoomStretch]) -> Array:
        """What each takes over each stretch, as simulated, (rows, proposals)."""
        taken = np.zeros((len(rows), len(proposals)))
        ends_s = np.array([(one.from_s, one.to_s) for one in rows]).reshape(-1, 2)
        for column, proposal in enumerate(proposals):
            curves = self.curves(*proposal)
            for n, curve in enumerate(curves):
                own = np.flatnonzero([one.store == n for one in rows])
                if len(own) and len(curve.t_s):
                    at = np.interp(ends_s[own], curve.t_s, curve.used_share)
                    taken[own, column] = at[:, 1] - at[:, 0]
        return taken

    def used_at_least(self, proposals: Sequence[Proposal], rows: Sequence[RoomStretch]) -> Array:
        """As `used`, by whole steps of looks alone, and of each pass what any of its paths uses."""
        taken = np.zeros((len(rows), len(proposals)))
        step_s, held = self._request.step_s, self._looking.held_steps
        from_s, to_s = np.array([(one.from_s, one.to_s) for one in rows]).reshape(-1, 2).T
        rate = np.array([self._stores[one.store].looking_per_s for one in rows])
        for column, (number, looks) in enumerate(proposals):
            begin_s = self._grid_s + step_s * np.array([[look.first_step] for look in looks])
            held_steps = [[held[look.target, look.length]] for look in looks]
            end_s = begin_s + step_s * np.array(held_steps)
            within_s = np.minimum(end_s, to_s) - np.maximum(begin_s, from_s)
            taken[:, column] = rate * np.maximum(within_s, 0.0).sum(axis=0)
            taken[:, column] += [self._fixed(number, one) for one in rows]
        return taken

    def _fixed(self, number: int, row: RoomStretch) -> float:
        """What a pass with any look uses beside them at least; negative where panels may bring more
        than at rest."""
        if (known := self._fixed_known.get((number, row))) is None:
            known = self._fixed_known[number, row] = self._fixed_of(number, row)
        return known

    def _fixed_of(self, number: int, row: RoomStretch) -> float:
        store, (start_s, stop_s) = self._stores[row.store], self._spans_s[number]
        if stop_s <= row.from_s or start_s >= row.to_s:
            return 0.0
        is_whole = row.from_s <= start_s and stop_s <= row.to_s
        # The whole room at both ends, but at those of the campaign.
        rests = (start_s > self._grid_s) + (stop_s < last_row_s(self._request))
        moved = rests * self._follower.rest_s * store.moving_per_s if is_whole else 0.0
        if store.extra_share is None:
            return moved
        more = np.interp([start_s, stop_s], store.t_s, store.extra_share)
        return moved - float(more[1] - more[0])

    def priced(
        self, networks: Sequence[Network], rows: Sequence[RoomStretch], row_price: Array
    ) -> tuple[list[Network], list[float], float]:
        """The networks with what looks pay, what each pass with any look pays beside, and the worth
        of all room."""
        rate = row_price * [self._stores[one.store].looking_per_s for one in rows]
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
        return dear, rents, float(row_price @ [one.room_share for one in rows])

    def dear(self, network: Network, price_s: float) -> Network:
        """A network whose looks pay for each second."""
        seconds = self._request.step_s * np.arange(network.stop_step + 1)
        return network._replace(cost=np.asarray(price_s * seconds + _cost_of(network)))

    def levels(self, passes: Sequence[tuple[Look, ...]], t_s: Array) -> dict[KeptResource, Array]:
        """What each resource holds at instants, (n,), in its unit, as simulated."""
        curves = self._all_curves(passes)
        rooms = [self._room(n, [one[n] for one in curves]) for n in range(len(self._stores))]
        return {
            store.name: store.level(np.interp(t_s, room.t_s, room.left_share))
            for store, room in zip(self._stores, rooms, strict=True)
        }

    def begins(self, passes: Sequence[tuple[Look, ...]]) -> list[Resources | None]:
        """What each pass with looks begins with."""
        starts_s = [
            self._looks.pass_span_s(self.ends_s(looks[0])[0], self.ends_s(looks[-1])[1])[0]
            for looks in passes
            if looks
        ]
        levels = self.levels(passes, np.array(starts_s))
        found: list[Resources | None] = []
        for number in range(len(starts_s)):
            begins = self._resources
            if begins is not None and begins.battery is not None:
                level = float(levels["battery"][number])
                begins = replace(begins, battery=replace(begins.battery, start_wh=level))
            if begins is not None and begins.memory is not None:
                level = float(levels["memory"][number])
                begins = replace(begins, memory=replace(begins.memory, start_gbit=level))
            found.append(begins)
        return found


_IDLE_WAYS = {
    "battery": "begin with more, or take less while idle",
    "memory": "begin with less",
}


def _inside(at_s: float, spans_s: Sequence[tuple[float, float]]) -> bool:
    return any(start_s < at_s < stop_s for start_s, stop_s in spans_s)


def _cost_of(network: Network) -> Array:
    return network.cost if len(network.cost) else np.zeros(network.stop_step + 1)


def _mixed(shares: Sequence[tuple[float, Curve]]) -> Curve:
    """The sum of shares."""
    shares = [(share, curve) for share, curve in shares if len(curve.t_s)]
    if not shares:
        return Curve(np.zeros(0), np.zeros(0))
    t_s = np.unique(np.concatenate([curve.t_s for _, curve in shares]))
    used = sum(share * np.interp(t_s, *curve) for share, curve in shares)
    return Curve(t_s, np.asarray(used))
