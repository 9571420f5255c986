"""Crossings of both axes from one track branch to another, with the least error on the way."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from planner.base.arrays import Array, Indices
from planner.base.commands import ROWS_PER_S
from planner.motion.keyhole.exact import ExactFollowing, RowMotion
from planner.motion.keyhole.ocp import nearest_ocp, sample_times_s


@dataclass(frozen=True, kw_only=True)
class CrossingOptions:
    """How the way through a keyhole is guessed and bounded."""

    # between knots: the first that rows allow
    spans: tuple[int, ...] = (96, 48, 24, 12, 6, 3, 2, 1)
    fine_s: float = 8.0  # beside the place where limits break; farther off knots stand wider apart
    swing_share: float = 0.8  # of the rate limit, in the guess
    frame_share: float = 0.995  # of the frame: the solver bounds the error at samples only


OPTIONS = CrossingOptions()


@dataclass(frozen=True, kw_only=True)
class Window:
    """Rows from `first` to `last` in which the exact motion is left.

    broken: the runs inside where it breaks a limit.
    fixed: whether the first and the last row belong to an exact motion; else that end is free.
    """

    first: int
    last: int
    broken: tuple[tuple[int, int], ...]
    fixed: tuple[bool, bool] = (False, False)


@dataclass(frozen=True, kw_only=True, eq=False)
class CrossingMotion:
    """One local optimum.

    beyond_rad: how far it goes outside the frame's inner circle at most; infinite where it
    keeps no limit.  squared_rad2_s: integral of the squared error.
    """

    motion: RowMotion
    beyond_rad: float
    squared_rad2_s: float


class Crossing:
    """All ways across one window."""

    def __init__(self, following: ExactFollowing, window: Window) -> None:
        self.window = window
        self.frame_rad = min(following.platform.frame_half_rad)
        self._following = following

    def solve_crossing(self, before: RowMotion, after: RowMotion) -> CrossingMotion:
        """The least integral of the squared error near a smooth swing from one to the other."""
        return self._solve_from(self._guess_states(before, after), in_frame=False)

    def nearest_in_frame(self, found: CrossingMotion) -> CrossingMotion:
        """Near a crossing that leaves the frame, the best one that doesn't, or the least beyond."""
        guess_states = found.motion.axis_states[:, self._knots - self.window.first]
        bounded = self._solve_from(guess_states, in_frame=True)
        return bounded if bounded.beyond_rad < found.beyond_rad else found

    def _solve_from(self, guess_states: Array, *, in_frame: bool) -> CrossingMotion:
        axis_states = nearest_ocp(len(self._knots) - 1, in_frame=in_frame).solve(
            self._following.platform,
            self._knots,
            guess_states,
            self._directions,
            OPTIONS.frame_share * self.frame_rad,
            fixed=self.window.fixed,
        )
        motion = RowMotion(self.window.first, axis_states)
        t_s, error_rad = self._following.error_rad(motion)
        beyond_rad = max(float(error_rad.max()) - self.frame_rad, 0.0)
        return CrossingMotion(
            motion=motion,
            beyond_rad=math.inf if motion.beyond(self._following.limits).any() else beyond_rad,
            squared_rad2_s=float(np.mean(error_rad**2)) * float(t_s[-1] - t_s[0]),
        )

    @cached_property
    def _directions(self) -> Array:
        return self._following.directions(sample_times_s(self._knots))

    @cached_property
    def _knots(self) -> Indices:
        """Rows at which the jerk may change: dense where limits break, wider apart beyond."""
        first, last = self.window.first, self.window.last
        spans = next(count for count in OPTIONS.spans if count <= last - first)
        rows = np.arange(first, last + 1)
        away = np.full(len(rows), np.inf)
        for start, stop in self.window.broken:
            away = np.minimum(away, np.maximum(start - rows, rows - stop).clip(0))
        density = 1.0 / (1.0 + away / (OPTIONS.fine_s * ROWS_PER_S))
        done = np.concatenate([[0.0], np.cumsum((density[1:] + density[:-1]) / 2.0)])
        knots = np.interp(np.linspace(0.0, done[-1], spans + 1), done, rows).round()
        offset = np.arange(spans + 1)
        # At least a row apart, and none past the end.
        spread = np.maximum.accumulate(knots.astype(np.intp) - offset) + offset
        return np.asarray(np.minimum(spread, last - offset[::-1]))

    def _guess_states(self, before: RowMotion, after: RowMotion) -> Array:
        """States at knots: exact on either side of where limits break, between a smooth swing."""
        knots, window = self._knots, self.window
        start, stop = window.broken[0][0], window.broken[-1][1]
        rate_max = np.array([axis.rate_max_rad_s for axis in self._following.limits])
        swing = after.at(stop) - before.at(start)
        rows = float(np.max(np.abs(swing) / rate_max)) / OPTIONS.swing_share * ROWS_PER_S
        extra = max(0, math.ceil((rows - (stop - start)) / 2.0))
        start, stop = max(window.first, start - extra), min(window.last, stop + extra)
        first, last = before.at(start), after.at(stop)
        share = np.clip((knots - start) / max(stop - start, 1), 0.0, 1.0)[:, None]
        angle = first + (last - first) * share**2 * (3.0 - 2.0 * share)
        angle = np.where((knots < start)[:, None], before.at(knots), angle)
        angle = np.where((knots > stop)[:, None], after.at(knots), angle)
        rate = np.gradient(angle, knots / ROWS_PER_S, axis=0)
        axis_states = np.stack([angle, rate, np.zeros_like(rate)])
        for motion, end, is_fixed in zip((before, after), (0, -1), window.fixed, strict=True):
            if is_fixed:
                row = int(knots[end]) - motion.first_row
                axis_states[1:, end] = motion.axis_states[1:, row]
        return axis_states
