"""Rough ways around cones and masks, through cells of the angles.

Time goes in steps, and in each step an axis moves by at most one cell of its rate limit.
Cells whose middle lies inside a cone, that are as near to a mask as half their size, or that are
out of reach from either end, are left out: a mask may be a boom thinner than a cell.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from planner.base import effort
from planner.base.arrays import Array
from planner.motion.detour.infeasibility_proof import Mask, angle_tube, with_neighbours
from planner.motion.pointing.keep_out import KeepOutView
from planner.motion.slew.problem import AxisState, SlewProblem


@dataclass(frozen=True, kw_only=True)
class PassageOptions:
    """How finely ways through the cells between cones are sought."""

    steps_s: tuple[float, ...] = (1.0, 0.5, 0.25)  # cells of 3, 1.5 and 0.75 deg at 3 deg/s
    layers_min: int = 60  # of a short slew
    layers_max: int = 600  # 200 MB at most
    layer: int = 5  # of `effort`: a layer, and
    cells_a_row: int = 2_000  # so many of its cells as one
    sides_a_row: int = 200  # of masks beside a cell, for one of `effort`
    # of the duration: over so much a path of cells is averaged
    smoothing_shares: tuple[float, ...] = (0.12, 0.04)


OPTIONS = PassageOptions()


def rough_paths(
    problem: SlewProblem, view: KeepOutView, duration_s: float
) -> tuple[Array, tuple[Array, ...]]:
    """Times (k,), and one way through the middles of free cells, smoothed more and less.

    The paths are angles (k, 2) each, none where the finest cells leave no way.
    """
    for step_s in OPTIONS.steps_s:
        t_s, paths_rad = _paths_in_cells(problem, view, duration_s, step_s)
        if paths_rad:
            break
    return t_s, paths_rad


class _AxisGrid(NamedTuple):
    """middles_rad: of k cells.  within_reach: the cells to look at, by layer."""

    size_rad: float
    middles_rad: Array
    within_reach: list[slice]


def _paths_in_cells(
    problem: SlewProblem, view: KeepOutView, duration_s: float, longest_s: float
) -> tuple[Array, tuple[Array, ...]]:
    layers = int(np.clip(np.ceil(duration_s / longest_s), OPTIONS.layers_min, OPTIONS.layers_max))
    t_s = np.linspace(0.0, duration_s, layers + 1)
    axes = []
    for start, end, limits in zip(problem.start, problem.end, problem.limits, strict=True):
        size, (least, most) = limits.rate_max_rad_s * t_s[1], angle_tube(t_s, start, end, limits)
        edges = np.arange(least.min(), most.max() + 2.0 * size, size)
        first, stop = np.searchsorted(edges[1:], least), np.searchsorted(edges[:-1], most, "right")
        windows = list(map(slice, first, np.maximum(first, stop)))
        axes.append(_AxisGrid(size, edges[:-1] + size / 2.0, windows))
    start_cell, end_cell = _cell_at(problem.start, axes), _cell_at(problem.end, axes)
    flooded = _flood_cells(view, t_s, axes, start_cell, end_cell)
    if not flooded[-1].any():
        return t_s, ()
    cells = _trace_back(flooded, start_cell, end_cell)
    path = np.stack([axes[axis].middles_rad[cells[:, axis]] for axis in range(2)], axis=1)
    return t_s, tuple(_smooth_path(path, problem, share) for share in OPTIONS.smoothing_shares)


def _cell_at(state: tuple[AxisState, ...], axes: list[_AxisGrid]) -> tuple[int, ...]:
    return tuple(
        int(np.argmin(np.abs(cells.middles_rad - axis.angle_rad)))
        for axis, cells in zip(state, axes, strict=True)
    )


def _flood_cells(
    view: KeepOutView,
    t_s: Array,
    axes: list[_AxisGrid],
    start_cell: tuple[int, ...],
    end_cell: tuple[int, ...],
) -> Mask:
    """Cells reached, (layers + 1, a, b); in the last layer the end's own, if reached.

    Each is within reach of both ends, outside the cones and off the masks.
    """
    first, second = np.meshgrid(*(axis.middles_rad for axis in axes), indexing="ij")
    boresight = view.boresight(np.stack([first.ravel(), second.ravel()], axis=1))
    boresight = boresight.reshape(*first.shape, 3)
    cones = [(*cone.at(t_s), np.cos(cone.half_angle_rad)) for cone in view.cones]
    is_open = _off_masks(view, boresight, math.hypot(*(axis.size_rad / 2.0 for axis in axes)))
    flooded = np.zeros((len(t_s), *first.shape), dtype=bool)
    flooded[(0, *start_cell)] = True
    for layer in range(1, len(t_s)):
        window = tuple(axis.within_reach[layer] for axis in axes)
        around = tuple(slice(max(one.start - 1, 0), one.stop + 1) for one in window)
        inside = tuple(
            slice(one.start - wide.start, one.stop - wide.start)
            for one, wide in zip(window, around, strict=True)
        )
        near = with_neighbours(flooded[layer - 1][around])[1:-1, 1:-1]
        reached = near[inside] & is_open[window]
        effort.charge(OPTIONS.layer + reached.size * (1 + len(cones)) / OPTIONS.cells_a_row)
        for towards, counts, edge in cones:
            if counts[layer]:
                reached &= boresight[window] @ towards[layer] < edge
        flooded[layer][window] = reached
    reached_end = bool(with_neighbours(flooded[-2])[1:-1, 1:-1][end_cell])
    flooded[-1] = False
    flooded[(-1, *end_cell)] = reached_end
    return flooded


def _off_masks(view: KeepOutView, boresight_platform: Array, apart_rad: float) -> Mask:
    """Which of unit vectors (a, b, 3) are so far from every mask."""
    found = np.ones(boresight_platform.shape[:2], dtype=bool)
    for mask in view.masks:
        polygon = mask.polygon
        reach_rad = min(polygon.reach_rad + mask.margin_rad + apart_rad, math.pi)
        near = boresight_platform @ polygon.middle_direction > math.cos(reach_rad)
        effort.charge(
            near.size / OPTIONS.cells_a_row
            + near.sum() * len(polygon.corner_directions) / OPTIONS.sides_a_row
        )
        found[near] &= mask.depth_rad(boresight_platform[near]) < -apart_rad
    return found


def _trace_back(
    flooded: Mask, start_cell: tuple[int, ...], end_cell: tuple[int, ...]
) -> NDArray[np.intp]:
    """The path from the end back to the start, evenly where nothing is in the way: cells (k, 2)."""
    start = np.array(start_cell)
    cells = np.empty((len(flooded), 2), dtype=np.intp)
    cells[-1] = end_cell
    around = np.array([(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1)])
    here = cells[-1].astype(float)
    for layer in range(len(flooded) - 2, -1, -1):
        wanted = here + (start - here) / (layer + 1)
        near = cells[layer + 1] + around
        near = near[(near >= 0).all(axis=1) & (near < flooded.shape[1:]).all(axis=1)]
        near = near[flooded[layer, near[:, 0], near[:, 1]]]
        cells[layer] = near[np.argmin(np.sum((near - wanted) ** 2, axis=1))]
        is_close = np.abs(wanted - cells[layer]).max() <= 1.0
        here = wanted if is_close else cells[layer].astype(float)
    return cells


def _smooth_path(path_rad: Array, problem: SlewProblem, share: float) -> Array:
    width = max(round(share * len(path_rad)) // 2, 1)
    ends = [np.array([axis.angle_rad for axis in side]) for side in (problem.start, problem.end)]
    padded = np.concatenate([np.tile(ends[0], (width, 1)), path_rad, np.tile(ends[1], (width, 1))])
    kernel = np.ones(2 * width + 1) / (2 * width + 1)
    return np.stack([np.convolve(padded[:, axis], kernel, "valid") for axis in range(2)], axis=1)
