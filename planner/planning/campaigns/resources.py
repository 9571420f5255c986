"""Resources that looks of a campaign use up: rows of its programmes, and the choice simulated.

Each carrier has stores of its own.  One never ends where no stretch of time uses more than it has:
each stretch is a row of the programmes, linear in what passes use.  Rows join as a choice breaks
them.  The momentum of wheels is no sum of what passes use, so it has no rows: it is simulated with
every choice.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import NamedTuple

import numpy as np

from planner.base.arrays import Array
from planner.base.errors import ResourceRunsOut, figures
from planner.planning.campaigns.chosen import KeptResource
from planner.planning.campaigns.joined import Joined
from planner.planning.campaigns.network import Network
from planner.planning.campaigns.path import Look
from planner.planning.campaigns.pricing import Networks
from planner.planning.campaigns.programmes import Proposal
from planner.planning.campaigns.revision import PassResources
from planner.planning.campaigns.stores import CarrierStores, Curve, Room, Store
from planner.planning.campaigns.wheels import Beyond, Turned
from planner.world.frames.time_scales import shifted_utc, utc_text
from planner.world.resources import resource_told


@dataclass(frozen=True, kw_only=True)
class RoomOptions:
    """When a resource is said to run out, and how many stretches in which it does are told."""

    rounding: float = 1e-9  # of a capacity
    rows_a_round: int = 20  # of each resource, the most broken first
    # at targets left out, of all together, shared out evenly: some seconds with wheels
    looks_tried: int = 2000
    # looks that turn out to be worth more than what they displace: after each all are tried anew
    exchanges_max: int = 10


OPTIONS = RoomOptions()


class RoomStretch(NamedTuple):
    """A row: what passes use of one resource over it is at most `room`, a share of the capacity.

    store: number of the resource among all carriers'.  from_s, to_s: on the carriers' clock.
    """

    store: int
    from_s: float
    to_s: float
    room_share: float


@dataclass(frozen=True, kw_only=True)
class RunsOut:
    """The resource that a choice would take too much of.

    at_s: when it passes its limit.  short: by how much in the end, in its unit.
    """

    name: KeptResource
    told_name: str
    unit: str
    limit: float
    at_s: float
    short_value: float

    @property
    def told(self) -> str:
        return f"the {self.told_name} would pass its limit of {self.limit:g} {self.unit}"


class Keeping:
    """The resources of all carriers: what passes use of each, and whether there is so much."""

    def __init__(self, joined: Joined, field_of: Callable[[str, str], str]) -> None:
        """Raises ResourceRunsOut where a resource does without any look.

        field_of: of the request, by carrier and field of its own.
        """
        self._request = joined.looks_by_carrier[0].request
        self._looking, self._grid_s = joined.looking, joined.looks_by_carrier[0].grid_s
        self.carriers = tuple(
            CarrierStores(looks, int(first_way))
            for looks, first_way in zip(joined.looks_by_carrier, joined.first_way, strict=True)
        )
        counts = [len(one.stores) for one in self.carriers]
        self._first_store = np.cumsum([0, *counts]).tolist()
        self._stores: tuple[Store, ...] = tuple(
            store for carrier in self.carriers for store in carrier.stores
        )
        self._store_of = [n for n, count in enumerate(counts) for _ in range(count)]
        self.carrier_of = [carrier for carrier, _ in joined.order.values()]
        self.passes_of = tuple(
            tuple(n for n, of in enumerate(self.carrier_of) if of == carrier)
            for carrier in range(len(self.carriers))
        )
        self._spans_s = [
            self.carriers[carrier].most_span_s(
                network.first_step, network.first_step + network.stop_step
            )
            for carrier, network in zip(self.carrier_of, joined.networks.values(), strict=True)
        ]
        self._curves: dict[Proposal, tuple[Curve, ...]] = {}
        self._turned: dict[Proposal, Turned] = {}
        self._fixed_known: dict[tuple[int, RoomStretch], float] = {}
        nothing: list[tuple[Look, ...]] = [()] * len(joined.networks)
        for carrier, name in enumerate(joined.carriers):
            if (out := self.runs_out(carrier, nothing)) is not None:
                raise ResourceRunsOut(
                    f"{name and f'{name}: '}the {out.told_name} passes its limit of {out.limit:g} "
                    f"{out.unit} at {utc_text(self.utc(out.at_s), 1)}, in the end by "
                    f"{figures(out.short_value)} {out.unit}, without any look; "
                    f"{_IDLE_WAYS[out.name]}",
                    field="revises.frozen_until"
                    if out.name == "duty_cycle"
                    else field_of(name, f"resources.{out.name}"),
                    limit=out.name,
                    at_utc=self.utc(out.at_s),
                )

    def utc(self, t_s: float) -> datetime:
        return shifted_utc(self._request.start, t_s)

    def curves(self, number: int, looks: tuple[Look, ...]) -> tuple[Curve, ...]:
        """What a pass with these looks uses of each of its carrier's resources."""
        known = self._curves.get((number, looks))
        if known is None:
            own = self.carriers[self.carrier_of[number]]
            known = self._curves[number, looks] = own.curves(looks)
        return known

    def _turns(self, number: int, looks: tuple[Look, ...]) -> Turned:
        known = self._turned.get((number, looks))
        if known is None:
            own = self.carriers[self.carrier_of[number]]
            known = self._turned[number, looks] = own.turned(looks)
        return known

    def _own(
        self, carrier: int, passes: Sequence[tuple[Look, ...]]
    ) -> Iterator[tuple[int, tuple[Look, ...]]]:
        return ((number, passes[number]) for number in self.passes_of[carrier])

    def _rooms(self, carrier: int, passes: Sequence[tuple[Look, ...]]) -> Iterator[Room]:
        curves = [self.curves(*one) for one in self._own(carrier, passes)]
        for n, store in enumerate(self.carriers[carrier].stores):
            yield store.room([one[n] for one in curves])

    def beyond(self, carrier: int, passes: Sequence[tuple[Look, ...]]) -> Beyond | None:
        """The momentum of a carrier's wheels that passes its limit first."""
        wheels = self.carriers[carrier].wheels
        if wheels is None:
            return None
        flown = (one for one in self._own(carrier, passes) if one[1])
        return wheels.beyond([self._turns(*one) for one in flown])

    def keeps(
        self, passes: Sequence[tuple[Look, ...]], number: int = -1, looks: tuple[Look, ...] = ()
    ) -> bool:
        """Whether no resource runs out, with other looks in one pass: of its carrier then, where
        those of others keep."""
        passes = list(passes)
        if number >= 0:
            passes[number] = looks
        carriers = [self.carrier_of[number]] if number >= 0 else range(len(self.carriers))
        return all(
            all(room.left_share.min() >= -OPTIONS.rounding for room in self._rooms(carrier, passes))
            and self.beyond(carrier, passes) is None
            for carrier in carriers
        )

    def runs_out(self, carrier: int, passes: Sequence[tuple[Look, ...]]) -> RunsOut | None:
        """The first resource of a carrier that does."""
        found = []
        for store, room in zip(
            self.carriers[carrier].stores, self._rooms(carrier, passes), strict=True
        ):
            beyond = np.flatnonzero(room.left_share < -OPTIONS.rounding)
            if len(beyond):
                k = max(int(beyond[0]), 1)
                before, after = room.left_share[k - 1], room.left_share[k]
                share = min(max(before / (before - after), 0.0), 1.0) if before != after else 0.0
                found.append(
                    RunsOut(
                        name=store.name,
                        told_name=store.name.replace("_", " "),
                        unit=store.unit,
                        limit=store.limit,
                        at_s=float(room.t_s[k - 1] + share * (room.t_s[k] - room.t_s[k - 1])),
                        short_value=-float(room.left_share.min()) * store.capacity,
                    )
                )
        if (over := self.beyond(carrier, passes)) is not None:
            found.append(
                RunsOut(
                    name="momentum",
                    told_name=resource_told(over.name),
                    unit="N m s",
                    limit=over.limit_n_m_s,
                    at_s=over.at_s,
                    short_value=over.short_n_m_s,
                )
            )
        return min(found, key=lambda one: one.at_s, default=None)

    def broken(
        self, mixed_shares: Sequence[Sequence[tuple[float, tuple[Curve, ...]]]]
    ) -> Iterator[RoomStretch]:
        """Stretches over which more is used than there is, the worst first, of each resource.

        mixed_shares: of each pass, shares of what it uses.
        """
        for n, (store, carrier) in enumerate(zip(self._stores, self._store_of, strict=True)):
            place = n - self._first_store[carrier]
            room = store.room(
                [
                    _mixed([(share, of[place]) for share, of in mixed_shares[number]])
                    for number in self.passes_of[carrier]
                ]
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
        is_own = self._store_of[row.store] == self.carrier_of[number]
        return is_own and stop_s > row.from_s and start_s < row.to_s

    def _stretch(self, n: int, left: Room, end: int) -> RoomStretch:
        """Since it was full, or the campaign began, or as long as its span."""
        store, to_s = self._stores[n], float(left.t_s[end])
        if store.span_s is not None:
            from_s, room = to_s - store.span_s, store.most_share
            if len(store.before.t_s):
                before = np.interp([from_s, to_s], *store.before)
                room -= float(before[1] - before[0])
            return RoomStretch(n, from_s, to_s, room)
        begin = int(np.argmax(left.whole_share[: end + 1]))
        from_s = float(left.t_s[begin]) if left.whole_share[begin] > store.most_share else 0.0
        came = store.came_by(np.array([from_s, to_s]))
        room = (store.most_share if from_s > 0.0 else store.begin_share) + float(came[1] - came[0])
        return RoomStretch(n, from_s, to_s, room)

    def used(self, proposals: Sequence[Proposal], rows: Sequence[RoomStretch]) -> Array:
        """What each takes over each stretch, as simulated, (rows, proposals)."""
        taken = np.zeros((len(rows), len(proposals)))
        ends_s = np.array([(one.from_s, one.to_s) for one in rows]).reshape(-1, 2)
        store = np.array([one.store for one in rows], np.intp)
        rows_of = [np.flatnonzero(store == n) for n in range(len(self._stores))]
        for column, (number, looks) in enumerate(proposals):
            first = self._first_store[self.carrier_of[number]]
            for n, curve in enumerate(self.curves(number, looks), start=first):
                own = rows_of[n]
                if len(own) and len(curve.t_s):
                    at = np.interp(ends_s[own], curve.t_s, curve.used_share)
                    taken[own, column] = at[:, 1] - at[:, 0]
        return taken

    def used_at_least(self, proposals: Sequence[Proposal], rows: Sequence[RoomStretch]) -> Array:
        """As `used`, by whole steps of looks alone, and of each pass what any of its paths uses."""
        taken = np.zeros((len(rows), len(proposals)))
        step_s, held = self._request.step_s, self._looking.held_steps
        from_s, to_s = np.array([(one.from_s, one.to_s) for one in rows]).reshape(-1, 2).T
        rate, of = self._rates(rows), np.array([self._store_of[one.store] for one in rows], np.intp)
        for column, (number, looks) in enumerate(proposals):
            begin_s = self._grid_s + step_s * np.array([[look.first_step] for look in looks])
            held_steps = [[held[look.target, look.length]] for look in looks]
            end_s = begin_s + step_s * np.array(held_steps)
            within_s = np.minimum(end_s, to_s) - np.maximum(begin_s, from_s)
            is_own = of == self.carrier_of[number]
            taken[:, column] = is_own * rate * np.maximum(within_s, 0.0).sum(axis=0)
            taken[:, column] += [self._fixed(number, one) for one in rows]
        return taken

    def _rates(self, rows: Sequence[RoomStretch]) -> Array:
        """What a second of a look uses of each."""
        return np.array([self._stores[one.store].looking_per_s for one in rows])

    def _fixed(self, number: int, row: RoomStretch) -> float:
        """What a pass with any look uses beside them at least; negative where panels may bring more
        than at rest."""
        if (known := self._fixed_known.get((number, row))) is None:
            known = self._fixed_known[number, row] = self._fixed_of(number, row)
        return known

    def _fixed_of(self, number: int, row: RoomStretch) -> float:
        if not self.is_in(number, row):
            return 0.0
        store, (start_s, stop_s) = self._stores[row.store], self._spans_s[number]
        is_whole = row.from_s <= start_s and stop_s <= row.to_s
        carrier = self.carriers[self.carrier_of[number]]
        moved = carrier.least_moving_s((start_s, stop_s)) * store.moving_per_s if is_whole else 0.0
        if store.extra_share is None:
            return moved
        more = np.interp([start_s, stop_s], store.t_s, store.extra_share)
        return moved - float(more[1] - more[0])

    def priced(
        self, networks: Networks, rows: Sequence[RoomStretch], row_price: Array
    ) -> tuple[list[Array], list[float], float]:
        """What looks of each pass pay, what each with any look pays beside, and the worth of all
        room."""
        costs = [self.cost(n, networks[n], rows, row_price) for n in range(len(networks))]
        rents = [
            sum(
                price * self._fixed(number, one)
                for price, one in zip(row_price.tolist(), rows, strict=True)
            )
            for number in range(len(networks))
        ]
        return costs, rents, float(row_price @ [one.room_share for one in rows])

    def cost(
        self, number: int, network: Network, rows: Sequence[RoomStretch], row_price: Array
    ) -> Array:
        """What looks of a pass pay, as of `Network`."""
        steps = network.first_step + np.arange(network.stop_step + 1)
        t_s = self._grid_s + self._request.step_s * steps
        cost = np.zeros(len(t_s))
        for price, one in zip((row_price * self._rates(rows)).tolist(), rows, strict=True):
            is_own = self._store_of[one.store] == self.carrier_of[number]
            if price > 0.0 and is_own and one.from_s < t_s[-1] and t_s[0] < one.to_s:
                cost += price * np.clip(t_s - one.from_s, 0.0, one.to_s - one.from_s)
        return cost

    def dear(self, network: Network, price_s: float) -> Array:
        """What looks pay that pay for each second, too."""
        seconds = self._request.step_s * np.arange(network.stop_step + 1)
        return np.asarray(price_s * seconds + _cost_of(network))

    def turning_looks(self, passes: Sequence[tuple[Look, ...]]) -> list[tuple[int, Look]]:
        """Looks of passes by whose leave a momentum might keep its limit: those around the first
        instant at which one doesn't, or else all of the last pass before it; none where all do."""
        for carrier, stores in enumerate(self.carriers):
            over = self.beyond(carrier, passes)
            if over is None:
                continue
            spans_s = {n: stores.span_s(looks) for n, looks in self._own(carrier, passes) if looks}
            number = max(n for n, (start_s, _) in spans_s.items() if start_s <= over.at_s)
            looks = passes[number]
            if over.at_s > spans_s[number][1]:
                return [(number, look) for look in looks]
            before = [look for look in looks if stores.ends_s(look)[0] <= over.at_s][-1:]
            after = [look for look in looks if stores.ends_s(look)[1] >= over.at_s][:1]
            return [(number, look) for look in dict.fromkeys([*before, *after])]
        return []

    def held(self, carrier: int, passes: Sequence[tuple[Look, ...]]) -> list[PassResources | None]:
        """What each pass of a carrier with looks starts and stops with."""
        return self.carriers[carrier].held([looks for _, looks in self._own(carrier, passes)])


_IDLE_WAYS = {
    "battery": "begin with more, take less while idle, or let the campaign stop sooner",
    "duty_cycle": "let less stay, or allow more",
    "memory": "begin with less, or let the campaign stop sooner",
    "momentum": "begin with less, unload more, choose another idle attitude, or let the campaign "
    "stop sooner",
}


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
