"""Is there any way around the cones at all, and where does one lead?

Time goes in steps, and in each step an axis moves by at most one cell of its rate limit.
Cells that lie wholly inside a cone, or beyond what jerk, acceleration and rate allow between
both ends, are left out; what is not flooded from the start can't be reached by any motion.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from planner.gimbal.keep_out import KeepOutView
from planner.platforms import AxisLimits
from planner.slew.problem import AxisState, SlewProblem
from planner.slew.stops import mirrored

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
STEPS_S = (1.0, 0.5, 0.25)  # cells of 3, 1.5 and 0.75 deg at 3 deg/s
LAYERS_MIN, LAYERS_MAX = 60, 600  # 400 MB at most
CAUGHT_S, CAUGHT_STEP_S = 4.0, 0.1
SMOOTHED = 0.12  # of the duration: over so much a path of cells is averaged


@dataclass(frozen=True, kw_only=True, eq=False)
class Passage:
    """What flooding found.

    impossible: proven, no motion within the limits keeps out of the cones.
    t_s: (k,), angle_rad: (k, 2), a rough path through the middles of free cells, or None.
    """

    impossible: bool
    t_s: Array
    angle_rad: Array | None


def passage(problem: SlewProblem, view: KeepOutView, duration_s: float) -> Passage:
    """Flood the angles from start to end, in finer cells until there is an answer.

    The proof is one-sided: acceleration and jerk limits enter only through what is within reach
    of each end by itself, so that a tight slew may be impossible without being proven so.
    """
    if _caught(problem, view, duration_s):
        return Passage(impossible=True, t_s=np.empty(0), angle_rad=None)
    for step_s in STEPS_S:
        found = _flooded(problem, view, duration_s, step_s)
        if found.impossible or found.angle_rad is not None:
            break
    return found


def _flooded(
    problem: SlewProblem, view: KeepOutView, duration_s: float, longest_s: float
) -> Passage:
    layers = int(np.clip(np.ceil(duration_s / longest_s), LAYERS_MIN, LAYERS_MAX))
    t_s = np.linspace(0.0, duration_s, layers + 1)
    step_s = duration_s / layers
    sizes = [limits.rate_max_rad_s * step_s for limits in problem.limits]
    tubes = [
        _tube(t_s, start, end, limits)
        for start, end, limits in zip(problem.start, problem.end, problem.limits, strict=True)
    ]
    middles = [
        np.arange(tube[0].min(), tube[1].max() + size, size) + size / 2.0
        for tube, size in zip(tubes, sizes, strict=True)
    ]
    blocked = _blocked(view, t_s, middles, tubes, sizes)
    impossible = not _flood(blocked.possible, problem, middles)[-1].any()
    if impossible:
        return Passage(impossible=True, t_s=t_s, angle_rad=None)
    flooded = _flood(blocked.free, problem, middles)
    if not flooded[-1].any():
        return Passage(impossible=False, t_s=t_s, angle_rad=None)
    cells = _back(flooded, problem, middles)
    path = np.stack([middles[axis][cells[:, axis]] for axis in range(2)], axis=1)
    return Passage(impossible=False, t_s=t_s, angle_rad=_smoothed(path, problem))


def _caught(problem: SlewProblem, view: KeepOutView, duration_s: float) -> bool:
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


@dataclass(frozen=True, eq=False)
class _Blocked:
    """possible: cells not wholly inside a cone.  free: cells whose middle is outside.

    Both (layers + 1, a, b), and within reach of both ends.
    """

    possible: Mask
    free: Mask


def _blocked(
    view: KeepOutView, t_s: Array, middles: list[Array], tubes: list[Array], sizes: list[float]
) -> _Blocked:
    first, second = np.meshgrid(*middles, indexing="ij")
    angles = np.stack([first.ravel(), second.ravel()], axis=1)
    boresight = view.boresight(angles)
    # Near the outer axis a turn about it hardly moves the boresight.
    outer = view.platform.axes_platform[0]
    off_axis = np.linalg.norm(np.cross(outer, boresight), axis=1) + sizes[1] / 2.0
    radius_rad = (sizes[0] * np.minimum(off_axis, 1.0) + sizes[1]).reshape(first.shape) / 2.0
    shape = (len(t_s), *first.shape)
    possible, free = np.ones(shape, dtype=bool), np.ones(shape, dtype=bool)
    for cone in view.cones:
        axes, counts = cone.at(t_s)
        wholly = cone.half_angle_rad > radius_rad
        inside = np.where(wholly, np.cos(cone.half_angle_rad - radius_rad), 2.0)
        edge = np.cos(cone.half_angle_rad)
        for layer in np.flatnonzero(counts):
            cosine = (boresight @ axes[layer]).reshape(first.shape)
            possible[layer] &= cosine < inside
            free[layer] &= cosine < edge
    for axis, (middle, tube, size) in enumerate(zip(middles, tubes, sizes, strict=True)):
        overlaps = (middle + size / 2.0 >= tube[0][:, None]) & (
            middle - size / 2.0 <= tube[1][:, None]
        )
        spread = overlaps[:, :, None] if axis == 0 else overlaps[:, None, :]
        possible &= spread
        free &= spread
    return _Blocked(possible, free)


def _tube(t_s: Array, start: AxisState, end: AxisState, limits: AxisLimits) -> Array:
    """Least and greatest angle at t_s, (2, k), of any motion from start to end."""
    before, after = t_s, t_s[-1] - t_s
    back = end.reversed()
    high = np.minimum(
        start.angle_rad + _farthest(before, start, limits),
        end.angle_rad + _farthest(after, back, limits),
    )
    low = np.maximum(
        start.angle_rad - _farthest(before, mirrored(start), limits),
        end.angle_rad - _farthest(after, mirrored(back), limits),
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


def _smoothed(path: Array, problem: SlewProblem) -> Array:
    width = max(round(SMOOTHED * len(path)) // 2, 1)
    ends = [np.array([axis.angle_rad for axis in side]) for side in (problem.start, problem.end)]
    padded = np.concatenate([np.tile(ends[0], (width, 1)), path, np.tile(ends[1], (width, 1))])
    kernel = np.ones(2 * width + 1) / (2 * width + 1)
    return np.stack([np.convolve(padded[:, axis], kernel, "valid") for axis in range(2)], axis=1)
