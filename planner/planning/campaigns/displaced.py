"""Chosen observations that displace a target which got none."""

import itertools
from collections.abc import Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from planner.base.arrays import Array, Indices
from planner.base.compiled import compiled, lean
from planner.planning.campaigns.choice import ChoiceOptions, Passes, worth_of
from planner.planning.campaigns.looking import FirstUnheld
from planner.planning.campaigns.network import NEVER, Network
from planner.planning.campaigns.path import Look, Worth, best_path, look_worth
from planner.planning.campaigns.resources import Keeping, RunsOut


@dataclass(frozen=True, kw_only=True)
class Displaced:
    """A look at a target that has none, in one pass of the networks.

    by: looks left out for it, with all of their groups.  looks: all of the pass, with it.  gain: of
    the choice's worth.
    out: the resource that it would take too much of, as all others would that gain.  tried: how
    many of these were tried, where not all.
    """

    look: Look
    pass_number: int
    by: tuple[Look, ...]
    looks: tuple[Look, ...]
    gain: float
    out: RunsOut | None = None
    tried: int | None = None

    def taken(self, passes: Iterable[tuple[Look, ...]]) -> Passes:
        """A choice with it, in the place of what it displaces."""
        passes = [tuple(one for one in looks if one not in self.by) for looks in passes]
        passes[self.pass_number] = self.looks
        return passes


def displaced_by(exchanged: Sequence["Exchanged"], left_out: Indices) -> tuple[Displaced, ...]:
    """The look at each target left out whose worth best makes up for those it would displace, had
    the others stayed as they are.

    left_out: rows of the request's targets.
    """
    best: dict[int, tuple[float, Displaced]] = {}
    wanted = left_out.tolist()
    for one in exchanged:
        for row in np.flatnonzero(np.isin(one.network.target, wanted)).tolist():
            target = int(one.network.target[row])
            gain, cell, length = _best_exchange(one.network, row, one.worth, one.places)
            if length != NEVER and (target not in best or gain > best[target][0]):
                best[target] = gain, one.with_look(row, cell, length)
    return tuple(best[target][1] for target in sorted(best))


def lacking(
    best: Displaced,
    exchanged: Sequence["Exchanged"],
    keeping: Keeping,
    first_unheld: FirstUnheld,
    tries: int,
) -> Displaced:
    """The look that a target came nearest to, where resources count: one in the place of what is
    worth less with which they keep, or else the first of those with which they don't.

    best: had they not counted.
    """
    first, tried, target = best, 0, best.look.target
    chosen = [other.looks for other in exchanged]
    further = (
        found for one in exchanged if target in one.targets for found in one.all_with(target)
    )
    for one in itertools.chain([best], further):
        carriers = [keeping.carrier_of[one.pass_number]]
        passes, wanted = one.taken(chosen), frozenset([target])
        for out, kept, runs_out in beside(passes, one.gain, wanted, exchanged, keeping, carriers):
            tried += 1
            if runs_out is None and first_unheld(kept[one.pass_number]) is None:
                looks, gain = kept[one.pass_number], one.gain - _worth(out)
                return replace(one, by=one.by + out, looks=looks, gain=gain)
            first = first if first.out else replace(one if runs_out else first, out=runs_out)
            if tried == tries:
                return replace(first, tried=tried)
    return first


def beside(
    passes: Passes,
    gain: float,
    wanted: Set[int],
    exchanged: Sequence["Exchanged"],
    keeping: Keeping,
    carriers: Sequence[int],
) -> Iterator[tuple[tuple[Look, ...], Passes, RunsOut | None]]:
    """Looks of carriers beside those at targets wanted, worth less together than a gain; passes
    without them, and the resource that these carriers then run out of."""
    look_at = {look.target: look for looks in passes for look in looks}
    own = dict.fromkeys(
        tuple(
            look if other.target == look.target else look_at[other.target]
            for other in exchanged[n].together(look)
        )
        for carrier in carriers
        for n in keeping.passes_of[carrier]
        for look in passes[n]
        if look.target not in wanted
    )
    for out in _worth_less(sorted(own, key=_worth), gain):
        kept = [tuple(x for x in looks if x not in out) for looks in passes] if out else passes
        runs_out = (keeping.runs_out(carrier, kept) for carrier in carriers)
        yield out, kept, next(filter(None, runs_out), None)


def _worth_less(
    looks: Sequence[tuple[Look, ...]], below_value: float
) -> Iterator[tuple[Look, ...]]:
    """Looks that are worth less together; looks: those left out together, by worth."""
    if below_value > ChoiceOptions.worthless:
        yield ()
        for number, own in enumerate(looks):
            if _worth(own) >= below_value:
                return
            for out in _worth_less(looks[number + 1 :], below_value - _worth(own)):
                yield *own, *out


def _worth(looks: Iterable[Look]) -> float:
    return worth_of([[*looks]])


class Exchanged:
    """A pass and its looks, with another one in the place of some."""

    def __init__(
        self,
        number: int,
        network: Network,
        looks: tuple[Look, ...],
        worth: Worth,
        groups: Mapping[int, tuple[Look, ...]] = MappingProxyType({}),
    ) -> None:
        """number: of the network.  groups: by target the looks of all passes at its group."""
        self._number, self.network, self.looks, self.worth = number, network, looks, worth
        self._groups, self.targets = groups, {*network.target.tolist()}
        self.places = _places(network, looks, worth, [self.together(look) for look in looks])

    def together(self, look: Look) -> tuple[Look, ...]:
        """All that is chosen with one or not at all."""
        return self._groups.get(look.target, (look,))

    def with_look(self, row: int, cell: int, length: int) -> Displaced:
        """One that ends at a cell of the way in that row, the others as they are."""
        network, worth, target = self.network, self.worth, int(self.network.target[row])
        start = cell - int(worth.steps[target, length])
        step = network.first_step + int(network.first[row]) + start - int(network.offset[row])
        step += worth.settle_steps
        value = look_worth(network, worth, cell, target, length)
        look = Look(target, int(network.way[row]), step, length, value)
        blocked = _blocked(network, row, start, cell, self.places)
        kept = [*itertools.compress(self.looks, ~blocked), look]
        return self._displaced(look, tuple(sorted(kept, key=lambda one: one.first_step)))

    def _displaced(self, look: Look, looks: tuple[Look, ...]) -> Displaced:
        seen = {one.target for one in looks}
        gone = (self.together(one) for one in self.looks if one.target not in seen)
        by = tuple(dict.fromkeys(itertools.chain.from_iterable(gone)))
        broken = {one.target for one in by}
        looks = tuple(one for one in looks if one.target not in broken)
        gain = _worth(looks) - _worth(dict.fromkeys((*self.looks, *by)))
        return Displaced(look=look, pass_number=self._number, by=by, looks=looks, gain=gain)

    def all_with(self, target: int) -> Iterator[Displaced]:
        """The best path with a look at a target, the others moved or left out, then any look at it
        with the others as they are."""
        network, worth = self.network, self.worth
        rows = np.flatnonzero(network.target == target).tolist()
        steps, price = np.zeros_like(worth.steps), np.full(len(worth.price), np.inf)
        steps[target], price[target] = worth.steps[target], -1.0 - worth_of([self.looks])
        for one in self.looks:
            steps[one.target, one.length] = worth.steps[one.target, one.length]
            price[one.target] = 0.0
        path = best_path(network, worth._replace(steps=steps, price=price)).looks
        yield from (self._displaced(look, path) for look in path if look.target == target)
        for row in rows:
            if _best_exchange(network, row, worth, self.places)[0] <= ChoiceOptions.worthless:
                continue
            first, count = int(network.offset[row]), int(network.last[row] - network.first[row]) + 1
            cells = range(first, first + count)
            for cell, length in itertools.product(cells, range(steps.shape[1])):
                if _is_home(network, row, cell, steps[target, length]):
                    yield self.with_look(row, cell, length)


class _Places(NamedTuple):
    """Looks of one pass: the way, the cells it begins and ends at, and the value of all that is
    left out with it, by whose number it is told, (looks,)."""

    way: Indices
    start: Indices
    stop: Indices
    value: Array
    group: Indices


def _places(
    network: Network, looks: Sequence[Look], worth: Worth, together: Sequence[tuple[Look, ...]]
) -> _Places:
    row = {way: n for n, way in enumerate(network.way.tolist())}
    way = np.array([row[look.way] for look in looks], np.intp)
    first = np.array([look.first_step for look in looks], np.intp) - network.first_step
    start = network.offset[way] + first - network.first[way] - worth.settle_steps
    takes = np.array([worth.steps[look.target, look.length] for look in looks], np.intp)
    value = np.array([_worth(own) for own in together])
    group = np.array([min(one.target for one in own) for own in together], np.intp)
    return _Places(way, start, start + takes, value, group)


@compiled
def _best_exchange(
    network: Network, way: int, worth: Worth, places: _Places
) -> tuple[float, int, int]:
    """The gain, the cell it ends at and the length of the best look by a way; length NEVER."""
    target, lengths = network.target[way], worth.value.shape[1]
    best, best_cell, best_length = -np.inf, NEVER, NEVER
    begin = network.offset[way]
    for cell in range(begin, begin + network.last[way] - network.first[way] + 1):
        for length in range(lengths):
            takes = worth.steps[target, length]
            if not _is_home(network, way, cell, takes):
                continue
            gain = look_worth(network, worth, cell, target, length)
            if gain <= best:
                continue
            blocked = _blocked(network, way, cell - takes, cell, places)
            for n in range(len(blocked)):
                if blocked[n]:
                    is_told = (blocked[:n] & (places.group[:n] == places.group[n])).any()
                    gain -= 0.0 if is_told else places.value[n]
            if gain > best:
                best, best_cell, best_length = gain, cell, length
    return best, best_cell, best_length


@compiled
def _is_home(network: Network, way: int, cell: int, takes: int) -> bool:
    """Whether one who rests before and after can look for so many steps of a way until a cell."""
    if not 0 < takes <= cell - network.offset[way] or not network.ends[cell]:
        return False
    return bool(NEVER < network.enters[way] <= cell - takes)


@compiled
def _blocked(
    network: Network, way: int, start: int, stop: int, places: _Places
) -> NDArray[np.bool_]:
    """Which looks can be flown neither before nor after one by a way from cell to cell."""
    blocked = np.empty(len(places.way), np.bool_)
    for n in range(len(places.way)):
        blocked[n] = not (
            _reaches(network, places.way[n], places.stop[n], way, start)
            or _reaches(network, way, stop, places.way[n], places.start[n])
        )
    return blocked


@lean
def _reaches(network: Network, way: int, leave: int, to: int, begin: int) -> bool:
    """Whether a slew from one way, left at a cell, is at another one's cell in time."""
    left = network.first[way] + leave - network.offset[way]
    begins = network.first[to] + begin - network.offset[to]
    if begins >= left + network.reach:
        return True
    edges = network.edge_from[way + 1] - network.edge_from[way]
    row = network.arrival_offset[way] + (leave - network.offset[way]) * edges
    for edge in range(edges):
        if network.edge_to[network.edge_from[way] + edge] == to:
            arrival = network.arrival[row + edge]
            return bool(arrival != NEVER and arrival <= begin)
    return False
