"""The camera model: the direction of a pixel, and the pixel of a direction.

Pinhole with Brown-Conrady distortion, OpenCV's conventions: +Z out of the lens, +X right,
+Y down, pixel centres at whole numbers, coefficients in the order k1, k2, p1, p2, k3.
Source: Brown 1966; the OpenCV camera model.
"""

from functools import cached_property
from typing import Annotated

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from planner.arrays import Array
from planner.spec import UnitPart, Within, spec

_Bend = Annotated[float, Within(-1e3, 1e3)]
_CornerPx = Annotated[float, Within(-1e5, 1e5)]
Polygon = tuple[tuple[_CornerPx, _CornerPx], ...]

MAX_SIDE_PX = 16384
_NEWTON_STEPS = 12
# Within 1 %, evenly.
_PHOTOGRAPHED_SIGMA = 0.01 / np.sqrt(3.0)
_LEAST_KNOWN_SIGMA = 0.05
_CONVERGED = 1e-9  # of the focal length: 1e-5 px at most


@spec
class HorizonCamera:
    """One camera as calibrated, and how it sits on the body.

    mask: polygons in pixels that hide the craft's own structure.  lens_sigma: how well the lens is
    known, the 1-sigma of its focal length, and of its distortion at the image's corner, as
    fractions.  None: perfectly, but for frames stored as photographs, whose lenses are taken as
    known to within 1 %.
    """

    name: str
    width_px: Annotated[int, Within(16, MAX_SIDE_PX)]
    height_px: Annotated[int, Within(16, MAX_SIDE_PX)]
    fx_px: Annotated[float, Within(1.0, 1e6)]
    fy_px: Annotated[float, Within(1.0, 1e6)]
    cx_px: Annotated[float, Within(-1e5, 1e5)]
    cy_px: Annotated[float, Within(-1e5, 1e5)]
    distortion: tuple[_Bend, _Bend, _Bend, _Bend, _Bend] = (0.0, 0.0, 0.0, 0.0, 0.0)
    q_camera_from_body_xyzw: tuple[UnitPart, UnitPart, UnitPart, UnitPart]
    mask: tuple[Polygon, ...] = ()
    lens_sigma: Annotated[float, Within(0.0, _LEAST_KNOWN_SIGMA)] | None = None

    def __post_init__(self) -> None:
        norm = float(np.linalg.norm(self.q_camera_from_body_xyzw))
        if abs(norm - 1.0) > 1e-3:
            raise ValueError(
                f"q_camera_from_body_xyzw must be a unit quaternion; its norm is {norm:.4f}"
            )
        if any(len(polygon) < 3 for polygon in self.mask):
            raise ValueError("mask: each polygon needs at least three [x, y] corners")
        _check_lens(self)

    @property
    def q_camera_from_body(self) -> Rotation:
        return Rotation.from_quat(self.q_camera_from_body_xyzw)

    @cached_property
    def _c_camera_from_body(self) -> Array:
        return np.asarray(self.q_camera_from_body.as_matrix())

    @cached_property
    def _reach(self) -> float:
        """Distance from the axis, on the plane at unit depth, of the image's farthest corner."""
        return float(np.max(np.linalg.norm(_corners(self), axis=1)))

    def rays_body(self, pixel: Array) -> Array:
        """Unit vectors in body axes that pixels (n, 2) look along, shape (n, 3).

        NaN where the distortion can't be undone, which is only outside the image.
        """
        plane = _undistort(self, pixel)
        rays = np.column_stack([plane, np.ones(len(plane))])
        rays /= np.linalg.norm(rays, axis=1, keepdims=True)
        return np.asarray(rays @ self._c_camera_from_body)

    def bends_body(self, rays_body: Array, photographed: bool) -> Array:
        """How rays (n, 3) change with 1-sigma of focal length and distortion, (n, 3, 2)."""
        sigma = self.lens_sigma
        if sigma is None:
            sigma = _PHOTOGRAPHED_SIGMA if photographed else 0.0
        ray = rays_body @ self._c_camera_from_body.T
        if sigma == 0.0:
            return np.zeros((len(ray), 3, 2))
        # Along the image plane, for points of the frame: r at unit depth, times r or r^3.
        outward = np.column_stack([ray[:, :2], np.zeros(len(ray))]) * -sigma
        far2 = (np.hypot(ray[:, 0], ray[:, 1]) / (ray[:, 2] * self._reach)) ** 2
        bent = np.stack([outward, far2[:, None] * outward], axis=2)
        return np.asarray(np.einsum("ij,nik->njk", self._c_camera_from_body, bent))

    def pixels(self, rays_body: Array) -> Array:
        """Pixels (n, 2) that see directions (n, 3); NaN for those outside the field of view."""
        ray = rays_body @ self._c_camera_from_body.T
        with np.errstate(divide="ignore", invalid="ignore"):
            plane = np.where(ray[:, 2:] > 1e-3, ray[:, :2] / ray[:, 2:], np.nan)
        # Outside the corner's radius the polynomial may fold back into the image.
        plane[np.sum(plane**2, axis=1) > (1.1 * self._reach) ** 2] = np.nan
        if any(self.distortion):
            plane = _distort(plane, self.distortion)[0]
        return plane * [self.fx_px, self.fy_px] + [self.cx_px, self.cy_px]

    def sees(self, pixel: Array, margin_px: float = 0.0) -> NDArray[np.bool_]:
        """Which pixels (n, 2) lie in the image, at least the margin from its edge."""
        with np.errstate(invalid="ignore"):
            return np.asarray(
                (pixel[:, 0] >= margin_px)
                & (pixel[:, 0] <= self.width_px - 1 - margin_px)
                & (pixel[:, 1] >= margin_px)
                & (pixel[:, 1] <= self.height_px - 1 - margin_px)
            )

    @property
    def rad_per_px(self) -> float:
        """Angle of a pixel near the axis."""
        return 2.0 / (self.fx_px + self.fy_px)

    @property
    def boresight_body(self) -> Array:
        return np.asarray(self._c_camera_from_body[2])


def _check_lens(camera: HorizonCamera) -> None:
    border = _border_px(camera.width_px, camera.height_px)
    if not np.all(np.isfinite(_undistort(camera, border))):
        raise ValueError(
            f"distortion {list(camera.distortion)} folds the image over before its edge; "
            "give coefficients that stay monotone out to the corners"
        )


def _distort(plane: Array, distortion: tuple[float, ...]) -> tuple[Array, Array]:
    """Distorted normalised coordinates (n, 2) and their Jacobian (n, 2, 2)."""
    k1, k2, p1, p2, k3 = distortion
    x, y = plane[:, 0], plane[:, 1]
    r2 = x * x + y * y
    radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
    slope = 2.0 * (k1 + r2 * (2.0 * k2 + 3.0 * r2 * k3))
    distorted = np.column_stack(
        [
            x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
            y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y,
        ]
    )
    jacobian = np.empty((len(plane), 2, 2))
    jacobian[:, 0, 0] = radial + x * x * slope + 2.0 * p1 * y + 6.0 * p2 * x
    jacobian[:, 0, 1] = x * y * slope + 2.0 * p1 * x + 2.0 * p2 * y
    jacobian[:, 1, 0] = jacobian[:, 0, 1]
    jacobian[:, 1, 1] = radial + y * y * slope + 6.0 * p1 * y + 2.0 * p2 * x
    return distorted, jacobian


def _undistort(camera: HorizonCamera, pixel: Array) -> Array:
    """Normalised coordinates (n, 2) by Newton's method; NaN where it finds no monotone root."""
    wanted = (pixel - [camera.cx_px, camera.cy_px]) / [camera.fx_px, camera.fy_px]
    if not any(camera.distortion):
        return np.asarray(wanted)
    plane = wanted.copy()
    with np.errstate(all="ignore"):
        for _ in range(_NEWTON_STEPS):
            distorted, jacobian = _distort(plane, camera.distortion)
            error = distorted - wanted
            a, b, c, d = jacobian[:, 0, 0], jacobian[:, 0, 1], jacobian[:, 1, 0], jacobian[:, 1, 1]
            determinant = a * d - b * c
            plane[:, 0] -= (d * error[:, 0] - b * error[:, 1]) / determinant
            plane[:, 1] -= (a * error[:, 1] - c * error[:, 0]) / determinant
        distorted, jacobian = _distort(plane, camera.distortion)
        good = (
            (np.abs(distorted - wanted).max(axis=1) < _CONVERGED)
            & (np.linalg.det(jacobian) > 0.0)
            & (np.einsum("ni,nij,nj->n", plane, jacobian, plane) >= 0.0)
        )
    plane[~good] = np.nan
    return plane


def _border_px(width_px: int, height_px: int) -> Array:
    x = np.linspace(0.0, width_px - 1.0, 17)
    y = np.linspace(0.0, height_px - 1.0, 17)
    return np.concatenate(
        [
            np.column_stack([x, np.zeros(17)]),
            np.column_stack([x, np.full(17, height_px - 1.0)]),
            np.column_stack([np.zeros(17), y]),
            np.column_stack([np.full(17, width_px - 1.0), y]),
        ]
    )


def _corners(camera: HorizonCamera) -> Array:
    right, bottom = camera.width_px - 1.0, camera.height_px - 1.0
    return _undistort(camera, np.array([[0.0, 0.0], [right, 0.0], [0.0, bottom], [right, bottom]]))
