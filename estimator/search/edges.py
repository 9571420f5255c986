"""Pixels of a frame that may lie on the limb: edges, bright on one side, dark beyond.

Source: Canny 1986 for the edges.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from estimator.camera import HorizonCamera
from estimator.images import Frame, Grey
from planner.base.arrays import Array

_WORK_SIDE_PX = 640
_MOST_EDGES = 500
_TO_SHORT = 4000.0  # full scale as 16-bit integers: Canny takes its gradients in those
_BEYOND_PX = (5.0, 9.0, 14.0)
_WITHIN_PX = (4.0, 7.0)


@dataclass(frozen=True)
class Edges:
    """Edge rays (n, 3): unit vectors in body axes.

    inward_body (n, 3): on the sphere of directions, across the edge to its bright side.
    weight (n,): 0..1, how dark it is beyond against within.
    """

    ray_body: Array
    inward_body: Array
    weight: Array

    def __len__(self) -> int:
        return len(self.weight)

    def at(self, index: NDArray[np.intp]) -> "Edges":
        return Edges(self.ray_body[index], self.inward_body[index], self.weight[index])


def find_edges(frame: Frame, camera: HorizonCamera, seed: int) -> Edges:
    """Up to 500 edges of a frame, the ones dark beyond drawn first."""
    shrink_factor = max(1.0, max(frame.grey.shape) / _WORK_SIDE_PX)
    small, usable = _shrink(frame, shrink_factor)
    bright = float(np.percentile(small[::3, ::3], 99.5))
    dark = float(np.percentile(small[::3, ::3], 1.0))
    if bright - dark < 3.0 * frame.step:
        return _NO_EDGES
    # The square root evens out shot noise and lifts a dim limb against lit clouds.
    level = np.sqrt(np.clip((small - dark) / (bright - dark), 0.0, 1.5))
    level = cv2.GaussianBlur(level, (0, 0), 1.5) * np.float32(_TO_SHORT)
    dx = cv2.Sobel(level, cv2.CV_32F, 1, 0)
    dy = cv2.Sobel(level, cv2.CV_32F, 0, 1)
    high = max(10.0 * _noise(level), 0.06 * _TO_SHORT)
    short = [np.clip(np.rint(d), -32767, 32767).astype(np.int16) for d in (dx, dy)]
    edge = cv2.Canny(short[0], short[1], 0.4 * high, high, L2gradient=True)
    edge[~cv2.erode(usable, np.ones((9, 9), np.uint8)).astype(bool)] = 0
    edge[:3], edge[-3:], edge[:, :3], edge[:, -3:] = 0, 0, 0, 0
    y, x = np.nonzero(edge)
    if len(x) < 8:
        return _NO_EDGES
    at_px = np.stack([x, y], axis=1)
    inward_unit = np.stack([dx[y, x], dy[y, x]], axis=1).astype(float)
    inward_unit /= np.linalg.norm(inward_unit, axis=1, keepdims=True)
    weight = _darkness_beyond(level, at_px, inward_unit)
    rng = np.random.default_rng(seed)
    chance = weight**2 + 1e-6
    count = min(_MOST_EDGES, len(x))
    keep = rng.choice(len(x), count, replace=False, p=chance / chance.sum())
    xy_px = (at_px[keep] + 0.5) * shrink_factor - 0.5
    return _edges_on_sphere(camera, xy_px, inward_unit[keep], weight[keep])


def _edges_on_sphere(
    camera: HorizonCamera, xy_px: Array, inward_unit: Array, weight: Array
) -> Edges:
    """Edges at pixels (n, 2) with their bright sides along image directions (n, 2)."""

    def difference_body(step_px: Array) -> Array:
        return camera.rays_body(xy_px + step_px) - camera.rays_body(xy_px - step_px)

    ray_body = camera.rays_body(xy_px)
    # Across the edge on the image is across it on the sphere only near the axis: take the
    # edge's own direction there and turn it a quarter about the ray.
    inward_body = np.cross(ray_body, difference_body(inward_unit[:, ::-1] * [-0.5, 0.5]))
    rough_body = difference_body(0.5 * inward_unit)
    inward_body *= np.sign(np.sum(inward_body * rough_body, axis=1, keepdims=True))
    inward_body /= np.linalg.norm(inward_body, axis=1, keepdims=True)
    return Edges(ray_body=ray_body, inward_body=inward_body, weight=weight)


def _shrink(frame: Frame, shrink_factor: float) -> tuple[Grey, NDArray[np.uint8]]:
    usable = frame.usable.astype(np.uint8)
    if shrink_factor == 1.0:
        return frame.grey, usable
    height, width = frame.grey.shape
    size = (round(width / shrink_factor), round(height / shrink_factor))
    small = cv2.resize(frame.grey, size, interpolation=cv2.INTER_AREA)
    clear = cv2.resize(usable, size, interpolation=cv2.INTER_NEAREST)
    return small.astype(np.float32, copy=False), clear.astype(np.uint8, copy=False)


def _noise(level: Grey) -> float:
    """Rms of the gradient that noise alone makes, from the smoothest half of the frame."""
    fine = cv2.Laplacian(level, cv2.CV_32F)[::2, ::2]
    return 4.0 * float(np.median(np.abs(fine)))


def _darkness_beyond(level: Grey, xy_px: NDArray[np.intp], inward_unit: Array) -> Array:
    """(within - beyond) / (within + beyond) of brightness across each edge, 0..1."""

    def brightness(steps_px: tuple[float, ...], sign: float) -> Array:
        picked = []
        for step_px in steps_px:
            beside = np.rint(xy_px + sign * step_px * inward_unit)
            x, y = np.clip(beside, 0, np.array(level.shape[::-1]) - 1).astype(int).T
            picked.append(level[y, x].astype(float) ** 2)
        return np.stack(picked)

    beyond = brightness(_BEYOND_PX, -1.0).max(axis=0)
    within = brightness(_WITHIN_PX, 1.0).mean(axis=0)
    floor = (0.02 * _TO_SHORT) ** 2
    return np.asarray(np.clip((within - beyond) / (within + beyond + floor), 0.0, 1.0))


_NO_EDGES = Edges(ray_body=np.zeros((0, 3)), inward_body=np.zeros((0, 3)), weight=np.zeros(0))
