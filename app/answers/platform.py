"""A platform in the form in which a request writes it out."""

from app.answers.members import degrees, fill
from planner.world.platforms import AxisDefinition, AxisDrive, AxisLimits, PlatformDefinition
from planner.world.platforms.two_axis import TwoAxisPlatform, UnitVector

_DECIMALS = 12  # 3 deg/s, not 3.0000000000000004


def definition_of(platform: TwoAxisPlatform) -> PlatformDefinition:
    """The platform in degrees."""
    return PlatformDefinition(
        name=platform.name,
        outer=_axis(
            platform.outer_name,
            platform.outer_axis_platform,
            platform.outer_limits,
            platform.drives[0],
        ),
        inner=_axis(
            platform.inner_name,
            platform.inner_axis_platform,
            platform.inner_limits,
            platform.drives[1],
        ),
        zero_direction_platform=platform.zero_direction_platform,
        q_platform_from_body_xyzw=platform.q_platform_from_body_xyzw,
        field_of_view_deg=(
            degrees(2.0 * platform.frame_half_rad[0], _DECIMALS),
            degrees(2.0 * platform.frame_half_rad[1], _DECIMALS),
        ),
        frame_turn_deg=degrees(platform.frame_turn_rad, _DECIMALS),
        camera=platform.camera,
        usual_yaw_pitch_roll_deg=platform.usual_yaw_pitch_roll_deg,
        park_positions_deg={
            position.name: {
                axis: degrees(angle_rad, _DECIMALS)
                for axis, angle_rad in zip(platform.axis_names, position.angle_rad, strict=True)
            }
            for position in platform.park_positions
        },
        masks=platform.masks,
        structural_modes=platform.structural_modes,
    )


def _axis(
    name: str, axis_platform: UnitVector, limits: AxisLimits, drive: AxisDrive
) -> AxisDefinition:
    return fill(
        AxisDefinition,
        limits,
        name=name,
        axis_platform=axis_platform,
        drive=drive,
        decimals=_DECIMALS,
    )
