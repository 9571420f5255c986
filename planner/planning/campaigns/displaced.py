"""Chosen observations that displace a target which got none."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from planner.base.arrays import Array, Indices
from planner.base.compiled import compiled
from planner.planning.campaigns.network import NEVER, Network
from planner.planning.campaigns.path import Look, Worth, look_worth


@dataclass(frozen=True, kw_only=True)
class Displaced:
    """The look a target (row of the request's) lost least by, had the others stayed as they are.

    value: of it.  pass_number: of the networks.  way, first_step, length: as in `Look`.
    by: the looks of that pass which can't be flown beside it.
    """

    target: int
    value: float
    pass_number: int
    way: int
    first_step: int
    length: int
    by: tuple[Look, ...]


def displaced_by(
    networks: Sequence[Network],
    passes: Sequence[Sequence[Look]],
    worth_in: Callable[[int], Worth],
    left_out: Indices,
) -> tuple[Displaced, ...]:
    """The look at each target left out whose worth best makes up for those it would displace.

    passes: the looks chosen, one sequence per network.  worth_in: of looks in one of these by its
    number.  left_out: rows of the request's targets.
    """
    best: dict[int, tuple[float, Displaced]] = {}
    wanted = set(left_out.tolist())
    for number, (network, looks) in enumerate(zip(networks, passes, strict=True)):
        worth = worth_in(number)
        places = _places(network, looks, worth)
        for way in np.flatnonzero(np.isin(network.target, list(wanted))).tolist():
            target = int(network.target[way])
            gain, cell, length = _best_exchange(network, way, worth, places)
            if length == NEVER or (target in best and gain <= best[target][0]):
                continue
            start = cell - int(worth.steps[target, length])
            blocked = _blocked(network, way, start, cell, places)
            step = network.first_step + int(network.first[way]) + start - int(network.offset[way])
            step += worth.settle_steps
            found = Displaced(
                target=target,
                value=look_worth(network, worth, cell, target, length),
                pass_number=number,
                way=int(network.way[way]),
                first_step=step,
                length=length,
                by=tuple(look for look, is_in_way in zip(looks, blocked, strict=True) if is_in_way),
            )
            best[target] = gain, found
    return tuple(best[target][1] for target in sorted(best))


class _Places(NamedTuple):
    """Looks of one pass: the way, the cells it begins and ends at, and its value, (looks,)."""

    way: Indices
    start: Indices
    stop: Indices
    value: Array


def _places(network: Network, looks: Sequence[Look], worth: Worth) -> _Places:
    row = {way: n for n, way in enumerate(network.way.tolist())}
    way = np.array([row[look.way] for look in looks], np.intp)
    first = np.array([look.first_step for look in looks], np.intp) - network.first_step
    start = network.offset[way] + first - network.first[way] - worth.settle_steps
    takes = np.array([worth.steps[look.target, look.length] for look in looks], np.intp)
    return _Places(way, start, start + takes, np.array([look.value for look in looks]))


@compiled
def _best_exchange(
    network: Network, way: int, worth: Worth, places: _Places
) -> tuple[float, int, int]:
    """The gain, the cell it ends at and the length of the best look by a way; length NEVER."""
    target, lengths = network.target[way], worth.value.shape[1]
    best, best_cell, best_length = -np.inf, NEVER, NEVER
    begin = network.offset[way]
    for steps in range(network.last[way] - network.first[way] + 1):
        cell = begin + steps
        for length in range(lengths):
            takes = worth.steps[target, length]
            if takes == 0 or takes > steps:
                continue
            if not network.ends[cell] or not NEVER < network.enters[way] <= cell - takes:
                continue
            gain = look_worth(network, worth, cell, target, length)
            if gain <= best:
                continue
            blocked = _blocked(network, way, cell - takes, cell, places)
            for n in range(len(blocked)):
                if blocked[n]:
                    gain -= places.value[n]
            if gain > best:
                best, best_cell, best_length = gain, cell, length
    return best, best_cell, best_length


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


@compiled
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
