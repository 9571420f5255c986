"""Reachability between the track branches of a pass, by start and arrival step."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from planner.base.arrays import Array, Indices, Mask
from planner.base.compiled import compiled, lean
from planner.planning.campaigns.platforms.slew_fits import (
    NECESSARY,
    SUFFICIENT,
    FollowerLimits,
    slew_fits,
)
from planner.planning.campaigns.ways import Ways

NEVER = -1
NO_COST: Array = np.zeros(0)


class Network(NamedTuple):
    """One pass as a graph; ways (w,) by their first step, steps counted from the pass's first.

    way: row in `Ways`.  target: row of the request's.  first, last: steps at which it can be
    followed.  offset: of its steps among all, `size` in all.  stop_step: after all of them.
    edge_from (w + 1,): the edges that leave way i are edge_from[i] to edge_from[i + 1].
    edge_to: where they lead; arrival: for every step of every way, and each of its edges, the
    first step at which that one's way can be followed then, by its place among all; NEVER.
    arrival_offset: of a way's first step in it.
    reach: after so many steps any way can be reached from anywhere, without an edge.
    enters: of each way, the first step at which who rests until the start can follow it, by its
    place among all; NEVER.  ends: whether who has looked until then is at rest by the stop, at each
    step of every way.
    begins: whether a look may begin at each step of every way.
    scanned: whether a way is a scan's: who has scanned leaves it at once.
    cost: of a platform that looks from the pass's first step to each, up to stop_step; empty where
    looks cost nothing.
    """

    first_step: int
    way: Indices
    target: Indices
    first: Indices
    last: Indices
    offset: Indices
    size: int
    quality_sum: Array
    stop_step: int
    edge_from: Indices
    edge_to: Indices
    arrival_offset: Indices
    arrival: NDArray[np.int32]
    reach: int
    enters: Indices
    ends: Mask
    begins: Mask
    scanned: Mask
    cost: Array = NO_COST


class Rests(NamedTuple):
    """Where a platform rests until step 0 of the grid and from stop_s after it on, at the latest.

    start_state, stop_state: (s,), as of `Ways.states`.
    """

    start_state: Array
    stop_state: Array
    stop_s: float


class Slewing(NamedTuple):
    """Slews of a platform: its limits, where it rests, and how long a slew takes at most."""

    limits: FollowerLimits
    rests: Rests
    longest_s: float


def network_of(ways: Ways, rows: Indices, least_steps: Indices, slewing: Slewing) -> Network:
    """rows: of one pass's ways.  least_steps: (targets,), the shortest look.

    Slew times suffice.
    """
    start = int(ways.first_step[rows].min())
    first = ways.first_step[rows] - start
    network = edges_between(
        first_step=start,
        way=rows,
        target=ways.target[rows],
        first=first,
        last=first + ways.steps[rows] - 1,
        least=least_steps[ways.target[rows]],
        quality_sum=_quality_sum(ways, rows),
        reach=int(np.ceil(slewing.longest_s / ways.step_s)),
        scanned=ways.scanned[rows],
    )
    _fill_arrivals(ways, network, least_steps, slewing, SUFFICIENT)
    return network


def edges_between(
    *,
    first_step: int,
    way: Indices,
    target: Indices,
    first: Indices,
    last: Indices,
    least: Indices,
    quality_sum: Array,
    reach: int,
    scanned: Mask,
) -> Network:
    """As `Network`, its edges to all ways that can be of use soon, and no arrivals filled in yet.

    least: of each way the steps of its shortest look.
    """
    steps, usable_to = last - first + 1, last - least
    near = (first[None, :] < last[:, None] + reach) & (
        usable_to[None, :] > first[:, None] + least[:, None]
    )
    near &= target[None, :] != target[:, None]
    # Contiguous whatever their number: compiled code knows the two layouts as two types.
    edge_source, edge_to = map(np.ascontiguousarray, np.nonzero(near))
    edge_from = np.searchsorted(edge_source, np.arange(len(way) + 1))
    counts = steps * np.diff(edge_from)
    return Network(
        first_step=first_step,
        way=way,
        target=target,
        first=first,
        last=last,
        offset=np.cumsum(steps) - steps,
        size=int(steps.sum()),
        quality_sum=quality_sum,
        stop_step=int(last.max()) + 1,
        edge_from=edge_from,
        edge_to=edge_to,
        arrival_offset=np.cumsum(counts) - counts,
        arrival=np.empty(int(counts.sum()), np.int32),
        reach=reach,
        enters=np.cumsum(steps) - steps,
        ends=np.ones(int(steps.sum()), np.bool_),
        begins=np.ones(int(steps.sum()), np.bool_),
        scanned=np.ascontiguousarray(scanned),
    )


def relax(network: Network, ways: Ways, least_steps: Indices, slewing: Slewing) -> Network:
    """The same, every arrival as early as no motion can beat: for a bound."""
    relaxed = network._replace(
        arrival=network.arrival.copy(), enters=network.enters.copy(), ends=network.ends.copy()
    )
    _fill_arrivals(ways, relaxed, least_steps, slewing, NECESSARY)
    return relaxed


class Cut(NamedTuple):
    """No look on a way begins from cell `begin` to `end` after another way.

    before: that way, None of the first look.
    """

    before: int | None
    way: int
    begin: int
    end: int


def without_look(network: Network, cut: Cut) -> Network:
    """The same with a cut; where no edge leads from its way before, after none."""
    before, way, begin, end = cut
    if before is not None:
        edges = slice(network.edge_from[before], network.edge_from[before + 1])
        leads_there = network.edge_to[edges] == way
        rows = int(network.last[before] - network.first[before]) + 1
        first = network.arrival_offset[before]
        arrival = network.arrival.copy()
        arrivals = arrival[first : first + rows * len(leads_there)].reshape(rows, -1)
        is_early = (arrivals != NEVER) & (arrivals <= end) & leads_there
        if is_early.any():
            last = network.offset[way] + network.last[way] - network.first[way]
            arrivals[is_early] = NEVER if end >= last else end + 1
            return network._replace(arrival=arrival)
    begins = network.begins.copy()
    begins[begin : end + 1] = False
    return network._replace(begins=begins)


def _quality_sum(ways: Ways, rows: Indices) -> Array:
    """Means of neighbouring steps added up."""
    offset = np.cumsum(ways.steps[rows]) - ways.steps[rows]
    begin = int(ways.offset[rows[0]])
    quality = ways.quality[begin : int(ways.offset[rows[-1]] + ways.steps[rows[-1]])]
    between = np.append(0.0, 0.5 * (quality[1:] + quality[:-1]))
    between[offset] = 0.0
    total = np.cumsum(between)
    return np.asarray(total - np.repeat(total[offset], ways.steps[rows]))


def _fill_arrivals(
    ways: Ways,
    network: Network,
    least_steps: Indices,
    slewing: Slewing,
    sign: float,
) -> None:
    """Arrivals, enters and ends; those that the network has begin with, where sign is NECESSARY."""
    rows = network.way
    part = slice(int(ways.offset[rows[0]]), int(ways.offset[rows[-1]] + ways.steps[rows[-1]]))
    states = ways.states[part], ways.begin_states[part]
    least = np.where(network.scanned, least_steps[network.target], 0)
    usable_to = network.last - least_steps[network.target]
    limits, rests, _ = slewing
    spare_s = ways.spare_s[rows] if len(ways.spare_s) else np.zeros((len(rows), 2))
    _fill(states, network, least, usable_to, spare_s, ways.step_s, limits, sign)
    _fill_rests(states, network, least, usable_to, spare_s, ways.step_s, limits, rests, sign)


@compiled
def _fill_rests(
    states: tuple[Array, Array],
    network: Network,
    least: Indices,
    usable_to: Indices,
    spare_s: Array,
    step_s: float,
    limits: FollowerLimits,
    rests: Rests,
    sign: float,
) -> None:
    """As `_fill`, of the first slew of all and of the last."""
    first, last, offset, begun = network.first, network.last, network.offset, -network.first_step
    for way in range(len(first)):
        latest = NEVER
        if sign < 0.0 and network.enters[way] != NEVER:
            latest = network.enters[way] - offset[way] + first[way]
        if first[way] >= begun + network.reach:
            latest = first[way]
        else:
            latest = _first_arrival(
                rests.start_state, states[1], offset[way], first[way],
                min(usable_to[way], begun + network.reach), begun, latest, spare_s[way, 1], step_s,
                limits, sign, network.scanned[way],
            )  # fmt: skip
        network.enters[way] = NEVER if latest == NEVER else offset[way] + latest - first[way]
        is_back = False
        for leave in range(last[way], first[way] - 1, -1):
            cell = offset[way] + leave - first[way]
            left_s = rests.stop_s - (leave - begun) * step_s + spare_s[way, 0] + 1e-9
            known = sign < 0.0 and network.ends[cell]
            is_back = known or (is_back and not network.scanned[way])
            if not is_back and leave - first[way] >= least[way] and left_s > 0.0:
                is_back = left_s >= network.reach * step_s or slew_fits(
                    states[0][cell], rests.stop_state, limits, sign, left_s
                )
            network.ends[cell] = is_back


@compiled
def _fill(
    states: tuple[Array, Array],
    network: Network,
    least: Indices,
    usable_to: Indices,
    spare_s: Array,
    step_s: float,
    limits: FollowerLimits,
    sign: float,
) -> None:
    """Arrivals of every edge, from the last departure to the first.

    Who leaves earlier arrives no later: the way can be followed until the later departure, unless
    it is a scan's.
    states: in which looks end, and in which they begin.  least: (w,), steps of a way before anybody
    leaves it.
    """
    first, last, offset, arrival = network.first, network.last, network.offset, network.arrival
    for source in range(len(first)):
        begin, end = network.edge_from[source], network.edge_from[source + 1]
        for edge in range(begin, end):
            to = network.edge_to[edge]
            latest = NEVER
            for leave in range(last[source], first[source] - 1, -1):
                steps = leave - first[source]
                place = network.arrival_offset[source] + steps * (end - begin) + edge - begin
                if steps < least[source]:
                    arrival[place] = NEVER
                    continue
                if network.scanned[source]:
                    latest = NEVER
                if sign < 0.0 and arrival[place] != NEVER:
                    known_step = arrival[place] - offset[to] + first[to]
                    latest = known_step if latest == NEVER else min(latest, known_step)
                if first[to] >= leave + network.reach:
                    latest = first[to]
                else:
                    latest = _first_arrival(
                        states[0][offset[source] + steps], states[1], offset[to], first[to],
                        min(usable_to[to], leave + network.reach), leave, latest,
                        spare_s[source, 0] + spare_s[to, 1], step_s, limits, sign,
                        network.scanned[to],
                    )  # fmt: skip
                arrival[place] = NEVER if latest == NEVER else offset[to] + latest - first[to]


@lean
def _first_arrival(
    state: Array,
    states: Array,
    offset: int,
    first: int,
    usable_to: int,
    leave: int,
    latest: int,
    spare_s: float,
    step_s: float,
    limits: FollowerLimits,
    sign: float,
    is_scan: bool,
) -> int:
    """Down from the latest arrival known, as long as the slew still fits; onto a scan, which isn't
    followed from one begin to the next, up to where nothing proves that it doesn't."""
    found = latest
    if is_scan and sign < 0.0:
        for at in range(max(first, leave + 1), (usable_to if latest == NEVER else latest - 1) + 1):
            if slew_fits(
                state, states[offset + at - first], limits, sign,
                (at - leave) * step_s + spare_s + 1e-9,
            ):  # fmt: skip
                return at
        return latest
    step = usable_to if latest == NEVER else latest - 1
    while step >= first and step > leave:
        there = states[offset + step - first]
        if not slew_fits(state, there, limits, sign, (step - leave) * step_s + spare_s + 1e-9):
            break
        found = step
        step -= 1
    return found
