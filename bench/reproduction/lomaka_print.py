"""The paper's experiment on the bench: a flat picture of the horizon before a tilting camera.

A rig carries camera and accelerometer and is turned about a nearly level axis in front of a print
or a screen.  What the camera finds for the tilt is compared with what the accelerometer says, both
zeroed upright.  Lengths are in distances from which the flat picture's perspective is right.
Source: Lomaka, Ustyugov 2016, p. 468-469; all sizes are assumed, the paper gives none.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from planner.base.arrays import Array
from reproduction.lomaka_geometry import dip_rad, limb_rays, longest_run

HEIGHT_M = 500e3
HALF_WIDTH, HALF_HEIGHT = np.tan(np.deg2rad(30.0)), 0.75 * np.tan(np.deg2rad(30.0))
WIDTH_PX = 640
TILTS_DEG = np.linspace(-14.0, 14.0, 29)
SWING_S = 20.0  # of a full swing to both sides, during which the video runs
UPRIGHT = len(TILTS_DEG) // 2


@dataclass(frozen=True, kw_only=True)
class Rig:
    """What is not as it should be; all zeros (distance 1) is a perfect one.

    distance: of the camera, by that from which the picture's perspective is right.
    off_square_deg: of the print, about the upright axis through its middle.
    leaning_deg: of the print, about the level axis through its middle.
    off_middle: how far below the frame's middle the horizon is, by half the frame's height.
    axis_off_deg: of the axis of tilt from the optical axis, sideways.
    pivot_below: the axis passes so far below the lens.
    distortion: of the lens, at the frame's corner, by the distance from the middle.
    whole_px: whether the arc's ends are whole pixels of a frame 640 wide.
    edge_noise_px: 1-sigma of each end.
    scale_error: of the accelerometer's sideways channel.  quantum_g, noise_g: of a sample.
    delay_s: of the video behind the accelerometer, during the swing.
    """

    distance: float = 1.0
    off_square_deg: float = 0.0
    leaning_deg: float = 0.0
    off_middle: float = 0.0
    axis_off_deg: float = 0.0
    pivot_below: float = 0.0
    distortion: float = 0.0
    whole_px: bool = False
    edge_noise_px: float = 0.0
    scale_error: float = 0.0
    quantum_g: float = 0.0
    noise_g: float = 0.0
    delay_s: float = 0.0


def horizon_print(count: int = 1600) -> Array:
    """Points (n, 2) of the horizon on the print: seen from 500 km, its top in the middle.

    x to the right, y down, in distances; it goes on beyond what the camera sees at first.
    """
    dip = dip_rad(HEIGHT_M)
    # The optical axis (+z) points at the horizon, nadir is mostly down (+y).
    rays = limb_rays(np.array([0.0, np.cos(dip), np.sin(dip)]), HEIGHT_M)
    ahead = rays[rays[:, 2] > 0.25]
    flat = ahead[:, :2] / ahead[:, 2:]
    order = np.argsort(flat[:, 0])
    # Close together in the middle, where most rigs see it.
    x = 3.6 * np.sinh(np.linspace(-3.0, 3.0, count)) / np.sinh(3.0)
    return np.column_stack([x, np.interp(x, flat[order, 0], flat[order, 1])])


def seen(print_xy: Array, rig: Rig, tilt_rad: float) -> Array:
    """Where the camera sees points (n, 2) of the print, on its own plane at unit depth, (n, 2)."""
    plane = Rotation.from_euler("yx", [rig.off_square_deg, rig.leaning_deg], degrees=True)
    point = plane.apply(np.column_stack([print_xy, np.zeros(len(print_xy))]))
    point += [0.0, rig.off_middle * HALF_HEIGHT * rig.distance, rig.distance]
    off = np.deg2rad(rig.axis_off_deg)
    turn = Rotation.from_rotvec(tilt_rad * np.array([np.sin(off), 0.0, np.cos(off)]))
    pivot = np.array([0.0, rig.pivot_below, 0.0])
    lens_at = pivot - turn.apply(pivot)
    x, y, z = turn.inv().apply(point - lens_at).T
    flat = np.column_stack([x, y]) / z[:, None]
    far2 = np.sum(flat**2, axis=1, keepdims=True) / (HALF_WIDTH**2 + HALF_HEIGHT**2)
    return np.asarray(flat * (1.0 + rig.distortion * far2))


def found_tilt_rad(
    print_xy: Array, rig: Rig, tilt_rad: float, unit_rays: bool, random: np.random.Generator
) -> float:
    """The tilt the camera finds by the chord of the arc in its frame; NaN without one."""
    flat = seen(print_xy, rig, tilt_rad)
    inside = (np.abs(flat[:, 0]) <= HALF_WIDTH) & (np.abs(flat[:, 1]) <= HALF_HEIGHT)
    run = longest_run(inside)
    if len(run) < 2:
        return float("nan")
    ends = flat[run[[0, -1]]]
    pixel = 2.0 * HALF_WIDTH / WIDTH_PX
    ends = ends + rig.edge_noise_px * pixel * random.standard_normal((2, 2))
    if rig.whole_px:
        ends = np.rint(ends / pixel) * pixel
    if not unit_rays:
        x, y = ends[1] - ends[0]
        return -float(np.arctan2(y, x))
    rays = np.column_stack([ends, np.ones(2)])
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    x, y, z = rays[1] - rays[0]
    # Square to the nadir [-sin, cos] cos(dip) + [0, 0, sin(dip)], the camera looking at the
    # horizon as it believes.
    lift = np.arcsin(np.clip(z * np.tan(dip_rad(HEIGHT_M)) / np.hypot(x, y), -1.0, 1.0))
    return -float(np.arctan2(y, x) + lift)


def told_tilt_rad(tilt_rad: Array, rig: Rig, random: np.random.Generator) -> Array:
    """What the accelerometer tells at tilts (n,), from both its channels."""
    g = np.stack([np.sin(tilt_rad) * (1.0 + rig.scale_error), np.cos(tilt_rad)])
    g = g + rig.noise_g * random.standard_normal(g.shape)
    if rig.quantum_g > 0.0:
        g = np.rint(g / rig.quantum_g) * rig.quantum_g
    return np.asarray(np.arctan2(g[0], g[1]))


def differences_deg(rig: Rig, *, unit_rays: bool, seed: int = 0) -> Array:
    """Camera minus accelerometer over TILTS_DEG, both zeroed upright."""
    random = np.random.default_rng(seed)
    tilt_rad = np.deg2rad(TILTS_DEG)
    # A swing about its middle: fast upright, at rest at the ends.
    rate_rad_s = 2.0 * np.pi / SWING_S * np.sqrt(tilt_rad[-1] ** 2 - tilt_rad**2)
    print_xy = horizon_print()
    found_rad = np.array(
        [
            found_tilt_rad(print_xy, rig, float(late_rad), unit_rays, random)
            for late_rad in tilt_rad - rate_rad_s * rig.delay_s
        ]
    )
    upright = replace(rig, noise_g=0.0, edge_noise_px=0.0, whole_px=False)
    zero_found = found_tilt_rad(print_xy, upright, 0.0, unit_rays, random)
    zero_told = told_tilt_rad(np.zeros(1), upright, random)[0]
    told_rad = told_tilt_rad(tilt_rad, rig, random)
    return np.asarray(np.rad2deg((found_rad - zero_found) - (told_rad - zero_told)))


def rms_deg(rig: Rig, *, unit_rays: bool, seed: int = 0) -> float:
    """Root mean square of `differences_deg`."""
    return float(np.sqrt(np.nanmean(differences_deg(rig, unit_rays=unit_rays, seed=seed) ** 2)))
