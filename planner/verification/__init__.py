"""The independent judge of command tables."""

from planner.verification.judge import verify
from planner.verification.report import (
    EarthFixedView,
    Finding,
    LimitMargin,
    SessionReport,
    SkyView,
    VerificationReport,
)

__all__ = [
    "EarthFixedView",
    "Finding",
    "LimitMargin",
    "SessionReport",
    "SkyView",
    "VerificationReport",
    "verify",
]
