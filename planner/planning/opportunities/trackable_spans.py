"""Trackable spans: the longest part of each window that the axes can follow, for a session.

A window says when a target can be seen by some pair of angles.  A session holds it by one pair
throughout, within the limits of rate, acceleration and jerk, and meets a stop only as slowly as
its axis can be braked before it.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from planner.base import effort
from planner.base.arrays import Array, Indices
from planner.motion.pointing.angles import axis_angles, singular_margin_rad
from planner.motion.pointing.track import TURN_RAD, turns_within_stops
from planner.planning.opportunities.conditions import NEVER_RAD, TURN_MAX_RAD, reach_margin_rad
from planner.planning.opportunities.sights import Sight
from planner.planning.opportunities.spans import (
    Margin,
    Nodes,
    Spans,
    Stretches,
    nodes_over,
    stretches,
    turning_point,
)
from planner.world.platforms import AxisLimits, TwoAxisPlatform


@dataclass(frozen=True, kw_only=True)
class TrackableOptions:
    """How closely windows are looked at for tracks that keep the limits."""

    # between the five looks from which rates, accelerations and jerks are found
    delta_s: float = 0.4
    within: float = 0.995  # of each limit: plans test the motion between rows, too
    braked_s: float = 0.2  # of motion: braking in rows of a table takes that much longer at most
    # Of a limit, by motion from node to node: below that no window is looked at more closely.
    plain: float = 0.4
    # of motion beside the braking distance: ways around a mask are harder to find
    off_mask_s: float = 0.5
    mask_edge_s: float = 30.0  # from a window's edge: where it can be braked before a mask
    plain_turn_rad: float = 0.6  # of an axis from node to node
    plain_stop_rad: float = 0.1  # beside the braking distance


OPTIONS = TrackableOptions()

EDGES = ("reach", "mask")


def held_parts(
    platform: TwoAxisPlatform, sight: Sight, spans: Spans, look_rows: float
) -> tuple[Array, Array]:
    """When tracking begins and ends, (m,) each; NaN where no pair of angles can follow at all.

    look_rows: of `effort`, for one look at a target.
    """
    start_s, stop_s = spans.start_s.copy(), spans.stop_s.copy()
    doubtful = np.flatnonzero(~_is_plain(platform, sight, spans, look_rows))
    if doubtful.size:
        longest = _longest_stretch(platform, sight, spans.select(doubtful), look_rows)
        start_s[doubtful], stop_s[doubtful] = longest
    return start_s, stop_s


def _is_plain(
    platform: TwoAxisPlatform, sight: Sight, spans: Spans, look_rows: float
) -> NDArray[np.bool_]:
    """Windows (m,) that one pair of angles can follow from end to end, far from all limits."""
    nodes = _nodes_over(sight, spans)
    effort.charge(look_rows * len(nodes.t_s))
    both_rad = axis_angles(platform, _los_platform(sight, nodes)).angle_rad
    stop_rad = np.array(
        [
            _braking_rad(np.array(OPTIONS.plain * axis.rate_max_rad_s), np.zeros(()), axis)
            for axis in platform.axis_limits
        ]
    )
    near_stop = reach_margin_rad(platform, both_rad) < OPTIONS.plain_stop_rad + stop_rad.max()
    same = nodes.group[1:] == nodes.group[:-1]
    change_rad = np.where(same[:, None], _wrap_angle(np.diff(both_rad, axis=1)), 0.0)
    lively = (np.abs(change_rad) > OPTIONS.plain_turn_rad).any(axis=2)
    lively = np.pad(lively, ((0, 0), (0, 1)))
    step_s = np.maximum(np.where(same, np.diff(nodes.t_s), 1.0), 1e-3)
    motion = change_rad / step_s[:, None]
    for bound in _motion_bounds(platform):
        cells = motion.shape[1]
        lively[:, :cells] |= (np.abs(motion) > OPTIONS.plain * bound).any(axis=2)
        within = same[:cells][1:] & same[: cells - 1]
        motion = np.where(within[:, None], np.diff(motion, axis=1), 0.0)
        motion = motion / np.maximum(step_s[: cells - 1], step_s[1:cells])[:, None]
    plain = np.ones((2, len(spans.target)), np.bool_)
    for branch in range(2):
        plain[branch, nodes.group[near_stop[branch] | lively[branch]]] = False
        plain[branch] &= ~_may_wind_up(platform, nodes.group[1:], change_rad[branch], len(plain[0]))
    at_edge = np.isin(spans.opened_by, EDGES) | np.isin(spans.closed_by, EDGES)
    return np.asarray(plain.any(axis=0) & ~at_edge)


def _longest_stretch(
    platform: TwoAxisPlatform, sight: Sight, spans: Spans, look_rows: float
) -> tuple[Array, Array]:
    """The longest stretch over which either branch of `axis_angles` holds, (m,) each, or NaN."""
    nodes = _with_keyholes(platform, sight, _nodes_over(sight, spans))
    parts = []
    for branch in range(2):
        effort.charge(5.0 * look_rows * len(nodes.t_s))
        found = stretches(_motion_margin(platform, sight, branch), nodes)
        if _wide_axes(platform).any():
            found = _unwind_stretches(platform, sight, branch, nodes, found)
        parts.append(found)
    group, begins_s, ends_s = (
        np.concatenate([getattr(part, name) for part in parts])
        for name in ("group", "start_s", "stop_s")
    )
    order = np.lexsort((ends_s - begins_s, group))  # the longest of each group last
    longest_s = np.full((2, len(spans.target)), math.nan)
    longest_s[:, group[order]] = begins_s[order], ends_s[order]
    if platform.masks:
        effort.charge(12.0 * OPTIONS.mask_edge_s * look_rows * len(spans.target))
        opens, closes = (
            np.flatnonzero((cause == "mask") & (edge_s == held_s))
            for cause, edge_s, held_s in (
                (spans.opened_by, spans.start_s, longest_s[0]),
                (spans.closed_by, spans.stop_s, longest_s[1]),
            )
        )
        longest_s[0, opens] = _off_masks(platform, sight, spans.select(opens), 1.0)
        longest_s[1, closes] = _off_masks(platform, sight, spans.select(closes), -1.0)
        longest_s[:, ~(longest_s[1] > longest_s[0])] = math.nan
    return longest_s[0], longest_s[1]


def _off_masks(platform: TwoAxisPlatform, sight: Sight, spans: Spans, sign: float) -> Array:
    """When a mask at an edge of each span (m,) is far enough off to brake before it; or NaN.

    sign: 1 at the start, -1 at the stop.
    """
    slowest = min(platform.axis_limits, key=lambda axis: axis.acceleration_max_rad_s2)
    edge_s = spans.start_s if sign > 0.0 else spans.stop_s

    def off_rad(which: Indices, t_s: Array) -> Array:
        direction = sight.carrier.in_platform(sight.sighting(which, t_s).direction_itrf, t_s)
        return np.asarray(-np.max([mask.depth_rad(direction) for mask in platform.masks], axis=0))

    def margin_rad(row: Indices, after_s: Array) -> Array:
        which, t_s = spans.target[row], edge_s[row] + sign * after_s
        after_rad, before_rad = (
            off_rad(which, t_s + OPTIONS.delta_s),
            off_rad(which, t_s - OPTIONS.delta_s),
        )
        rate_rad_s = np.abs(after_rad - before_rad) / (2.0 * OPTIONS.delta_s)
        braking_rad = _braking_rad(rate_rad_s, np.zeros(len(t_s)), slowest)
        return off_rad(which, t_s) - braking_rad - OPTIONS.off_mask_s * rate_rad_s

    rows = np.arange(len(edge_s))
    after_s = np.arange(0.0, OPTIONS.mask_edge_s, 0.5)
    found = stretches(
        margin_rad, Nodes(rows, np.repeat(rows, len(after_s)), np.tile(after_s, len(rows)))
    )
    first_s = np.full(len(rows), math.nan)
    first_s[found.group[::-1]] = found.start_s[::-1]  # the first of each group is written last
    return np.asarray(edge_s + sign * first_s)


def _wide_axes(platform: TwoAxisPlatform) -> NDArray[np.bool_]:
    """Which axes can be in one place by several turns, (2,)."""
    return np.array([_travel_rad(axis) > TURN_RAD for axis in platform.axis_limits])


def _travel_rad(axis: AxisLimits) -> float:
    return axis.angle_max_rad - axis.angle_min_rad


def _may_wind_up(
    platform: TwoAxisPlatform, group: Indices, change_rad: Array, count: int
) -> NDArray[np.bool_]:
    """Groups (count,) of which a wide axis may turn so far that no number of turns holds them all.

    change_rad: (n, 2), of the axes' angles, in each `group` (n,).
    """
    may = np.zeros(count, np.bool_)
    for n in np.flatnonzero(_wide_axes(platform)):
        turned_rad = np.bincount(group, np.abs(change_rad[:, n]), minlength=count)
        may |= turned_rad > _travel_rad(platform.axis_limits[n]) - TURN_RAD
    return may


def _unwind_stretches(
    platform: TwoAxisPlatform, sight: Sight, branch: int, nodes: Nodes, found: Stretches
) -> Stretches:
    """The longest part of each stretch, from node to node, that one number of turns holds."""
    start_s, stop_s = found.start_s.copy(), found.stop_s.copy()
    for n, group in enumerate(found.group.tolist()):
        own_s = nodes.t_s[nodes.group == group]
        inside_s = own_s[(own_s > start_s[n]) & (own_s < stop_s[n])]
        t_s = np.concatenate([[start_s[n]], inside_s, [stop_s[n]]])
        one = Nodes(nodes.target[[group]], np.zeros(len(t_s), np.intp), t_s)
        angle_rad = axis_angles(platform, _los_platform(sight, one)).angle_rad[branch]
        first, last = _longest_on_turns(platform, np.unwrap(angle_rad, axis=0))
        start_s[n], stop_s[n] = t_s[first], t_s[last]
    return replace(found, start_s=start_s, stop_s=stop_s)


def _longest_on_turns(platform: TwoAxisPlatform, angle_rad: Array) -> tuple[int, int]:
    """First and last of the most rows of a motion (n, 2) that lie within the stops together."""
    best, first = (0, 0), 0
    for last in range(len(angle_rad)):
        while not all(turns_within_stops(angle_rad[first : last + 1], platform.axis_limits, 0.0)):
            first += 1
        best = max(best, (first, last), key=lambda rows: rows[1] - rows[0])
    return best


def _nodes_over(sight: Sight, spans: Spans) -> Nodes:
    return nodes_over(spans, sight, float(sight.carrier.node_s[1]), TURN_MAX_RAD)


def _los_platform(sight: Sight, nodes: Nodes) -> Array:
    which = nodes.target[nodes.group]
    return sight.carrier.in_platform(sight.sighting(which, nodes.t_s).direction_itrf, nodes.t_s)


def _with_keyholes(platform: TwoAxisPlatform, sight: Sight, nodes: Nodes) -> Nodes:
    """The nodes, and when between them the line of sight comes nearest to the plane of the axes.

    There the axes are quickest, for a moment.
    """

    def off_plane(which: Indices, t_s: Array) -> Array:
        los = sight.carrier.in_platform(sight.sighting(which, t_s).direction_itrf, t_s)
        angle_rad = axis_angles(platform, los).angle_rad[0]
        return np.nan_to_num(-singular_margin_rad(platform, angle_rad, los), nan=0.0)

    group, t_s = nodes.group, nodes.t_s
    values = off_plane(nodes.target[group], t_s)
    same = group[1:] == group[:-1]
    before, after = np.append(False, same), np.append(same, False)
    nearest = (~before | (values >= np.roll(values, 1))) & (
        ~after | (values >= np.roll(values, -1))
    )
    rows = np.flatnonzero(nearest)
    at_s = turning_point(
        off_plane, nodes.target[group[rows]], t_s[rows - before[rows]], t_s[rows + after[rows]]
    )
    place = rows + (at_s > t_s[rows])
    return Nodes(nodes.target, np.insert(group, place, group[rows]), np.insert(t_s, place, at_s))


def _motion_margin(platform: TwoAxisPlatform, sight: Sight, branch: int) -> Margin:
    """How far from its limits the motion along one branch is, in shares of them."""
    looks = OPTIONS.delta_s * np.arange(-2, 3)
    reach_rad = [0.5 * (axis.angle_max_rad - axis.angle_min_rad) for axis in platform.axis_limits]

    def margin_rad(which: Indices, t_s: Array) -> Array:
        angle_rad = np.stack(
            [
                axis_angles(
                    platform,
                    sight.carrier.in_platform(
                        sight.sighting(which, t_s + look_s).direction_itrf, t_s + look_s
                    ),
                ).angle_rad[branch]
                for look_s in looks
            ]
        )
        turn_rad = _wrap_angle(angle_rad - angle_rad[2])
        rate = (turn_rad[3] - turn_rad[1]) / (2.0 * OPTIONS.delta_s)
        acceleration = (turn_rad[3] + turn_rad[1]) / OPTIONS.delta_s**2
        jerk = (turn_rad[4] - 2.0 * turn_rad[3] + 2.0 * turn_rad[1] - turn_rad[0]) / (
            2.0 * OPTIONS.delta_s**3
        )
        from_stop_rad = _from_stop_rad(platform, angle_rad[2])
        shares = []
        for n, axis in enumerate(platform.axis_limits):
            braking_rad = _braking_rad(np.abs(rate[:, n]), np.abs(acceleration[:, n]), axis)
            shares.append((from_stop_rad[:, n] - braking_rad) / reach_rad[n])
            peak = np.abs(rate[:, n]) + acceleration[:, n] ** 2 / (2.0 * axis.jerk_max_rad_s3)
            shares.append(OPTIONS.within - peak / axis.rate_max_rad_s)
            shares.append(
                OPTIONS.within - np.abs(acceleration[:, n]) / axis.acceleration_max_rad_s2
            )
            shares.append(OPTIONS.within - np.abs(jerk[:, n]) / axis.jerk_max_rad_s3)
        return np.asarray(np.nan_to_num(np.min(shares, axis=0), nan=NEVER_RAD))

    return margin_rad


def _from_stop_rad(platform: TwoAxisPlatform, angle_rad: Array) -> Array:
    """Angles to the nearer stop by axis, at angles (n, 2) moved by whole turns to mid-travel."""
    low, high = (
        np.array([getattr(axis, name) for axis in platform.axis_limits])
        for name in ("angle_min_rad", "angle_max_rad")
    )
    return np.asarray(0.5 * (high - low) - np.abs(_wrap_angle(angle_rad - 0.5 * (low + high))))


def _braking_rad(rate_rad_s: Array, acceleration_rad_s2: Array, axis: AxisLimits) -> Array:
    """How far an axis still moves that speeds up and is braked as hard as rows of a table let it.

    Source: Biagiotti, Melchiorri 2008, "Trajectory Planning for Automatic Machines", 3.4.
    """
    brake, jerk = axis.acceleration_max_rad_s2, axis.jerk_max_rad_s3
    ramp_s = acceleration_rad_s2 / jerk
    peak = rate_rad_s + 0.5 * acceleration_rad_s2 * ramp_s
    ramp_rad = ramp_s * (rate_rad_s + acceleration_rad_s2 * ramp_s / 3.0)
    brake_s = np.where(
        peak >= brake**2 / jerk, peak / brake + brake / jerk, 2.0 * np.sqrt(peak / jerk)
    )
    return np.asarray(ramp_rad + peak * (0.5 * brake_s + OPTIONS.braked_s))


def _motion_bounds(platform: TwoAxisPlatform) -> list[Array]:
    """Limits of rate, acceleration and jerk, (2,) each."""
    return [
        np.array([getattr(axis, name) for axis in platform.axis_limits])
        for name in ("rate_max_rad_s", "acceleration_max_rad_s2", "jerk_max_rad_s3")
    ]


def _wrap_angle(angle_rad: Array) -> Array:
    """Wrap an angle to [-pi, pi]."""
    return np.asarray(angle_rad - 2.0 * math.pi * np.round(angle_rad / (2.0 * math.pi)))
