"""Errors, oscillations, stick-slip and exceeded limits of each axis, as answered."""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from app.answers.telemetry_samples import StretchOut, span
from planner.base.answer_members import Count, NotNegative, Share, Signed
from planner.inflight.telemetry.following import Basis, Limit
from planner.world.plan import SegmentKind

if TYPE_CHECKING:
    from planner.inflight.telemetry.alignment import Estimate
    from planner.inflight.telemetry.compare import AxisComparison, Comparison
    from planner.inflight.telemetry.following import Exceeded, PhaseErrors

_LIST_MAX = 1000
_ARCSEC_PER_RAD = math.degrees(1.0) * 3600.0
_LimitUnit = Literal["deg", "deg/s", "deg/s2"]
_UNITS: dict[Limit, _LimitUnit] = {
    "angle_min": "deg",
    "angle_max": "deg",
    "rate": "deg/s",
    "acceleration": "deg/s2",
}


@dataclass(frozen=True, kw_only=True)
class EstimateOut:
    """An estimate, in the unit that the name of its member says.

    value: the most likely.
    sigma: its 1-sigma error, of the errors' own size and of how they go together in time.
    """

    value: Signed
    sigma: NotNegative


@dataclass(frozen=True, kw_only=True)
class PhaseErrorsOut:
    """Measured less planned during one segment of the table.

    kind: kind of the segment.
    session: number of the session it belongs to, from 0; null on the way to the final state.
    start: of the segment; UTC.
    stop: of the segment; UTC.
    samples: there are of it.
    rms_arcsec: null without samples.
    max_arcsec: the largest, either way; null without samples.
    mean_arcsec: null without samples.
    """

    kind: SegmentKind
    session: Count | None
    start: str
    stop: str
    samples: Count
    rms_arcsec: NotNegative | None
    max_arcsec: NotNegative | None
    mean_arcsec: Signed | None


@dataclass(frozen=True, kw_only=True)
class OscillationOut(StretchOut):
    """A stretch in which the axis swings about its plan.

    frequency_hz: of the sinusoid that fits best. E.g. `0.8`.
    amplitude_arcsec: of the sinusoid. E.g. `12.5`.
    """

    frequency_hz: NotNegative
    amplitude_arcsec: NotNegative


@dataclass(frozen=True, kw_only=True)
class StickSlipOut(StretchOut):
    """A stretch in which the axis stands while its command moves, and catches up in slips.

    slips: number of slips. E.g. `4`.
    stuck_share: of the time that it stood. E.g. `0.6`.
    slip_arcsec: the farthest slip. E.g. `10.5`.
    rate_arcsec_s: largest rate commanded meanwhile [arcsec/s]. E.g. `18.2`.
    """

    slips: Count
    stuck_share: Share
    slip_arcsec: NotNegative
    rate_arcsec_s: NotNegative


@dataclass(frozen=True, kw_only=True)
class ExceededOut(StretchOut):
    """A stretch in which the measured motion went beyond a limit, by more than its noise.

    limit: the limit that was exceeded. E.g. `"rate"`.
    value: the farthest, in `unit`. E.g. `3.2`.
    bound: the limit, in `unit`. E.g. `3.0`.
    unit: of both. E.g. `"deg/s"`.
    """

    limit: Limit
    value: Signed
    bound: Signed
    unit: _LimitUnit


@dataclass(frozen=True, kw_only=True)
class AxisComparisonOut:
    """Errors of one axis, measured less planned, with the telemetry's clock corrected.

    basis: `angles` for errors of angles, `rates` for errors of rates added up: of the latter a
    constant and a steady drift can't be seen and are left out.
    samples: errors there are.
    rms_arcsec: of all errors.
    max_arcsec: the largest, either way.
    mean_arcsec: of all errors.
    gain: measured over planned: of an encoder's scale, a gear or a unit; near -1 where the axis is
    measured the other way round, whose errors are those with the sign changed. Null where the axis
    doesn't follow its plan, and of a body's attitude, which has none.
    bias: the measured value where the plan is at zero: of an encoder's zero, a gyro's, or of a
    tracker's mount; null where the axis doesn't follow its plan.
    bias_unit: of `bias`: of angles, or of rates where `basis` is rates.
    rate_gain: gain of rates sent beside angles, as of a gyro; null without.
    rate_bias_arcsec_s: the measured rate where the plan stands still; null likewise.
    noise_arcsec: of the sensor of a body's attitude, 1 sigma, each row by itself; null of axes, of
    rates alone and of too short samples.
    wander_arcsec: of a body's attitude, 1 sigma, slow against rows; null where too slow to tell.
    wander_half_life_s: time in which the wander forgets half of itself; null likewise.
    lag_s: delay of the axis behind the earliest one, where none is clearly earlier behind the best
    known, so within its error it may be below zero; a delay of all can't be separated from the
    clock, and is in `time_offset_s`. Null for an axis that gives no time, as it doesn't follow its
    plan or hardly moves; `warnings` say which.
    lag_sigma_s: 1-sigma error of the axes' difference; null without `lag_s`.
    phases: segment by segment of the table.
    oscillations: in order of time, at most 1,000.
    oscillations_searched_hz: lowest and highest frequency that the samples are long and fine enough
    to show; null where they are too few. E.g. `[0.05, 6.8]`.
    stick_slip: stretches in order of time, at most 1,000.
    limits_exceeded: stretches in order of time, at most 1,000.
    limits_checked: limits that the samples are fine enough to check; none of an axis that doesn't
    follow its plan.
    """

    basis: Basis
    samples: Count
    rms_arcsec: NotNegative
    max_arcsec: NotNegative
    mean_arcsec: Signed
    gain: EstimateOut | None
    bias: EstimateOut | None
    bias_unit: Literal["arcsec", "arcsec/s"]
    rate_gain: EstimateOut | None
    rate_bias_arcsec_s: EstimateOut | None
    noise_arcsec: EstimateOut | None
    wander_arcsec: EstimateOut | None
    wander_half_life_s: EstimateOut | None
    lag_s: Signed | None
    lag_sigma_s: NotNegative | None
    phases: list[PhaseErrorsOut]
    oscillations: list[OscillationOut]
    oscillations_searched_hz: list[NotNegative] | None
    stick_slip: list[StickSlipOut]
    limits_exceeded: list[ExceededOut]
    limits_checked: list[Limit]


def axis_of(comparison: "Comparison", axis: "AxisComparison") -> AxisComparisonOut:
    """Its angles in arcsec."""
    rates, wander, searched_hz = axis.rates, axis.wander, axis.oscillations_searched_hz
    return AxisComparisonOut(
        basis=axis.followed.basis,
        samples=axis.error.samples,
        rms_arcsec=arcsec(axis.error.rms_rad),
        max_arcsec=arcsec(axis.error.max_rad),
        mean_arcsec=arcsec(axis.error.mean_rad),
        gain=_told(axis.gain, 9),
        bias=_told(axis.bias, 6, _ARCSEC_PER_RAD),
        bias_unit="arcsec" if axis.followed.basis == "angles" else "arcsec/s",
        rate_gain=_told(rates.gain if rates else None, 9),
        rate_bias_arcsec_s=_told(rates.bias if rates else None, 6, _ARCSEC_PER_RAD),
        noise_arcsec=_told(wander.noise_rad if wander else None, 4, _ARCSEC_PER_RAD),
        wander_arcsec=_told(wander.sigma_rad if wander else None, 4, _ARCSEC_PER_RAD),
        wander_half_life_s=_told(wander.half_life_s if wander else None, 4),
        lag_s=None if axis.lag_s is None else round(axis.lag_s.value, 9),
        lag_sigma_s=None if axis.lag_s is None else round(axis.lag_s.sigma, 9),
        phases=[_phase(comparison, phase) for phase in axis.phases],
        oscillations=[
            OscillationOut(
                frequency_hz=round(one.frequency_hz, 6),
                amplitude_arcsec=arcsec(one.amplitude_rad),
                **span(comparison, one.start_s, one.stop_s),
            )
            for one in axis.oscillations[:_LIST_MAX]
        ],
        oscillations_searched_hz=searched_hz and [round(one, 6) for one in searched_hz],
        stick_slip=[
            StickSlipOut(
                slips=one.slips,
                stuck_share=round(one.stuck_share, 3),
                slip_arcsec=arcsec(one.slip_rad),
                rate_arcsec_s=arcsec(one.rate_rad_s),
                **span(comparison, one.start_s, one.stop_s),
            )
            for one in axis.stick_slip[:_LIST_MAX]
        ],
        limits_exceeded=[_exceeded(comparison, one) for one in axis.limits_exceeded[:_LIST_MAX]],
        limits_checked=list(axis.limits_checked),
    )


def estimate(found: "Estimate", decimals: int, scale: float = 1.0) -> EstimateOut:
    """Scaled into its member's unit."""
    return EstimateOut(
        value=round(scale * found.value, decimals) + 0.0,
        sigma=round(scale * found.sigma, decimals),
    )


def _told(found: "Estimate | None", decimals: int, scale: float = 1.0) -> EstimateOut | None:
    return None if found is None else estimate(found, decimals, scale)


def _phase(comparison: "Comparison", phase: "PhaseErrors") -> PhaseErrorsOut:
    return PhaseErrorsOut(
        kind=phase.kind,
        session=phase.session,
        samples=phase.error.samples,
        rms_arcsec=_or_none(phase.error.rms_rad),
        max_arcsec=_or_none(phase.error.max_rad),
        mean_arcsec=_or_none(phase.error.mean_rad),
        **span(comparison, phase.start_s, phase.stop_s),
    )


def _exceeded(comparison: "Comparison", one: "Exceeded") -> ExceededOut:
    return ExceededOut(
        limit=one.limit,
        value=round(math.degrees(one.value), 6),
        bound=round(math.degrees(one.bound), 6),
        unit=_UNITS[one.limit],
        **span(comparison, one.start_s, one.stop_s),
    )


def _or_none(angle_rad: float) -> float | None:
    """None for NaN, of no samples."""
    return None if math.isnan(angle_rad) else arcsec(angle_rad)


def arcsec(angle_rad: float) -> float:
    """To a ten-thousandth, without a negative zero."""
    return round(angle_rad * _ARCSEC_PER_RAD, 4) + 0.0
