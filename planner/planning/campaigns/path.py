"""The looks of one pass, one after another, that are worth most together."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from planner.base.arrays import Array, Indices, Mask
from planner.base.compiled import compiled, inlined, lean
from planner.planning import label_search
from planner.planning.campaigns.network import NEVER, Network
from planner.planning.label_search import (
    NONE,
    ROUNDING,
    LabelMemory,
    Labels,
    Repeats,
    Round,
    Visit,
    best,
    follow,
    no_labels,
    rounds,
    visit,
)

NOT_HELD: Indices = np.zeros((0, 0), np.intp)


class Look(NamedTuple):
    """A target looked at: by which way (row in `Ways`), from which step on the grid.

    length: which of the target's lengths.  value: without a price.
    """

    target: int
    way: int
    first_step: int
    length: int
    value: float


@dataclass(frozen=True, kw_only=True)
class Path:
    """Looks in order of time, and what they are worth less their prices."""

    value: float
    looks: tuple[Look, ...]


class Worth(NamedTuple):
    """What looks at each target are worth.

    steps: on the grid, and value: at the best view, (targets, lengths), 0 for lengths there are
    not.  price: of any look, (targets,); one that is worth no more is never taken.  settle_steps:
    of these steps, before the look itself begins.  held_steps: whole steps that a look lasts at
    least, as steps, where networks say what their steps cost.
    """

    steps: Indices
    value: Array
    price: Array
    settle_steps: int = 0
    held_steps: Indices = NOT_HELD


def best_path(network: Network, worth: Worth) -> Path:
    """A path that looks at no target twice, though a better one may be missed."""
    value, visits = _sweep_once(network, worth)
    return _path_of(network, worth, value, visits)


def exact_path(
    network: Network, worth: Worth, labels_max: int, kept: Sequence[int]
) -> tuple[Path | None, int]:
    """The path worth most that looks at no target twice, and labels made; None where it takes more.

    labels_max: of a round, and of those before the last one.
    kept: targets whose price makes them wanted at every turn.
    """
    made = list(_rounds(network, worth, kept, labels_max, labels_max))
    found, labels = made[-1], sum(one.labels for one in made)
    targets = found.visits[:, 1]
    if not found.is_complete or len(np.unique(targets)) < len(targets):
        return None, labels
    return _path_of(network, worth, found.value, found.visits), labels


def _path_of(network: Network, worth: Worth, value: float, visits: Indices) -> Path:
    """visits: as of `Round`."""
    numbers, values = _looks_of(network, worth, visits)
    looks = zip(*numbers.tolist(), values.tolist(), strict=True)
    return Path(value=value, looks=tuple(map(Look._make, looks)))


@compiled
def _looks_of(network: Network, worth: Worth, visits: Indices) -> tuple[Indices, Array]:
    """Whole numbers of looks as `Look` has them, (4, looks), and the values."""
    numbers, values = np.empty((4, len(visits)), np.intp), np.empty(len(visits))
    for n in range(len(visits)):
        cell, length = divmod(visits[n, 0], worth.value.shape[1])
        target = visits[n, 1]
        way = np.searchsorted(network.offset, cell, side="right") - 1
        begin = cell - network.offset[way] + network.first[way] - worth.steps[target, length]
        numbers[0, n], numbers[1, n] = target, network.way[way]
        numbers[2, n] = network.first_step + begin + worth.settle_steps
        numbers[3, n] = length
        values[n] = look_worth(network, worth, cell, target, length)
    return numbers, values


def bounded_path(network: Network, worth: Worth, labels_max: int) -> tuple[float, Path]:
    """No path that looks at each target once has a greater value, and the best one known.

    Tightened until a path of that value is known, or more than labels_max labels were made.
    """
    known = best_path(network, worth)
    least = np.inf
    for found in _rounds(network, worth, (), labels_max):
        least = min(least, label_search.bound([found]))
        if least <= known.value + ROUNDING * abs(known.value):
            break
        targets = found.visits[:, 1]
        if found.value > known.value and len(np.unique(targets)) == len(targets):
            known = _path_of(network, worth, found.value, found.visits)
    return least, known


def _rounds(
    network: Network, worth: Worth, kept: Sequence[int], *labels_max: int
) -> Iterator[Round]:
    """kept: as of `exact_path`.  labels_max: as of `rounds`."""
    leap_ticks = 2 * int((network.last - network.first).max()) + network.reach
    things = len(worth.price)
    return rounds(
        lambda memory: Round(*_sweep(network, worth, memory)),
        Repeats(things, network.target, network.first, network.last, leap_ticks, everywhere=kept),
        *labels_max,
    )


@compiled
def look_worth(network: Network, worth: Worth, cell: int, target: int, length: int) -> float:
    """Without its price, of a look that ends at a cell: by the mean quality of its view."""
    takes = max(worth.steps[target, length] - worth.settle_steps, 1)
    seen = network.quality_sum[cell] - network.quality_sum[max(cell - takes, 0)]
    return float(worth.value[target, length] * seen / takes)


@inlined
def _gain(
    network: Network, worth: Worth, cell: int, target: int, length: int, begin_step: int
) -> float:
    """Of a look that ends at a cell, less its price and what it costs while it is held."""
    value: float = look_worth(network, worth, cell, target, length) - worth.price[target]
    if len(network.cost):
        begin = begin_step + worth.settle_steps
        value -= network.cost[begin + worth.held_steps[target, length]] - network.cost[begin]
    return value


@compiled
def _of_use(network: Network, worth: Worth) -> Mask:
    """Ways on which the longest look at the best view is worth more than its price, (w,)."""
    is_of_use = np.empty(len(network.way), np.bool_)
    for way in range(len(network.way)):
        target = network.target[way]
        is_of_use[way] = worth.value[target].max() > worth.price[target]
    return is_of_use


@lean
def _look_until(
    labels: Labels,
    network: Network,
    worth: Worth,
    memory: LabelMemory,
    cell: int,
    way: int,
    step: int,
) -> bool:
    """Looks of any length that end at a cell; whether there are any."""
    lengths, target, is_seen = worth.value.shape[1], network.target[way], False
    for length in range(lengths):
        takes = worth.steps[target, length]
        if not 0 < takes <= step - network.first[way] or not network.begins[cell - takes]:
            continue
        value = _gain(network, worth, cell, target, length, step - takes)
        if value > 0.0:
            look = Visit(cell * lengths + length, target, value, step)
            is_seen |= visit(labels, (cell - takes,), cell + network.size, memory, look)
    return is_seen


class _Reached(NamedTuple):
    """The best known at each place of `_sweep`: worth, and the cell where its last look ended.

    number, target, before: of the look that ends at each cell, and the cell where the one before it
    ended.  NONE is no cell.
    """

    value: Array
    last: Indices
    number: Indices
    target: Indices
    before: Indices


@lean
def _come(reached: _Reached, begin: int, to: int) -> None:
    """To another place with nothing done on the way, where that is better."""
    if reached.value[begin] > reached.value[to]:
        reached.value[to], reached.last[to] = reached.value[begin], reached.last[begin]


@lean
def _look_once(
    reached: _Reached, network: Network, worth: Worth, cell: int, way: int, step: int
) -> bool:
    """As `_look_until`, of targets that the path to there hasn't looked at."""
    lengths, target, is_seen = worth.value.shape[1], network.target[way], False
    done = cell + network.size
    for length in range(lengths):
        takes = worth.steps[target, length]
        if not 0 < takes <= step - network.first[way] or not network.begins[cell - takes]:
            continue
        value = _gain(network, worth, cell, target, length, step - takes)
        total = reached.value[cell - takes] + value
        if not value > 0.0 or reached.value[done] >= total - ROUNDING:
            continue
        before = last = reached.last[cell - takes]
        while last != NONE and reached.target[last] != target:
            last = reached.before[last]
        if last == NONE:
            reached.value[done], reached.last[done], is_seen = total, cell, True
            reached.number[cell], reached.target[cell] = cell * lengths + length, target
            reached.before[cell] = before
    return is_seen


@lean
def _leave_once(reached: _Reached, network: Network, cell: int, way: int, step: int) -> None:
    """As `_leave`."""
    done, rest = cell + network.size, 2 * network.size
    _come(reached, done, rest + step)
    if network.ends[cell]:
        _come(reached, done, rest + network.stop_step + 1)
    edges = network.edge_from[way + 1] - network.edge_from[way]
    begin = network.arrival_offset[way] + (step - network.first[way]) * edges
    for to in network.arrival[begin : begin + edges]:
        if to != NEVER:
            _come(reached, done, to)


@compiled
def _looks_until(reached: _Reached, place: int) -> Indices:
    """Number and target of each look of the best path to a place, (n, 2)."""
    count, last = 0, reached.last[place]
    while last != NONE:
        count, last = count + 1, reached.before[last]
    looks, last = np.empty((count, 2), np.intp), reached.last[place]
    for row in range(count - 1, -1, -1):
        looks[row, 0], looks[row, 1] = reached.number[last], reached.target[last]
        last = reached.before[last]
    return looks


@compiled
def _sweep_once(network: Network, worth: Worth) -> tuple[float, Indices]:
    """As `_sweep`, of the best path to each place alone, which looks back at all of itself: many
    times as quick.  Its worth, and number and target of each look, (n, 2)."""
    size, end = network.size, network.stop_step
    rest = 2 * size
    start, home = rest + end, rest + end + 1
    cells = np.empty((3, size), np.intp)
    reached = _Reached(
        np.full(home + 1, -np.inf), np.full(home + 1, NONE), cells[0], cells[1], cells[2]
    )
    reached.value[start] = 0.0
    _come(reached, start, home)
    is_of_use = _of_use(network, worth)
    for step in range(end):
        if step > 0:
            _come(reached, rest + step - 1, rest + step)
        for way in range(len(network.first)):
            steps = step - network.first[way]
            if steps < 0:
                break
            if step > network.last[way] or not is_of_use[way]:
                continue
            cell = network.offset[way] + steps
            done = cell + size
            if cell == network.enters[way]:
                _come(reached, start, cell)
            if steps == 0:
                _come(reached, rest + max(step - network.reach, 0), cell)
            else:
                _come(reached, cell - 1, cell)
                if not network.scanned[way]:
                    _come(reached, done - 1, done)
            if _look_once(reached, network, worth, cell, way, step):
                _leave_once(reached, network, cell, way, step)
    return reached.value[home], _looks_until(reached, home)


@lean
def _leave(
    labels: Labels, network: Network, memory: LabelMemory, cell: int, way: int, step: int
) -> None:
    """From a look that ends at a cell to other ways, to rest, and home if that is in time."""
    done, rest = cell + network.size, 2 * network.size
    follow(labels, done, (rest + step,), memory.every, True)
    if network.ends[cell]:
        follow(labels, done, (rest + network.stop_step + 1,), memory.none, True)
    edges = network.edge_from[way + 1] - network.edge_from[way]
    begin = network.arrival_offset[way] + (step - network.first[way]) * edges
    follow(labels, done, network.arrival[begin : begin + edges], memory.every, True)


@compiled
def _sweep(network: Network, worth: Worth, memory: LabelMemory) -> tuple[float, Indices, int, bool]:
    """Places: on a way, by cell, first ready to look, then after a look; at rest, by step; at rest
    before all looks, and after them."""
    size, end = network.size, network.stop_step
    rest = 2 * size
    start, home = rest + end, rest + end + 1
    labels = no_labels(home + 1, start, memory)
    follow(labels, start, (home,), memory.none, False)
    is_of_use = _of_use(network, worth)
    for step in range(end):
        mask = memory.tick_mask[step]
        if step > 0:
            follow(labels, rest + step - 1, (rest + step,), mask, False)
        for way in range(len(network.first)):
            steps = step - network.first[way]
            if steps < 0:
                break
            if step > network.last[way] or not is_of_use[way]:
                continue
            cell = network.offset[way] + steps
            done = cell + size
            if cell == network.enters[way]:
                follow(labels, start, (cell,), mask, False)
            if steps == 0:
                follow(labels, rest + max(step - network.reach, 0), (cell,), mask, False)
            else:
                follow(labels, cell - 1, (cell,), mask, False)
                if not network.scanned[way]:
                    follow(labels, done - 1, (done,), mask, False)
            if _look_until(labels, network, worth, memory, cell, way, step):
                _leave(labels, network, memory, cell, way, step)
    return best(labels, (home, home + 1))
