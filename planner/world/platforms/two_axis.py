"""A two-axis platform: its axes, its limits, its mounting, and how that rings."""

import math
from dataclasses import replace
from typing import Annotated, ClassVar

import numpy as np

from planner.base.arrays import Array
from planner.base.commands import Channel, axis_channels
from planner.base.header_text import one_line
from planner.base.rotation import Rotation
from planner.base.spec import UnitPart, Within, spec
from planner.world.platforms.camera import HRC_CAMERA, Camera
from planner.world.platforms.carrier_mode import UNIT_TOLERANCE, CarrierMode
from planner.world.platforms.drive import AxisDrive
from planner.world.platforms.field_mask import FieldMask
from planner.world.platforms.geometry import Bounds, Described, MotionBounds, Scanning, vector_text
from planner.world.platforms.kept_direction import KeptDirection

UnitVector = tuple[UnitPart, UnitPart, UnitPart]
# 5.36 x 3.56 km from 350 km (Sumarokov 2016).
HRC_FRAME_HALF_RAD = (math.atan(2.68 / 350.0), math.atan(1.78 / 350.0))


@spec
class AxisLimits:
    """Mechanical limits of one gimbal axis; zero is the axis's index mark.

    rate_min_rad_s: below this commanded rate friction makes the drive oscillate; it is
    reported, not forbidden.
    """

    angle_min_rad: float
    angle_max_rad: float
    rate_max_rad_s: float
    acceleration_max_rad_s2: float
    jerk_max_rad_s3: float
    rate_min_rad_s: float = 0.0

    def __post_init__(self) -> None:
        if not self.angle_min_rad < self.angle_max_rad:
            raise ValueError(
                f"hard stops out of order: {self.angle_min_rad} >= {self.angle_max_rad} rad"
            )
        for name in ("rate_max_rad_s", "acceleration_max_rad_s2", "jerk_max_rad_s3"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name} must be positive, not {getattr(self, name)}")
        if not 0.0 <= self.rate_min_rad_s < self.rate_max_rad_s:
            raise ValueError(f"rate_min_rad_s must lie in [0, rate_max), not {self.rate_min_rad_s}")

    @property
    def bounds(self) -> tuple[Bounds, Bounds, Bounds, Bounds]:
        """(least, greatest) of angle, rate, acceleration and jerk."""
        rate, acceleration, jerk = (
            (-bound, bound)
            for bound in (self.rate_max_rad_s, self.acceleration_max_rad_s2, self.jerk_max_rad_s3)
        )
        return (self.angle_min_rad, self.angle_max_rad), rate, acceleration, jerk


@spec
class ParkPosition:
    """Where the axes may rest, by a name: angles in the order of `TwoAxisPlatform.axis_names`."""

    name: str
    angle_rad: tuple[float, float]


@spec
class TwoAxisPlatform:
    """Line of sight in the platform frame is R(outer, a) R(inner, b) zero_direction.

    outer_*: the axis fixed to the base (alpha of the HRC); inner_*: the one it carries
    (beta).  Axes and zero direction are unit vectors in the platform frame.
    q_platform_from_body_xyzw: the mount, scalar last.
    frame_half_rad: half the camera's field of view along the frame's first side and along its
    second.  frame_turn_rad: how far the first side is turned from the inner axis, right-handed
    about the boresight.
    camera: pixel, exposure and frame rate of the camera.
    usual_yaw_pitch_roll_deg: mean attitude to LVLH that its carrier usually has, where it is known.
    park_positions: where it may be left at rest.
    masks: what stands in its view; fixed to the base, as the carrier is.
    drives: how the axes follow a table, in the order of `axis_names`.  structural_modes: how the
    carrier rings when they do.  directions: that a request's conditions hold, of the carrier.
    Source: Sumarokov 2016, eq. 10-11.
    """

    kind: ClassVar[str] = "two_axis"
    always_excluded: ClassVar[tuple[()]] = ()  # what a carrier keeps away from is the request's

    name: str
    outer_name: str
    outer_axis_platform: UnitVector
    outer_limits: AxisLimits
    inner_name: str
    inner_axis_platform: UnitVector
    inner_limits: AxisLimits
    zero_direction_platform: UnitVector
    q_platform_from_body_xyzw: tuple[UnitPart, UnitPart, UnitPart, UnitPart] = (0.0, 0.0, 0.0, 1.0)
    frame_half_rad: tuple[float, float] = HRC_FRAME_HALF_RAD
    frame_turn_rad: float = 0.0
    camera: Camera = HRC_CAMERA
    usual_yaw_pitch_roll_deg: tuple[float, float, float] | None = None
    park_positions: tuple[ParkPosition, ...] = ()
    masks: tuple[FieldMask, ...] = ()
    drives: tuple[AxisDrive, AxisDrive] = (AxisDrive(), AxisDrive())
    structural_modes: tuple[CarrierMode, ...] = ()
    directions: tuple[KeptDirection, ...] = ()

    def __post_init__(self) -> None:
        for name in (
            "outer_axis_platform",
            "inner_axis_platform",
            "zero_direction_platform",
            "q_platform_from_body_xyzw",
        ):
            norm = math.hypot(*getattr(self, name))
            if not abs(norm - 1.0) <= UNIT_TOLERANCE:
                raise ValueError(f"{name} must have unit length, not {norm}")
        if not all(0.0 < half < math.pi / 2.0 for half in self.frame_half_rad):
            raise ValueError(f"frame_half_rad must lie in (0, pi/2), not {self.frame_half_rad}")
        parallel = math.cos(math.radians(1.0))
        if abs(np.dot(self.outer_axis_platform, self.inner_axis_platform)) > parallel:
            raise ValueError("the two axes are within 1 deg of parallel: one direction is lost")
        if abs(np.dot(self.zero_direction_platform, self.inner_axis_platform)) > parallel:
            raise ValueError(
                "zero_direction_platform is within 1 deg of the inner axis, which can't move it"
            )

    def keeping(self, directions: tuple[KeptDirection, ...]) -> "TwoAxisPlatform":
        """The same with a request's directions."""
        return replace(self, directions=directions) if directions != self.directions else self

    def with_limits(self, axis_limits: tuple[AxisLimits, ...]) -> "TwoAxisPlatform":
        """The platform with other limits, in the order of `axis_names`."""
        outer, inner = axis_limits
        return replace(self, outer_limits=outer, inner_limits=inner)

    @property
    def held_half_rad(self) -> tuple[float, float]:
        """The frame holds what is inside it."""
        return self.frame_half_rad

    @property
    def scanning(self) -> Scanning:
        """However the frame lies along the line, by its shorter side."""
        return Scanning(min(self.frame_half_rad), both_ways=True, settle_s=0.0)

    @property
    def axis_names(self) -> tuple[str, str]:
        """Column order of every angle array of this platform."""
        return (self.outer_name, self.inner_name)

    @property
    def axis_limits(self) -> tuple[AxisLimits, AxisLimits]:
        """Limits in the order of `axis_names`."""
        return (self.outer_limits, self.inner_limits)

    def limits_with_jerk(self, jerk_max_deg_s3: float | None) -> tuple[AxisLimits, ...]:
        """The limits with another one of jerk, unless that is None."""
        if jerk_max_deg_s3 is None:
            return self.axis_limits
        jerk_max_rad_s3 = math.radians(jerk_max_deg_s3)
        return tuple(replace(one, jerk_max_rad_s3=jerk_max_rad_s3) for one in self.axis_limits)

    def motion_bounds(self, jerk_max_deg_s3: float | None = None) -> tuple[MotionBounds, ...]:
        """Of each axis."""
        return tuple(limits.bounds for limits in self.limits_with_jerk(jerk_max_deg_s3))

    @property
    def axes_platform(self) -> Array:
        """Unit vectors of the axes, shape (2, 3), in the order of `axis_names`."""
        axes = np.array([self.outer_axis_platform, self.inner_axis_platform])
        return np.asarray(axes / np.linalg.norm(axes, axis=1, keepdims=True))

    @property
    def q_platform_from_body(self) -> Rotation:
        """The mount: `q_platform_from_body.apply(v_body)` gives `v_platform`."""
        return Rotation.from_quat(self.q_platform_from_body_xyzw)

    @property
    def q_base_from_carrier(self) -> Rotation:
        """The mount."""
        return self.q_platform_from_body

    @property
    def dof_names(self) -> tuple[str, ...]:
        """The axes' names."""
        return self.axis_names

    @property
    def channels(self) -> tuple[Channel, ...]:
        """Angle and rate of each axis."""
        return axis_channels(self.axis_names)

    def described(self) -> Described:
        """The boresight as a product of right-handed turns, the mount, the payload's axes."""
        outer, inner = self.axes_platform
        a, b = map(one_line, self.axis_names)
        return Described(
            f"boresight_platform = R({a}) R({b}) zero, right-handed; {a} about "
            f"{vector_text(outer)} (outer, fixed to the base), {b} about {vector_text(inner)} "
            f"(inner, carried by {a}), zero {vector_text(self.zero_direction_platform)}, "
            "platform axes",
            f"q_platform_from_body_xyzw = {vector_text(self.q_platform_from_body_xyzw)}",
            "payload: +Z boresight, +X at zero angles the inner axis (its part across the "
            "boresight), +Y completes; both axes carry it",
            "between rows the platform flies the cubic Hermite of angle and rate",
        )

    def q_payload_from_body(self, position: Array) -> Rotation:
        """n rotations from the carrier's axes to the payload's; position: angles, (n, 2)."""
        return self.q_payload_from_base(position) * self.q_platform_from_body

    def q_payload_from_base(self, position: Array) -> Rotation:
        """n rotations to the payload's axes: +Z the boresight, +X and +Y carried by both axes.

        position: angles, (n, 2).  At zero angles +X is the inner axis, or its part across the zero
        direction; so on the HRC the payload's axes then are the platform's.  +Y completes.
        """
        outer, inner = self.axes_platform
        turn = Rotation.from_rotvec(position[:, :1] * outer) * Rotation.from_rotvec(
            position[:, 1:] * inner
        )
        return (turn * Rotation.from_matrix(self._c_platform_from_payload_at_zero)).inv()

    def omega_payload_rad_s(self, position: Array, rate_rad_s: Array) -> Array:
        """Angular velocity of the payload against the platform's base, payload axes, (n, 3).

        position, rate_rad_s: angles and their rates, (n, 2).
        """
        outer, inner = self.axes_platform
        inner_platform = Rotation.from_rotvec(position[:, :1] * outer).apply(inner)
        omega_platform_rad_s = rate_rad_s[:, :1] * outer + rate_rad_s[:, 1:] * inner_platform
        return np.asarray(self.q_payload_from_base(position).apply(omega_platform_rad_s))

    @property
    def _c_platform_from_payload_at_zero(self) -> Array:
        """Columns: the payload's axes in the platform frame when both angles are zero."""
        z = np.array(self.zero_direction_platform)
        z = z / np.linalg.norm(z)
        _, inner = self.axes_platform
        across = inner - (inner @ z) * z
        x = across / np.linalg.norm(across)
        return np.stack([x, np.cross(z, x), z], axis=1)


@spec
class StructuralMode:
    """One mode of vibration, excited by the acceleration of either axis.

    frequency_hz: undamped; slower is no vibration, and a table has five rows a second.
    damping: share of critical damping.
    """

    frequency_hz: Annotated[float, Within(0.02, 2.5)]
    damping: Annotated[float, Within(0.0, 0.5)] = 0.005

    @property
    def eigenvalue_rad_s(self) -> complex:
        """The mode's deflection goes as exp of this times t."""
        omega_rad_s = 2.0 * math.pi * self.frequency_hz
        return omega_rad_s * complex(-self.damping, math.sqrt(1.0 - self.damping**2))
