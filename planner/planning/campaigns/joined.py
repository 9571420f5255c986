"""Looks of several carriers under one choice: a target is one, whoever looks at it."""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property

import numpy as np

from planner.base.arrays import Array, Indices
from planner.planning.campaigns.candidates import LookCandidate
from planner.planning.campaigns.carrier_looks import CarrierLooks
from planner.planning.campaigns.looking import FirstUnheld, Looking
from planner.planning.campaigns.network import Network
from planner.planning.campaigns.path import Look
from planner.planning.campaigns.pricing import AskedPass, PricedPasses
from planner.planning.campaigns.request import BOUNDS, CampaignRequest


@dataclass(frozen=True, kw_only=True, eq=False)
class Joined:
    """carriers: by id.

    candidates: targets that are no modes, each once, then the scans of every carrier.  numbers:
    of each carrier's candidates among these.  first_way: of each carrier's ways among all.
    order: of each network by its number, in order of time, the carrier and the number there.
    """

    carriers: Mapping[str, CarrierLooks]
    candidates: tuple[LookCandidate, ...]
    numbers: tuple[Indices, ...]
    first_way: Indices
    order: Mapping[int, tuple[int, int]]

    @cached_property
    def looks_by_carrier(self) -> tuple[CarrierLooks, ...]:
        return tuple(self.carriers.values())

    @cached_property
    def ids(self) -> tuple[str, ...]:
        """Of targets, in the requests' order."""
        wanted = (one for looks in self.looks_by_carrier for one in looks.request.targets)
        return tuple(dict.fromkeys(one.id for one in wanted))

    @cached_property
    def networks(self) -> Mapping[int, Network]:
        """Of all passes, by `order`."""
        return {
            number: self.numbered(*one, lambda looks, n: looks.networks[n])
            for number, one in self.order.items()
        }

    def numbered(
        self, carrier: int, number: int, made: Callable[[CarrierLooks, int], Network]
    ) -> Network:
        """A carrier's network, with the numbers of all."""
        own = made(self.looks_by_carrier[carrier], number)
        way, target = own.way + self.first_way[carrier], self.numbers[carrier][own.target]
        return own._replace(way=way, target=target)

    @cached_property
    def seen(self) -> frozenset[int]:
        """Candidates that somebody can look at."""
        return frozenset(target for one in self.networks.values() for target in one.target.tolist())

    def looks_at(self, network: int) -> CarrierLooks:
        """Of the carrier whose pass it is."""
        return self.looks_by_carrier[self.order[network][0]]

    def carrier_id(self, network: int) -> str:
        """Of the carrier whose pass it is."""
        return tuple(self.carriers)[self.order[network][0]]

    @cached_property
    def first_unheld(self) -> FirstUnheld:
        """Of looks of one pass."""
        return cache(self._first_unheld)

    def _first_unheld(self, looks: tuple[Look, ...]) -> tuple[int, int] | None:
        if not looks:
            return None
        number = int(np.searchsorted(self.first_way, looks[0].way, side="right")) - 1
        own_number = self._own_numbers[number]
        own = (
            one._replace(target=own_number[one.target], way=one.way - int(self.first_way[number]))
            for one in looks
        )
        return self.looks_by_carrier[number].first_unheld(tuple(own))

    @cached_property
    def _own_numbers(self) -> tuple[Mapping[int, int], ...]:
        return tuple({n: own for own, n in enumerate(each.tolist())} for each in self.numbers)

    @cached_property
    def looking(self) -> Looking:
        """What the looks may be."""
        step_s = self.looks_by_carrier[0].request.step_s
        candidates, thing_of = self.candidates, self._things()
        # A group by its name, the scans of a mode in one pass by that, and what each is a way to do
        names: dict[object, int] = {}
        things: dict[object, int] = {}
        group, way_to, way_limit = np.full(len(candidates), -1, np.intp), [], []
        length_steps = np.zeros((len(candidates), BOUNDS.lengths), np.intp)
        held_steps = np.zeros_like(length_steps)
        look_value = np.zeros((len(candidates), BOUNDS.lengths))
        spare_quality = np.zeros(len(candidates))
        for own, looks in zip(self.numbers, self.looks_by_carrier, strict=True):
            np.maximum.at(spare_quality, own, looks.spare_quality)
        for number, one in enumerate(candidates):
            for place, length_s in enumerate(one.lengths_s):
                length_steps[number, place] = one.length_steps(step_s)[place]
                held_steps[number, place] = math.floor(length_s / step_s + 1e-9)
                look_value[number, place] = one.worth_value(length_s)
            name = thing_of[number]
            if name is None:
                continue
            if name not in names:
                names[name] = len(names)
                thing = ("mode", one.wanted.id) if one.is_part else ("group", one.wanted.group)
                if thing not in things:
                    things[thing] = len(things)
                    way_limit.append(float(one.wanted.looks))
                way_to.append(things[thing])
            group[number] = names[name]
        return Looking(
            length_steps=length_steps,
            look_value=look_value,
            look_limit=np.array([float(one.looks) for one in candidates]),
            group=group,
            way_to=np.array(way_to, np.intp),
            way_limit=np.array(way_limit),
            settle_steps=np.array(
                [self.looks_by_carrier[carrier].settle_steps for carrier, _ in self.order.values()],
                np.intp,
            ),
            held_steps=held_steps,
            spare_value=look_value.max(axis=1, initial=0.0) * spare_quality,
        )

    def _things(self) -> list[object]:
        """By candidate the name of its group: as asked, or of a mode's pass; None of none."""
        named: list[object] = [one.wanted.group for one in self.candidates]
        for carrier, numbers in enumerate(self.numbers):
            for number in numbers.tolist():
                one = self.candidates[number]
                if one.is_part:
                    named[number] = carrier, one.scans[0].pass_number
        return named

    @cached_property
    def priced_passes(self) -> PricedPasses:
        """All passes; looks at a group that lacks a target are worth nothing."""
        looking = self.looking
        unseen = [n for n in range(len(self.candidates)) if n not in self.seen]
        is_hopeful = ~np.isin(looking.group, looking.group[unseen]) | (looking.group < 0)
        value: Array = looking.look_value * is_hopeful[:, None]
        worths = replace(looking, look_value=value)
        return PricedPasses(self.networks, Relaxed(self), worths, self.first_unheld)

    def part(self, carriers: Sequence[int]) -> "FleetPart":
        """Of some carriers, by their places in order."""
        names = tuple(self.carriers)
        place = {carrier: n for n, carrier in enumerate(carriers)}
        return FleetPart(
            joined=Joined(
                carriers={names[one]: self.looks_by_carrier[one] for one in carriers},
                candidates=(),  # what they are worth is told by `looking`
                numbers=tuple(self.numbers[one] for one in carriers),
                first_way=self.first_way[list(carriers)],
                order={
                    n: (place[one], own) for n, (one, own) in self.order.items() if one in place
                },
            ),
            looking=self.priced_passes.looking,
            requests={names[one]: self.looks_by_carrier[one].request for one in carriers},
        )


class Relaxed:
    """Networks at slew times that nothing can beat, made as they are asked for: together they take
    as much room as all others."""

    def __init__(self, joined: Joined) -> None:
        self._joined = joined

    def __len__(self) -> int:
        return len(self._joined.order)

    def __getitem__(self, number: int) -> Network:
        return self._joined.numbered(*self._joined.order[number], CarrierLooks.relaxed)


@dataclass(frozen=True, kw_only=True, eq=False)
class FleetPart:
    """Passes of some carriers, to be priced where pickle takes them."""

    joined: Joined
    looking: Looking
    requests: Mapping[str, CampaignRequest]

    def own(self, asked: Iterable[AskedPass]) -> list[AskedPass]:
        """Those of its passes."""
        return [one for one in asked if one.number in self.joined.order]

    def priced_passes(self) -> PricedPasses:
        """By their numbers among all; nothing here holds them, so that they go when they are done
        with."""
        joined = self.joined
        for carrier, looks in joined.carriers.items():
            looks.completed(self.requests[carrier])
        first_unheld = cache(joined._first_unheld)
        return PricedPasses(joined.networks, Relaxed(joined), self.looking, first_unheld)


def joined_of(carriers: Mapping[str, CarrierLooks]) -> Joined:
    """Targets of the same id are one."""
    all_looks = list(carriers.values())
    number_of: dict[object, int] = {}
    candidates: list[LookCandidate] = []

    def number_for(key: object, one: LookCandidate) -> int:
        if key not in number_of:
            number_of[key] = len(candidates)
            candidates.append(one)
        return number_of[key]

    numbers = [np.empty(len(looks.candidates), np.intp) for looks in all_looks]
    for scans in (False, True):  # places first, as in a campaign of one carrier
        for carrier, own, one in _each(all_looks):
            if bool(one.scans) == scans:
                key = (carrier, own) if scans else one.wanted.id
                numbers[carrier][own] = number_for(key, one)
    counts = [len(looks.ways.target) for looks in all_looks]
    passes = [
        (network.first_step, carrier, number)
        for carrier, looks in enumerate(all_looks)
        for number, network in enumerate(looks.networks)
    ]
    return Joined(
        carriers=carriers,
        candidates=tuple(candidates),
        numbers=tuple(numbers),
        first_way=np.cumsum([0, *counts[:-1]]),
        order=dict(enumerate((carrier, number) for _, carrier, number in sorted(passes))),
    )


def _each(all_looks: Sequence[CarrierLooks]) -> Iterable[tuple[int, int, LookCandidate]]:
    for carrier, looks in enumerate(all_looks):
        for own, one in enumerate(looks.candidates):
            yield carrier, own, one
