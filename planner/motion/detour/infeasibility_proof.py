"""Proof that cones, masks and limits leave no slew from start to end.

The angles are cut into cells as wide as an axis may move in one step of time: what is in a cell
at one step is in it or in one of its eight neighbours at the next.  Left out are cells that lie
wholly inside a cone or mask, and what is beyond what rate, acceleration and jerk allow from
either end, which cuts the outermost cells.  Where this flood from the start never reaches the
end, no motion does.

That a cell lies wholly inside is proven by its corners.  The cosine f between boresight and cone
axis is 1 x 1 in the cosines and sines of both angles, and no second derivative by one angle is
greater than 1, since it is an acceleration on a unit circle.  So over a cell a by b
f leaves the bilinear interpolation of its corners, whose least value is at one of them, by
at most (a^2 + b^2) / 8.  A mask holds a cell whose middle lies deeper in it than any direction of
the cell is away: half of a and half of b at most, as that is how far either axis turns it.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from planner.base import effort
from planner.base.arrays import Array
from planner.motion.pointing.angles import cosine_coefficients
from planner.motion.pointing.keep_out import KeepOutView, MovingCone
from planner.motion.slew.problem import AxisState, SlewProblem
from planner.world.platforms import AxisLimits, FieldMask

Mask = NDArray[np.bool_]


@dataclass(frozen=True, kw_only=True)
class InfeasibilityProofOptions:
    """How finely a slew that cones forbid is proved impossible."""

    # before a detour is sought: most slews that cones shut are proved in these, the wide first
    cells_rad: tuple[float, ...] = (math.radians(1.2), math.radians(0.6))
    # where none was found and the reason is asked for: thinner barriers leak less
    fine_cells_rad: tuple[float, ...] = (math.radians(0.3), math.radians(0.15))
    flood_cells_max: int = 1_000_000_000  # 3 s
    layer_max: int = 10_000_000  # cells: 90 MB
    layers_min: int = 60  # of a short slew, so that what is within reach of its ends is not blurred
    layer: int = 5  # of `effort`: a layer, and
    cells_a_row: int = 3_000  # so many of its cells as one
    sides_a_row: int = 200  # of masks beside a cell, for one of `effort`
    rounding: float = 1e-6  # of a cell
    # from either end: moving axes may be inside a region before they can stop
    catching_s: float = 4.0
    catching_step_s: float = 0.1  # between the moments at which that is looked for


OPTIONS = InfeasibilityProofOptions()


def is_unreachable(
    problem: SlewProblem, view: KeepOutView, duration_s: float, cells_rad: tuple[float, ...]
) -> bool:
    """Whether a flood in cells of any of these sizes doesn't reach the end: no motion does.

    The proof is one-sided: acceleration and jerk limits enter only through what is within reach
    of each end by itself, so that a tight slew may be impossible without being proven so.
    A flood leaks through what is thinner than a cell, so a finer one may prove what a coarser
    doesn't.
    """
    return any(_flood_misses_end(problem, view, duration_s, cell_rad) for cell_rad in cells_rad)


def _flood_misses_end(
    problem: SlewProblem, view: KeepOutView, duration_s: float, cell_rad: float
) -> bool:
    rate = max(limits.rate_max_rad_s for limits in problem.limits)
    layers = max(math.ceil(duration_s * rate / cell_rad), OPTIONS.layers_min)
    t_s = np.linspace(0.0, duration_s, layers + 1)
    axes = [
        _axis_cells(t_s, start, end, limits)
        for start, end, limits in zip(problem.start, problem.end, problem.limits, strict=True)
    ]
    cones = cones_over(view, t_s, axes[0].size_rad, axes[1].size_rad)
    masks = MasksOverCells(view, [axis.edges_rad for axis in axes]) if view.masks else None
    wet, corner, cells = np.ones((1, 1), dtype=bool), [axis.start for axis in axes], 0
    for layer in range(1, layers + 1):
        spans = [
            axis.cells_near(layer, at, count)
            for axis, at, count in zip(axes, corner, wet.shape, strict=True)
        ]
        size = math.prod(max(span.stop - span.start, 0) for span in spans)
        cells += size
        effort.charge(OPTIONS.layer + size / OPTIONS.cells_a_row)
        if size > OPTIONS.layer_max or cells > OPTIONS.flood_cells_max:
            return False
        wet = with_neighbours(wet)[_cells_within(spans, corner)]
        if size and masks:
            wet &= ~masks.proven_inside(spans)
        for cone in cones:
            if size and cone.counts[layer]:
                edges = [
                    axis.edges_within_reach(layer, span)
                    for axis, span in zip(axes, spans, strict=True)
                ]
                wet &= ~cone.proven_inside(layer, edges)
        if not wet.any():
            return True
        rows, columns = (np.flatnonzero(wet.any(axis=axis)) for axis in (1, 0))
        wet = wet[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
        corner = [spans[0].start + int(rows[0]), spans[1].start + int(columns[0])]
    return False


def _cells_within(spans: list[slice], corner: list[int]) -> tuple[slice, ...]:
    """These cells in an array that begins one cell before the corner."""
    return tuple(
        slice(span.start - at + 1, max(span.stop, span.start) - at + 1)
        for span, at in zip(spans, corner, strict=True)
    )


class _AxisCells(NamedTuple):
    """edges_rad: of the cells, (k + 1,).  start: the cell of the slew's start, in its middle.

    low_rad, high_rad: what is within reach of both ends, (layers + 1,).
    first, last: the cells that it is in.
    """

    edges_rad: Array
    start: int
    low_rad: Array
    high_rad: Array
    first: list[int]
    last: list[int]

    @property
    def size_rad(self) -> float:
        return float(self.edges_rad[1] - self.edges_rad[0])

    def cells_near(self, layer: int, at: int, count: int) -> slice:
        """Cells that count cells, one layer before, lead to; none: it ends before it begins."""
        return slice(max(at - 1, self.first[layer]), min(at + count, self.last[layer]) + 1)

    def edges_within_reach(self, layer: int, span: slice) -> Array:
        """Edges of the span's cells, the outermost cut to what is within reach."""
        edges = self.edges_rad[span.start : span.stop + 1]
        return np.clip(edges, self.low_rad[layer], self.high_rad[layer])


def _axis_cells(t_s: Array, start: AxisState, end: AxisState, limits: AxisLimits) -> _AxisCells:
    size = limits.rate_max_rad_s * float(t_s[1]) * (1.0 + OPTIONS.rounding)
    low, high = angle_tube(t_s, start, end, limits)
    below = math.ceil((start.angle_rad - low.min()) / size) + 1
    lowest = start.angle_rad - (below + 0.5) * size
    count = math.ceil((high.max() - lowest) / size) + 1
    return _AxisCells(
        edges_rad=lowest + size * np.arange(count + 1),
        start=below,
        low_rad=low - OPTIONS.rounding * size,
        high_rad=high + OPTIONS.rounding * size,
        first=np.floor((low - lowest) / size - OPTIONS.rounding).astype(int).tolist(),
        last=np.floor((high - lowest) / size + OPTIONS.rounding).astype(int).tolist(),
    )


@dataclass(frozen=True, eq=False)
class ConeOverCells:
    """A cell whose corners' cosines all reach the threshold is inside.

    counts: whether the cone does, by layer.
    coefficients: the cosine's by (1, cos, sin) of either angle, (layers, 3, 3).
    """

    coefficients: Array
    counts: Mask
    cosine_threshold: float

    def proven_inside(self, layer: int, edges_rad: Sequence[Array]) -> Mask:
        """Cells between these edges of either axis that are proven to be wholly inside."""
        outer, inner = (
            np.stack([np.ones(len(q)), np.cos(q), np.sin(q)], axis=1) for q in edges_rad
        )
        corner = outer @ self.coefficients[layer] @ inner.T >= self.cosine_threshold
        side = corner[:-1] & corner[1:]
        return np.asarray(side[:, :-1] & side[:, 1:])


def cones_over(
    view: KeepOutView, t_s: Array, outer_size_rad: float, inner_size_rad: float
) -> list[ConeOverCells]:
    """Every cone at the instants t_s, over cells of at most that size along either axis."""
    bulge = (outer_size_rad**2 + inner_size_rad**2) / 8.0
    found = []
    for cone in view.cones:
        axis, counts = cone.at(t_s)
        coefficients = cosine_coefficients(view.platform, axis).reshape(-1, 3, 3)
        found.append(ConeOverCells(coefficients, counts, math.cos(cone.half_angle_rad) + bulge))
    return found


class MasksOverCells:
    """Which cells between edges of either axis are proven to be wholly inside a mask.

    Looked for where it's asked, and once.
    """

    def __init__(self, view: KeepOutView, edges_rad: Sequence[Array]) -> None:
        self._view = view
        self._middles_rad = [(edges[:-1] + edges[1:]) / 2.0 for edges in edges_rad]
        sizes_rad = [float(edges[1] - edges[0]) for edges in edges_rad]
        self._reach_rad = sum(sizes_rad) / 2.0 * (1.0 + OPTIONS.rounding)
        shape = tuple(len(middles) for middles in self._middles_rad)
        self._is_known, self._is_inside = np.zeros(shape, dtype=bool), np.zeros(shape, dtype=bool)

    def proven_inside(self, cells: Sequence[slice]) -> Mask:
        """Which of these cells are proven to be in the cone."""
        window = tuple(cells)
        known = self._is_known[window]
        if not known.all():
            new = np.nonzero(~known)
            angle = [
                middles[span][place]
                for middles, span, place in zip(self._middles_rad, cells, new, strict=True)
            ]
            boresight = self._view.boresight(np.stack(angle, axis=1))
            inside = np.zeros(len(boresight), dtype=bool)
            for mask in self._view.masks:
                polygon = mask.polygon
                reach_rad = min(polygon.reach_rad + mask.margin_rad, math.pi)
                near = boresight @ polygon.middle_direction > math.cos(reach_rad)
                effort.charge(
                    len(near) / OPTIONS.cells_a_row
                    + near.sum() * len(polygon.corner_directions) / OPTIONS.sides_a_row
                )
                inside[near] |= mask.depth_rad(boresight[near]) > self._reach_rad
            self._is_inside[window][new] = inside
            known[new] = True
        return np.asarray(self._is_inside[window])


def with_neighbours(mask: Mask) -> Mask:
    """The cells with all eight neighbours of each, in an array larger by one cell all around."""
    rows, columns = mask.shape
    tall = np.zeros((rows + 2, columns), dtype=bool)
    grown = np.zeros((rows + 2, columns + 2), dtype=bool)
    for off in range(3):
        tall[off : off + rows] |= mask
    for off in range(3):
        grown[:, off : off + columns] |= tall
    return grown


def catching_region(
    problem: SlewProblem, view: KeepOutView, duration_s: float
) -> MovingCone | FieldMask | None:
    """Into which the motion at an end leads, which jerk limits from changing at once."""
    since_s = np.arange(
        OPTIONS.catching_step_s, min(OPTIONS.catching_s, duration_s / 2.0), OPTIONS.catching_step_s
    )
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
        catches = (view.depths_rad(t_s, angle) > reach_rad).any(axis=1)
        if catches.any():
            return view.regions[int(np.argmax(catches))]
    return None


def angle_tube(t_s: Array, start: AxisState, end: AxisState, limits: AxisLimits) -> Array:
    """Least and greatest angle at t_s, (2, k), of any motion from start to end."""
    before, after = t_s, t_s[-1] - t_s
    back = end.backwards()
    high = np.minimum(
        start.angle_rad + _farthest_up(before, start, limits),
        end.angle_rad + _farthest_up(after[::-1], back, limits)[::-1],
    )
    low = np.maximum(
        start.angle_rad - _farthest_up(before, start.mirror_image(), limits),
        end.angle_rad - _farthest_up(after[::-1], back.mirror_image(), limits)[::-1],
    )
    return np.stack([np.maximum(low, limits.angle_min_rad), np.minimum(high, limits.angle_max_rad)])


def _farthest_up(t_s: Array, state: AxisState, limits: AxisLimits) -> Array:
    """How far up it may come at t_s, sorted, of a slew that lasts to the last of them.

    Jerk brings acceleration up to its limit, and takes it back as the rate comes to its own: no
    rate is greater at any time, as acceleration is at most what can be taken back until then.
    At the end of the slew it need not be taken back any more, so that there only the rate counts.
    """
    v0, a0 = state.rate_rad_s, state.acceleration_rad_s2
    v, a, jerk = limits.rate_max_rad_s, limits.acceleration_max_rad_s2, limits.jerk_max_rad_s3
    peak = min(math.sqrt(max(jerk * (v - v0) + a0 * a0 / 2.0, 0.0)), a)
    peak = max(peak, a0)
    rising_s, falling_s = (peak - a0) / jerk, peak / jerk
    risen = v0 + rising_s * (a0 + peak) / 2.0
    holding_s = max((v - risen - peak * falling_s / 2.0) / a, 0.0) if peak == a else 0.0
    counts_s = np.minimum(t_s, max(t_s[-1] - a / jerk, 0.0))
    t = np.minimum(counts_s, rising_s)
    way = t * (v0 + t * (a0 / 2.0 + t * jerk / 6.0))
    t = np.clip(counts_s - rising_s, 0.0, holding_s)
    way += t * (risen + t * peak / 2.0)
    t = np.clip(counts_s - rising_s - holding_s, 0.0, falling_s)
    way += t * (risen + peak * holding_s + t * (peak / 2.0 - t * jerk / 6.0))
    full_s = np.maximum(counts_s - rising_s - holding_s - falling_s, 0.0)
    return np.asarray(way + v * (full_s + t_s - counts_s))
