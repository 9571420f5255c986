"""Rows of the table on which a target can be tracked exactly, by track branch."""

import itertools
import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from planner.base.arrays import Array, Indices, Mask
from planner.base.commands import COMMAND_STEP_S, ROWS_PER_S
from planner.motion.pointing.angles import (
    axis_angles,
    axis_motion,
    boresight_platform,
    singular_margin_rad,
)
from planner.motion.pointing.hermite import beyond_limits, cubic_and_row_range
from planner.motion.pointing.line_of_sight import LineOfSight
from planner.motion.pointing.track import TURN_RAD, turns_within_stops
from planner.world.platforms import AxisLimits, TwoAxisPlatform


@dataclass(frozen=True, kw_only=True)
class ExactAnglesOptions:
    """Where exact angles hold, and how closely limits do."""

    singular_rad: float = 1e-5  # nearer to the plane of the axes exact angles are noise
    dead_margin_rad: float = 1e-9  # by which rounding may pass the edge of what the axes can reach
    limit_tolerance: float = 1e-7  # of the limit's range
    points_per_row: int = 4  # where an error is measured, as the judge does


OPTIONS = ExactAnglesOptions()


@dataclass(frozen=True, eq=False)
class RowMotion:
    """Both axes on n consecutive rows.

    axis_states: angle, rate, acceleration (rad, s), (3, n, 2).
    """

    first_row: int
    axis_states: Array

    @property
    def last_row(self) -> int:
        return self.first_row + len(self.axis_states[0]) - 1

    def at(self, row: int | Indices) -> Array:
        """The angles on that row, (2,), or on those rows, (n, 2)."""
        return np.asarray(self.axis_states[0, row - self.first_row])

    def beyond(self, limits: tuple[AxisLimits, ...]) -> Mask:
        """Where the limits are broken, as `beyond_limits` has it, (4, n - 1, 2)."""
        ranges = cubic_and_row_range(COMMAND_STEP_S, *self.axis_states)
        return beyond_limits(ranges, limits, OPTIONS.limit_tolerance)

    def rows_between(self, first_row: int, last_row: int) -> "RowMotion":
        """The motion on these rows, both included."""
        rows = slice(first_row - self.first_row, last_row - self.first_row + 1)
        return RowMotion(first_row, self.axis_states[:, rows])

    def turn(self, turns: tuple[int, ...]) -> "RowMotion":
        """The motion moved by whole turns of each axis."""
        angle_rad, *rates = self.axis_states
        return RowMotion(self.first_row, np.stack([angle_rad + TURN_RAD * np.array(turns), *rates]))


@dataclass(frozen=True, kw_only=True, eq=False)
class ExactWay:
    """Exact following within all limits on rows first_row..last_row of a branch's `whole`."""

    whole: RowMotion
    first_row: int
    last_row: int


class ExactFollowing:
    """Both branches of exact angles over the rows of a line of sight, which may be unflyable.

    branches: two motions, unwrapped; where no angles point there, those that come nearest.
    """

    def __init__(self, platform: TwoAxisPlatform, los: LineOfSight) -> None:
        # SciPy's interpolators take 0.2 s to import, which only a plan should pay.
        from scipy.interpolate import CubicHermiteSpline

        self.platform, self.limits = platform, platform.axis_limits
        t_s = los.instants.t_s
        self.first_row = round(float(t_s[0]) * ROWS_PER_S)
        self.last_row = round(float(t_s[-1]) * ROWS_PER_S)
        # A short session's line of sight is sampled more finely than its rows.
        self._direction = CubicHermiteSpline(t_s, los.los_base, los.los_rate_base_per_s)
        self._rate = CubicHermiteSpline(
            t_s, los.los_rate_base_per_s, los.los_acceleration_base_per_s2
        )
        rows_s = np.arange(self.first_row, self.last_row + 1) / ROWS_PER_S
        directions = self.directions(rows_s)
        found = axis_angles(platform, _nearest_reachable(platform, directions))
        reachable = axis_angles(platform, directions).reachable
        self.margin_rad = singular_margin_rad(platform, found.angle_rad[0], directions)
        usable = reachable & (self.margin_rad > OPTIONS.singular_rad)
        self._usable_cells = usable[:-1] & usable[1:]
        self.branches = tuple(self._motion(angle, rows_s, directions) for angle in found.angle_rad)

    def directions(self, t_s: Array) -> Array:
        """Unit vectors in the platform frame, (n, 3), at any time of the line of sight."""
        towards = self._direction(t_s)
        return np.asarray(towards / np.linalg.norm(towards, axis=1, keepdims=True))

    def error_rad(self, motion: RowMotion) -> tuple[Array, Array]:
        """Times and the angle between the flown boresight and the target, (n,) each."""
        from scipy.interpolate import CubicHermiteSpline

        points = np.arange((motion.last_row - motion.first_row) * OPTIONS.points_per_row + 1)
        since_first_s = points / OPTIONS.points_per_row / ROWS_PER_S
        curve = CubicHermiteSpline(
            since_first_s[:: OPTIONS.points_per_row], *motion.axis_states[:2]
        )
        angle, t_s = curve(since_first_s), motion.first_row / ROWS_PER_S + since_first_s
        boresight, towards = boresight_platform(self.platform, angle), self.directions(t_s)
        across = np.linalg.norm(np.cross(boresight, towards), axis=1)
        return t_s, np.arctan2(across, np.sum(boresight * towards, axis=1))

    @cached_property
    def _flyable(self) -> Mask:
        """Cells in which either branch keeps rate, acceleration and jerk."""
        broken = [branch.beyond(self.limits)[1:].any(axis=(0, 2)) for branch in self.branches]
        return np.asarray(~np.all(broken, axis=0) & self._usable_cells)

    def broken_runs(self, first_row: int, last_row: int) -> list[tuple[int, int]]:
        """Runs of rows, both ends included, between which following breaks a limit.

        Where none does (it is the stops that are in the way) the most singular row.
        """
        cells = self._flyable[first_row - self.first_row : last_row - self.first_row]
        edges = np.flatnonzero(np.diff(np.concatenate([[False], ~cells, [False]])))
        if edges.size:
            return [
                (first_row + int(start), first_row + int(stop))
                for start, stop in edges.reshape(-1, 2)
            ]
        margins = self.margin_rad[first_row - self.first_row : last_row - self.first_row + 1]
        worst = first_row + int(np.nanargmin(margins))
        return [(worst, worst)]

    def ways(self, first_row: int, last_row: int, *, lead: bool = False) -> list[ExactWay]:
        """Every way to follow exactly over these rows within all limits, stops included.

        lead: each from as early on as it is possible without a break.
        """
        found = []
        for branch in self.branches:
            angle_rad = branch.rows_between(first_row, last_row).axis_states[0]
            choices = turns_within_stops(angle_rad, self.limits, OPTIONS.limit_tolerance)
            for whole in map(branch.turn, itertools.product(*choices)):
                lost = whole.beyond(self.limits).any(axis=(0, 2)) | ~self._usable_cells
                if lost[first_row - self.first_row : last_row - self.first_row].any():
                    continue
                earlier = np.flatnonzero(lost[: first_row - self.first_row])
                start = int(earlier[-1]) + 1 if earlier.size else 0
                found.append(
                    ExactWay(
                        whole=whole,
                        first_row=self.first_row + start if lead else first_row,
                        last_row=last_row,
                    )
                )
        return found

    def _motion(self, angle_rad: Array, rows_s: Array, directions: Array) -> RowMotion:
        with np.errstate(divide="ignore", invalid="ignore"):
            rate, acceleration = axis_motion(
                self.platform, angle_rad, directions, self._rate(rows_s), self._rate(rows_s, 1)
            )
        axis_states = np.stack([np.unwrap(angle_rad, axis=0), rate, acceleration])
        return RowMotion(self.first_row, axis_states)


def _nearest_reachable(platform: TwoAxisPlatform, directions: Array) -> Array:
    """Out of the dead cones about the outer axis, where an oblique layout has them."""
    outer, inner = platform.axes_platform
    zero = np.array(platform.zero_direction_platform)
    spread = math.acos(outer @ inner)
    carried = math.acos(inner @ zero / np.linalg.norm(zero))
    along = directions @ outer
    across = directions - along[:, None] * outer
    across /= np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-12)
    away = np.clip(
        np.arctan2(np.linalg.norm(np.cross(outer, directions), axis=1), along),
        abs(spread - carried) + OPTIONS.dead_margin_rad,
        math.pi - abs(math.pi - spread - carried) - OPTIONS.dead_margin_rad,
    )
    return np.asarray(np.cos(away)[:, None] * outer + np.sin(away)[:, None] * across)
