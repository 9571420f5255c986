"""Resources of one carrier that looks of a campaign use up, each told as the room that is left.

Of a battery that is its charge above the least, of a memory what may still be written.  Room that
comes and finds no place is lost, so that at t there is the least of `begin + came(0, t) - used(0,
t)` and, for every s before, of `most + came(s, t) - used(s, t)`.  The imaging of a duty cycle is
one more resource, whose room at t is what no look since `t - span` used.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from planner.base.arrays import Array
from planner.base.rotation import Rotation
from planner.planning.campaigns.carrier_looks import CarrierLooks, last_row_s
from planner.planning.campaigns.charging import CHARGING, Attitudes, Charging, most_w
from planner.planning.campaigns.chosen import KeptResource
from planner.planning.campaigns.path import Look
from planner.planning.campaigns.platforms.follower import Follower
from planner.planning.campaigns.request import CampaignRequest
from planner.planning.campaigns.revision import PassResources
from planner.planning.campaigns.wheels import Turned, Wheels
from planner.world.frames.time_scales import elapsed_s
from planner.world.orbits import Ephemeris
from planner.world.platforms import BodyPlatform
from planner.world.resources import Battery, Memory, Resources


class Curve(NamedTuple):
    """What a pass uses of a resource from its start to its stop, linear in between, (m,)."""

    t_s: Array
    used_share: Array


NOTHING_USED = Curve(np.zeros(0), np.zeros(0))


class Room(NamedTuple):
    """The room left of a resource, (m,), and what it would be if none were lost."""

    t_s: Array
    left_share: Array
    whole_share: Array


@dataclass(frozen=True, kw_only=True, eq=False)
class Store:
    """One resource, all in shares of its capacity.

    begin, most: the room at first, and at most.  t_s, came: what comes while the platform rests,
    less what it takes then, since the campaign's start, linear in between, (n,).  looking, moving:
    used in a second of a look, and of any other of a pass.  span: after which what was used is
    there again; None: never.  before: used before the campaign's start, at negative times.
    charged: what panels bring of what comes.
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
    before: Curve = NOTHING_USED
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

    def room(self, curves: Sequence[Curve]) -> Room:
        """curves: of all passes, in order of time."""
        given = [one for one in (self.before, *curves) if len(one.t_s)]
        t_s, came = self.turns
        if given:
            knots_s = np.concatenate([one.t_s for one in given])
            before = np.cumsum([0.0, *(one.used_share[-1] for one in given)])
            used = np.concatenate(
                [one.used_share + more for one, more in zip(given, before, strict=False)]
            )
            further_s = [knots_s]
            if self.charged_share is not None:
                further_s += [np.arange(x.t_s[0], x.t_s[-1], CHARGING.tick_s) for x in given]
            if self.span_s is not None:
                further_s.append(knots_s + self.span_s)
            at_s = np.concatenate(further_s)
            t_s, came = np.append(t_s, at_s), np.append(came, self.came_by(at_s))
            order = np.argsort(t_s, kind="stable")
            order = order[t_s[order] >= 0.0]
            t_s = t_s[order]
            taken = np.interp(t_s, knots_s, used, left=0.0)
            if self.span_s is not None:
                taken -= np.interp(t_s - self.span_s, knots_s, used, left=0.0)
            whole = self.begin_share + came[order] - taken
        else:
            whole = self.begin_share + came
        lost = np.maximum.accumulate(np.maximum(whole - self.most_share, 0.0))
        return Room(t_s, whole - lost, whole)

    def eased(self) -> "Store":
        """With as much more at first as is short without any look, by no more than what panels
        bring is known to: passes that stay were followed on another clock."""
        short = -float(self.room(()).left_share.min())
        is_little = 0.0 < short <= CHARGING.known_share
        return replace(self, begin_share=self.begin_share + short) if is_little else self


class RestStores:
    """The resources of one carrier, and what comes of each while it rests."""

    def __init__(
        self,
        request: CampaignRequest,
        follower: Follower,
        ephemeris: Ephemeris,
        start_state: tuple[float, Array] | None,
    ) -> None:
        """start_state: when the campaign begins, and its state, where that is one of its own."""
        self._request, self._start_state = request, start_state
        self._follower, self._ephemeris = follower, ephemeris
        self.resources = request.resources
        self._attitudes: Attitudes | None = None
        self.wheels: Wheels | None = None
        stores = tuple(self._stores_of())
        self.stores = tuple(one.eased() for one in stores) if request.revises else stores

    def _stores_of(self) -> Iterator[Store]:
        last_s = self._request.span_s
        if (duty := self._request.duty_cycle) is not None:
            yield Store(
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
                before=self._imaged_before(duty.imaging_max_s),
            )
        if self.resources is None:
            return
        around = Charging(self._request, self._ephemeris)
        battery, memory, momentum = (
            self.resources.battery,
            self.resources.memory,
            self.resources.momentum,
        )
        if momentum is not None or (battery is not None and battery.panels):
            self._attitudes = Attitudes.of(self._follower, around, self._start_state)
        if momentum is not None:
            assert self._attitudes is not None  # a body's, or the request was refused
            self.wheels = Wheels(self._request, momentum, self._attitudes)
        if battery is not None:
            yield self._battery(battery, around)
        if memory is not None:
            yield _memory(memory, around)

    def _imaged_before(self, most_s: float) -> Curve:
        """By passes that stay of the campaign that is revised."""
        past = self._request.revises.past_looks if self._request.revises else ()
        start_s, stop_s = (
            np.array(
                [[elapsed_s(at, self._request.start) for at in (x.start, x.stop)] for x in past]
            )
            .reshape(-1, 2)
            .T
        )
        t_s = np.unique([start_s, stop_s])
        looked_s = np.clip(t_s[:, None] - start_s, 0.0, stop_s - start_s).sum(axis=1)
        return Curve(t_s, looked_s / most_s)

    def _battery(self, battery: Battery, around: Charging) -> Store:
        contacts = tuple(span for _, span in around.contacts)
        edges_s = [end for span in (*around.lit, *contacts) for end in span]
        t_s = np.unique(np.concatenate([[0.0, around.last_s], edges_s]))
        charge_w, best_w = np.full(len(t_s), battery.sunlight_w or 0.0), 0.0
        attitudes = self._attitudes if battery.panels else None
        if battery.panels:
            count = max(math.ceil(around.last_s / CHARGING.step_s), 8)
            t_s = np.unique(np.concatenate([np.linspace(0.0, around.last_s, count + 1), edges_s]))
            if attitudes is not None:
                best_w = most_w(battery)
                charge_w = attitudes.idle_w(t_s)
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
        if attitudes is not None:
            attitudes.lit_s = t_s, np.append(0.0, np.cumsum(lit_s))
        return Store(
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
                if attitudes is not None
                else None
            ),
        )


class CarrierStores(RestStores):
    """The resources of one carrier: what its looks use of each.

    A pass moves from its start to its stop wherever it does not look: its plan may wait meanwhile,
    and use less.  A body's slews are smooth turns.
    """

    def __init__(self, looks: CarrierLooks, first_way: int) -> None:
        """first_way: of its ways among all carriers'."""
        self._looks, self._first_way, self._ways = looks, first_way, looks.ways
        request, follower, start_state = looks.request, looks.follower, None
        if request.initial_q_body_from_eci_xyzw is not None:
            start_state = looks.grid_s, follower.start_state(looks.carrier, looks.grid_s)[:10]
        super().__init__(request, follower, looks.viewing.ephemeris, start_state)

    def ends_s(self, look: Look) -> tuple[float, float]:
        begin_s = self._looks.grid_s + look.first_step * self._request.step_s
        return begin_s, begin_s + self._length_s(look)

    def _length_s(self, look: Look) -> float:
        own = int(self._ways.target[look.way - self._first_way])
        return self._looks.candidates[own].lengths_s[look.length]

    def span_s(self, looks: Sequence[Look]) -> tuple[float, float]:
        """From when to when the pass of these looks moves."""
        return self._looks.pass_span_s(self.ends_s(looks[0])[0], self.ends_s(looks[-1])[1])

    def most_span_s(self, first_step: int, stop_step: int) -> tuple[float, float]:
        """The same of a pass whose looks lie between two steps."""
        begin_s, step_s = self._looks.grid_s, self._request.step_s
        return self._looks.pass_span_s(begin_s + first_step * step_s, begin_s + stop_step * step_s)

    def least_moving_s(self, span_s: tuple[float, float]) -> float:
        """The whole room at both ends of a pass, but at those of the campaign."""
        start_s, stop_s = span_s
        rests = (start_s > self._looks.grid_s) + (stop_s < last_row_s(self._request))
        return rests * self._looks.follower.rest_s

    def curves(self, looks: tuple[Look, ...]) -> tuple[Curve, ...]:
        """What a pass with these looks uses of each resource."""
        if not looks:
            return tuple(NOTHING_USED for _ in self.stores)
        start_s, stop_s = self.span_s(looks)
        ends_s = np.array([end for look in looks for end in self.ends_s(look)])
        t_s = np.concatenate([[start_s], ends_s, [stop_s]])
        found = []
        for store in self.stores:
            rates = np.full(len(t_s) - 1, store.moving_per_s)
            rates[1::2] = store.looking_per_s
            curve = Curve(t_s, np.append(0.0, np.cumsum(rates * np.diff(t_s))))
            if store.extra_share is not None:
                curve = self._turned(store, curve, looks)
            found.append(curve)
        return tuple(found)

    def _turned(self, store: Store, rested: Curve, looks: Sequence[Look]) -> Curve:
        """With what panels bring more, or less, than in the idle attitude."""
        assert self._attitudes is not None
        assert store.charged_share is not None
        t_s, brought_ws = self._attitudes.brought_ws(
            list(self._states(looks)), float(rested.t_s[0]), float(rested.t_s[-1])
        )
        scale = 1.0 / (3600.0 * store.capacity)
        at_rest = np.interp(t_s, store.t_s, store.charged_share)
        at_rest -= at_rest[0]
        used = np.interp(t_s, *rested) + at_rest - scale * brought_ws
        return Curve(t_s, used)

    def turned(self, looks: Sequence[Look]) -> Turned:
        """How the body turns in a pass with these looks, of a carrier with wheels."""
        assert self.wheels is not None
        start_s, stop_s = self.span_s(looks)
        states = list(self._states(looks))
        return self.wheels.turned(states, start_s, stop_s)

    def _states(self, looks: Sequence[Look]) -> Iterator[tuple[float, Array]]:
        """When, and attitude, rate and acceleration: where looks begin to be followed and end, and
        every so often between.

        A roll that is free follows from the attitude before, with no turn about the boresight.
        """
        assert self._attitudes is not None
        step_s, ways = self._request.step_s, self._ways
        before = self._attitudes.begin(self.span_s(looks)[0])[:4]
        for look in looks:
            begin_s, stop_s = self.ends_s(look)
            way = look.way - self._first_way
            row = int(ways.offset[way] - ways.first_step[way]) + look.first_step
            long_s = stop_s - begin_s
            last = math.ceil(long_s / step_s - 1e-9)
            steps, moving_states = [-self._looks.settle_steps], ways.begin_states
            if not ways.scanned[way]:
                parts = max(int(long_s / max(CHARGING.track_s, step_s)), 1)
                inside = {round(n * long_s / parts / step_s) for n in range(parts)}
                steps, moving_states = sorted({*steps, *inside} - {last}), ways.states
            states = [(begin_s + n * step_s, moving_states[row + n]) for n in steps]
            state = ways.states[row + last].copy()
            turned = Rotation.from_rotvec((long_s - last * step_s) * state[4:7])
            state[:4] = (Rotation.from_quat(state[:4]) * turned).as_quat()
            for at_s, moving in (*states, (stop_s, state)):
                carried = self._carried(before, moving) if moving[10] else moving[:10]
                before = carried[:4]
                yield at_s, carried

    def _carried(self, before_state: Array, moving_state: Array) -> Array:
        """A state, its roll the one that the shortest turn of the boresight brings."""
        platform = self._request.platform
        assert isinstance(platform, BodyPlatform)
        lying, on_target = Rotation.from_quat(before_state), Rotation.from_quat(moving_state[:4])
        old, new = (one.apply(platform.boresight_body) for one in (lying, on_target))
        across = np.cross(old, new)
        sine = float(np.linalg.norm(across))
        angle = math.atan2(sine, float(old @ new))
        turned = Rotation.from_rotvec(across * (angle / max(sine, 1e-15))) * lying
        motion = (turned.inv() * on_target).apply(moving_state[4:10].reshape(2, 3))
        return np.concatenate([turned.as_quat(), motion.ravel()])

    def held(self, passes: Sequence[tuple[Look, ...]]) -> list[PassResources | None]:
        """As each pass with looks starts and stops; passes: its own, in order of time."""
        flown = [looks for looks in passes if looks]
        if self.resources is None:
            return [None] * len(flown)
        ends_s = np.array([self.span_s(looks) for looks in flown]).reshape(-1, 2)
        told = self.levels(passes, ends_s)
        if self.wheels is not None:
            told["momentum"] = self.wheels.at_ends([self.turned(looks) for looks in flown])
        return [held_of(told, number) for number in range(len(flown))]

    def levels(self, passes: Sequence[tuple[Look, ...]], t_s: Array) -> dict[KeptResource, Array]:
        """What each resource holds at instants, of any shape, in its unit, as simulated."""
        curves = [self.curves(looks) for looks in passes]
        rooms = [store.room([one[n] for one in curves]) for n, store in enumerate(self.stores)]
        return {
            store.name: store.level(np.interp(t_s, room.t_s, room.left_share))
            for store, room in zip(self.stores, rooms, strict=True)
        }


def held_of(told: Mapping[KeptResource, Array], number: int) -> PassResources:
    """Of one of n passes: levels by resource, (n, 2), of a momentum (n, 2, 3)."""
    ends: dict[str, list[Any]] = {one: level[number].tolist() for one, level in told.items()}
    momentum = ends.get("momentum", ())
    return PassResources(
        battery_wh=tuple(ends["battery"]) if "battery" in ends else None,
        memory_gbit=tuple(ends["memory"]) if "memory" in ends else None,
        momentum_n_m_s=(tuple(momentum[0]), tuple(momentum[1])) if momentum else None,
    )


def begun_with(own: Resources, held: PassResources, end: int = 0) -> Resources:
    """A carrier's resources at a pass's start, or at its stop."""
    return replace(
        own,
        battery=own.battery
        and held.battery_wh
        and replace(own.battery, start_wh=held.battery_wh[end]),
        memory=own.memory
        and held.memory_gbit
        and replace(own.memory, start_gbit=held.memory_gbit[end]),
        momentum=own.momentum
        and held.momentum_n_m_s
        and replace(own.momentum, start_n_m_s=held.momentum_n_m_s[end]),
    )


def _memory(memory: Memory, around: Charging) -> Store:
    contacts = tuple(span for _, span in around.contacts)
    t_s = np.unique([0.0, around.last_s, *(end for span in contacts for end in span)])
    sends = np.array([_inside(at_s, contacts) for at_s in 0.5 * (t_s[1:] + t_s[:-1])])
    sent = np.diff(t_s) * sends * memory.downlink_gbit_s / memory.capacity_gbit
    return Store(
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


def _inside(at_s: float, spans_s: Sequence[tuple[float, float]]) -> bool:
    return any(start_s < at_s < stop_s for start_s, stop_s in spans_s)
