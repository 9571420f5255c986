"""The answer to telemetry beside a plan: arcsec, seconds and UTC by the plan's clock."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from app.answers.horizon import CorrectionOut
from app.answers.members import ProvenanceOut, fill, to_json
from app.answers.platform import definition_of
from app.answers.ranges import Count, NotNegative, Share, Signed
from planner.arrays import Array
from planner.attitude.corrections import AttitudeCorrection
from planner.export import SegmentKind
from planner.frames.time_scales import shifted_utc, utc_text
from planner.platforms import PlatformDefinition
from planner.telemetry.alignment import Estimate
from planner.telemetry.attitude import PointingParts
from planner.telemetry.columns import AngleUnit, Kind, UnitFrom
from planner.telemetry.compare import AxisComparison, Comparison
from planner.telemetry.exceeded import Exceeded, Limit
from planner.telemetry.following import Basis, PhaseErrors
from planner.telemetry.parameters import Parameter, PlatformFound
from planner.telemetry.samples import Dropped

_ARCSEC_PER_RAD = math.degrees(1.0) * 3600.0
_LIST_MAX = 1000
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
class StretchOut:
    """Of time, by the plan's clock.

    start: when it begins; UTC. E.g. `"2015-02-27T17:36:20.000Z"`.
    stop: when it ends; UTC. E.g. `"2015-02-27T17:36:24.000Z"`.
    """

    start: str
    stop: str


@dataclass(frozen=True, kw_only=True)
class TelemetryColumnOut:
    """How a column was read.

    name: as it was sent.
    axis: the axis it tells of.
    kind: of its angle or of its rate.
    unit: in which it was read; of a rate, the unit's part before the time.
    unit_from: what said so: the column's name, a row of units under the names, or which unit fits
    the plan.
    """

    name: str
    axis: str
    kind: Kind
    unit: AngleUnit
    unit_from: UnitFrom


@dataclass(frozen=True, kw_only=True)
class SamplesOut:
    """What became of the rows.

    read: rows there were: those used and those dropped.
    used: rows that the comparison rests on.
    dropped: rows by reason: `no_time` and `no_value` hold no number there, `repeated` have a time
    tag again, `clock_reset` belong to a clock that began anew, `outside_plan` lie before or after
    its table, `outlier` stand out from those around. E.g. `{"outlier": 3}`.
    reordered: rows used that came before an earlier one.
    wrapped: angles that were brought within half a turn of the plan.
    start: of the first row used; UTC.
    stop: of the last row used; UTC.
    step_s: usual time from row to row.
    gaps: stretches without rows, at most 200. E.g.
    `[{"start": "2015-02-27T17:35:00.000Z", "stop": "2015-02-27T17:35:10.000Z"}]`.
    columns: those read.
    ignored_columns: names of those that tell of no axis, or hold nothing. E.g. `["temperature"]`.
    """

    read: Count
    used: Count
    dropped: dict[Dropped, Count]
    reordered: Count
    wrapped: Count
    start: str
    stop: str
    step_s: NotNegative
    gaps: list[StretchOut]
    columns: list[TelemetryColumnOut]
    ignored_columns: list[str]


@dataclass(frozen=True, kw_only=True)
class PhaseErrorsOut:
    """Measured less planned during one segment of the table.

    kind: what the table does.
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

    slips: how often it let go. E.g. `4`.
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

    limit: which. E.g. `"rate"`.
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
    """What one axis did, measured less planned, once the telemetry's clock was set right.

    basis: whether errors are those of angles, or of rates added up: of those a constant and a
    steady drift can't be seen and are left out.
    samples: errors there are.
    rms_arcsec: of all errors.
    max_arcsec: the largest, either way.
    mean_arcsec: of all errors.
    lag_s: how much later the axis moves than the other one; what both are late by can't be told
    from the clock, and is in `time_offset_s`.
    lag_sigma_s: 1-sigma error of the axes' difference.
    phases: segment by segment of the table.
    oscillations: in order of time, at most 1,000.
    oscillations_searched_hz: lowest and highest frequency that the samples are long and fine enough
    to tell of; null where they are too few. E.g. `[0.067, 6.8]`.
    stick_slip: stretches in order of time, at most 1,000.
    limits_exceeded: stretches in order of time, at most 1,000.
    limits_checked: limits that the samples are fine enough to tell of.
    """

    basis: Basis
    samples: Count
    rms_arcsec: NotNegative
    max_arcsec: NotNegative
    mean_arcsec: Signed
    lag_s: Signed
    lag_sigma_s: NotNegative
    phases: list[PhaseErrorsOut]
    oscillations: list[OscillationOut]
    oscillations_searched_hz: list[NotNegative] | None
    stick_slip: list[StickSlipOut]
    limits_exceeded: list[ExceededOut]
    limits_checked: list[Limit]


@dataclass(frozen=True, kw_only=True)
class PointingPartsOut:
    """How far the target was from the frame's centre at an instant and why: along the frame's
    first side and its second.

    at: when; UTC. E.g. `"2015-02-27T17:37:00.000Z"`.
    session: number of the session then, from 0; null outside of sessions. E.g. `0`.
    measured: what told of the attitude: a rotation as of the horizon, or the target in an image.
    E.g. `"image"`.
    axes_arcsec: error of the boresight by the axes; null without angles of both. E.g.
    `[2.5, -1.0]`.
    attitude_arcsec: of the target by the attitude, beyond what the plan reckoned with. E.g.
    `[432.0, -180.0]`.
    attitude_sigma_arcsec: 1-sigma of each. E.g. `[3.6, 3.6]`.
    target_arcsec: of the target from the frame's centre: attitude less axes; null without axes.
    E.g. `[429.5, -179.0]`.
    """

    at: str
    session: Count | None
    measured: Literal["rotation", "image"]
    axes_arcsec: list[Signed] | None
    attitude_arcsec: list[Signed]
    attitude_sigma_arcsec: list[NotNegative]
    target_arcsec: list[Signed] | None


@dataclass(frozen=True, kw_only=True)
class ParameterOut:
    """A parameter of the platform as it must have been.

    name: the axis's name, a dot, and the field's in `platform`. E.g. `"beta.coulomb_deg_s2"`.
    planned: what the plan's platform has, in the field's unit. E.g. `0.05`.
    found: what it must have been. E.g. `0.1`.
    sigma: 1-sigma error; null where the found one is a bound, as of `rate_min_deg_s`, below which
    the axis was seen to stick and slip. E.g. `0.001`.
    """

    name: str
    planned: Signed
    found: Signed
    sigma: NotNegative | None


@dataclass(frozen=True, kw_only=True)
class ComparisonResponse:
    """Telemetry beside the plan that was flown.

    plan: id of the plan.
    name: the plan's.
    epoch: of the plan's table, from which the clock is told; UTC.
    samples: what became of the rows.
    time_offset_s: by how much the telemetry's clock is ahead at `epoch`: a time tag is the plan's
    time, plus this, plus `clock_drift` times the seconds since `epoch`.
    clock_drift: by how much the telemetry's clock gains, a share of time.
    axes: by the axis's name, those with samples.
    pointing: what corrections and image offsets say beside the axes.
    corrections: of the attitude against its law, as `attitude.corrections` of the next request
    takes them: measured ones given and those found of images. Angles of the axes alone say nothing
    of the attitude: without either there are none.
    parameters: of the platform, those asked for by `identify` and the least smooth rate of an axis
    that stuck and slipped above it.
    platform: as planned with, but for `parameters`, as `platform` of the next request takes it;
    null where none was found. E.g. `null`.
    warnings: what one should know before relying on it. E.g.
    `["alpha_deg fits the plan in rad and was read so, not in deg as its name says"]`.
    """

    plan: str
    name: str
    epoch: str
    samples: SamplesOut
    time_offset_s: EstimateOut
    clock_drift: EstimateOut
    axes: dict[str, AxisComparisonOut]
    pointing: list[PointingPartsOut]
    corrections: list[CorrectionOut]
    parameters: list[ParameterOut]
    platform: PlatformDefinition | None
    warnings: list[str]
    provenance: ProvenanceOut


def comparison_json(
    comparison: Comparison,
    pointing: Sequence[PointingParts],
    found: PlatformFound | None,
    plan_id: str,
    provenance: ProvenanceOut,
) -> bytes:
    """The whole answer as UTF-8 JSON."""
    scenario = comparison.plan.scenario
    return to_json(
        ComparisonResponse(
            plan=plan_id,
            name=scenario.name,
            epoch=utc_text(comparison.plan.table.epoch_utc, 1),
            samples=_samples(comparison),
            time_offset_s=_estimate(comparison.alignment.offset_s, 9),
            clock_drift=_estimate(comparison.alignment.drift, 15),
            axes={axis.name: _axis(comparison, axis) for axis in comparison.axes},
            pointing=[_pointing(parts) for parts in pointing],
            corrections=[_correction(parts.correction) for parts in pointing],
            parameters=[_parameter(one) for one in found.parameters] if found else [],
            platform=definition_of(found.platform) if found else None,
            warnings=list(comparison.notes),
            provenance=provenance,
        )
    )


def _samples(comparison: Comparison) -> SamplesOut:
    clean, alignment = comparison.samples, comparison.alignment
    first_s, last_s = alignment.t_s(clean.tag_s[[0, -1]]).tolist()
    names = comparison.plan.scenario.platform.axis_names
    return SamplesOut(
        read=clean.read,
        used=len(clean.tag_s),
        dropped=dict(clean.dropped),
        reordered=clean.reordered,
        wrapped=comparison.wrapped,
        step_s=round(comparison.step_s, 6),
        gaps=[StretchOut(**_span(comparison, *gap_s)) for gap_s in comparison.gaps_s],
        columns=[
            fill(
                TelemetryColumnOut,
                column,
                column.meaning,
                axis=names[column.meaning.axis],
            )
            for column in comparison.columns
        ],
        ignored_columns=list(comparison.ignored),
        **_span(comparison, first_s, last_s),
    )


def _axis(comparison: Comparison, axis: AxisComparison) -> AxisComparisonOut:
    return AxisComparisonOut(
        basis=axis.followed.basis,
        samples=axis.error.samples,
        rms_arcsec=_arcsec(axis.error.rms_rad),
        max_arcsec=_arcsec(axis.error.max_rad),
        mean_arcsec=_arcsec(axis.error.mean_rad),
        lag_s=round(axis.lag_s.value, 9),
        lag_sigma_s=round(axis.lag_s.sigma, 9),
        phases=[_phase(comparison, phase) for phase in axis.phases],
        oscillations=[
            OscillationOut(
                frequency_hz=round(one.frequency_hz, 6),
                amplitude_arcsec=_arcsec(one.amplitude_rad),
                **_span(comparison, one.start_s, one.stop_s),
            )
            for one in axis.oscillations[:_LIST_MAX]
        ],
        oscillations_searched_hz=_rounded(axis.oscillations_searched_hz),
        stick_slip=[
            StickSlipOut(
                slips=one.slips,
                stuck_share=round(one.stuck_share, 3),
                slip_arcsec=_arcsec(one.slip_rad),
                rate_arcsec_s=_arcsec(one.rate_rad_s),
                **_span(comparison, one.start_s, one.stop_s),
            )
            for one in axis.stick_slip[:_LIST_MAX]
        ],
        limits_exceeded=[_exceeded(comparison, one) for one in axis.limits_exceeded[:_LIST_MAX]],
        limits_checked=list(axis.limits_checked),
    )


def _rounded(band_hz: tuple[float, float] | None) -> list[float] | None:
    return None if band_hz is None else [round(one, 6) for one in band_hz]


def _phase(comparison: Comparison, phase: PhaseErrors) -> PhaseErrorsOut:
    return PhaseErrorsOut(
        kind=phase.kind,
        session=phase.session,
        samples=phase.error.samples,
        rms_arcsec=_or_none(phase.error.rms_rad),
        max_arcsec=_or_none(phase.error.max_rad),
        mean_arcsec=_or_none(phase.error.mean_rad),
        **_span(comparison, phase.start_s, phase.stop_s),
    )


def _exceeded(comparison: Comparison, one: Exceeded) -> ExceededOut:
    return ExceededOut(
        limit=one.limit,
        value=round(math.degrees(one.value), 6),
        bound=round(math.degrees(one.bound), 6),
        unit=_UNITS[one.limit],
        **_span(comparison, one.start_s, one.stop_s),
    )


def _pointing(parts: PointingParts) -> PointingPartsOut:
    return PointingPartsOut(
        at=utc_text(parts.epoch_utc),
        session=parts.session,
        measured=parts.measured,
        axes_arcsec=_arcsecs(parts.axes_rad),
        attitude_arcsec=[_arcsec(one) for one in parts.attitude_rad],
        attitude_sigma_arcsec=[_arcsec(one) for one in parts.attitude_sigma_rad],
        target_arcsec=_arcsecs(parts.target_rad),
    )


def _parameter(one: Parameter) -> ParameterOut:
    return ParameterOut(
        name=one.name, planned=one.planned_value, found=one.found_value, sigma=one.sigma
    )


def _correction(correction: AttitudeCorrection) -> CorrectionOut:
    return CorrectionOut(
        epoch=utc_text(correction.epoch, 6),
        turn_body_deg=list(correction.turn_body_deg),
        covariance_deg2=[list(row) for row in correction.covariance_deg2],
    )


def _span(comparison: Comparison, start_s: float, stop_s: float) -> dict[str, str]:
    epoch_utc = comparison.plan.table.epoch_utc
    return {
        "start": utc_text(shifted_utc(epoch_utc, start_s)),
        "stop": utc_text(shifted_utc(epoch_utc, stop_s)),
    }


def _estimate(estimate: Estimate, decimals: int) -> EstimateOut:
    return EstimateOut(value=round(estimate.value, decimals), sigma=round(estimate.sigma, decimals))


def _arcsec(angle_rad: float) -> float:
    return round(angle_rad * _ARCSEC_PER_RAD, 4) + 0.0


def _or_none(angle_rad: float) -> float | None:
    """None for NaN, of no samples."""
    return None if math.isnan(angle_rad) else _arcsec(angle_rad)


def _arcsecs(angle_rad: Sequence[float] | Array | None) -> list[float] | None:
    return None if angle_rad is None else [_arcsec(float(one)) for one in angle_rad]
