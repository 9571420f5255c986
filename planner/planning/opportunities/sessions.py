"""The longest part of each window that the axes can follow, for a session; compiled.

A window says when a target can be seen by some pair of angles.  A session holds it by one pair
throughout, within the limits of rate, acceleration and jerk, and meets a stop only as slowly as
its axis can be braked before it.
"""

import math
from typing import NamedTuple

import numpy as np

from planner.base.arrays import Array, Mask
from planner.base.compiled import compiled, nested
from planner.base.vectors import TURN_RAD, wrapped
from planner.motion.pointing.reach import Reach, axes_at
from planner.planning.opportunities.looks import platform_los
from planner.planning.opportunities.margins import (
    MASK,
    MOTION_0,
    OFF_MASK,
    OFF_PLANE,
    WindowScene,
    margin,
    motion_margins,
)
from planner.planning.opportunities.sweep import OPTIONS as SWEEP
from planner.planning.opportunities.sweep import (
    Found,
    nodes_over,
    stretches,
    stretches_by,
    turning_of,
)


class SessionOptions(NamedTuple):
    """Where it is looked for how far off a mask an axis can be braked."""

    mask_edge_s: float = 30.0  # from a window's edge
    mask_step_s: float = 0.5
    mask_looks: int = 200  # that takes
    scan_step_s: float = 1.0  # between looks at the motion along a line that is scanned


OPTIONS = SessionOptions()


@nested
def _with_keyholes(s: WindowScene, n: int, t_s: Array) -> Array:
    """The nodes, and when between them the line of sight comes nearest to the plane of the axes.

    There the axes are quickest, for a moment.
    """
    count = len(t_s)
    f, nodes, more = np.empty(count), np.empty(2 * count), 0
    for k in range(count):
        f[k] = margin(s, OFF_PLANE, n, t_s[k], 0.0)
    for k in range(count):
        low, high = max(k - 1, 0), min(k + 1, count - 1)
        at_s = math.nan
        if f[k] >= f[low] and f[k] >= f[high]:
            at_s = turning_of(s, OFF_PLANE, n, 1.0, t_s[low], t_s[high])
        if at_s <= t_s[k]:
            nodes[more] = at_s
            more += 1
        nodes[more] = t_s[k]
        more += 1
        if at_s > t_s[k]:
            nodes[more] = at_s
            more += 1
    return nodes[:more].copy()


@nested
def _is_on_turns(g: Reach, low_rad: Array, high_rad: Array) -> bool:
    """Whether some number of whole turns holds an axis's angles from low_rad to high_rad, (2,)
    each."""
    for axis in range(2):
        least = math.ceil((g.low[axis] - low_rad[axis]) / TURN_RAD)
        if least > math.floor((g.high[axis] - high_rad[axis]) / TURN_RAD):
            return False
    return True


@nested
def _unwound(
    s: WindowScene, n: int, branch: int, nodes_s: Array, a: float, b: float
) -> tuple[float, float]:
    """The longest part of a stretch, from node to node, that one number of turns holds."""
    inside = nodes_s[(nodes_s > a) & (nodes_s < b)]
    t_s = np.concatenate((np.array([a]), inside, np.array([b])))
    angle = np.empty((len(t_s), 2))
    for k in range(len(t_s)):
        pair = axes_at(s.g, platform_los(s.c, s.p, n, t_s[k]))[branch]
        for axis in range(2):
            angle[k, axis] = pair[axis]
            if k > 0:
                before = angle[k - 1, axis]
                angle[k, axis] = before + wrapped(pair[axis] - before)
    first, best_a, best_b, most = 0, 0, 0, 0
    for last in range(len(t_s)):
        while True:
            low, high = angle[last].copy(), angle[last].copy()
            for k in range(first, last):
                low, high = np.minimum(low, angle[k]), np.maximum(high, angle[k])
            if _is_on_turns(s.g, low, high) or first == last:
                break
            first += 1
        if last - first > most:
            best_a, best_b, most = first, last, last - first
    return t_s[best_a], t_s[best_b]


@nested
def _off_mask(s: WindowScene, n: int, edge_s: float, sign: float) -> float:
    """When a mask at an edge is far enough off to brake before it, or NaN; sign: 1 at a start."""
    count = int(OPTIONS.mask_edge_s / OPTIONS.mask_step_s)
    t_s = np.empty(count)
    for k in range(count):
        t_s[k] = edge_s + OPTIONS.mask_step_s * (k if sign > 0.0 else k + 1 - count)
    found = stretches(s, OFF_MASK, n, t_s)
    if len(found) == 0:
        return math.nan
    return float(found[0, 0] if sign > 0.0 else found[-1, 1])


@nested
def _longest(s: WindowScene, n: int, a: float, b: float) -> tuple[float, float, int]:
    """The longest stretch that either pair of angles holds from a to b, or NaN; and looks."""
    is_wide = s.g.high[0] - s.g.low[0] > TURN_RAD or s.g.high[1] - s.g.low[1] > TURN_RAD
    held_a, held_b, longest = math.nan, math.nan, -1.0
    t_s = nodes_over(s.c, s.p, n, a, b, s.c.step_s, SWEEP.turn_rad)
    t_s = _with_keyholes(s, n, t_s)
    f = np.empty((2, len(t_s)))
    for k in range(len(t_s)):
        f[0, k], f[1, k] = motion_margins(s, n, t_s[k])
    for branch in range(2):
        parts = stretches_by(s, MOTION_0 + branch, n, t_s, f[branch])
        for m in range(len(parts)):
            begins, ends = parts[m, 0], parts[m, 1]
            if is_wide:
                begins, ends = _unwound(s, n, branch, t_s, begins, ends)
            if ends - begins > longest:
                held_a, held_b, longest = begins, ends, ends - begins
        if longest >= b - a:
            break  # the other pair can't hold more
    return held_a, held_b, 10 * len(t_s)


@compiled
def hold(s: WindowScene, found: Found, looks_limit: float) -> tuple[Array, int]:
    """When a session holds the target in each window, (n, 2), NaN where no pair of angles can
    follow at all; and how many looks that took: none are sought once looks_limit is reached."""
    held, looks = found.edge_s.copy(), 0
    for w in range(len(held)):
        if found.is_plain[w]:
            continue
        a, b, more = math.nan, math.nan, 0
        if looks <= looks_limit:
            n, rise_s, set_s = found.target[w], found.edge_s[w, 0], found.edge_s[w, 1]
            a, b, more = _longest(s, n, rise_s, set_s)
            if found.cause[w, 0] == MASK and a == rise_s:
                a = _off_mask(s, n, a, 1.0)
                more += OPTIONS.mask_looks
            if found.cause[w, 1] == MASK and b == set_s:
                b = _off_mask(s, n, b, -1.0)
                more += OPTIONS.mask_looks
        if len(s.g.side_parameters) and not b > a:
            a, b = math.nan, math.nan
        held[w, 0], held[w, 1] = a, b
        looks += more
    return held, looks


@compiled
def hold_line(s: WindowScene, begins_s: Array, duration_s: float) -> Mask:
    """Of scans of a line that begin at n times, whether one pair of angles holds it from end to
    end, (n,)."""
    held = np.zeros(len(begins_s), np.bool_)
    cells = max(math.ceil(duration_s / OPTIONS.scan_step_s), 1)
    for n in range(len(begins_s)):
        t_s = begins_s[n] + np.linspace(0.0, duration_s, cells + 1)
        for branch in range(2):
            follows = True
            for k in range(cells + 1):
                follows = follows and margin(s, MOTION_0 + branch, n, t_s[k], 0.0) > 0.0
                if len(s.g.side_parameters):
                    follows = follows and margin(s, OFF_MASK, n, t_s[k], 0.0) > 0.0
            if follows:
                a, b = _unwound(s, n, branch, t_s, t_s[0], t_s[cells])
                follows = a == t_s[0] and b == t_s[cells]
            held[n] = held[n] or follows
    return held
