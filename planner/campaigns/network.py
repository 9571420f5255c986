"""When each way of a pass can be reached from each other one."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from planner.arrays import Array
from planner.campaigns.slew_time import slew_time_s
from planner.campaigns.ways import Ways
from planner.compiled import compiled

Indices = NDArray[np.intp]
NEVER = -1
SUFFICIENT, NECESSARY = 1.0, -1.0
Shape = tuple[Indices, Indices, Indices, Indices, Indices, Indices]


@dataclass(frozen=True, kw_only=True, eq=False)
class Network:
    """One pass as a graph; ways (w,) with steps counted from the pass's first.

    way: row in `Ways`.  target: row of the request's.  first, last: steps at which it can be
    followed.  offset: of its steps among all, `size` in all.
    edge_from (w + 1,): the edges that leave way i are edge_from[i] to edge_from[i + 1].
    edge_to: where they lead; arrival[arrival_offset[e] + k]: the first step at which edge
    e's way can be followed when the other is left k steps after its first; NEVER.
    reach: after so many steps any way can be reached from anywhere, without an edge.
    """

    first_step: int
    way: Indices
    target: Indices
    first: Indices
    last: Indices
    offset: Indices
    size: int
    edge_from: Indices
    edge_to: Indices
    arrival_offset: Indices
    arrival: NDArray[np.int32]
    reach: int


def network_of(
    ways: Ways, rows: Indices, least_steps: Indices, limits: Array, longest_s: float
) -> Network:
    """rows: of one pass's ways.  least_steps: (targets,), the shortest look.

    limits: as of `limit_table`.  longest_s: no slew needs longer.  Slew times suffice.
    """
    start = int(ways.first_step[rows].min())
    first = ways.first_step[rows] - start
    last = first + ways.steps[rows] - 1
    target, offset = ways.target[rows], np.cumsum(ways.steps[rows]) - ways.steps[rows]
    reach = int(np.ceil(longest_s / ways.step_s))
    usable_to = last - least_steps[target]
    near = (first[None, :] < last[:, None] + reach) & (
        usable_to[None, :] > first[:, None] + least_steps[target][:, None]
    )
    near &= target[None, :] != target[:, None]
    edge_source, edge_to = np.nonzero(near)
    counts = ways.steps[rows][edge_source]
    network = Network(
        first_step=start,
        way=rows,
        target=target,
        first=first,
        last=last,
        offset=offset,
        size=int(ways.steps[rows].sum()),
        edge_from=np.searchsorted(edge_source, np.arange(len(rows) + 1)).astype(np.intp),
        edge_to=edge_to.astype(np.intp),
        arrival_offset=np.cumsum(counts) - counts,
        arrival=np.empty(int(counts.sum()), np.int32),
        reach=reach,
    )
    states = _states(ways, rows)
    _fill(
        states,
        _shape(network),
        usable_to,
        ways.step_s,
        limits,
        SUFFICIENT,
        reach,
        network.arrival,
        network.arrival,
    )
    return network


def relax(network: Network, ways: Ways, least_steps: Indices, limits: Array) -> Network:
    """The same, every arrival as early as no motion can beat: for a bound."""
    arrival = np.empty_like(network.arrival)
    _fill(
        _states(ways, network.way),
        _shape(network),
        network.last - least_steps[network.target],
        ways.step_s,
        limits,
        NECESSARY,
        network.reach,
        network.arrival,
        arrival,
    )
    return replace(network, arrival=arrival)


def _states(ways: Ways, rows: Indices) -> Array:
    begin = int(ways.offset[rows[0]])
    return ways.state[begin : int(ways.offset[rows[-1]] + ways.steps[rows[-1]])]


def _shape(network: Network) -> Shape:
    return (
        network.first,
        network.last,
        network.offset,
        network.edge_from,
        network.edge_to,
        network.arrival_offset,
    )


@compiled
def _fill(
    state: Array,
    shape: Shape,
    usable_to: Indices,
    step_s: float,
    limits: Array,
    sign: float,
    reach: int,
    known: NDArray[np.int32],
    arrival: NDArray[np.int32],
) -> None:
    """Arrivals of every edge, from the last departure to the first.

    Who leaves earlier arrives no later: the way can be followed until the later departure.
    known: arrivals to begin with, where sign is NECESSARY.
    """
    first, last, offset, edge_from, edge_to, arrival_offset = shape
    for source in range(len(first)):
        for edge in range(edge_from[source], edge_from[source + 1]):
            to, base = edge_to[edge], arrival_offset[edge]
            latest = NEVER
            for leave in range(last[source], first[source] - 1, -1):
                place = base + leave - first[source]
                if sign < 0.0 and known[place] != NEVER:
                    latest = known[place] if latest == NEVER else min(latest, known[place])
                here = state[offset[source] + leave - first[source]]
                if first[to] >= leave + reach:
                    latest = first[to]
                else:
                    latest = _first_arrival(
                        here, state, offset[to], first[to], usable_to[to], leave, latest,
                        step_s, limits, sign,
                    )  # fmt: skip
                arrival[place] = latest


@compiled
def _first_arrival(
    here: Array,
    state: Array,
    offset: int,
    first: int,
    usable_to: int,
    leave: int,
    latest: int,
    step_s: float,
    limits: Array,
    sign: float,
) -> int:
    """Down from the latest arrival known, as long as the slew still fits."""
    found = latest
    step = usable_to if latest == NEVER else latest - 1
    while step >= first and step > leave:
        there = state[offset + step - first]
        if slew_time_s(here, there, limits, sign) > (step - leave) * step_s + 1e-9:
            break
        found = step
        step -= 1
    return found
