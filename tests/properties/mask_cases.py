"""Random slews of the HRC whose straight path enters a random polygon, and a plain test of it."""

import math
from dataclasses import dataclass, replace

import numpy as np
from keep_out_cases import LIMITS, hermite
from scipy_boresight import scipy_boresight

from planner.errors import InfeasibleSlew
from planner.platforms import ISS_HRC, FieldMask
from planner.pointing.keep_out import KeepOutView
from planner.slew import AxisState, SlewProblem, SlewSolution, fit_to_rows, next_duration_s, optimal_slew


def star(rng, middle, size_rad, count):
    """Corners around a middle, by no more than two thirds of a half turn from one to the next."""
    shares = rng.dirichlet(np.full(count, 4.0))
    while shares.max() > 1.0 / 3.0:
        shares = rng.dirichlet(np.full(count, 4.0))
    clock = 2.0 * np.pi * np.cumsum(shares)
    away = size_rad * rng.uniform(0.3, 1.0, count)
    first = np.cross(middle, rng.normal(size=3))
    first /= np.linalg.norm(first)
    second = np.cross(middle, first)
    return (
        np.cos(away)[:, None] * middle
        + (np.sin(away) * np.cos(clock))[:, None] * first
        + (np.sin(away) * np.sin(clock))[:, None] * second
    )


def boom(rng, middle, half_length_rad, half_width_rad):
    """A thin quadrilateral."""
    along = np.cross(middle, rng.normal(size=3))
    along /= np.linalg.norm(along)
    across = np.cross(middle, along)
    u, v = math.tan(half_length_rad), math.tan(half_width_rad)
    corners = [middle + a * u * along + b * v * across for a, b in ((1, 1), (-1, 1), (-1, -1), (1, -1))]
    return np.array([corner / np.linalg.norm(corner) for corner in corners])


def inside(corners, directions):
    """Whether unit vectors (n, 3) are: the corners wind around them.

    The sum of the angles at which each side is seen; a polygon seen from behind winds too.
    """
    total = np.zeros(len(directions))
    for first, second in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        a, b = np.cross(directions, first), np.cross(directions, second)
        total += np.arctan2(directions @ np.cross(first, second), np.sum(a * b, axis=1))
    return (np.abs(total) > np.pi) & (directions @ corners.sum(axis=0) > 0.0)


def away_rad(corners, directions, steps=2000):
    """Distance of unit vectors (n, 3) from the sides, by points along them: too large by the square
    of half a point's distance over twice the distance, at most."""
    share = np.linspace(0.0, 1.0, steps + 1)[:, None]
    sides = zip(corners, np.roll(corners, -1, axis=0), strict=True)
    points = np.concatenate([(1.0 - share) * a + share * b for a, b in sides])
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    chord = np.array([np.linalg.norm(points - one, axis=1).min() for one in directions])
    return 2.0 * np.arcsin(chord / 2.0)


@dataclass(frozen=True)
class MaskCase:
    """straight: flown as if there were no mask."""

    straight: SlewSolution
    masks: tuple[FieldMask, ...]

    @property
    def problem(self):
        return self.straight.problem

    def is_entered(self, angle_rad):
        boresight = scipy_boresight(angle_rad)
        return any(inside(mask_corners(mask), boresight).any() for mask in self.masks)


def mask_corners(mask):
    corners = np.array(mask.corners_platform)
    return corners / np.linalg.norm(corners, axis=1, keepdims=True)


def draw_mask_cases(seed, count, draw_corners, masks=1):
    """draw_corners: of a mask about a direction on the straight path, by a generator and it."""
    rng = np.random.default_rng(seed)
    drawn = 0
    while drawn < count:
        case = _drawn(rng, draw_corners, masks)
        if case is not None:
            drawn += 1
            yield case


def _drawn(rng, draw_corners, masks):
    def state():
        return AxisState(
            angle_rad=math.radians(rng.uniform(-170.0, 170.0)),
            rate_rad_s=math.radians(rng.uniform(-1.0, 1.0)),
        )

    start, end = (state(), state()), (state(), state())
    least_s = [next_duration_s(a, b, LIMITS, 0.0) for a, b in zip(start, end, strict=True)]
    if None in least_s:
        return None
    duration_s = math.ceil(max(least_s) * rng.uniform(1.2, 3.0) * 5.0) / 5.0
    problem = SlewProblem(
        axis_names=ISS_HRC.axis_names,
        limits=ISS_HRC.axis_limits,
        start=start,
        end=end,
        duration_s=duration_s,
    )
    try:
        straight = fit_to_rows(optimal_slew(problem))
    except InfeasibleSlew:
        return None
    drawn = []
    for number in range(masks):
        at_s = np.array([duration_s * rng.uniform(0.25, 0.75)])
        middle = scipy_boresight(straight.motion(at_s)[0])[0]
        corners = draw_corners(rng, middle)
        drawn.append(FieldMask(name=f"{number}", corners_platform=tuple(map(tuple, corners.tolist()))))
    view = KeepOutView(platform=ISS_HRC, masks=tuple(drawn))
    case = MaskCase(replace(straight, problem=replace(problem, keep_out=view)), tuple(drawn))
    _, angle, _, _ = hermite(straight)
    if case.is_entered(angle[[0, -1]]) or not case.is_entered(angle):
        return None
    return case
