"""The camera model: the direction of a pixel, and the pixel of a direction.

Pinhole with Brown-Conrady distortion, OpenCV's conventions: +Z out of the lens, +X right,
+Y down, pixel centres at whole numbers, coefficients in the order k1, k2, p1, p2, k3.
Source: Brown 1966; the OpenCV camera model.
"""

from dataclasses import replace
from functools import cached_property
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from planner.base.arrays import Array
from planner.base.rotation import Rotation
from planner.base.spec import UnitPart, Within, spec

_Bend = Annotated[float, Within(-1e3, 1e3)]
_CornerPx = Annotated[float, Within(-1e5, 1e5)]
Polygon = tuple[tuple[_CornerPx, _CornerPx], ...]

MAX_SIDE_PX = 16384
_NEWTON_STEPS = 12
# Within 1 %, evenly.
_UNSTATED_SIGMA = 0.01 / np.sqrt(3.0)
_LEAST_KNOWN_SIGMA = 0.05
_CONVERGED = 1e-9  # of the focal length: 1e-5 px at most


@spec
class HorizonCamera:
    """One camera as calibrated, and how it sits on the body.

    name: yours, different from the other cameras'.
    width_px: of the image.
    height_px: of the image.
    fx_px: focal length along the rows, in pixels' widths.
    fy_px: focal length along the columns, in pixels' heights.
    cx_px: principal point, from the left; pixel centres at whole numbers.
    cy_px: principal point, from the top.
    distortion: Brown-Conrady coefficients k1, k2, p1, p2, k3, as OpenCV has them.
    q_camera_from_body_xyzw: scalar last; carries body axes onto the camera's: +Z out of the lens,
    +X right, +Y down.
    mask: polygons, corners as [x, y], that hide the craft's own structure. E.g. `[[[0, 900], [640,
    900], [0, 1023]]]` [pixels]
    lens_sigma: uncertainty of the lens: the 1-sigma of its focal length, and of its distortion
    at the image's corner, as fractions; 0 for a calibrated lens. Null: not stated, and taken as
    known to within 1 %. E.g. `0.002`.
    readout_s: time from the first row's exposure to the last's, which a rolling shutter reads one
    after another; negative where it begins with the last. The epoch is that of the middle row.
    0 for a global shutter. Null: not stated, and taken as global with doubt. E.g. `0.03`.
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
    readout_s: Annotated[float, Within(-1.0, 1.0)] | None = None

    def __post_init__(self) -> None:
        require_unit_quaternion("q_camera_from_body_xyzw", self.q_camera_from_body_xyzw)
        if any(len(polygon) < 3 for polygon in self.mask):
            raise ValueError("mask: each polygon needs at least three [x, y] corners")
        if not np.all(np.isfinite(_undistort(self, _border_px(self)))):
            raise ValueError(
                f"distortion {list(self.distortion)} folds the image over before its edge; "
                "give coefficients that stay monotone out to the corners"
            )

    @property
    def q_camera_from_body(self) -> Rotation:
        return Rotation.from_quat(self.q_camera_from_body_xyzw)

    @cached_property
    def _c_camera_from_body(self) -> Array:
        return np.asarray(self.q_camera_from_body.as_matrix())

    @cached_property
    def _corner_radius(self) -> float:
        """Distance from the axis, on the plane at unit depth, of the image's farthest corner."""
        return float(np.max(np.linalg.norm(_undistort(self, _corners_px(self)), axis=1)))

    def rays_body(self, xy_px: Array) -> Array:
        """Unit vectors in body axes that pixels (n, 2) look along, shape (n, 3).

        NaN where the distortion can't be undone, which is only outside the image.
        """
        xy_at_unit_depth = _undistort(self, xy_px)
        ray_camera = np.column_stack([xy_at_unit_depth, np.ones(len(xy_at_unit_depth))])
        ray_camera /= np.linalg.norm(ray_camera, axis=1, keepdims=True)
        return np.asarray(ray_camera @ self._c_camera_from_body)

    def exposed_s(self, xy_px: Array) -> Array:
        """When the rows of pixels (n, 2) are exposed, after the middle row, (n,)."""
        return np.asarray((self.readout_s or 0.0) * ((xy_px[:, 1] + 0.5) / self.height_px - 0.5))

    def lens_shift_body(self, ray_body: Array) -> Array:
        """How rays (n, 3) change with 1-sigma of focal length and distortion, (n, 3, 2)."""
        sigma = _UNSTATED_SIGMA if self.lens_sigma is None else self.lens_sigma
        ray_camera = ray_body @ self._c_camera_from_body.T
        if sigma == 0.0:
            return np.zeros((len(ray_camera), 3, 2))
        # Along the image plane, for points of the frame: r at unit depth, times r or r^3.
        outward = np.column_stack([ray_camera[:, :2], np.zeros(len(ray_camera))]) * -sigma
        radius = np.hypot(ray_camera[:, 0], ray_camera[:, 1])
        far2 = (radius / (ray_camera[:, 2] * self._corner_radius)) ** 2
        shift_camera = np.stack([outward, far2[:, None] * outward], axis=2)
        return np.asarray(np.einsum("ij,nik->njk", self._c_camera_from_body, shift_camera))

    def with_doubted_lens(self) -> "HorizonCamera":
        """As if nobody had stated its lens, where that is stated to be known better."""
        known = self.lens_sigma is not None and self.lens_sigma < _UNSTATED_SIGMA
        return replace(self, lens_sigma=None) if known else self

    def with_doubted_shutter(self, readout_s: float) -> "HorizonCamera":
        """With a rolling shutter, where none is stated."""
        return replace(self, readout_s=readout_s) if self.readout_s is None else self

    def pixels(self, ray_body: Array) -> Array:
        """Pixels (n, 2) that see directions (n, 3); NaN for those outside the field of view."""
        ray_camera = ray_body @ self._c_camera_from_body.T
        depth = ray_camera[:, 2:]
        with np.errstate(divide="ignore", invalid="ignore"):
            plane = np.where(depth > 1e-3, ray_camera[:, :2] / depth, np.nan)
        # Outside the corner's radius the polynomial may fold back into the image.
        plane[np.sum(plane**2, axis=1) > (1.1 * self._corner_radius) ** 2] = np.nan
        if any(self.distortion):
            plane = _distort(plane, self.distortion)[0]
        return plane * [self.fx_px, self.fy_px] + [self.cx_px, self.cy_px]

    def sees(self, xy_px: Array, margin_px: float = 0.0) -> NDArray[np.bool_]:
        """Which pixels (n, 2) lie in the image, at least the margin from its edge."""
        last_px = np.array([self.width_px, self.height_px]) - 1 - margin_px
        with np.errstate(invalid="ignore"):
            return np.asarray(np.all((xy_px >= margin_px) & (xy_px <= last_px), axis=1))

    @property
    def rad_per_px(self) -> float:
        """Angle of a pixel near the axis."""
        return 2.0 / (self.fx_px + self.fy_px)

    @property
    def boresight_body(self) -> Array:
        return np.asarray(self._c_camera_from_body[2])


def require_unit_quaternion(field: str, q_unit: tuple[float, ...]) -> None:
    """Raise ValueError, which names the field, for a norm more than 1e-3 off."""
    norm = float(np.linalg.norm(q_unit))
    if not abs(norm - 1.0) <= 1e-3:
        raise ValueError(f"{field} must be a unit quaternion; its norm is {norm:.4f}")


def _distort(xy_at_unit_depth: Array, coefficients: tuple[float, ...]) -> tuple[Array, Array]:
    """Distorted coordinates (n, 2) on the plane at unit depth and their Jacobian (n, 2, 2)."""
    k1, k2, p1, p2, k3 = coefficients
    x, y = xy_at_unit_depth.T
    r2 = x * x + y * y
    radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
    slope = 2.0 * (k1 + r2 * (2.0 * k2 + 3.0 * r2 * k3))
    distorted = np.column_stack(
        [
            x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
            y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y,
        ]
    )
    jacobian = np.empty((len(x), 2, 2))
    jacobian[:, 0, 0] = radial + x * x * slope + 2.0 * p1 * y + 6.0 * p2 * x
    jacobian[:, 0, 1] = x * y * slope + 2.0 * p1 * x + 2.0 * p2 * y
    jacobian[:, 1, 0] = jacobian[:, 0, 1]
    jacobian[:, 1, 1] = radial + y * y * slope + 6.0 * p1 * y + 2.0 * p2 * x
    return distorted, jacobian


def _undistort(camera: HorizonCamera, xy_px: Array) -> Array:
    """Coordinates (n, 2) at unit depth by Newton's method; NaN where it finds no monotone root."""
    wanted = (xy_px - [camera.cx_px, camera.cy_px]) / [camera.fx_px, camera.fy_px]
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


def _corners_px(camera: HorizonCamera) -> Array:
    right, bottom = camera.width_px - 1.0, camera.height_px - 1.0
    return np.array([[0.0, 0.0], [right, 0.0], [right, bottom], [0.0, bottom]])


def _border_px(camera: HorizonCamera) -> Array:
    """Points along the image's four sides, corners included."""
    corners_px = _corners_px(camera)
    return np.concatenate(np.linspace(corners_px, np.roll(corners_px, 1, axis=0), 17))
