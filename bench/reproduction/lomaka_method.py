"""The nadir by the paper's own method, the baseline.

Two cameras; Canny edges, those dark beyond; a circle fitted to the horizon's arc; the vector
that joins the arc's ends; the cross product of the two such vectors is the direction to the
Earth's centre.
Source: Lomaka, Ustyugov 2016, p. 467-468.  The paper takes the chord in the image plane, true
only for a limb through the principal point seen from afar; between unit rays it is exact on
a sphere at any roll: both are here.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from estimator.camera import HorizonCamera
from estimator.images import Pixels, prepare
from estimator.search.edges import find_edges
from planner.base.arrays import Array

_TRIALS = 300
_NEAR_PX = 1.5


def paper_nadir(
    images: Sequence[Pixels], cameras: Sequence[HorizonCamera], unit_rays: bool
) -> Array | None:
    """Nadir in body axes from two frames; None where a frame shows no arc.

    unit_rays: False for the chord as printed, in the image plane.
    """
    chords, inward = [], np.zeros(3)
    for image, camera in zip(images, cameras, strict=True):
        arc = horizon_arc_px(image, camera)
        if arc is None:
            return None
        ends, centre = arc
        chords.append(chord_body(camera, ends, unit_rays))
        towards, middle = camera.rays_body(np.stack([centre, ends.mean(axis=0)]))
        inward += towards - middle
    nadir = np.cross(chords[0], chords[1])
    if not np.linalg.norm(nadir) > 0.0:
        return None
    nadir /= np.linalg.norm(nadir)
    return np.asarray(nadir * np.sign(nadir @ inward))


def chord_body(camera: HorizonCamera, ends_px: Array, unit_rays: bool) -> Array:
    """What joins the ends (2, 2) of an arc, (3,): between unit rays, or as printed on the image."""
    if unit_rays:
        first, last = camera.rays_body(ends_px)
        return np.asarray(last - first)
    flat = np.append(ends_px[1] - ends_px[0], 0.0)
    return np.asarray(camera.q_camera_from_body.inv().apply(flat))


def horizon_arc_px(image: Pixels, camera: HorizonCamera) -> tuple[Array, Array] | None:
    """The ends (2, 2) of the circle arc most edge pixels lie on, and the circle's centre."""
    edges = find_edges(prepare(image, camera, "images", blue=False), camera, seed=0)
    point = camera.pixels(edges.ray_body)
    if len(point) < 30:
        return None
    rng = np.random.default_rng(0)
    best: tuple[int, NDArray[np.bool_]] | None = None
    for _ in range(_TRIALS):
        circle = _circle(point[rng.choice(len(point), 3, replace=False)])
        if circle is None or circle[2] < 0.5 * camera.width_px:
            continue
        near = np.abs(np.hypot(*(point - circle[:2]).T) - circle[2]) < _NEAR_PX
        if best is None or near.sum() > best[0]:
            best = (int(near.sum()), near)
    if best is None or best[0] < 30:
        return None
    circle = _circle(point[best[1]])
    if circle is None:
        return None
    centre, radius = circle[:2], circle[2]
    arc = point[best[1]]
    middle = arc.mean(axis=0) - centre
    turn = np.arctan2((arc - centre) @ np.array([-middle[1], middle[0]]), (arc - centre) @ middle)
    base = np.arctan2(middle[1], middle[0])
    ends = [base + turn.min(), base + turn.max()]
    on_circle = centre + radius * np.stack([np.cos(ends), np.sin(ends)], axis=1)
    return on_circle, centre


def _circle(point: Array) -> Array | None:
    """Kasa's circle through points (n, 2): centre and radius, shape (3,)."""
    design = np.column_stack([2.0 * point, np.ones(len(point))])
    solution, _, rank, _ = np.linalg.lstsq(design, np.sum(point**2, axis=1), rcond=None)
    if rank < 3:
        return None
    square = solution[2] + solution[0] ** 2 + solution[1] ** 2
    return np.array([solution[0], solution[1], np.sqrt(square)]) if square > 0.0 else None
