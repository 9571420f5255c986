"""Random slews of the HRC whose straight path enters a random polygon, and a plain test of it."""

import math
from dataclasses import dataclass, replace

import numpy as np
from keep_out_cases import draw_straight, hermite
from mask_shapes import inside, mask_corners
from scipy_boresight import scipy_boresight

from planner.motion.pointing.keep_out import KeepOutView, MovingCone
from planner.motion.slew import SlewSolution
from planner.world.platforms import ISS_HRC, FieldMask


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
    straight = draw_straight(rng)
    if straight is None:
        return None
    drawn = []
    for number in range(masks):
        at_s = np.array([straight.problem.duration_s * rng.uniform(0.25, 0.75)])
        middle = scipy_boresight(straight.motion(at_s)[0])[0]
        corners = draw_corners(rng, middle)
        drawn.append(
            FieldMask(name=f"{number}", corners_platform=tuple(map(tuple, corners.tolist())))
        )
    view = KeepOutView(platform=ISS_HRC, masks=tuple(drawn))
    case = MaskCase(
        replace(straight, problem=replace(straight.problem, keep_out=view)), tuple(drawn)
    )
    _, angle, _, _ = hermite(straight)
    if case.is_entered(angle[[0, -1]]) or not case.is_entered(angle):
        return None
    return case


def ring(rng, middle, count=40):
    """Corners on a circle around something beside the middle, which is inside."""
    radius_rad = math.radians(rng.uniform(10.0, 45.0))
    off = np.cross(middle, rng.normal(size=3))
    centre = middle + rng.uniform(0.0, 0.7) * math.tan(radius_rad) * off / np.linalg.norm(off)
    centre /= np.linalg.norm(centre)
    first = np.cross(centre, off) / np.linalg.norm(np.cross(centre, off))
    clock = 2.0 * np.pi * np.arange(count)[:, None] / count
    around = np.cos(clock) * first + np.sin(clock) * np.cross(centre, first)
    return math.cos(radius_rad) * centre + math.sin(radius_rad) * around


def cone_around(case):
    """The straight slew with the smallest cone around the case's one mask in place of it."""
    polygon = case.masks[0].polygon
    cone = MovingCone(
        about="the same",
        half_angle_rad=polygon.reach_rad,
        t_s=np.linspace(0.0, case.problem.duration_s, 4),
        axis_platform=np.tile(polygon.middle_direction, (4, 1)),
        counts_rad=np.ones(4),
    )
    view = KeepOutView(platform=ISS_HRC, cones=(cone,))
    return replace(case.straight, problem=replace(case.problem, keep_out=view))
