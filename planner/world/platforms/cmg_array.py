"""Four single-gimbal control moment gyros: their momentum and envelope.

The envelope of two scissor pairs is inverted in closed form.
Source: Platonov, Sumarokov 2019, eq. 1 and the definitions below it.
"""

import math
from typing import Annotated, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from planner.base.arrays import Array
from planner.base.spec import Within, spec

Positive = Annotated[float, Within(1e-9, 1e9)]
NotNegative = Annotated[float, Within(0.0, 1e9)]


class Gyros(NamedTuple):
    """A `CmgArray` as compiled code takes it; axes (4, 3), at zero gimbal angle."""

    momentum_n_m_s: float
    rotor_axes_body: Array
    torque_axes_body: Array
    rate_max_rad_s: float


@spec
class CmgArray:
    """Identical CMGs in two scissor pairs: gimbal axes, rotor directions at zero angle, one drive.

    The gimbal axes lie along X and Y: H = h [s3 + s4, s1 + s2, c1 + c2 + c3 + c4].
    rate_step_rad_s: the drive executes whole multiples of it (and nothing smaller).
    rate_error_share, rate_error_rad_s: execution error +-(share x rate + constant).
    servo_rad_s, servo_damping: W(s) = 1/(T^2 s^2 + 2 xi T s + 1), T = 1/servo_rad_s; the
    paper gives the form but no numbers: 50 rad/s and 0.7 are assumed.
    gimbal_inertia_kg_m2: of rotor and frame about the gimbal axis; 0 leaves its reaction out.
    gimbal_axes_body, rotor_axes_body, torque_axes_body: (4, 3), what the gimbals turn about, and
    at zero gimbal angle the rotors' momentum and what they turn towards.
    """

    momentum_n_m_s: Positive = 60.0
    rate_max_rad_s: Positive = math.radians(57.3)
    rate_step_rad_s: NotNegative = math.radians(0.0069)
    rate_error_share: NotNegative = 0.01
    rate_error_rad_s: NotNegative = math.radians(0.0069)
    servo_rad_s: Positive = 50.0
    servo_damping: Positive = 0.7
    gimbal_inertia_kg_m2: NotNegative = 0.0
    gimbal_axes_body: ClassVar[Array] = np.array([[-1.0, 0, 0], [-1, 0, 0], [0, 1, 0], [0, 1, 0]])
    rotor_axes_body: ClassVar[Array] = np.tile([0.0, 0.0, 1.0], (4, 1))
    torque_axes_body: ClassVar[Array] = np.cross(gimbal_axes_body, rotor_axes_body)

    @property
    def sphere_n_m_s(self) -> float:
        """Momentum that is held in every direction well away from singular: that of one gyro."""
        return self.momentum_n_m_s

    @property
    def torque_n_m(self) -> float:
        """What every direction can count on while no more than that is held; the paper's 30 N m."""
        return 0.5 * self.momentum_n_m_s * self.rate_max_rad_s

    def gyros(self) -> Gyros:
        """The array for compiled code."""
        return Gyros(
            self.momentum_n_m_s, self.rotor_axes_body, self.torque_axes_body, self.rate_max_rad_s
        )

    def momentum(self, gimbal_rad: Array) -> Array:
        """Momentum of the rotors in body axes, N m s; gimbal_rad (..., 4) -> (..., 3)."""
        return self.momentum_n_m_s * np.asarray(
            np.cos(gimbal_rad) @ self.rotor_axes_body + np.sin(gimbal_rad) @ self.torque_axes_body
        )

    def jacobian(self, gimbal_rad: Array) -> Array:
        """D = (1/h) dH/d(gimbal angle), shape (..., 3, 4)."""
        columns = (
            np.cos(gimbal_rad)[..., None] * self.torque_axes_body
            - np.sin(gimbal_rad)[..., None] * self.rotor_axes_body
        )
        return np.asarray(np.swapaxes(columns, -1, -2))

    def singularity_margin(self, gimbal_rad: Array) -> Array:
        """Smallest singular value of D, shape (...): 0 where no torque is left in a direction.

        At rates of 1 rad/s it is the torque over h that every direction can count on.
        """
        return np.asarray(np.linalg.svd(self.jacobian(gimbal_rad), compute_uv=False)[..., -1])

    def in_envelope(self, momentum_n_m_s: Array) -> NDArray[np.bool_]:
        """Whether some gimbal angles reach a momentum, (..., 3) -> (...).

        Exactly |Hx|, |Hy| <= 2h and |Hz| <= sqrt(4h^2 - Hx^2) + sqrt(4h^2 - Hy^2).
        """
        h = self.momentum_n_m_s
        hx, hy, hz = np.moveaxis(np.asarray(momentum_n_m_s), -1, 0)
        room_x, room_y = 4 * h**2 - hx**2, 4 * h**2 - hy**2
        reach = np.sqrt(np.maximum(room_x, 0.0)) + np.sqrt(np.maximum(room_y, 0.0))
        return np.asarray((room_x >= 0) & (room_y >= 0) & (np.abs(hz) <= reach))

    def gimbal_angles(self, momentum_n_m_s: Array) -> Array:
        """Well-conditioned gimbal angles (4,) that hold a momentum (3,).

        Closed form; each pair's half-angle is arccos(L/2h), and the split of Hz between the pairs
        (z12 = Hz/2 + s) is the one furthest from singularity on a grid of 201 splits.
        Raises ValueError outside the envelope.
        """
        if not self.in_envelope(momentum_n_m_s):
            raise ValueError(
                f"momentum {np.round(momentum_n_m_s, 1).tolist()} N m s is outside the envelope "
                "of the gyros; unload it first"
            )
        h = self.momentum_n_m_s
        hx, hy, hz = momentum_n_m_s
        split = np.linspace(-2.0 * h, 2.0 * h, 201)
        z12, z34 = hz / 2 + split, hz / 2 - split
        length_12, length_34 = np.hypot(hy, z12), np.hypot(hx, z34)
        ok = (length_12 <= 2 * h) & (length_34 <= 2 * h)
        half_12 = np.arccos(np.minimum(length_12 / (2 * h), 1.0))
        half_34 = np.arccos(np.minimum(length_34 / (2 * h), 1.0))
        middle_12, middle_34 = _angle_rad(hy, z12), _angle_rad(hx, z34)
        angles = np.stack(
            [middle_12 + half_12, middle_12 - half_12, middle_34 + half_34, middle_34 - half_34],
            axis=-1,
        )
        return np.asarray(angles[np.argmax(np.where(ok, self.singularity_margin(angles), -1.0))])


def _angle_rad(y: Array, x: Array) -> Array:
    """As arctan2, cut just beyond -pi: the sign of a y of rounding decides no whole turn."""
    angle_rad = np.arctan2(y, x)
    return np.asarray(np.where(angle_rad < -np.pi + 1e-6, angle_rad + 2.0 * np.pi, angle_rad))
