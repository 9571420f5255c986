"""The spans of time over which a condition holds.

A condition is a margin, a function of time that is positive where the condition holds.
It is looked at on nodes; a turning point between nodes that could hide a change of sign is
searched for, and every change of sign is bracketed and found.  All targets go together.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from planner.base.arrays import Array, Indices
from planner.planning.opportunities.sights import Sight

Margin = Callable[[Indices, Array], Array]
"""Margins (n,) of targets (n,), by number, at t_s (n,)."""


@dataclass(frozen=True, kw_only=True)
class SpanOptions:
    """How finely the ends of a span are told."""

    edge_s: float = 1e-6  # a microsecond, the resolution of a time in a request
    # of a turning point beyond its node, in steps of the two cells on either side
    overshoot: float = 2.0
    turning_s: float = 1e-3  # an excursion this much shorter than a command step is none
    cells_min: int = 3  # in which a span is looked through, at least
    slowest_rad_s: float = 1e-6  # what stands still is taken to turn so, as it is divided by
    delta_s: float = 0.05  # either side, for the rate at an edge


OPTIONS = SpanOptions()


@dataclass(frozen=True, eq=False)
class Spans:
    """Times that meet the conditions so far, in order of target and time, each (m,).

    opened_by, closed_by: what made each edge, a `Cause`.
    """

    target: Indices
    start_s: Array
    stop_s: Array
    opened_by: NDArray[np.str_]
    closed_by: NDArray[np.str_]

    def select(self, rows: NDArray[np.bool_] | Indices) -> "Spans":
        """Select those at `rows`."""
        return Spans(*(column[rows] for column in vars(self).values()))


@dataclass(frozen=True, eq=False)
class Nodes:
    """Where a margin is looked at: group (n,) ascending, t_s (n,) ascending in each group.

    target: (groups,), the number of each group's target.
    """

    target: Indices
    group: Indices
    t_s: Array


@dataclass(frozen=True, eq=False)
class Stretches:
    """Where a margin holds, in order of group and time, each array of shape (m,).

    from_first, to_last: whether the stretch begins or ends with the group's nodes.
    """

    group: Indices
    start_s: Array
    stop_s: Array
    from_first: NDArray[np.bool_]
    to_last: NDArray[np.bool_]


def nodes_over(spans: Spans, sight: Sight, step_s: float, turn_rad: float) -> Nodes:
    """Nodes from start to stop of each span, closest where the line of sight turns most.

    At most step_s apart, and turn_rad of the line of sight by the straight course at
    mid-span; they divide evenly the angle by which it turns on that course.
    """
    middle_s = 0.5 * (spans.start_s + spans.stop_s)
    after_s, turn_rad_s = sight.nearest_passage(spans.target, middle_s)
    nearest_s, turn_rad_s = middle_s + after_s, np.maximum(turn_rad_s, OPTIONS.slowest_rad_s)
    from_rad = np.arctan(turn_rad_s * (spans.start_s - nearest_s))
    to_rad = np.arctan(turn_rad_s * (spans.stop_s - nearest_s))
    wanted = np.maximum((spans.stop_s - spans.start_s) / step_s, (to_rad - from_rad) / turn_rad)
    cells = np.maximum(np.ceil(wanted).astype(np.intp), OPTIONS.cells_min)
    group = np.repeat(np.arange(len(cells)), cells + 1)
    first = np.cumsum(cells + 1) - (cells + 1)
    share = (np.arange(len(group)) - first[group]) / cells[group]
    angle_rad = from_rad[group] + share * (to_rad - from_rad)[group]
    t_s = np.tan(angle_rad) / turn_rad_s[group] + nearest_s[group]
    t_s[first], t_s[first + cells] = spans.start_s, spans.stop_s
    return Nodes(spans.target, group, t_s)


def stretches(margin: Margin, nodes: Nodes) -> Stretches:
    """The stretches of each group over which the margin is positive.

    Edges are found to a microsecond.  A stretch or gap is missed only where the margin turns
    twice between two nodes, or by far more than it changes from node to node.
    """
    values = margin(nodes.target[nodes.group], nodes.t_s)
    nodes, values = _with_hidden_turns(margin, nodes, values)
    group, t_s, holds = nodes.group, nodes.t_s, values > 0.0
    same = group[1:] == group[:-1]
    first = np.append(True, ~same)
    last = np.append(~same, True)
    changes = np.flatnonzero(same & (holds[1:] != holds[:-1]))
    edge_s = _crossing_s(margin, nodes.target[group[changes]], t_s[changes], t_s[changes + 1])
    rises = holds[changes + 1]
    start_group = np.concatenate([group[first & holds], group[changes[rises]]])
    start_s = np.concatenate([t_s[first & holds], edge_s[rises]])
    stop_group = np.concatenate([group[last & holds], group[changes[~rises]]])
    stop_s = np.concatenate([t_s[last & holds], edge_s[~rises]])
    starts, stops = np.lexsort((start_s, start_group)), np.lexsort((stop_s, stop_group))
    return Stretches(
        group=start_group[starts],
        start_s=start_s[starts],
        stop_s=stop_s[stops],
        from_first=starts < np.count_nonzero(first & holds),
        to_last=stops < np.count_nonzero(last & holds),
    )


def turning_point(function: Margin, target: Indices, low_s: Array, high_s: Array) -> Array:
    """Where a function is greatest between low_s and high_s, (n,), if it turns at most once.

    At an end where it doesn't turn.  Within a millisecond of a smooth function's; within
    50 ms of a kink.
    """

    def slope_at(t_s: Array, which: Indices) -> Array:
        return function(which, t_s + OPTIONS.delta_s) - function(which, t_s - OPTIONS.delta_s)

    at_low, at_high = slope_at(low_s, target), slope_at(high_s, target)
    turns = (at_low > 0.0) & (at_high < 0.0)
    found_s = np.where(at_low <= 0.0, low_s, high_s)
    found_s[turns] = _root(slope_at, low_s[turns], high_s[turns], target[turns], OPTIONS.turning_s)
    return found_s


def _with_hidden_turns(margin: Margin, nodes: Nodes, node_margin: Array) -> tuple[Nodes, Array]:
    """The nodes and those turning points between them at which the margin has the other sign."""
    group, t_s = nodes.group, nodes.t_s
    same = group[1:] == group[:-1]
    before, after = np.append(False, same), np.append(same, False)
    sign = np.where(node_margin > 0.0, -1.0, 1.0)  # seek a minimum where positive, else a maximum
    above_left = np.where(before, sign * (node_margin - np.roll(node_margin, 1)), 0.0)
    above_right = np.where(after, sign * (node_margin - np.roll(node_margin, -1)), 0.0)
    step = np.pad(np.where(same, np.abs(np.diff(node_margin)), 0.0), 2)
    nearby = np.maximum.reduce([step[:-3], step[1:-2], step[2:-1], step[3:]])
    turns = np.flatnonzero(
        (above_left >= 0.0)
        & (above_right >= 0.0)
        & (np.abs(node_margin) <= OPTIONS.overshoot * nearby)
    )
    sought, target = sign[turns], nodes.target[group[turns]]
    low_s, high_s = t_s[turns - before[turns]], t_s[turns + after[turns]]

    def margin_towards(which: Indices, at_s: Array) -> Array:
        return np.asarray(sought[which] * margin(target[which], at_s))

    which = np.arange(len(turns))
    extra_s = turning_point(margin_towards, which, low_s, high_s)
    extra = margin(target, extra_s)
    crosses = sought * extra > 0.0
    place = turns[crosses] + (extra_s[crosses] > t_s[turns[crosses]])
    return (
        Nodes(
            nodes.target,
            np.insert(group, place, group[turns[crosses]]),
            np.insert(t_s, place, extra_s[crosses]),
        ),
        np.insert(node_margin, place, extra[crosses]),
    )


def _crossing_s(margin: Margin, target: Indices, low_s: Array, high_s: Array) -> Array:
    return _root(lambda t_s, which: margin(which, t_s), low_s, high_s, target, OPTIONS.edge_s)


def _root(
    function: Callable[[Array, Indices], Array],
    low_s: Array,
    high_s: Array,
    target: Indices,
    tolerance_s: float,
) -> Array:
    """Bracketed roots, (n,).  Source: Chandrupatla 1997, Adv. Eng. Software 28, 145."""
    if not len(low_s):
        return low_s
    from scipy.optimize import elementwise  # half a second, for searches only

    found = elementwise.find_root(
        function, (low_s, high_s), args=(target,), tolerances={"xatol": tolerance_s, "xrtol": 0.0}
    )
    return np.asarray(found.x)
