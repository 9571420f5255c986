"""The independent judge of command tables."""

from typing import TYPE_CHECKING

from planner.base.on_first_use import on_first_use
from planner.verification.report import (
    Finding,
    LimitMargin,
    Reserve,
    SessionReport,
    VerificationReport,
)

if TYPE_CHECKING:
    from planner.verification.judge import verify
else:
    __getattr__ = on_first_use(verify="planner.verification.judge")

__all__ = [
    "Finding",
    "LimitMargin",
    "Reserve",
    "SessionReport",
    "VerificationReport",
    "verify",
]
