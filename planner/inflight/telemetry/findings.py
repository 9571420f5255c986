"""Findings of a comparison as answers hold them: the use of the rows, and what each axis did."""

from dataclasses import dataclass
from typing import Annotated, Literal

from planner.base.answer_members import Count, Internal, Member, answer
from planner.base.correction import CorrectionOut
from planner.inflight.telemetry.estimates import ClockEstimate, Estimate, Inseparable
from planner.inflight.telemetry.following import (
    Basis,
    Exceeded,
    Followed,
    Limit,
    PhaseErrors,
    SignedArcsec,
    SizeArcsec,
    Stretch,
)
from planner.inflight.telemetry.oscillations import Oscillation
from planner.inflight.telemetry.platforms.sensors import Parameter, PointingParts, ToldColumn
from planner.inflight.telemetry.samples import Dropped
from planner.inflight.telemetry.stick_slip import StickSlip
from planner.world.frames.time_scales import Utc
from planner.world.platforms import BodyPlatform, PlatformDefinition

Gain = Annotated[Estimate, Member(decimals=9)]
Bias = Annotated[Estimate, Member("arcsec", decimals=6)]
Noise = Annotated[Estimate, Member("arcsec", decimals=4)]
Hertz = Annotated[float, Member(least=0.0, decimals=6)]
Offset = Annotated[ClockEstimate, Member(decimals=9)]
Drift = Annotated[ClockEstimate, Member(decimals=15)]


@answer
class SamplesUse:
    """The use of the rows: read, left out, compared.

    read: rows there were: those used and those dropped.
    used: rows that the comparison rests on.
    dropped: rows by reason: `no_time` and `no_value` hold no number there, `repeated` have a time
    tag again, `held` only values of the row before while the plan moves on, `outside_plan` lie
    before or after its table, `outlier` stand out from those around. E.g. `{"outlier": 3}`.
    reordered: rows used that came before an earlier one.
    wrapped: angles that were brought within half a turn of the plan.
    start_utc: of the first row used; UTC.
    stop_utc: of the last row used; UTC.
    step_s: usual time from row to row.
    gaps: stretches without rows, at most 200. E.g.
    `[{"start": "2015-02-27T17:35:00.000Z", "stop": "2015-02-27T17:35:10.000Z"}]`.
    columns: those read.
    ignored_columns: names of those that are none of the contract nor in `columns`, or are empty.
    E.g. `["temperature"]`.
    """

    read: Count
    used: Count
    dropped: dict[Dropped, Count]
    reordered: Count
    wrapped: Count
    start_utc: Utc
    stop_utc: Utc
    step_s: Annotated[float, Member(least=0.0, decimals=6)]
    gaps: tuple[Stretch, ...]
    columns: tuple[ToldColumn, ...]
    ignored_columns: tuple[str, ...]


@answer
class AxisComparison:
    """Errors of one axis, measured less planned, with the telemetry's clock corrected.

    basis: `angles` for errors of angles, `rates` for errors of rates added up: of the latter a
    constant and a steady drift can't be seen and are left out.
    samples: errors there are.
    rms_rad: of all errors.
    max_rad: the largest, either way.
    mean_rad: of all errors.
    gain: measured over planned: of an encoder's scale, a gear or a unit; near -1 where the axis is
    measured the other way round, whose errors are those with the sign changed. Null where the axis
    doesn't follow its plan, and of a body's attitude, which has none.
    bias: the measured value where the plan is at zero: of an encoder's zero, a gyro's, or of a
    tracker's mount; null where the axis doesn't follow its plan.
    bias_unit: of `bias`: of angles, or of rates where `basis` is rates.
    rate_gain: gain of rates sent beside angles, as of a gyro; null without.
    rate_bias_rad_s: the measured rate where the plan stands still; null likewise.
    noise_rad: of the sensor of a body's attitude, 1 sigma, each row by itself; null of axes, of
    rates alone and of too short samples.
    wander_rad: of a body's attitude, 1 sigma, slow against rows; null where too slow to tell.
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

    name: Internal[str]
    followed: Internal[Followed]
    lag: Internal[Estimate | None]
    basis: Basis
    samples: Count
    rms_rad: SizeArcsec
    max_rad: SizeArcsec
    mean_rad: SignedArcsec
    gain: Gain | None
    bias: Bias | None
    bias_unit: Literal["arcsec", "arcsec/s"]
    rate_gain: Gain | None
    rate_bias_rad_s: Bias | None
    noise_rad: Noise | None
    wander_rad: Noise | None
    wander_half_life_s: Annotated[Estimate, Member(decimals=4)] | None
    lag_s: Annotated[float, Member(decimals=9)] | None
    lag_sigma_s: Annotated[float, Member(least=0.0, decimals=9)] | None
    phases: tuple[PhaseErrors, ...]
    oscillations: tuple[Oscillation, ...]
    oscillations_searched_hz: tuple[Hertz, ...] | None
    stick_slip: tuple[StickSlip, ...]
    limits_exceeded: tuple[Exceeded, ...]
    limits_checked: tuple[Limit, ...]


@dataclass(frozen=True, kw_only=True)
class ComparisonFound:
    """Telemetry beside the plan that was flown.

    plan: id of the plan.
    name: the plan's.
    epoch: of the plan's table, from which the clock is counted; UTC.
    samples: use of the rows: read, left out, compared.
    time_offset_s: by how much the telemetry's clock is ahead at `epoch`: a time tag is the plan's
    time, plus this, plus `clock_drift` times the seconds since `epoch`. Of the earlier axis: its
    sigma holds that any may be late by what their difference leaves open.
    clock_drift: by how much the telemetry's clock gains, a share of time.
    common_offset_s: the same if all axes are equally late, as those of one make are; null where
    they clearly aren't, or where one axis alone gives the time. E.g. `null`.
    ideal_offset_s: the same if the axes do as they are told, but for a bias: sharper, as nothing
    else is estimated beside it; null where the samples show friction, a lag or a gain.
    ideal_drift: the drift likewise.
    inseparable: estimates among clock, lags, gains and biases that the samples hardly tell apart.
    axes: by the axis's name, those with samples.
    pointing: pointing errors from corrections and image offsets.
    corrections: of the attitude against its law, as `attitude.corrections` of the next request
    takes them: measured ones given and those found of images. Angles of the axes alone say nothing
    of the attitude: without either there are none.
    parameters: of the platform, those asked for by `identify` and the least smooth rate of an axis
    that stuck and slipped above it; of a body how far and how long its attitude wanders.
    platform: as planned with, but for `parameters`, as `platform` of the next request takes it;
    null where none was found. E.g. `null`.
    warnings: cautions to read before relying on it. E.g.
    `["there is no telemetry of beta"]`.
    """

    plan: str
    name: str
    epoch: str
    samples: SamplesUse
    time_offset_s: Offset
    clock_drift: Drift
    common_offset_s: Offset | None
    ideal_offset_s: Offset | None
    ideal_drift: Drift | None
    inseparable: tuple[Inseparable, ...]
    axes: dict[str, AxisComparison]
    pointing: list[PointingParts]
    corrections: list[CorrectionOut]
    parameters: tuple[Parameter, ...]
    platform: PlatformDefinition | BodyPlatform | None
    warnings: tuple[str, ...]
