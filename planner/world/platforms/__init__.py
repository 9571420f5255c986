"""The platforms known by name."""

from planner.world.platforms.body import BodyPlatform, RollRule
from planner.world.platforms.camera import PIXELS_ARCSEC, Camera, Shutter
from planner.world.platforms.carrier_mode import CarrierMode
from planner.world.platforms.choice import BODIES, PLATFORMS, AnyPlatform, Platform
from planner.world.platforms.definition import (
    AngleDeg,
    AxisDefinition,
    FinalAngles,
    JerkDegS3,
    PlatformDefinition,
    definition_of,
)
from planner.world.platforms.drive import IDEAL_DRIVE, AxisDrive
from planner.world.platforms.field_mask import FieldMask
from planner.world.platforms.geometry import Bounds, MotionBounds, PlatformGeometry
from planner.world.platforms.iss_hrc import ISS_HRC
from planner.world.platforms.two_axis import (
    AxisLimits,
    ParkPosition,
    StructuralMode,
    TwoAxisPlatform,
)

__all__ = [
    "BODIES",
    "IDEAL_DRIVE",
    "ISS_HRC",
    "PIXELS_ARCSEC",
    "PLATFORMS",
    "AngleDeg",
    "AnyPlatform",
    "AxisDefinition",
    "AxisDrive",
    "AxisLimits",
    "BodyPlatform",
    "Bounds",
    "Camera",
    "CarrierMode",
    "FieldMask",
    "FinalAngles",
    "JerkDegS3",
    "MotionBounds",
    "ParkPosition",
    "Platform",
    "PlatformDefinition",
    "PlatformGeometry",
    "RollRule",
    "Shutter",
    "StructuralMode",
    "TwoAxisPlatform",
    "definition_of",
]
