"""A two-axis platform as a person writes it down, in degrees."""

import math
from collections.abc import Mapping
from dataclasses import field
from typing import Annotated, Literal

from pydantic import WithJsonSchema

from planner.base.spec import UnitPart, Within, spec
from planner.world.platforms.camera import HRC_CAMERA, Camera
from planner.world.platforms.carrier_mode import CarrierMode
from planner.world.platforms.drive import AxisDrive
from planner.world.platforms.field_mask import FieldMask
from planner.world.platforms.two_axis import (
    HRC_FRAME_HALF_RAD,
    AxisLimits,
    ParkPosition,
    TwoAxisPlatform,
    UnitVector,
)

HRC_FIELD_OF_VIEW_DEG = (
    math.degrees(2.0 * HRC_FRAME_HALF_RAD[0]),
    math.degrees(2.0 * HRC_FRAME_HALF_RAD[1]),
)
# Three turns either way: cable wraps hold one and a half, and on slip rings more show nothing new.
AngleDeg = Annotated[float, Within(-1080.0, 1080.0)]
STOPS_APART_DEG = 1e-3
JerkDegS3 = Annotated[float, Within(1e-4, 1e3)]
MASKS_MAX = 8  # each makes the way around them a larger problem
MODES_MAX = 8  # each makes a flight longer to compute
_MotionLimit = Annotated[float, Within(1e-4, 1e3)]
_TurnDeg = Annotated[float, Within(-360.0, 360.0)]
_WidthDeg = Annotated[float, Within(1e-6, 170.0)]


@spec
class AxisDefinition:
    """One gimbal axis as its data sheet gives it.

    name: name of the axis in columns and messages.
    axis_platform: unit vector of the axis in the platform frame, at zero angles.
    angle_min_deg: lower hard stop; zero is the axis's index mark.
    angle_max_deg: upper hard stop.
    rate_max_deg_s: largest rate, either way.
    acceleration_max_deg_s2: largest acceleration, either way.
    jerk_max_deg_s3: largest jerk, either way.
    rate_min_deg_s: below this commanded rate friction makes the drive oscillate; it is reported,
    not forbidden.
    drive: the drive that follows a table in flight.
    """

    name: str
    axis_platform: UnitVector
    angle_min_deg: AngleDeg
    angle_max_deg: AngleDeg
    rate_max_deg_s: _MotionLimit
    acceleration_max_deg_s2: _MotionLimit
    jerk_max_deg_s3: JerkDegS3
    rate_min_deg_s: Annotated[float, Within(0.0, 1e3)] = 0.0
    drive: AxisDrive = field(default_factory=AxisDrive)

    def __post_init__(self) -> None:
        if not self.name:
            raise ValueError("name must not be empty: angles and rates are given per axis name")
        if not self.angle_max_deg - self.angle_min_deg >= STOPS_APART_DEG:
            raise ValueError(
                f"angle_max_deg must lie {STOPS_APART_DEG:g} or more above angle_min_deg "
                f"({self.angle_min_deg}), not at {self.angle_max_deg}"
            )
        if not self.rate_min_deg_s < self.rate_max_deg_s:
            raise ValueError(
                f"rate_min_deg_s must be less than rate_max_deg_s ({self.rate_max_deg_s}), "
                f"not {self.rate_min_deg_s}"
            )
        self.limits()

    def limits(self) -> AxisLimits:
        """The same in radians."""
        return AxisLimits(
            angle_min_rad=math.radians(self.angle_min_deg),
            angle_max_rad=math.radians(self.angle_max_deg),
            rate_max_rad_s=math.radians(self.rate_max_deg_s),
            acceleration_max_rad_s2=math.radians(self.acceleration_max_deg_s2),
            jerk_max_rad_s3=math.radians(self.jerk_max_deg_s3),
            rate_min_rad_s=math.radians(self.rate_min_deg_s),
        )


@spec
class PlatformDefinition:
    """A two-axis platform: `outer` is fixed to the base and carries `inner`.

    kind: two_axis, which may be left out.
    name: name of the platform in plans.
    outer: the axis fixed to the base.
    inner: the axis that the outer one carries.
    zero_direction_platform: unit vector of the boresight in the platform frame, both axes at zero.
    q_platform_from_body_xyzw: the mount, scalar last: carries body axes onto the platform's.
    field_of_view_deg: the camera's, along the frame's first side and its second; the HRC's unless
    given.
    frame_turn_deg: angle from the inner axis to the frame's first side, right-handed about the
    boresight; that of the HRC isn't published, 0 is assumed.
    camera: pixel, exposure and frame rate of the camera; the HRC's unless given.
    usual_yaw_pitch_roll_deg: mean attitude to LVLH that the carrier usually has, if one is known; a
    request whose attitude is 0/0/0 is warned of it. E.g. `[-4.0, -2.0, 1.0]`.
    park_positions_deg: by name, the angle of each axis by its name; a plan's `final_state` may
    name one.
    masks: up to 8 regions fixed to the platform's base that the boresight never enters: kept by
    slews, tracks and windows.
    structural_modes: up to 8 in which the carrier rocks when the axes accelerate.
    """

    kind: Annotated[
        Literal["two_axis"],
        WithJsonSchema({"type": "string", "enum": ["two_axis"], "default": "two_axis"}),
    ] = "two_axis"
    name: str
    outer: AxisDefinition
    inner: AxisDefinition
    zero_direction_platform: UnitVector = (0.0, 0.0, 1.0)
    q_platform_from_body_xyzw: tuple[UnitPart, UnitPart, UnitPart, UnitPart] = (0.0, 0.0, 0.0, 1.0)
    field_of_view_deg: tuple[_WidthDeg, _WidthDeg] = HRC_FIELD_OF_VIEW_DEG
    frame_turn_deg: Annotated[float, Within(-180.0, 180.0)] = 0.0
    camera: Camera = HRC_CAMERA
    usual_yaw_pitch_roll_deg: tuple[_TurnDeg, _TurnDeg, _TurnDeg] | None = None
    park_positions_deg: Mapping[str, Mapping[str, AngleDeg]] = field(default_factory=dict)
    masks: tuple[FieldMask, ...] = ()
    structural_modes: tuple[CarrierMode, ...] = ()

    def __post_init__(self) -> None:
        if self.outer.name == self.inner.name:
            raise ValueError(f"the axes need two names, not {self.outer.name!r} twice")
        for name, angles_deg in self.park_positions_deg.items():
            self._require_park_position(name, angles_deg)
        if len(self.masks) > MASKS_MAX:
            raise ValueError(f"masks must hold at most {MASKS_MAX} masks, not {len(self.masks)}")
        if len(self.structural_modes) > MODES_MAX:
            raise ValueError(
                f"structural_modes must hold at most {MODES_MAX} modes, "
                f"not {len(self.structural_modes)}"
            )
        for number, mask in enumerate(self.masks):
            if mask.name in [before.name for before in self.masks[:number]]:
                raise ValueError(f"masks.{number}.name must be its own, not {mask.name!r} again")
        self.platform()

    def _require_park_position(self, name: str, angles_deg: Mapping[str, float]) -> None:
        if not name:
            raise ValueError("park_positions_deg must give every position a name, not an empty one")
        if set(angles_deg) != {self.outer.name, self.inner.name}:
            raise ValueError(
                f"park_positions_deg.{name} must name the axes {self.outer.name}, "
                f"{self.inner.name}, not {', '.join(angles_deg) or 'none'}"
            )
        for axis in (self.outer, self.inner):
            if not axis.angle_min_deg <= angles_deg[axis.name] <= axis.angle_max_deg:
                raise ValueError(
                    f"park_positions_deg.{name}.{axis.name} must lie within its stops "
                    f"{axis.angle_min_deg:g}..{axis.angle_max_deg:g}, not {angles_deg[axis.name]:g}"
                )

    def platform(self) -> TwoAxisPlatform:
        """The same in radians."""
        return TwoAxisPlatform(
            name=self.name,
            outer_name=self.outer.name,
            outer_axis_platform=self.outer.axis_platform,
            outer_limits=self.outer.limits(),
            inner_name=self.inner.name,
            inner_axis_platform=self.inner.axis_platform,
            inner_limits=self.inner.limits(),
            zero_direction_platform=self.zero_direction_platform,
            q_platform_from_body_xyzw=self.q_platform_from_body_xyzw,
            frame_half_rad=(
                math.radians(self.field_of_view_deg[0]) / 2.0,
                math.radians(self.field_of_view_deg[1]) / 2.0,
            ),
            frame_turn_rad=math.radians(self.frame_turn_deg),
            camera=self.camera,
            usual_yaw_pitch_roll_deg=self.usual_yaw_pitch_roll_deg,
            park_positions=tuple(
                ParkPosition(
                    name=name,
                    angle_rad=(
                        math.radians(angles_deg[self.outer.name]),
                        math.radians(angles_deg[self.inner.name]),
                    ),
                )
                for name, angles_deg in self.park_positions_deg.items()
            ),
            masks=self.masks,
            drives=(self.outer.drive, self.inner.drive),
            structural_modes=self.structural_modes,
        )


@spec
class FinalAngles:
    """Angles at which the axes are to rest.

    angles_deg: of each axis, by its name. E.g. `{"alpha": 0.0, "beta": 0.0}`.
    park: name of a park position of the platform. E.g. `"zero"`.
    """

    angles_deg: Mapping[str, AngleDeg] | None = None
    park: str | None = None

    def __post_init__(self) -> None:
        if (self.angles_deg is None) == (self.park is None):
            raise ValueError('give either angles_deg or park; for rest anywhere, "rest" instead')


def definition_of(platform: TwoAxisPlatform) -> PlatformDefinition:
    """The platform in degrees, as a request writes it out."""
    frame_deg = [_degrees(2.0 * half_rad) for half_rad in platform.frame_half_rad]
    outer, inner = (
        AxisDefinition(
            name=name,
            axis_platform=axis_platform,
            angle_min_deg=_degrees(limits.angle_min_rad),
            angle_max_deg=_degrees(limits.angle_max_rad),
            rate_max_deg_s=_degrees(limits.rate_max_rad_s),
            acceleration_max_deg_s2=_degrees(limits.acceleration_max_rad_s2),
            jerk_max_deg_s3=_degrees(limits.jerk_max_rad_s3),
            rate_min_deg_s=_degrees(limits.rate_min_rad_s),
            drive=drive,
        )
        for name, axis_platform, limits, drive in zip(
            platform.axis_names,
            (platform.outer_axis_platform, platform.inner_axis_platform),
            platform.axis_limits,
            platform.drives,
            strict=True,
        )
    )
    return PlatformDefinition(
        name=platform.name,
        outer=outer,
        inner=inner,
        zero_direction_platform=platform.zero_direction_platform,
        q_platform_from_body_xyzw=platform.q_platform_from_body_xyzw,
        field_of_view_deg=(frame_deg[0], frame_deg[1]),
        frame_turn_deg=_degrees(platform.frame_turn_rad),
        camera=platform.camera,
        usual_yaw_pitch_roll_deg=platform.usual_yaw_pitch_roll_deg,
        park_positions_deg={
            position.name: dict(
                zip(platform.axis_names, map(_degrees, position.angle_rad), strict=True)
            )
            for position in platform.park_positions
        },
        masks=platform.masks,
        structural_modes=platform.structural_modes,
    )


def _degrees(angle_rad: float) -> float:
    return round(math.degrees(angle_rad), 12)  # 3 deg/s, not 3.0000000000000004
