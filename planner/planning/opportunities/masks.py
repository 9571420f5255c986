"""Spans in which the line of sight runs clear of a platform's masks.

A mask may be a boom that the line of sight passes in a moment, and two may be close together, so
that turning points between nodes don't tell.  But how far off a mask is changes by no more than
the line of sight turns: only where it might have come that far is it looked at again.
"""

import math
from collections.abc import Callable

import numpy as np

from planner.base.arrays import Array, Indices
from planner.planning.opportunities.spans import Margin, Nodes
from planner.world.platforms import FieldMask

TURN_RAD = math.radians(2.0)  # between nodes, before they are looked at again
FINEST_RAD = math.radians(0.05)  # a look through a gap so narrow may be missed
BENT = 1.5  # times the angle between two lines of sight: more than any turns on its way

Direction = Callable[[Indices, Array], Array]


def clear_of(masks: tuple[FieldMask, ...], los_platform: Direction) -> Margin:
    """How far off the nearest mask's margin the line of sight runs."""

    def margin_rad(which: Indices, t_s: Array) -> Array:
        direction = los_platform(which, t_s)
        return np.asarray(-np.max([mask.depth_rad(direction) for mask in masks], axis=0))

    return margin_rad


def nodes_beside(nodes: Nodes, margin: Margin, los_platform: Direction) -> Nodes:
    """The nodes, and more between those where the margin may have another sign."""
    group, t_s = nodes.group, nodes.t_s
    direction = los_platform(nodes.target[group], t_s)
    off_rad = np.abs(margin(nodes.target[group], t_s))
    is_open = np.ones(len(t_s) - 1, dtype=bool)
    while True:
        chord = np.linalg.norm(np.diff(direction, axis=0), axis=1)
        turn_rad = 2.0 * BENT * np.arcsin(np.minimum(chord / 2.0, 1.0))
        is_open &= (group[1:] == group[:-1]) & (turn_rad > FINEST_RAD)
        is_open &= off_rad[1:] + off_rad[:-1] < turn_rad
        place = np.flatnonzero(is_open)
        if not place.size:
            return Nodes(nodes.target, group, t_s)
        middle_s = 0.5 * (t_s[place] + t_s[place + 1])
        target = nodes.target[group[place]]
        halves = np.repeat(is_open, 1 + is_open)
        group = np.insert(group, place + 1, group[place])
        t_s = np.insert(t_s, place + 1, middle_s)
        direction = np.insert(direction, place + 1, los_platform(target, middle_s), axis=0)
        off_rad = np.insert(off_rad, place + 1, np.abs(margin(target, middle_s)))
        is_open = halves
