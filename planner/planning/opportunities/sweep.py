"""The search for windows, compiled, target by target.

By elevation no window of a place at rest is missed: rows are leapt over while the Earth's central
angle can't shrink enough, and between two rows the height above the cone of least elevation bends
by no more than a bound, so that it is known whether they hide an edge.  All other margins are
looked at on nodes; a turning point between nodes that could hide a change of sign is searched for,
and every change of sign is bracketed and found.
"""

import math
from typing import NamedTuple

import numpy as np

from planner.base.arrays import Array, Indices, Mask
from planner.base.compiled import compiled, inlined, lean, nested
from planner.base.vectors import (
    TURN_RAD,
    Vector,
    dot,
    motion_at,
    norm,
    plus,
    scaled,
    vector_of,
    wrapped,
)
from planner.motion.pointing.reach import axes_at, braking, off_masks, off_stops, pair_at
from planner.planning.opportunities.looks import (
    CarrierTables,
    Places,
    place_at,
    platform_los,
    sight_at,
)
from planner.planning.opportunities.margins import (
    ELEVATION,
    INTERVAL,
    MASK,
    REACH,
    SUN,
    WindowScene,
    margin,
)


class SweepOptions(NamedTuple):
    """How closely the carrier's motion is looked at."""

    edge_s: float = 1e-6  # a microsecond, the resolution of a time in a request
    shortest_s: float = 1e-3  # the resolution promised of an edge
    plumb_rad: float = 0.0034  # geodetic against geocentric vertical: 0.1924 deg at most
    nearest_m: float = 1e5  # which the range is taken to be at least
    leaps: int = 2000  # bins of the cosine, for how many rows can be leapt over
    sun_step_s: float = 600.0  # 2.5 deg of the Earth's turn
    turn_rad: float = math.radians(10.0)  # between nodes; a keep-out or stop is met at its own pace
    mask_turn_rad: float = math.radians(2.0)  # before they are looked at again
    mask_finest_rad: float = math.radians(0.05)  # a look through a gap so narrow may be missed
    bent_ratio: float = (
        1.5  # times the angle between two lines of sight: more than any turns on its way
    )
    cells_min: int = 3  # in which a span is looked through, at least
    slowest_rad_s: float = 1e-6  # what stands still is taken to turn so, as it is divided by
    # of a turning point beyond its node, in steps of the two cells on either side
    overshoot_ratio: float = 2.0
    rate_s: float = 0.05  # either side, for a rate
    turning_s: float = 1e-3  # an excursion this much shorter than a command step is none
    plain_share: float = 0.4  # of a limit: below that no window is looked at more closely
    plain_node_rad: float = math.radians(20.0)  # a turn of the line of sight: rates hold to 3 %
    plain_turn_rad: float = 1.0  # of an axis from node to node: its peak rate is 1.6 times the mean
    plain_stop_rad: float = 0.1  # beside the braking distance


OPTIONS = SweepOptions()


class LeapRows(NamedTuple):
    """What tells how many of the orbit's rows can be leapt over.

    sat_states: on its rows, (m, 7): position, m, its rate in ITRF, m/s, and 1 / the distance from
    the geocentre.  leaps_rows: in which the carrier passes an angle, by the cosine of that from -1
    on, bin by bin.
    """

    sat_states: Array
    leaps_rows: Array


Cone = tuple[Vector, Vector, float]
"""A place's position and vertical, and the sine of its least elevation."""


class Found(NamedTuple):
    """Windows by target and time: edges (n, 2), what opened and closed them, and whether a session
    can hold all of it, far from every limit.  looks: how many that took."""

    target: Indices
    edge_s: Array
    cause: Indices
    is_plain: Mask
    looks: int


@inlined
def _above_cone(r_sat: Vector, v: Vector, place: Cone) -> Vector:
    """Height above the cone of least elevation, m along the vertical, its rate, and the range."""
    r, up, sine = place
    apart = plus(r_sat, -1.0, r)
    range_m = norm(apart)
    return (
        dot(apart, up) - sine * range_m,
        dot(v, up) - sine * dot(v, apart) / range_m,
        range_m,
    )


@inlined
def _above(c: CarrierTables, place: Cone, t_s: float) -> Vector:
    r_sat, v = motion_at(c.orbit, c.step_s, t_s)
    return _above_cone(r_sat, v, place)


@inlined
def _above_at_row(rows: LeapRows, place: Cone, row: int) -> Vector:
    """The same where the orbit has a row, which needs no polynomial."""
    states = rows.sat_states
    return _above_cone(vector_of(states, row, 0), vector_of(states, row, 3), place)


@lean
def _edge_by_elevation(
    c: CarrierTables, place: Cone, bend_m_s2: float, begin: Vector, end: Vector
) -> tuple[float, int]:
    """When the height is nought between states of time, height and rate; and looks.

    By Hermite's cubic, then Newton's steps in the bracket, until one is known to leave less than
    half of `edge_s`; a halving of the bracket says nothing of that.
    """
    (a, value_a, rate_a), (b, value_b, rate_b) = begin, end
    h, change = b - a, value_b - value_a
    bent = 3.0 * change - (2.0 * rate_a + rate_b) * h
    twisted = (rate_a + rate_b) * h - 2.0 * change
    u = -value_a / change
    for _ in range(3):
        value = value_a + u * (rate_a * h + u * (bent + u * twisted))
        u -= value / (rate_a * h + u * (2.0 * bent + 3.0 * u * twisted))
    t = a + u * h if 0.0 < u < 1.0 else a - value_a / change * h
    looks = 0
    while looks < 60:
        looks += 1
        f, rate, _range = _above(c, place, t)
        if (f > 0.0) == (value_b > 0.0):
            b = t
        else:
            a = t
        off = -f / rate
        if bend_m_s2 * off * off < OPTIONS.edge_s * abs(rate) or abs(off) < OPTIONS.edge_s:
            return min(max(t + off, a), b), looks
        t = t + off if a < t + off < b else 0.5 * (a + b)
    return t, looks


@lean
def _edges_in_cell(
    c: CarrierTables, place: Cone, bend_m_s2: float, todo_states: Array, edges_s: Array
) -> tuple[int, int]:
    """Where the elevation is the least one between two instants, in order, into edges_s; how many,
    and how many looks that took.

    todo_states: rows of time, height above the cone and its rate; first the cell's end, then its
    begin. With `bend_m_s2` the bound of the second derivative, ends of a cell of h s of one sign
    hide nothing if they are bend_m_s2 h^2 / 8 away; of two signs they enclose one edge if a rate
    there exceeds bend_m_s2 h.  Otherwise the cell is halved.
    """
    t1, f1, g1 = todo_states[1, 0], todo_states[1, 1], todo_states[1, 2]
    count, looks, deep = 0, 0, 1
    while deep:
        t2, f2, g2 = todo_states[deep - 1, 0], todo_states[deep - 1, 1], todo_states[deep - 1, 2]
        h = t2 - t1
        same = (f1 > 0.0) == (f2 > 0.0)
        clear = max(abs(g1), abs(g2)) > bend_m_s2 * h
        if same:
            clear = min(abs(f1), abs(f2)) > 0.125 * bend_m_s2 * h * h
        if not clear and h > OPTIONS.shortest_s and deep < len(todo_states):
            middle = 0.5 * (t1 + t2)
            looks += 1
            todo_states[deep, 0] = middle
            todo_states[deep, 1], todo_states[deep, 2], _range = _above(c, place, middle)
            deep += 1
            continue
        if not same and count < len(edges_s):
            begin, end = (t1, f1, g1), (t2, f2, g2)
            edges_s[count], looked = _edge_by_elevation(c, place, bend_m_s2, begin, end)
            looks += looked
            count += 1
        t1, f1, g1 = t2, f2, g2
        deep -= 1
    return count, looks


@nested
def _spans_by_elevation(
    c: CarrierTables, rows: LeapRows, resting_parameters: Array, n: int
) -> tuple[Array, int]:
    """Where a place at rest sees the carrier high enough, (k, 2), and how many looks that took."""
    r, up, least = (
        vector_of(resting_parameters, n, 0),
        vector_of(resting_parameters, n, 3),
        resting_parameters[n, 6],
    )
    sine, radius = math.sin(least), norm(r)
    toward = scaled(1.0 / radius, r)
    below = least - OPTIONS.plumb_rad
    central = math.acos(min(radius * math.cos(below) / c.farthest_m, 1.0)) - below
    offset = central / (c.step_s * c.passing_rad_s)
    edges_s, todo_states, found_s = np.empty(16), np.empty((64, 3)), np.empty(64)
    count, looks, cell, known = 0, 0, 0, False
    place = r, up, sine
    f1, g1, far1 = _above_at_row(rows, place, 0)
    if f1 > 0.0:
        edges_s[0], count = 0.0, 1
    while cell < len(c.orbit):
        along = dot(vector_of(rows.sat_states, cell, 0), toward) * rows.sat_states[cell, 6]
        leap = int(rows.leaps_rows[int((along + 1.0) * OPTIONS.leaps)] - offset)
        if leap > 0:
            cell += leap
            known = False
            continue
        if not known:
            f1, g1, far1 = _above_at_row(rows, place, cell)
        end_s = min((cell + 1) * c.step_s, c.span_s)
        f2, g2, far2 = _above_at_row(rows, place, cell + 1)
        nearest = max(min(far1, far2) - 0.5 * c.speed_m_s * c.step_s, OPTIONS.nearest_m)
        bend_m_s2 = (1.0 + sine) * c.acceleration_m_s2 + sine * c.speed_m_s**2 / nearest
        looks += 1
        bent_m = 0.125 * bend_m_s2 * c.step_s**2
        if (f1 > 0.0) != (f2 > 0.0) or min(abs(f1), abs(f2)) <= bent_m:
            todo_states[0, 0], todo_states[0, 1], todo_states[0, 2] = end_s, f2, g2
            todo_states[1, 0], todo_states[1, 1], todo_states[1, 2] = cell * c.step_s, f1, g1
            more, looked = _edges_in_cell(c, place, bend_m_s2, todo_states, found_s)
            looks += looked
            if count + more >= len(edges_s):
                edges_s = np.concatenate((edges_s, np.empty(len(edges_s) + more)))
            for k in range(more):
                edges_s[count + k] = found_s[k]
            count += more
        f1, g1, far1, known = f2, g2, far2, True
        cell += 1
    if count % 2:
        edges_s[count] = c.span_s
        count += 1
    return edges_s[:count].copy().reshape(-1, 2), looks


@lean
def root_of(
    s: WindowScene,
    kind: int,
    n: int,
    low_state: tuple[float, float],
    high_state: tuple[float, float],
    tolerance_s: float,
    rate_s: float,
) -> float:
    """Of a margin or its rate, as `margin` has it, between states (t, value).

    Source: Chandrupatla 1997, Adv. Eng. Software 28, 145.
    """
    (a, fa), (b, fb) = low_state, high_state
    share, k, fk = 0.5, a, fa
    for _ in range(80):
        x = a + share * (b - a)
        f = margin(s, kind, n, x, rate_s)
        if (f > 0.0) == (fa > 0.0):
            k, fk = a, fa
        else:
            k, b, fk, fb = b, a, fb, fa
        a, fa = x, f
        if abs(b - a) < tolerance_s or fa == 0.0:
            break
        xi, phi = (a - b) / (k - b), (fa - fb) / (fk - fb)
        share = 0.5
        if 1.0 - math.sqrt(1.0 - xi) < phi < math.sqrt(xi):
            share = fa / (fb - fa) * fk / (fb - fk)
            share += (k - a) / (b - a) * fa / (fk - fa) * fb / (fk - fb)
        least = 0.5 * tolerance_s / abs(b - a)
        share = min(max(share, least), 1.0 - least)
    return a if abs(fa) < abs(fb) else b


@lean
def turning_of(
    s: WindowScene,
    kind: int,
    n: int,
    sign: float,
    low_s: float,
    high_s: float,
) -> float:
    """Where sign times a margin is greatest, if it turns at most once: at an end where it doesn't.

    Within a millisecond of a smooth function's, within 50 ms of a kink.
    """
    rate, low = 0.0, 0.0
    for end in range(2):
        low, rate = rate, margin(s, kind, n, high_s if end else low_s, OPTIONS.rate_s)
        if end == 0 and sign * rate <= 0.0:
            return low_s
    if sign * rate >= 0.0:
        return high_s
    return root_of(s, kind, n, (low_s, low), (high_s, rate), OPTIONS.turning_s, OPTIONS.rate_s)


@nested
def nodes_over(
    c: CarrierTables,
    p: Places,
    n: int,
    start_s: float,
    stop_s: float,
    step_s: float,
    turn_rad: float,
) -> Array:
    """Nodes from start_s to stop_s, closest where the line of sight turns most.

    At most step_s apart, and turn_rad of the line of sight by the straight course at mid-span; they
    divide evenly the angle by which it turns on that course.
    """
    middle = 0.5 * (start_s + stop_s)
    nearest, turn = middle, OPTIONS.slowest_rad_s
    if not p.in_space:
        r_sat, v = motion_at(c.orbit, c.step_s, middle)
        apart = plus(r_sat, -1.0, place_at(p, n, middle))
        after = -dot(apart, v) / dot(v, v)
        nearest = middle + after
        turn = max(norm(v) / norm(plus(apart, after, v)), turn)
    first, last = math.atan(turn * (start_s - nearest)), math.atan(turn * (stop_s - nearest))
    wanted = max((stop_s - start_s) / step_s, (last - first) / turn_rad)
    cells = max(math.ceil(wanted), OPTIONS.cells_min)
    t_s = np.empty(cells + 1)
    for k in range(1, cells):
        t_s[k] = math.tan(first + k / cells * (last - first)) / turn + nearest
    t_s[0], t_s[cells] = start_s, stop_s
    return t_s


@nested
def _nodes_beside_masks(s: WindowScene, n: int, t_s: Array) -> Array:
    """The nodes, and more between those where a mask may be passed in a moment.

    How far off a mask is changes by no more than the line of sight turns.
    """
    nodes, count = np.empty(2 * len(t_s)), 1
    nodes[0] = t_s[0]
    todo = np.empty((64, 5))
    los = platform_los(s.c, s.p, n, t_s[0])
    off = abs(off_masks(s.g, los))
    for k in range(1, len(t_s)):
        deep = 1
        end = platform_los(s.c, s.p, n, t_s[k])
        todo[0, 0], todo[0, 1] = t_s[k], abs(off_masks(s.g, end))
        todo[0, 2], todo[0, 3], todo[0, 4] = end
        while deep:
            end = vector_of(todo, deep - 1, 2)
            chord = norm(plus(end, -1.0, los))
            turn = 2.0 * OPTIONS.bent_ratio * math.asin(min(0.5 * chord, 1.0))
            if (
                turn > OPTIONS.mask_finest_rad
                and off + todo[deep - 1, 1] < turn
                and deep < len(todo)
            ):
                middle = 0.5 * (nodes[count - 1] + todo[deep - 1, 0])
                half = platform_los(s.c, s.p, n, middle)
                todo[deep, 0], todo[deep, 1] = middle, abs(off_masks(s.g, half))
                todo[deep, 2], todo[deep, 3], todo[deep, 4] = half
                deep += 1
                continue
            if count == len(nodes):
                nodes = np.concatenate((nodes, np.empty_like(nodes)))
            nodes[count] = todo[deep - 1, 0]
            count += 1
            off, los = todo[deep - 1, 1], end
            deep -= 1
    return nodes[:count].copy()


@lean
def _hidden_turn(
    s: WindowScene, kind: int, n: int, t_s: Array, f: Array, k: int
) -> tuple[float, float]:
    """Where a margin turns beside a node and has the other sign, and the margin; NaN where not."""
    count = len(t_s)
    sign = -1.0 if f[k] > 0.0 else 1.0  # seek a minimum where positive, else a maximum
    low, high = max(k - 1, 0), min(k + 1, count - 1)
    if sign * (f[k] - f[low]) < 0.0 or sign * (f[k] - f[high]) < 0.0:
        return math.nan, 0.0
    nearby = 0.0
    for m in range(max(k - 2, 0), min(k + 2, count - 1)):
        nearby = max(nearby, abs(f[m + 1] - f[m]))
    if abs(f[k]) > OPTIONS.overshoot_ratio * nearby:
        return math.nan, 0.0
    at_s = turning_of(s, kind, n, sign, t_s[low], t_s[high])
    value = margin(s, kind, n, at_s, 0.0)
    return (at_s if sign * value > 0.0 else math.nan), value


@nested
def stretches(s: WindowScene, kind: int, n: int, t_s: Array) -> Array:
    """Where a margin holds on nodes, (k, 2).

    A stretch or gap is missed only where the margin turns twice between two nodes, or by far more
    than it changes from node to node.
    """
    f = np.empty(len(t_s))
    for k in range(len(t_s)):
        f[k] = margin(s, kind, n, t_s[k], 0.0)
    return stretches_by(s, kind, n, t_s, f)


@nested
def stretches_by(s: WindowScene, kind: int, n: int, t_s: Array, margin_by_node: Array) -> Array:
    """The same by the margin on the nodes."""
    count = len(t_s)
    edges_s, found = np.empty(4 * count + 2), 0
    if margin_by_node[0] > 0.0:
        edges_s[0], found = t_s[0], 1
    t1, f1 = t_s[0], margin_by_node[0]
    for k in range(count):
        extra_s, extra = _hidden_turn(s, kind, n, t_s, margin_by_node, k)
        for t2, f2 in (
            (extra_s if extra_s <= t_s[k] else math.nan, extra),
            (t_s[k], margin_by_node[k]),
            (extra_s if extra_s > t_s[k] else math.nan, extra),
        ):
            if t2 != t2:
                continue
            if (f2 > 0.0) != (f1 > 0.0):
                ends = (t1, f1), (t2, f2)
                edges_s[found] = root_of(s, kind, n, ends[0], ends[1], OPTIONS.edge_s, 0.0)
                found += 1
            t1, f1 = t2, f2
    if found % 2:
        edges_s[found] = t_s[count - 1]
        found += 1
    return edges_s[:found].copy().reshape(-1, 2)


@lean
def _ease_of_axis(
    limit: Vector, travel_rad: float, t_s: Array, off_middle_rad: Array, axis: int
) -> int:
    """2 where an axis stays far from the limits of its motion from node to node, and some number of
    turns holds all of it; 1 where it moves only so far that no stop is met between nodes; else 0.

    off_middle_rad: (n, 2), in [-pi, pi] from mid-travel.
    """
    rate_before, acceleration_before, turned_rad, ease = 0.0, 0.0, 0.0, 2
    for k in range(len(t_s) - 1):
        moved = off_middle_rad[k + 1, axis] - off_middle_rad[k, axis]
        change = wrapped(moved)
        if abs(change) > OPTIONS.plain_turn_rad or (travel_rad <= TURN_RAD and change != moved):
            return 0
        turned_rad += abs(change)
        step = max(t_s[k + 1] - t_s[k], 1e-3)
        rate = change / step
        if abs(rate) > OPTIONS.plain_share * limit[0]:
            ease = 1
        if k > 0:
            step_before = max(t_s[k] - t_s[k - 1], 1e-3)
            acceleration = (rate - rate_before) / max(step, step_before)
            longest = step_before if k == 1 else max(step_before, t_s[k - 1] - t_s[k - 2])
            jerk = 0.0 if k == 1 else (acceleration - acceleration_before) / longest
            if (
                abs(acceleration) > OPTIONS.plain_share * limit[1]
                or abs(jerk) > OPTIONS.plain_share * limit[2]
            ):
                ease = 1
            acceleration_before = acceleration
        rate_before = rate
    return 1 if travel_rad > TURN_RAD and turned_rad > travel_rad - TURN_RAD else ease


@nested
def _ease(s: WindowScene, n: int, t_s: Array) -> int:
    """2 where one pair of angles, looked at at t_s, follows a target far from all limits; 1 where
    one stays clear of the stops; else 0."""
    stop_rad = OPTIONS.plain_stop_rad + max(
        braking(OPTIONS.plain_share * s.g.limits[0][0], 0.0, s.g.limits[0]),
        braking(OPTIONS.plain_share * s.g.limits[1][0], 0.0, s.g.limits[1]),
    )
    off_middle_rad, best = np.empty((len(t_s), 2)), 0
    one, two = axes_at(s.g, platform_los(s.c, s.p, n, t_s[len(t_s) // 2]))
    better = 1.0 if off_stops(s.g, one) > off_stops(s.g, two) else -1.0
    for side in (better, -better):
        ease = 2
        for k in range(len(t_s)):
            pair = pair_at(s.g, sight_at(s.c, s.p, n, t_s[k]), side)
            for axis in range(2):
                off_rad = wrapped(pair[axis] - 0.5 * (s.g.low[axis] + s.g.high[axis]))
                off_middle_rad[k, axis] = off_rad
                if not 0.5 * (s.g.high[axis] - s.g.low[axis]) - abs(off_rad) >= stop_rad:
                    ease = 0
            if ease == 0:
                break
        for axis in range(2):
            if ease > 0:
                travel_rad = s.g.high[axis] - s.g.low[axis]
                axis_ease = _ease_of_axis(s.g.limits[axis], travel_rad, t_s, off_middle_rad, axis)
                ease = min(ease, axis_ease)
        best = max(best, ease)
        if best == 2:
            break
    return best


@nested
def found_of(row_parameters: Array, looks: int) -> Found:
    """row_parameters: target, start, stop, what opened and closed, whether plain, (n, 6) and up."""
    r = row_parameters
    cause = r[:, 3:5].astype(np.intp)
    return Found(r[:, 0].astype(np.intp), r[:, 1:3].copy(), cause, r[:, 5] > 0.0, looks)


@nested
def _nodes_for(s: WindowScene, kind: int, n: int, start_s: float, stop_s: float) -> Array:
    """Nodes at which a margin is looked at."""
    step_s, turn_rad = s.c.step_s, OPTIONS.turn_rad
    if kind == SUN:
        step_s, turn_rad = OPTIONS.sun_step_s, math.inf
    if kind == MASK:
        turn_rad = OPTIONS.mask_turn_rad
        step_s = min(step_s, OPTIONS.mask_turn_rad / s.c.turn_rad_s)
    t_s = nodes_over(s.c, s.p, n, start_s, stop_s, step_s, turn_rad)
    return _nodes_beside_masks(s, n, t_s) if kind == MASK else t_s


@nested
def _narrowed(s: WindowScene, kind: int, n: int, span_parameters: Array) -> tuple[Array, int]:
    """Where a condition holds, too, and looks; rows (k, 5) are as of `found_of`, but target."""
    left, count, looks = np.empty((2 * len(span_parameters) + 8, 5)), 0, 0
    for span in span_parameters:
        found, ease = span[:2].copy().reshape(1, 2), 0
        if kind == REACH:
            turn_rad = OPTIONS.plain_node_rad
            t_s = nodes_over(s.c, s.p, n, span[0], span[1], s.c.step_s, turn_rad)
            ease = _ease(s, n, t_s)
            looks += len(t_s)
        if ease == 0:
            t_s = _nodes_for(s, kind, n, span[0], span[1])
            found = stretches(s, kind, n, t_s)
            looks += len(t_s) + 12 * len(found)
        for m in range(len(found)):
            if count == len(left):
                left = np.concatenate((left, np.empty_like(left)))
            row, is_whole = left[count], True
            for end in range(2):
                row[end], row[2 + end] = found[m, end], span[2 + end]
                if found[m, end] != span[end]:
                    row[2 + end], is_whole = kind, False
            row[4] = 1.0 if ease == 2 else span[4] if is_whole else 0.0
            count += 1
    return left[:count].copy(), looks


@nested
def _of_target(s: WindowScene, rows: LeapRows, n: int) -> tuple[Array, int]:
    """Where all conditions hold, as `_narrowed` returns."""
    if s.p.step_s == 0.0:
        span_s, looks = _spans_by_elevation(s.c, rows, s.p.resting_parameters, n)
    else:
        t_s = np.linspace(0.0, s.c.span_s, len(s.c.orbit) + 1)
        span_s, looks = stretches(s, ELEVATION, n, t_s), len(t_s)
    spans = np.zeros((len(span_s), 5))
    spans[:, :2], spans[:, 2:4] = span_s, ELEVATION
    if len(spans) and spans[0, 0] <= 0.0:
        spans[0, 2] = INTERVAL
    if len(spans) and spans[-1, 1] >= s.c.span_s:
        spans[-1, 3] = INTERVAL
    for kind in s.q.kinds:
        spans, more = _narrowed(s, kind, n, spans)
        looks += more
    return spans, looks


@compiled
def sweep(s: WindowScene, rows: LeapRows, shortest_s: float, looks_limit: float) -> Found:
    """All windows, in order of target and time, until a bound of looks is reached."""
    found, count, looks = np.empty((64, 6)), 0, 0
    for n in range(len(s.p.resting_parameters)):
        if looks > looks_limit:
            break
        spans, more = _of_target(s, rows, n)
        looks += more
        for span in spans:
            if span[1] - span[0] >= shortest_s:
                if count == len(found):
                    found = np.concatenate((found, np.empty_like(found)))
                found[count, 0], found[count, 1:] = n, span
                count += 1
    return found_of(found[:count], looks)
