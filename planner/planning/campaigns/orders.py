"""The best order of looks of one pass whose looks at each target last alike, and what bounds it."""

from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Array, Indices, Mask
from planner.planning.campaigns.network import NEVER, Network
from planner.planning.campaigns.path import Look, Path, Worth
from planner.planning.label_search import BITS, NONE
from planner.planning.look_orders import LookGraph, Orders, orders_by_count, places_of


@dataclass(frozen=True, kw_only=True)
class OrderOptions:
    """How large a pass is looked at, and how much of it."""

    arrivals_max: int = 5_000_000  # of all steps onto all ways: 40 MB
    extensions_max: int = 2_000_000  # of orders of as many looks by one more: 100 MB
    timed: int = 8  # of the orders that are worth most, whose times are then sought


OPTIONS = OrderOptions()


def most_worth(network: Network, worth: Worth, orders_max: int) -> float:
    """No path that looks at each target once has a greater value; infinite where that takes more
    than orders_max orders."""
    graph = _graph_of(network, worth)
    if graph is None:
        return np.inf
    width = min(orders_max, OPTIONS.extensions_max // len(network.way))
    most, left = 0.0, orders_max
    for orders in orders_by_count(graph, width + 1):
        left -= len(orders.place)
        if len(orders.place) > width or left < 0:
            return np.inf
        most = max(most, float(orders.value[_are_back(graph, orders)].max(initial=0.0)))
    return most


def ordered_path(network: Network, worth: Worth, width: int) -> Path | None:
    """A path that looks at no target twice, from so many orders of as many looks; None where the
    pass is too large, or looks at a target may last differently long."""
    graph = _graph_of(network, worth)
    if graph is None or (np.count_nonzero(worth.steps[network.target], axis=1) > 1).any():
        return None
    width = min(width, OPTIONS.extensions_max // len(network.way))
    found = list(orders_by_count(graph, width))
    ends = [
        (float(value[row]), count, row)
        for count, orders in enumerate(found, start=1)
        for value in [np.where(_are_back(graph, orders), orders.value, -np.inf)]
        for row in np.argsort(-value, kind="stable")[: OPTIONS.timed].tolist()
    ]
    best: Path | None = None
    for value, count, row in sorted(ends, key=lambda end: -end[0])[: OPTIONS.timed]:
        if best is not None and value <= best.value:
            break
        path = _timed(network, worth, graph.way[places_of(found[:count], row)].tolist())
        if path is not None and (best is None or path.value > best.value):
            best = path
    return best


def _are_back(graph: LookGraph, orders: Orders) -> Mask:
    """Which of the orders may end with their last look, (n,)."""
    return np.asarray(orders.place <= graph.last[graph.way[orders.place]])


def _graph_of(network: Network, worth: Worth) -> LookGraph | None:
    """Places are the network's cells; looks are as short and as good as they can be."""
    if len(network.way) * network.size > OPTIONS.arrivals_max:
        return None
    gain = worth.value.max(axis=1) * _best_quality(network, len(worth.price)) - worth.price
    items = np.unique(network.target[gain[network.target] > 0.0])
    is_hopeful = np.isin(network.target, items)
    word, bit = np.divmod(np.searchsorted(items, network.target) * is_hopeful, BITS)
    seen = np.zeros((len(network.way), len(items) // BITS + 1), np.int64)
    seen[np.arange(len(word)), word] = (1 << bit) * is_hopeful
    shortest = np.where(worth.steps > 0, worth.steps, network.stop_step).min(axis=1)
    takes = shortest[network.target]
    steps = network.last - network.first + 1
    entered = network.enters - network.offset + takes
    way = np.repeat(np.arange(len(steps)), steps)
    return LookGraph(
        way=way,
        end=np.arange(network.size) - (network.offset - network.first)[way],
        first=np.where(
            (network.enters != NEVER) & (entered < steps), entered + network.offset, NONE
        ),
        last=_last_ends(network),
        follow=_soonest_ends(network, takes),
        seen=seen,
        gain=np.where(is_hopeful, gain[network.target], 0.0),
    )


def _best_quality(network: Network, targets: int) -> Array:
    """The greatest of any step, (targets,): no mean over a look is greater."""
    best = np.zeros(targets)
    for way, target in enumerate(network.target.tolist()):
        first = network.offset[way]
        total = network.quality_sum[first : first + network.last[way] - network.first[way] + 1]
        best[target] = max(best[target], float(np.diff(total).max(initial=0.0)))
    return best


def _soonest_ends(network: Network, takes: Indices) -> Indices:
    """As `LookGraph.follow`."""
    never = np.iinfo(np.int32).max
    follow: Indices = np.full((network.size, len(network.way)), never, np.intp)
    for way in range(len(network.way)):
        own, arrivals = slice(*_cells(network, way)), _arrivals(network, way)
        to = network.edge_to[_edges(network, way)]
        follow[own, to] = np.where(arrivals == NEVER, never, arrivals)
        beyond = network.first >= network.last[way] + network.reach
        follow[own, beyond] = network.offset[beyond]
        follow[own] = np.minimum.accumulate(follow[own][::-1], axis=0)[::-1]
    ends: Indices = follow + takes.astype(np.intp)
    ends[ends > network.offset + network.last - network.first] = NONE
    return ends


def _last_ends(network: Network) -> Indices:
    """As `LookGraph.last`."""
    back = np.where(network.ends, np.arange(network.size), NONE)
    return np.asarray(np.maximum.reduceat(back, network.offset), np.intp)


def _cells(network: Network, way: int) -> tuple[int, int]:
    first = int(network.offset[way])
    return first, first + int(network.last[way] - network.first[way]) + 1


def _edges(network: Network, way: int) -> slice:
    return slice(int(network.edge_from[way]), int(network.edge_from[way + 1]))


def _arrivals(network: Network, way: int) -> Indices:
    """Of each step of a way by each edge."""
    edges = _edges(network, way)
    first, stop = _cells(network, way)
    shape = stop - first, edges.stop - edges.start
    begin = int(network.arrival_offset[way])
    return np.asarray(network.arrival[begin : begin + shape[0] * shape[1]], np.intp).reshape(shape)


def _timed(network: Network, worth: Worth, order: list[int]) -> Path | None:
    """The best times of looks by ways in this order."""
    done_value = np.zeros(0)
    steps_back: list[Indices] = []
    values: list[Array] = []
    for place, way in enumerate(order):
        first, stop = _cells(network, way)
        if place == 0:
            is_there = (network.enters[way] != NEVER) & (
                network.enters[way] <= np.arange(first, stop)
            )
            ready, whence = np.where(is_there, 0.0, -np.inf), np.zeros(stop - first, np.intp)
        else:
            ready, whence = _ready_after(network, order[place - 1], way, done_value)
        target = network.target[way]
        takes = int(worth.steps[target, 0])
        lasts = max(takes - worth.settle_steps, 1)
        total = network.quality_sum[first:stop]
        value = np.zeros(stop - first)
        value[takes:] = worth.value[target, 0] * (total[takes:] - total[takes - lasts : -lasts])
        value /= lasts
        done_value = np.full(stop - first, -np.inf)
        begun = np.where(
            network.begins[first : stop - takes], ready[: stop - first - takes], -np.inf
        )
        done_value[takes:] = begun + value[takes:] - worth.price[target]
        steps_back.append(whence)
        values.append(value)
    done_value = np.where(network.ends[first:stop], done_value, -np.inf)
    at = int(np.argmax(done_value))
    best = float(done_value[at])
    if not np.isfinite(best):
        return None
    looks: list[Look] = []
    for way, whence, value in zip(order[::-1], steps_back[::-1], values[::-1], strict=True):
        target = int(network.target[way])
        begin = at - int(worth.steps[target, 0])
        step = network.first_step + network.first[way] + begin + worth.settle_steps
        looks.append(
            Look(
                target=target,
                way=int(network.way[way]),
                first_step=int(step),
                length=0,
                value=float(value[at]),
            )
        )
        at = int(whence[begin])
    return Path(value=best, looks=tuple(looks[::-1]))


def _ready_after(network: Network, way: int, to: int, done_value: Array) -> tuple[Array, Indices]:
    """By each step of a way the most of who can be on it by then, and at which step of the way
    before that one has ended its look."""
    first, stop = _cells(network, to)
    arrival = np.zeros(len(done_value), np.intp)
    edge = np.flatnonzero(network.edge_to[_edges(network, way)] == to)
    if len(edge):
        cells = _arrivals(network, way)[:, edge[0]]
        arrival = np.where(cells == NEVER, stop - first, cells - first)
    ready, whence = np.full(stop - first, -np.inf), np.zeros(stop - first, np.intp)
    for at in np.flatnonzero(np.isfinite(done_value) & (arrival < stop - first)).tolist():
        if done_value[at] > ready[arrival[at]]:
            ready[arrival[at]], whence[arrival[at]] = done_value[at], at
    best = np.maximum.accumulate(ready)
    is_new = np.append(True, ready[1:] > best[:-1])
    newest = np.maximum.accumulate(np.where(is_new, np.arange(stop - first), 0))
    return best, whence[newest]
