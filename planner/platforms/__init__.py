"""Which platforms are known by name?"""

from planner.platforms.definition import AngleDeg, AxisDefinition, JerkDegS3, PlatformDefinition
from planner.platforms.iss_hrc import ISS_HRC
from planner.platforms.structural_mode import StructuralMode
from planner.platforms.two_axis import AxisLimits, TwoAxisPlatform

PLATFORMS = {platform.name: platform for platform in (ISS_HRC,)}

__all__ = [
    "PLATFORMS",
    "AngleDeg",
    "AxisDefinition",
    "AxisLimits",
    "JerkDegS3",
    "PlatformDefinition",
    "StructuralMode",
    "TwoAxisPlatform",
]
