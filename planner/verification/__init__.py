"""The independent judge of command tables."""

from planner.verification.judge import verify
from planner.verification.report import (
    EarthFixedView,
    Finding,
    LimitMargin,
    OffTarget,
    PointingError,
    SessionReport,
    SkyView,
    SlowStretch,
    VerificationReport,
)

__all__ = [
    "EarthFixedView",
    "Finding",
    "LimitMargin",
    "OffTarget",
    "PointingError",
    "SessionReport",
    "SkyView",
    "SlowStretch",
    "VerificationReport",
    "verify",
]
