"""How far off its target the boresight may be, and where it tracks it only nearly."""

import math
from collections.abc import Iterator

import numpy as np

from planner.arrays import Array
from planner.frames.time_scales import utc_text
from planner.scenario import Scenario
from planner.verification.report import Finding, OffTarget, SessionReport
from planner.verification.session import TableSession

EXACT_RAD = math.radians(0.1 / 3600.0)  # a seventh of a pixel of the HRC
_ARCSEC_PER_RAD = math.degrees(1.0) * 3600.0


def allowed_rad(scenario: Scenario, number: int) -> float:
    """0.1 arcsec, or the circle inside the frame where the session is content with that."""
    if scenario.sessions[number].keyhole == "nearest":
        return max(EXACT_RAD, min(scenario.platform.frame_half_rad))
    return EXACT_RAD


def off_target(flown: TableSession, error_rad: Array, exact_rad: Array) -> tuple[OffTarget, ...]:
    """Where the error (n,) is larger than an exact track's (n,), good to the judged instants."""
    beyond = np.concatenate([[False], error_rad > exact_rad, [False]])
    edges = np.flatnonzero(np.diff(beyond)).reshape(-1, 2)
    last = len(error_rad) - 1
    return tuple(
        OffTarget(
            start_utc=flown.utc(max(int(start) - 1, 0)),
            stop_utc=flown.utc(min(int(stop), last)),
            max_rad=float(error_rad[start:stop].max()),
        )
        for start, stop in edges
    )


def nearness_findings(report: SessionReport) -> Iterator[Finding]:
    """The warning that a session is tracked only nearly; nothing where it is tracked exactly."""
    if report.allowed_rad <= EXACT_RAD or not report.off_target:
        return
    worst, stretches = report.overall, report.off_target
    share = worst.max_rad / report.allowed_rad
    yield Finding(
        detail=(
            f"sessions.{report.number} is tracked as near as the limits allow: from "
            f"{utc_text(stretches[0].start_utc, 1)} to {utc_text(stretches[-1].stop_utc, 1)} the "
            f"boresight is up to {worst.max_rad * _ARCSEC_PER_RAD:.3g} arcsec off the target, at "
            f"{utc_text(worst.max_utc, 1)} {share:.0%} of the way to the frame's nearest edge; "
            f"rms {worst.rms_rad * _ARCSEC_PER_RAD:.3g} arcsec over the session"
        ),
        severity="warning",
        limit="pointing",
        axis=None,
        t_s=worst.max_t_s,
        at_utc=worst.max_utc,
    )
