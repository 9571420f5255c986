"""The platforms known by name."""

from planner.platforms.camera import PIXELS_ARCSEC, Camera
from planner.platforms.carrier_mode import CarrierMode
from planner.platforms.choice import PLATFORMS, Platform
from planner.platforms.definition import AngleDeg, AxisDefinition, JerkDegS3, PlatformDefinition
from planner.platforms.drive import IDEAL_DRIVE, AxisDrive
from planner.platforms.field_mask import FieldMask
from planner.platforms.iss_hrc import ISS_HRC
from planner.platforms.two_axis import AxisLimits, ParkPosition, StructuralMode, TwoAxisPlatform

__all__ = [
    "IDEAL_DRIVE",
    "ISS_HRC",
    "PIXELS_ARCSEC",
    "PLATFORMS",
    "AngleDeg",
    "AxisDefinition",
    "AxisDrive",
    "AxisLimits",
    "Camera",
    "CarrierMode",
    "FieldMask",
    "JerkDegS3",
    "ParkPosition",
    "Platform",
    "PlatformDefinition",
    "StructuralMode",
    "TwoAxisPlatform",
]
