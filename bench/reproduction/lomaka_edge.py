"""Limits of the paper's method (tilt, altitude, length of the arc), and sources of its errors."""

import numpy as np
from scipy.optimize import linprog

from estimator.camera import HorizonCamera
from planner.base.arrays import Array
from reproduction.lomaka_geometry import (
    RADIUS_M,
    arc_px,
    dip_rad,
    lens,
    limb_rays,
    nadir_error_deg,
    roll_error_deg,
    tilted_nadir,
)

MAP_DEG = np.arange(-30.0, 31.0, 3.0)
ROLLS_DEG = np.arange(-14.0, 14.1, 0.5)
PAPERS_HEIGHT_M = 500e3  # ours: the paper names none


def pair(width_deg: float, down_deg: float) -> tuple[HorizonCamera, HorizonCamera]:
    """Two cameras at right angles, each so far below the level (the paper's: 0)."""
    return lens(width_deg, 640, down_deg, 0.0), lens(width_deg, 640, down_deg, 90.0)


def error_map_deg(
    cameras: tuple[HorizonCamera, HorizonCamera], *, unit_rays: bool, whole_px: bool
) -> Array:
    """Errors of the exact arcs' chords over MAP_DEG of yaw (rows) and pitch, at 500 km."""
    return np.array(
        [
            [
                nadir_error_deg(
                    cameras,
                    tilted_nadir(pitch, yaw),
                    PAPERS_HEIGHT_M,
                    unit_rays=unit_rays,
                    whole_px=whole_px,
                )
                for pitch in MAP_DEG
            ]
            for yaw in MAP_DEG
        ]
    )


def model_rms_deg(
    width_deg: float, height_m: float, *, unit_rays: bool, width_px: int = 640
) -> float:
    """Of one camera's pitch over +-14 deg, the horizon in the middle, ends in whole pixels."""
    return _rms(lens(width_deg, width_px, np.rad2deg(dip_rad(height_m)), 0.0), height_m, unit_rays)


def strip_rms_deg(arc_width_px: int) -> float:
    """The same between unit rays of an arc so short in a frame 640 px and 60 deg wide."""
    width_deg = np.rad2deg(2.0 * np.arctan(arc_width_px / 640.0 * np.tan(np.deg2rad(30.0))))
    down_deg = np.rad2deg(dip_rad(PAPERS_HEIGHT_M))
    return _rms(lens(width_deg, arc_width_px, down_deg, 0.0), PAPERS_HEIGHT_M, True)


def _rms(one: HorizonCamera, height_m: float, unit_rays: bool) -> float:
    """Over ROLLS_DEG about the boresight, about which the chord measures."""
    errors = [
        roll_error_deg(
            one,
            _turned(one.boresight_body, float(roll)),
            height_m,
            unit_rays=unit_rays,
            whole_px=True,
        )
        for roll in np.deg2rad(ROLLS_DEG)
    ]
    return float(np.sqrt(np.mean(np.square(errors))))


def _turned(axis: Array, angle: float) -> Array:
    nadir, c, s = np.array([0.0, 0.0, 1.0]), np.cos(angle), np.sin(angle)
    return np.asarray(c * nadir + s * np.cross(axis, nadir) + (1.0 - c) * (axis @ nadir) * axis)


def edge_deg(width_deg: float, down_deg: float, height_m: float) -> float:
    """The smallest pitch, either way, at which one of both cameras has lost the horizon."""
    cameras = pair(width_deg, down_deg)
    edges = []
    for sign in (-1.0, 1.0):
        low, high = 0.0, next(t for t in range(1, 61) if not _both_see(cameras, sign * t, height_m))
        while high - low > 1e-3:
            middle = 0.5 * (low + high)
            seen = _both_see(cameras, sign * middle, height_m)
            low, high = (middle, high) if seen else (low, middle)
        edges.append(high)
    return min(edges)


def _both_see(cameras: tuple[HorizonCamera, HorizonCamera], pitch: float, height_m: float) -> bool:
    """Is there a point of the horizon on both cameras' pixels, their outer edges included?"""
    rays = limb_rays(tilted_nadir(pitch, 0.0), height_m)
    for one in cameras:
        off_px = np.abs(one.pixels(rays) - [one.cx_px, one.cy_px])
        if not np.any(np.all(off_px <= [0.5 * one.width_px, 0.5 * one.height_px], axis=1)):
            return False
    return True


def highest_m(width_deg: float) -> float:
    """From where level cameras of the paper's arrangement see no horizon at zero tilt."""
    half_height = np.arctan(0.75 * np.tan(np.deg2rad(0.5 * width_deg)))
    return float(RADIUS_M / np.cos(half_height) - RADIUS_M)


def circle_misfit_px(width_deg: float) -> float:
    """Most that the horizon's arc in the middle of a frame departs from the circle nearest to it.

    Gauss-Newton in the largest departure: each step is a linear programme in the circle's changes.
    """
    one = lens(width_deg, 640, np.rad2deg(dip_rad(PAPERS_HEIGHT_M)), 0.0)
    arc = arc_px(one, np.array([0.0, 0.0, 1.0]), PAPERS_HEIGHT_M)
    design = np.column_stack([2.0 * arc, np.ones(len(arc))])
    x, y, rest = np.linalg.lstsq(design, np.sum(arc**2, axis=1), rcond=None)[0]
    circle = np.array([x, y, np.sqrt(rest + x * x + y * y)])
    for _ in range(8):
        away = arc - circle[:2]
        distance = np.hypot(*away.T)
        off = distance - circle[2]
        slope = np.column_stack([-away / distance[:, None], -np.ones(len(arc))])
        bound = -np.ones((2 * len(arc), 1))
        rows = np.hstack([np.vstack([slope, -slope]), bound])
        step = linprog([0, 0, 0, 1], rows, np.append(-off, off), bounds=(None, None)).x
        circle += step[:3]
    return float(np.max(np.abs(np.hypot(*(arc - circle[:2]).T) - circle[2])))
