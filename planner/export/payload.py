"""The orientation of the payload's axes while the platform moves."""

import numpy as np
from scipy.spatial.transform import Rotation

from planner.arrays import Array
from planner.platforms import TwoAxisPlatform


def q_payload_from_platform(platform: TwoAxisPlatform, angle_rad: Array) -> Rotation:
    """n rotations to the payload's axes: +Z the boresight, +X and +Y carried by both axes.

    angle_rad: shape (n, 2), in the order of `platform.axis_names`.  At zero angles +X is the
    inner axis, or its part across the zero direction; so on the HRC the payload's axes then
    are the platform's.  +Y completes.
    """
    outer, inner = platform.axes_platform
    carried = Rotation.from_rotvec(angle_rad[:, :1] * outer) * Rotation.from_rotvec(
        angle_rad[:, 1:] * inner
    )
    return (carried * Rotation.from_matrix(_c_platform_from_payload_at_zero(platform))).inv()


def omega_payload_rad_s(platform: TwoAxisPlatform, angle_rad: Array, rate_rad_s: Array) -> Array:
    """Angular velocity of the payload against the platform's base, payload axes, shape (n, 3).

    angle_rad, rate_rad_s: shape (n, 2).
    """
    outer, inner = platform.axes_platform
    carried_inner = Rotation.from_rotvec(angle_rad[:, :1] * outer).apply(inner)
    omega_platform_rad_s = rate_rad_s[:, :1] * outer + rate_rad_s[:, 1:] * carried_inner
    return np.asarray(
        q_payload_from_platform(platform, angle_rad).apply(omega_platform_rad_s), dtype=np.float64
    )


def _c_platform_from_payload_at_zero(platform: TwoAxisPlatform) -> Array:
    """Columns: the payload's axes in the platform frame when both angles are zero."""
    z = np.array(platform.zero_direction_platform)
    z = z / np.linalg.norm(z)
    _, inner = platform.axes_platform
    across = inner - (inner @ z) * z
    x = across / np.linalg.norm(across)
    return np.stack([x, np.cross(z, x), z], axis=1)
