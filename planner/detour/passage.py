"""Where may a way around the cones lead, roughly?

Time goes in steps, and in each step an axis moves by at most one cell of its rate limit.
Cells whose middle lies inside a cone, or that are out of reach from either end, are left out.
"""

import numpy as np
from numpy.typing import NDArray

from planner.arrays import Array
from planner.detour.barrier import tube
from planner.pointing.keep_out import KeepOutView
from planner.slew.problem import AxisState, SlewProblem

Mask = NDArray[np.bool_]
STEPS_S = (1.0, 0.5, 0.25)  # cells of 3, 1.5 and 0.75 deg at 3 deg/s
LAYERS_MIN, LAYERS_MAX = 60, 600  # 200 MB at most
SMOOTHED = (0.12, 0.04)  # of the duration: over so much a path of cells is averaged


def rough_paths(
    problem: SlewProblem, view: KeepOutView, duration_s: float
) -> tuple[Array, tuple[Array, ...]]:
    """Times (k,), and one way through the middles of free cells, smoothed more and less.

    The paths are (k, 2) each, none where the finest cells leave no way.
    """
    for step_s in STEPS_S:
        t_s, paths = _flooded(problem, view, duration_s, step_s)
        if paths:
            break
    return t_s, paths


def _flooded(
    problem: SlewProblem, view: KeepOutView, duration_s: float, longest_s: float
) -> tuple[Array, tuple[Array, ...]]:
    layers = int(np.clip(np.ceil(duration_s / longest_s), LAYERS_MIN, LAYERS_MAX))
    t_s = np.linspace(0.0, duration_s, layers + 1)
    step_s = duration_s / layers
    sizes = [limits.rate_max_rad_s * step_s for limits in problem.limits]
    tubes = [
        tube(t_s, start, end, limits)
        for start, end, limits in zip(problem.start, problem.end, problem.limits, strict=True)
    ]
    middles = [
        np.arange(reach[0].min(), reach[1].max() + size, size) + size / 2.0
        for reach, size in zip(tubes, sizes, strict=True)
    ]
    flooded = _flood(_free(view, t_s, middles, tubes, sizes), problem, middles)
    if not flooded[-1].any():
        return t_s, ()
    cells = _back(flooded, problem, middles)
    path = np.stack([middles[axis][cells[:, axis]] for axis in range(2)], axis=1)
    return t_s, tuple(_smoothed(path, problem, share) for share in SMOOTHED)


def _free(
    view: KeepOutView, t_s: Array, middles: list[Array], tubes: list[Array], sizes: list[float]
) -> Mask:
    """Cells within reach of both ends whose middle is outside, (layers + 1, a, b)."""
    first, second = np.meshgrid(*middles, indexing="ij")
    boresight = view.boresight(np.stack([first.ravel(), second.ravel()], axis=1))
    free = np.ones((len(t_s), *first.shape), dtype=bool)
    for cone in view.cones:
        axes, counts = cone.at(t_s)
        edge = np.cos(cone.half_angle_rad)
        for layer in np.flatnonzero(counts):
            free[layer] &= (boresight @ axes[layer]).reshape(first.shape) < edge
    for axis, (middle, reach, size) in enumerate(zip(middles, tubes, sizes, strict=True)):
        overlaps = (middle + size / 2.0 >= reach[0][:, None]) & (
            middle - size / 2.0 <= reach[1][:, None]
        )
        free &= overlaps[:, :, None] if axis == 0 else overlaps[:, None, :]
    return free


def _cell(state: tuple[AxisState, ...], middles: list[Array]) -> tuple[int, int]:
    nearest = [
        int(np.argmin(np.abs(middle - axis.angle_rad)))
        for axis, middle in zip(state, middles, strict=True)
    ]
    return nearest[0], nearest[1]


def _flood(allowed: Mask, problem: SlewProblem, middles: list[Array]) -> Mask:
    """Cells reached in each layer; in the last one the end's own, if reached."""
    flooded = np.zeros_like(allowed)
    flooded[(0, *_cell(problem.start, middles))] = True
    for layer in range(1, len(allowed)):
        flooded[layer] = _grown(flooded[layer - 1]) & allowed[layer]
    end = _cell(problem.end, middles)
    reached = bool(_grown(flooded[-2])[end])
    flooded[-1] = False
    flooded[(-1, *end)] = reached
    return flooded


def _grown(mask: Mask) -> Mask:
    """With all eight neighbours."""
    grown = mask.copy()
    grown[1:] |= mask[:-1]
    grown[:-1] |= mask[1:]
    wide = grown.copy()
    wide[:, 1:] |= grown[:, :-1]
    wide[:, :-1] |= grown[:, 1:]
    return wide


def _back(flooded: Mask, problem: SlewProblem, middles: list[Array]) -> NDArray[np.intp]:
    """From the end back to the start, evenly where nothing is in the way: cells (k, 2)."""
    start = np.array(_cell(problem.start, middles))
    cells = np.empty((len(flooded), 2), dtype=np.intp)
    cells[-1] = _cell(problem.end, middles)
    around = np.array([(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1)])
    here = cells[-1].astype(float)
    for layer in range(len(flooded) - 2, -1, -1):
        wanted = here + (start - here) / (layer + 1)
        near = cells[layer + 1] + around
        near = near[(near >= 0).all(axis=1) & (near < flooded.shape[1:]).all(axis=1)]
        near = near[flooded[layer, near[:, 0], near[:, 1]]]
        cells[layer] = near[np.argmin(np.sum((near - wanted) ** 2, axis=1))]
        off = np.abs(wanted - cells[layer]).max() <= 1.0
        here = wanted if off else cells[layer].astype(float)
    return cells


def _smoothed(path: Array, problem: SlewProblem, share: float) -> Array:
    width = max(round(share * len(path)) // 2, 1)
    ends = [np.array([axis.angle_rad for axis in side]) for side in (problem.start, problem.end)]
    padded = np.concatenate([np.tile(ends[0], (width, 1)), path, np.tile(ends[1], (width, 1))])
    kernel = np.ones(2 * width + 1) / (2 * width + 1)
    return np.stack([np.convolve(padded[:, axis], kernel, "valid") for axis in range(2)], axis=1)
