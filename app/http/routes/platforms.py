"""The platforms that can be named in a request, over HTTP."""

import math
from dataclasses import dataclass

from fastapi import APIRouter, Depends

from app.http.negotiation import accepts_json
from planner.platforms import PLATFORMS, AxisDefinition, AxisLimits, PlatformDefinition
from planner.platforms.two_axis import TwoAxisPlatform, UnitVector

router = APIRouter(tags=["platforms"], dependencies=[Depends(accepts_json)])


@dataclass(frozen=True, kw_only=True)
class PlatformList:
    """Every registered platform, written as a request may write out its own."""

    platforms: list[PlatformDefinition]


@router.get("/v1/platforms", summary="The platforms known by name")
async def get_platforms() -> PlatformList:
    """Axes, limits and mount of each; copy one into a request's `platform` to change it."""
    return PlatformList(platforms=[definition_of(platform) for platform in PLATFORMS.values()])


def definition_of(platform: TwoAxisPlatform) -> PlatformDefinition:
    """The platform in degrees."""
    return PlatformDefinition(
        name=platform.name,
        outer=_axis(platform.outer_name, platform.outer_axis_platform, platform.outer_limits),
        inner=_axis(platform.inner_name, platform.inner_axis_platform, platform.inner_limits),
        zero_direction_platform=platform.zero_direction_platform,
        q_platform_from_body_xyzw=platform.q_platform_from_body_xyzw,
        field_of_view_deg=(
            _degrees(2.0 * platform.frame_half_rad[0]),
            _degrees(2.0 * platform.frame_half_rad[1]),
        ),
        frame_turn_deg=_degrees(platform.frame_turn_rad),
    )


def _axis(name: str, axis_platform: UnitVector, limits: AxisLimits) -> AxisDefinition:
    return AxisDefinition(
        name=name,
        axis_platform=axis_platform,
        angle_min_deg=_degrees(limits.angle_min_rad),
        angle_max_deg=_degrees(limits.angle_max_rad),
        rate_max_deg_s=_degrees(limits.rate_max_rad_s),
        acceleration_max_deg_s2=_degrees(limits.acceleration_max_rad_s2),
        jerk_max_deg_s3=_degrees(limits.jerk_max_rad_s3),
        rate_min_deg_s=_degrees(limits.rate_min_rad_s),
    )


def _degrees(angle_rad: float) -> float:
    """Without the last digit's noise: 3 deg/s, not 3.0000000000000004."""
    return round(math.degrees(angle_rad), 12)
