"""The findings on limits: what the judge of the platform's kind measured, against what may be."""

import math
from collections.abc import Iterator

from planner.verification.field_masks import TOLERANCE_RAD
from planner.verification.report import (
    ExclusionMargin,
    Finding,
    GyroLimit,
    GyroMargin,
    KeepOutMargin,
    Limit,
    LimitMargin,
)

# A solver works to 1e-8 and a drive resolves 1e-4 of its range: neither is worth a rejection.
RELATIVE_TOLERANCE = 1e-6
_TOLD: dict[GyroLimit, tuple[Limit, str]] = {
    "torque": ("torque", "the gyros' torque reaches {}"),
    "momentum": ("momentum", "the gyros' momentum reaches {}"),
    "gimbal_rate": ("rate", "a gimbal turns at {}"),
    "gimbal_rate_needed": ("rate", "the torque takes a gimbal to {}"),
    "momentum_mismatch": ("momentum", "the gimbals hold {} other than the body's motion asks"),
}


def limit_findings(margins: tuple[LimitMargin, ...]) -> Iterator[Finding]:
    """One error for each limit that is broken by more than rounding."""
    for margin in margins:
        if margin.margin < -margin.tolerance:
            yield Finding(
                limit=margin.kind,
                axis=margin.axis,
                t_s=margin.t_s,
                at_utc=margin.at_utc,
                detail=(
                    f"{margin.axis} reaches {math.degrees(margin.extreme):.6g} {margin.unit}, "
                    f"{math.degrees(-margin.margin):.3g} {margin.unit} past its limit of "
                    f"{math.degrees(margin.limit):.6g} {margin.unit} ({margin.kind}), "
                    f"{margin.t_s:.3f} s after the table's epoch"
                ),
            )


def exclusion_findings(margins: tuple[ExclusionMargin, ...]) -> Iterator[Finding]:
    """One error for each exclusion that is entered."""
    for margin in margins:
        if margin.margin_rad is not None and margin.margin_rad < -TOLERANCE_RAD:
            yield Finding(
                limit="exclusion",
                t_s=margin.t_s,
                at_utc=margin.at_utc,
                detail=(
                    f'"{margin.name}" is entered by {-math.degrees(margin.margin_rad):.3f} deg, '
                    f"{margin.t_s:.2f} s after the table's epoch"
                ),
            )


def keep_out_findings(margins: tuple[KeepOutMargin, ...]) -> Iterator[Finding]:
    """One error for each cone that is entered."""
    for margin in margins:
        away_rad = margin.away_min_rad
        if away_rad is not None and away_rad < margin.half_angle_rad - TOLERANCE_RAD:
            yield Finding(
                limit="keep_out",
                t_s=margin.t_s,
                at_utc=margin.at_utc,
                detail=(
                    f"the boresight comes {math.degrees(away_rad):.3f} deg near {margin.about}, "
                    f"less than {math.degrees(margin.half_angle_rad):.3f} deg, {margin.t_s:.2f} s "
                    "after the table's epoch"
                ),
            )


def gyro_findings(margins: tuple[GyroMargin, ...]) -> Iterator[Finding]:
    """One error for each limit of the gyros that is passed by more than rounding."""
    for one in margins:
        if one.margin < -RELATIVE_TOLERANCE * one.limit:
            limit, told = _TOLD[one.name]
            reached = told.format(f"{one.extreme:.6g} {one.unit}")
            yield Finding(
                limit=limit,
                t_s=one.t_s,
                at_utc=one.at_utc,
                detail=f"{reached}, more than {one.limit:.6g}",
            )
