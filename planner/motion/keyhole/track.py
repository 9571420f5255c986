"""Tracks a target through the singular direction, as near as the limits allow.

Where the exact motion breaks no limit it is kept.  Around each place where it does, both axes
are optimised together, from every way of following the target before to every way after it:
the outer axis swings round in the time it needs, early and late, or the inner axis carries the
boresight over the top.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from planner.base.arrays import Array
from planner.base.commands import ROWS_PER_S
from planner.base.errors import Refusal, SolverFailed, TrackBreaksLimit
from planner.motion.keyhole.crossing import Crossing, CrossingMotion, Window
from planner.motion.keyhole.exact import ExactFollowing, ExactWay, RowMotion
from planner.motion.pointing.line_of_sight import LineOfSight
from planner.motion.pointing.track import AxisTrack
from planner.world.frames.time_scales import shifted_utc, utc_text
from planner.world.platforms import TwoAxisPlatform

HOPELESS_SHARE = 1.0  # of the frame beyond it: no optimum in the frame is near such a one


@dataclass(frozen=True, kw_only=True, eq=False)
class _Chain:
    """A motion up to next_row, from where on `way` is followed.

    axis_states: as of `RowMotion`, on the rows before next_row.  beyond_rad: farthest outside
    the frame.
    """

    way: ExactWay
    next_row: int
    axis_states: Array
    beyond_rad: float = 0.0
    squared_rad2_s: float = 0.0

    @property
    def rank(self) -> tuple[float, float]:
        return self.beyond_rad, self.squared_rad2_s

    def carry_on(self, crossing: CrossingMotion, way: ExactWay) -> "_Chain":
        """Across a window, onto another way; a window's ends, which may be free, are its own."""
        return _Chain(
            way=way,
            next_row=crossing.motion.last_row + 1,
            axis_states=np.concatenate(
                [self._states_to(crossing.motion.first_row - 1), crossing.motion.axis_states],
                axis=1,
            ),
            beyond_rad=max(self.beyond_rad, crossing.beyond_rad),
            squared_rad2_s=self.squared_rad2_s + crossing.squared_rad2_s,
        )

    def motion(self) -> RowMotion:
        """To the end of the way."""
        axis_states = self._states_to(self.way.last_row)
        return RowMotion(self.way.last_row + 1 - axis_states.shape[1], axis_states)

    def _states_to(self, last_row: int) -> Array:
        exact = self.way.whole.rows_between(self.next_row, last_row).axis_states
        return np.concatenate([self.axis_states, exact], axis=1)


def nearest_track(
    platform: TwoAxisPlatform, los: LineOfSight, start_s: float, stop_s: float, exact: Refusal
) -> AxisTrack:
    """The way to hold the target that errs least, in the frame from start_s to stop_s.

    platform: with the limits to keep.  los: covers the session and may reach before it.
    exact: why the target can't be followed exactly.  Least is the integral of the squared
    error, of all local optima found (from every way of following before to every one after);
    where that leaves the circle inside the frame, of those within it.
    Raises TrackBreaksLimit with the error reached and when, SolverFailed.
    """
    following = ExactFollowing(platform, los)
    first, last = round(start_s * ROWS_PER_S), round(stop_s * ROWS_PER_S)
    chains = _best_chains(following, first, last)
    if not chains:
        raise exact
    best = min(chains, key=lambda chain: chain.rank)
    if not math.isfinite(best.beyond_rad):
        raise SolverFailed(
            f"{_limits_text(exact)}; and the solver found no motion within the limits near it",
            axis=exact.axis,
            limit=exact.limit,
        )
    motion = best.motion()
    _require_in_frame(following, los, motion, exact)
    return AxisTrack(
        axis_names=platform.axis_names,
        t_s=np.arange(motion.first_row, motion.last_row + 1) / ROWS_PER_S,
        axis_states=motion.axis_states,
        los=los,
    )


def _limits_text(exact: Refusal) -> str:
    """Without the ways out."""
    return exact.detail.partition(";")[0]


def _require_in_frame(
    following: ExactFollowing, los: LineOfSight, motion: RowMotion, exact: Refusal
) -> None:
    t_s, error_rad = following.error_rad(motion)
    worst = int(np.argmax(error_rad))
    frame_rad = min(following.platform.frame_half_rad)
    if error_rad[worst] <= frame_rad:
        return
    at_utc = shifted_utc(los.instants.epoch_utc, float(t_s[worst]))
    raise TrackBreaksLimit(
        f"{_limits_text(exact)}; as near as the limits allow, the target is "
        f"{math.degrees(error_rad[worst]):.3f} deg off at {utc_text(at_utc)}, outside the "
        f"circle of {math.degrees(frame_rad):.3f} deg inside the frame",
        axis=exact.axis,
        limit=exact.limit,
        at_utc=at_utc,
    )


def _best_chains(following: ExactFollowing, first: int, last: int) -> list[_Chain]:
    """The best chain to each way of following at the session's end."""
    windows = _crossing_windows(following, first, last)
    chains = [
        _Chain(way=way, next_row=way.first_row, axis_states=np.empty((3, 0, 2)))
        for way in following.ways(first, windows[0].first, lead=windows[0].fixed[0])
    ]
    untils = [*(window.first for window in windows[1:]), last]
    for window, until in zip(windows, untils, strict=True):
        ways = following.ways(window.last, until) if chains else []
        chains = _carry_on(Crossing(following, window), chains, ways)
    return chains


def _carry_on(crossing: Crossing, chains: list[_Chain], ways: list[ExactWay]) -> list[_Chain]:
    """The best chain that leads to each way of following after a window."""
    pairs = [(chain, way) for way in ways for chain in chains]
    found = [crossing.solve_crossing(chain.way.whole, way.whole) for chain, way in pairs]
    in_frame = [one.squared_rad2_s for one in found if one.beyond_rad == 0.0]
    for number in sorted(range(len(found)), key=lambda number: found[number].squared_rad2_s):
        one = found[number]
        promising = 0.0 < one.beyond_rad < HOPELESS_SHARE * crossing.frame_rad
        if promising and one.squared_rad2_s < min(in_frame, default=math.inf):
            found[number] = better = crossing.nearest_in_frame(one)
            in_frame += [better.squared_rad2_s] if better.beyond_rad == 0.0 else []
    longer = [chain.carry_on(one, way) for (chain, way), one in zip(pairs, found, strict=True)]
    count = len(chains)
    return [
        min(longer[number * count : (number + 1) * count], key=lambda chain: chain.rank)
        for number in range(len(ways))
    ]


def _crossing_windows(following: ExactFollowing, first: int, last: int) -> list[Window]:
    """Around each broken run as long as a half turn of the outer axis takes, merged."""
    outer = following.platform.outer_limits
    swing_s = (
        math.pi / 2.0 / outer.rate_max_rad_s
        + outer.rate_max_rad_s / outer.acceleration_max_rad_s2
        + outer.acceleration_max_rad_s2 / outer.jerk_max_rad_s3
    )
    reach = math.ceil(swing_s * ROWS_PER_S)
    merged: list[Window] = []
    for start, stop in following.broken_runs(first, last):
        window = Window(
            first=max(first, start - reach), last=min(last, stop + reach), broken=((start, stop),)
        )
        if merged and window.first <= merged[-1].last:
            before = merged.pop()
            window = replace(window, first=before.first, broken=before.broken + window.broken)
        merged.append(window)
    return [replace(w, fixed=(w.first > first, w.last < last)) for w in merged]
