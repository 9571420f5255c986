"""The optimal slew compared with the paper's spline, as an answer holds it."""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from app.answers.members import DECIMALS, fill
from app.answers.ranges import Count, NotNegative, Share, Signed

if TYPE_CHECKING:
    from planner.motion.baseline.compare import SlewComparison, SlewFigures


@dataclass(frozen=True, kw_only=True)
class AxisFigures:
    """One axis over one slew; null where the acceleration jumps and the jerk has no bound.

    peak_rate_deg_s: largest rate.
    peak_acceleration_deg_s2: largest acceleration.
    peak_jerk_deg_s3: largest jerk.
    jerk_squared_integral_deg2_s5: the cost the objective `smooth` makes least.
    limits_broken: limits the axis breaks. E.g. `["rate"]`.
    end_error_arcsec: the angle reached at the end less the one wanted.
    """

    peak_rate_deg_s: NotNegative
    peak_acceleration_deg_s2: NotNegative
    peak_jerk_deg_s3: NotNegative | None
    jerk_squared_integral_deg2_s5: NotNegative | None
    limits_broken: list[str]
    end_error_arcsec: Signed


@dataclass(frozen=True, kw_only=True)
class ModeResidualOut:
    """Residual vibration of one of `slew.avoid_modes` after the slew, by axis.

    The mode's share in the axis's motion is taken as one: deflections scale with it.

    frequency_hz: of the mode. E.g. `0.2`.
    damping: of the mode, as a share of critical. E.g. `0.005`.
    ocp_arcsec: after the optimal slew. E.g. `{"alpha": 0.01, "beta": 0.0}`.
    spline_arcsec: after the paper's spline. E.g. `{"alpha": 42.0, "beta": 1.3}`.
    """

    frequency_hz: NotNegative
    damping: Share
    ocp_arcsec: dict[str, NotNegative]
    spline_arcsec: dict[str, NotNegative]


@dataclass(frozen=True, kw_only=True)
class SlewComparisonOut:
    """Both ways over the same time between the same states, by axis.

    session: number of the session it leads to, from 0; null for the slew to the final state.
    duration_s: of the slew.
    least_s: the least time the limits allow.
    paper_s: the time the paper's estimate asks for (Sumarokov 2016, eq. 12-13).
    ocp: the optimal slew, by axis.
    spline: the paper's spline, by axis.
    residual_vibration: one entry for each mode to suppress.
    """

    session: Count | None
    duration_s: NotNegative
    least_s: NotNegative | None
    paper_s: NotNegative
    ocp: dict[str, AxisFigures]
    spline: dict[str, AxisFigures]
    residual_vibration: list[ModeResidualOut]


def comparison_out(session: int | None, comparison: "SlewComparison") -> SlewComparisonOut:
    """In degrees."""
    names = comparison.axis_names
    return SlewComparisonOut(
        session=session,
        duration_s=comparison.ocp.duration_s,
        least_s=_finite(comparison.least_duration_s),
        paper_s=comparison.paper_duration_s,
        ocp=_by_axis(names, comparison.ocp),
        spline=_by_axis(names, comparison.spline),
        residual_vibration=[
            fill(
                ModeResidualOut,
                residual.mode,
                ocp_arcsec=_arcsec_by_axis(names, residual.ocp_rad),
                spline_arcsec=_arcsec_by_axis(names, residual.spline_rad),
            )
            for residual in comparison.residuals
        ],
    )


def _by_axis(names: tuple[str, ...], figures: "SlewFigures") -> dict[str, AxisFigures]:
    deg = math.degrees(1.0)
    return {
        name: AxisFigures(
            peak_rate_deg_s=round(figures.peak_rate_rad_s[axis] * deg, DECIMALS),
            peak_acceleration_deg_s2=round(figures.peak_acceleration_rad_s2[axis] * deg, DECIMALS),
            peak_jerk_deg_s3=_finite(figures.peak_jerk_rad_s3[axis] * deg),
            jerk_squared_integral_deg2_s5=_finite(
                figures.jerk_squared_integral[axis] * deg**2, None
            ),
            limits_broken=[found.limit for found in figures.violations if found.axis == name],
            end_error_arcsec=round(figures.end_error_rad[axis] * deg * 3600.0, DECIMALS),
        )
        for axis, name in enumerate(names)
    }


def _arcsec_by_axis(names: tuple[str, ...], amplitude_rad: tuple[float, ...]) -> dict[str, float]:
    return {
        name: math.degrees(amplitude) * 3600.0
        for name, amplitude in zip(names, amplitude_rad, strict=True)
    }


def _finite(value: float, decimals: int | None = DECIMALS) -> float | None:
    if not math.isfinite(value):
        return None
    return value if decimals is None else round(value, decimals)
