"""The optimal slew beside the paper's spline, in figures that answers hold."""

from typing import Annotated

from planner.base.answer_members import AngleSize, Count, Member, NotNegative, Share, answer

_Amplitude = Annotated[float, Member("arcsec", 0.0)]


@answer
class AxisFigures:
    """One axis over one slew; null where the acceleration jumps and the jerk has no bound.

    peak_rate_rad_s: largest rate.
    peak_acceleration_rad_s2: largest acceleration.
    peak_jerk_rad_s3: largest jerk.
    jerk_squared_integral_rad2_s5: the cost the objective `smooth` makes least.
    limits_broken: limits the axis breaks. E.g. `["rate"]`.
    end_error_rad: the angle reached at the end less the one wanted.
    """

    peak_rate_rad_s: AngleSize
    peak_acceleration_rad_s2: AngleSize
    peak_jerk_rad_s3: AngleSize | None
    jerk_squared_integral_rad2_s5: Annotated[float, Member("deg2", 0.0)] | None
    limits_broken: tuple[str, ...]
    end_error_rad: Annotated[float, Member("arcsec", decimals=9)]


@answer
class ModeResidual:
    """Residual vibration of one of `slew.avoid_modes` after the slew, by axis.

    The mode's share in the axis's motion is taken as one: deflections scale with it.

    frequency_hz: of the mode. E.g. `0.2`.
    damping: of the mode, as a share of critical. E.g. `0.005`.
    ocp_rad: after the optimal slew. E.g. `{"alpha": 0.01, "beta": 0.0}`.
    spline_rad: after the paper's spline. E.g. `{"alpha": 42.0, "beta": 1.3}`.
    """

    frequency_hz: NotNegative
    damping: Share
    ocp_rad: dict[str, _Amplitude]
    spline_rad: dict[str, _Amplitude]


@answer
class SlewComparison:
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
    least_s: Annotated[float, Member(least=0.0, decimals=9)] | None
    paper_s: NotNegative
    ocp: dict[str, AxisFigures]
    spline: dict[str, AxisFigures]
    residual_vibration: tuple[ModeResidual, ...]
