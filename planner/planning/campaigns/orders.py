"""The best order of looks of one pass whose looks at each target last alike, and what bounds it."""

from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Array, Indices
from planner.planning.campaigns.network import NEVER, Network
from planner.planning.campaigns.path import Look, Path, Worth
from planner.planning.label_search import BITS, NONE
from planner.planning.look_orders import LookGraph, orders_by_count, places_of


@dataclass(frozen=True, kw_only=True)
class OrderOptions:
    """How large a pass is looked at, and how much of it."""

    arrivals_max: int = 20_000_000  # of all steps onto all ways: 80 MB
    timed: int = 8  # of the orders that are worth most, whose times are then sought


OPTIONS = OrderOptions()


def most_worth(network: Network, worth: Worth, orders_max: int) -> float:
    """No path that looks at each target once has a greater value; infinite where that takes more
    than orders_max orders."""
    graph = _graph_of(network, worth)
    if graph is None:
        return np.inf
    most, left = 0.0, orders_max
    for orders in orders_by_count(graph, orders_max + 1):
        left -= len(orders.place)
        if left < 0:
            return np.inf
        most = max(most, float(orders.value.max()))
    return most


def ordered_path(network: Network, worth: Worth, width: int) -> Path | None:
    """A path that looks at no target twice, from so many orders of as many looks; None where the
    pass is too large, or looks at a target may last differently long."""
    graph = _graph_of(network, worth)
    if graph is None or (np.count_nonzero(worth.steps[network.target], axis=1) > 1).any():
        return None
    found = list(orders_by_count(graph, width))
    ends = [
        (float(orders.value[row]), count, row)
        for count, orders in enumerate(found, start=1)
        for row in np.argsort(-orders.value, kind="stable")[: OPTIONS.timed].tolist()
    ]
    best: Path | None = None
    for value, count, row in sorted(ends, key=lambda end: -end[0])[: OPTIONS.timed]:
        if best is not None and value <= best.value:
            break
        path = _timed(network, worth, graph.way[places_of(found[:count], row)].tolist())
        if path is not None and (best is None or path.value > best.value):
            best = path
    return best


def _graph_of(network: Network, worth: Worth) -> LookGraph | None:
    """Places are the network's cells; looks are as short and as good as they can be."""
    if len(network.way) * network.size > OPTIONS.arrivals_max:
        return None
    gain = worth.value.max(axis=1) * _best_quality(network, len(worth.price)) - worth.price
    items = np.unique(network.target[gain[network.target] > 0.0])
    if len(items) > BITS:
        return None
    is_hopeful = np.isin(network.target, items)
    seen = np.where(is_hopeful, 1 << np.searchsorted(items, network.target) * is_hopeful, 0)
    shortest = np.where(worth.steps > 0, worth.steps, network.stop_step).min(axis=1)
    takes = shortest[network.target]
    steps = network.last - network.first + 1
    way = np.repeat(np.arange(len(steps)), steps)
    return LookGraph(
        way=way,
        end=np.arange(network.size) - (network.offset - network.first)[way],
        first=np.where(takes < steps, network.offset + takes, NONE),
        follow=_soonest_ends(network, takes),
        seen=seen,
        needs=np.zeros_like(seen),
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
    done = np.zeros(0)
    steps_back: list[Indices] = []
    values: list[Array] = []
    for place, way in enumerate(order):
        first, stop = _cells(network, way)
        if place == 0:
            ready, whence = np.zeros(stop - first), np.zeros(stop - first, np.intp)
        else:
            ready, whence = _ready_after(network, order[place - 1], way, done)
        target = network.target[way]
        takes = int(worth.steps[target, 0])
        lasts = max(takes - worth.settle_steps, 1)
        total = network.quality_sum[first:stop]
        value = np.zeros(stop - first)
        value[takes:] = worth.value[target, 0] * (total[takes:] - total[takes - lasts : -lasts])
        value /= lasts
        done = np.full(stop - first, -np.inf)
        begun = np.where(
            network.begins[first : stop - takes], ready[: stop - first - takes], -np.inf
        )
        done[takes:] = begun + value[takes:] - worth.price[target]
        steps_back.append(whence)
        values.append(value)
    at = int(np.argmax(done))
    best = float(done[at])
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


def _ready_after(network: Network, way: int, to: int, done: Array) -> tuple[Array, Indices]:
    """By each step of a way the most of who can be on it by then, and at which step of the way
    before that one has ended its look."""
    first, stop = _cells(network, to)
    arrival = np.zeros(len(done), np.intp)
    edge = np.flatnonzero(network.edge_to[_edges(network, way)] == to)
    if len(edge):
        cells = _arrivals(network, way)[:, edge[0]]
        arrival = np.where(cells == NEVER, stop - first, cells - first)
    ready, whence = np.full(stop - first, -np.inf), np.zeros(stop - first, np.intp)
    for at in np.flatnonzero(np.isfinite(done) & (arrival < stop - first)).tolist():
        if done[at] > ready[arrival[at]]:
            ready[arrival[at]], whence[arrival[at]] = done[at], at
    best = np.maximum.accumulate(ready)
    is_new = np.append(True, ready[1:] > best[:-1])
    newest = np.maximum.accumulate(np.where(is_new, np.arange(stop - first), 0))
    return best, whence[newest]
