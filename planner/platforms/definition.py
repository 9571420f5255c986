"""How does a person write down a two-axis platform?  In degrees."""

import math

from planner.platforms.two_axis import (
    HRC_FRAME_HALF_RAD,
    AxisLimits,
    TwoAxisPlatform,
    Vector3,
)
from planner.spec import spec

HRC_FIELD_OF_VIEW_DEG = (
    math.degrees(2.0 * HRC_FRAME_HALF_RAD[0]),
    math.degrees(2.0 * HRC_FRAME_HALF_RAD[1]),
)


@spec
class AxisDefinition:
    """One gimbal axis as its data sheet gives it; the fields of `AxisLimits` in degrees."""

    name: str
    axis_platform: Vector3
    angle_min_deg: float
    angle_max_deg: float
    rate_max_deg_s: float
    acceleration_max_deg_s2: float
    jerk_max_deg_s3: float
    rate_min_deg_s: float = 0.0

    def __post_init__(self) -> None:
        if not self.name:
            raise ValueError("name must not be empty: angles and rates are given per axis name")
        for name in ("rate_max_deg_s", "acceleration_max_deg_s2", "jerk_max_deg_s3"):
            value = getattr(self, name)
            if not 1e-4 <= value <= 1e3:
                raise ValueError(f"{name} must lie in 0.0001..1000, not {value:g}")
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
    """A `TwoAxisPlatform`: `outer` is fixed to the base and carries `inner`.

    field_of_view_deg: the camera's, along the inner axis and across it; the HRC's unless given.
    """

    name: str
    outer: AxisDefinition
    inner: AxisDefinition
    zero_direction_platform: Vector3 = (0.0, 0.0, 1.0)
    q_platform_from_body_xyzw: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 1.0)
    field_of_view_deg: tuple[float, float] = HRC_FIELD_OF_VIEW_DEG

    def __post_init__(self) -> None:
        if not all(1e-6 <= width <= 170.0 for width in self.field_of_view_deg):
            raise ValueError(
                f"field_of_view_deg must lie in 0.000001..170, not {self.field_of_view_deg}"
            )
        if self.outer.name == self.inner.name:
            raise ValueError(f"the axes need two names, not {self.outer.name!r} twice")
        self.platform()

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
        )
