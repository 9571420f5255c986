"""Proof that cones and limits shut every way from start to end.

The angles are cut into cells as wide as an axis may move in one step of time: what is in a cell
at one step is in it or in one of its eight neighbours at the next.  Left out are cells that lie
wholly inside a cone, and those beyond what rate, acceleration and jerk allow from either end.
Where this flood from the start never reaches the end, no motion does.

That a cell lies wholly inside is proven by its corners.  The cosine f between boresight and cone
axis is 1 x 1 in the cosines and sines of both angles, and no second derivative by one angle is
greater than 1, since it is an acceleration on a unit circle.  So over a cell a by b
f leaves the bilinear interpolation of its corners, whose least value is at one of them, by
at most (a^2 + b^2) / 8.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from planner import effort
from planner.arrays import Array
from planner.platforms import AxisLimits
from planner.pointing.angles import cosine_coefficients
from planner.pointing.keep_out import KeepOutView
from planner.slew.problem import AxisState, SlewProblem

Mask = NDArray[np.bool_]
CELLS_RAD = (math.radians(1.2), math.radians(0.6))
FINE_CELLS_RAD = (math.radians(0.3), math.radians(0.15))
FLOOD_CELLS_MAX = 1_000_000_000  # 3 s
LAYER_MAX = 10_000_000  # cells: 90 MB
LAYERS_MIN = 60
LAYER, CELLS_A_ROW = 5, 3_000  # of `planner.effort`
ROUNDING = 1e-6  # of a cell
CAUGHT_S, CAUGHT_STEP_S = 4.0, 0.1


def is_impossible(problem: SlewProblem, view: KeepOutView, duration_s: float) -> bool:
    """Whether it is proven that no motion within the limits keeps out of the cones.

    The proof is one-sided: acceleration and jerk limits enter only through what is within reach
    of each end by itself, so that a tight slew may be impossible without being proven so.
    """
    return is_caught(problem, view, duration_s) or is_barred(problem, view, duration_s, CELLS_RAD)


def is_barred(
    problem: SlewProblem, view: KeepOutView, duration_s: float, cells_rad: tuple[float, ...]
) -> bool:
    """Whether a flood in cells of any of these sizes doesn't reach the end.

    A barrier thinner than a cell leaks, so that a finer flood may prove what a coarser doesn't.
    """
    return any(_shuts(problem, view, duration_s, cell_rad) for cell_rad in cells_rad)


def _shuts(problem: SlewProblem, view: KeepOutView, duration_s: float, cell_rad: float) -> bool:
    rate = max(limits.rate_max_rad_s for limits in problem.limits)
    layers = max(math.ceil(duration_s * rate / cell_rad), LAYERS_MIN)
    t_s = np.linspace(0.0, duration_s, layers + 1)
    axes = [
        _axis_cells(t_s, start, end, limits)
        for start, end, limits in zip(problem.start, problem.end, problem.limits, strict=True)
    ]
    cones = cones_over(view, t_s, axes[0].edges_rad, axes[1].edges_rad)
    wet, corner, cells = np.ones((1, 1), dtype=bool), [axis.start for axis in axes], 0
    for layer in range(1, layers + 1):
        spans = [
            axis.near(layer, at, count)
            for axis, at, count in zip(axes, corner, wet.shape, strict=True)
        ]
        size = math.prod(max(span.stop - span.start, 0) for span in spans)
        cells += size
        effort.spend(LAYER + size / CELLS_A_ROW)
        if size > LAYER_MAX or cells > FLOOD_CELLS_MAX:
            return False
        wet = _with_neighbours(wet)[_within(spans, corner)]
        for cone in cones:
            if size and cone.counts[layer]:
                wet &= ~cone.inside(layer, spans)
        if not wet.any():
            return True
        rows, columns = (np.flatnonzero(wet.any(axis=axis)) for axis in (1, 0))
        wet = wet[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
        corner = [spans[0].start + int(rows[0]), spans[1].start + int(columns[0])]
    return False


def _within(spans: list[slice], corner: list[int]) -> tuple[slice, ...]:
    """The same cells in an array that begins one cell before the corner."""
    return tuple(
        slice(span.start - at + 1, max(span.stop, span.start) - at + 1)
        for span, at in zip(spans, corner, strict=True)
    )


class _AxisCells(NamedTuple):
    """edges_rad: of the cells, (k + 1,).  start: the cell of the slew's start, in its middle.

    first, last: cells within reach of both ends, (layers + 1,).
    """

    edges_rad: Array
    start: int
    first: list[int]
    last: list[int]

    def near(self, layer: int, at: int, count: int) -> slice:
        """Cells that count cells, one layer before, lead to; none: it ends before it begins."""
        return slice(max(at - 1, self.first[layer]), min(at + count, self.last[layer]) + 1)


def _axis_cells(t_s: Array, start: AxisState, end: AxisState, limits: AxisLimits) -> _AxisCells:
    size = limits.rate_max_rad_s * float(t_s[1]) * (1.0 + ROUNDING)
    low, high = tube(t_s, start, end, limits)
    below = math.ceil((start.angle_rad - low.min()) / size) + 1
    lowest = start.angle_rad - (below + 0.5) * size
    count = math.ceil((high.max() - lowest) / size) + 1
    return _AxisCells(
        edges_rad=lowest + size * np.arange(count + 1),
        start=below,
        first=np.floor((low - lowest) / size - ROUNDING).astype(int).tolist(),
        last=np.floor((high - lowest) / size + ROUNDING).astype(int).tolist(),
    )


@dataclass(frozen=True, eq=False)
class ConeOverCells:
    """A cell whose corners' cosines all reach the threshold is inside.

    counts: whether the cone does, by layer.
    coefficients: the cosine's by (1, cos, sin) of either angle, (layers, 3, 3), which outer_basis
    and inner_basis hold for the cells' edges, (k + 1, 3).
    """

    coefficients: Array
    counts: Mask
    cosine_threshold: float
    outer_basis: Array
    inner_basis: Array

    def inside(self, layer: int, spans: list[slice]) -> Mask:
        """Cells of these spans along either axis that are proven to be wholly inside."""
        edges = [slice(span.start, span.stop + 1) for span in spans]
        cosine = (
            self.outer_basis[edges[0]] @ self.coefficients[layer] @ self.inner_basis[edges[1]].T
        )
        corner = cosine >= self.cosine_threshold
        side = corner[:-1] & corner[1:]
        return np.asarray(side[:, :-1] & side[:, 1:])


def cones_over(
    view: KeepOutView, t_s: Array, outer_edges_rad: Array, inner_edges_rad: Array
) -> list[ConeOverCells]:
    """Every cone at the instants t_s, over cells of equal size along either axis."""
    edges_rad = (outer_edges_rad, inner_edges_rad)
    trig = [np.stack([np.ones(len(q)), np.cos(q), np.sin(q)], axis=1) for q in edges_rad]
    bulge = sum((q[1] - q[0]) ** 2 for q in edges_rad) / 8.0
    found = []
    for cone in view.cones:
        axis, counts = cone.at(t_s)
        coefficients = cosine_coefficients(view.platform, axis).reshape(-1, 3, 3)
        threshold = math.cos(cone.half_angle_rad) + bulge
        found.append(ConeOverCells(coefficients, counts, threshold, *trig))
    return found


def _with_neighbours(mask: Mask) -> Mask:
    """With all eight neighbours of each cell, in an array larger by one cell all around."""
    rows, columns = mask.shape
    tall = np.zeros((rows + 2, columns), dtype=bool)
    grown = np.zeros((rows + 2, columns + 2), dtype=bool)
    for off in range(3):
        tall[off : off + rows] |= mask
    for off in range(3):
        grown[:, off : off + columns] |= tall
    return grown


def is_caught(problem: SlewProblem, view: KeepOutView, duration_s: float) -> bool:
    """Whether the motion at an end, which jerk limits from changing at once, leads into a cone."""
    since_s = np.arange(CAUGHT_STEP_S, min(CAUGHT_S, duration_s / 2.0), CAUGHT_STEP_S)
    off_rad = [limits.jerk_max_rad_s3 * since_s**3 / 6.0 for limits in problem.limits]
    for side, sign in ((problem.start, 1.0), (problem.end, -1.0)):
        angle = np.stack(
            [
                axis.angle_rad
                + sign * axis.rate_rad_s * since_s
                + axis.acceleration_rad_s2 * since_s**2 / 2.0
                for axis in side
            ],
            axis=1,
        )
        t_s = since_s if sign > 0.0 else duration_s - since_s
        middle = view.boresight(angle)
        corners = [
            np.linalg.norm(
                view.boresight(angle + np.stack([off_rad[0], mirror * off_rad[1]], axis=1))
                - middle,
                axis=1,
            )
            for mirror in (1.0, -1.0)
        ]
        # To second order the boresight stays in the box whose corners these are.
        reach_rad = np.maximum(*corners) + 2.0 * (off_rad[0] + off_rad[1]) ** 2
        if (view.depths_rad(t_s, angle) > reach_rad).any():
            return True
    return False


def tube(t_s: Array, start: AxisState, end: AxisState, limits: AxisLimits) -> Array:
    """Least and greatest angle at t_s, (2, k), of any motion from start to end."""
    before, after = t_s, t_s[-1] - t_s
    back = end.backwards()
    high = np.minimum(
        start.angle_rad + _farthest(before, start, limits),
        end.angle_rad + _farthest(after, back, limits),
    )
    low = np.maximum(
        start.angle_rad - _farthest(before, start.mirror_image(), limits),
        end.angle_rad - _farthest(after, back.mirror_image(), limits),
    )
    return np.stack([np.maximum(low, limits.angle_min_rad), np.minimum(high, limits.angle_max_rad)])


def _farthest(t_s: Array, state: AxisState, limits: AxisLimits) -> Array:
    """How far up it may come at t_s: jerk, acceleration, rate each all that the limits allow."""
    v0, a0 = state.rate_rad_s, state.acceleration_rad_s2
    v, a, jerk = limits.rate_max_rad_s, limits.acceleration_max_rad_s2, limits.jerk_max_rad_s3
    rising_s = (a - a0) / jerk
    risen = v0 + rising_s * (a0 + a) / 2.0
    if risen >= v:
        full_s = (math.sqrt(max(a0 * a0 + 2.0 * jerk * (v - v0), 0.0)) - a0) / jerk
        rising_s = full_s
    else:
        full_s = rising_s + (v - risen) / a
    t = np.minimum(t_s, rising_s)
    gathering_s = np.clip(t_s - rising_s, 0.0, full_s - rising_s)
    way = t * (v0 + t * (a0 / 2.0 + t * jerk / 6.0))
    way += gathering_s * (risen + a * gathering_s / 2.0)
    return np.asarray(way + v * np.maximum(t_s - full_s, 0.0))
