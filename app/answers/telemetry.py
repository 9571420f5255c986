"""The answer to a comparison of telemetry: arcsec, seconds and UTC by the plan's clock."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from app.answers.horizon import CorrectionOut
from app.answers.members import BUILT_ON_FIRST_USE, ProvenanceOut, fill, to_json
from app.answers.telemetry_axes import AxisComparisonOut, EstimateOut, arcsec, axis_of, estimate
from app.answers.telemetry_samples import SamplesOut, samples_of
from planner.base.answer_members import Count, NotNegative, Signed
from planner.base.arrays import Array
from planner.world.attitude.corrections import AttitudeCorrection
from planner.world.frames.time_scales import utc_text
from planner.world.platforms import BodyPlatform, PlatformDefinition

if TYPE_CHECKING:
    from planner.inflight.telemetry.alignment import Estimate
    from planner.inflight.telemetry.compare import Comparison
    from planner.inflight.telemetry.platforms import sensors


@dataclass(frozen=True, kw_only=True)
class ClockEstimateOut(EstimateOut):
    """An estimate of the clock, in the unit that the name of its member says.

    assumes: the condition on the axes under which it holds.
    """

    assumes: str


@dataclass(frozen=True, kw_only=True)
class InseparableOut:
    """Two estimates that the samples hardly tell apart: one's error is made up for by the other's.

    members: both, as they stand in this answer. E.g. `["clock_drift", "axes.alpha.gain"]`.
    correlation: of their errors, from -1 to 1. E.g. `-0.994`.
    """

    members: list[str]
    correlation: Signed


@dataclass(frozen=True, kw_only=True)
class PointingPartsOut:
    """Distance of the target from the frame's centre at an instant, and its causes: along the
    frame's first side and its second.

    at: time of the measurement; UTC. E.g. `"2015-02-27T17:37:00.000Z"`.
    session: number of the session then, from 0; null outside of sessions. E.g. `0`.
    measured: source of the measured attitude: a rotation as of the horizon, or the target in an
    image. E.g. `"image"`.
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
    """A parameter of the platform, estimated from the telemetry.

    name: path of the field in `platform`; of a drive the axis's name, a dot, and the field's. E.g.
    `"beta.coulomb_deg_s2"`.
    planned: value of the plan's platform, in the field's unit. E.g. `0.05`.
    found: value estimated from the telemetry. E.g. `0.1`.
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

    __pydantic_config__ = BUILT_ON_FIRST_USE

    plan: str
    name: str
    epoch: str
    samples: SamplesOut
    time_offset_s: ClockEstimateOut
    clock_drift: ClockEstimateOut
    common_offset_s: ClockEstimateOut | None
    ideal_offset_s: ClockEstimateOut | None
    ideal_drift: ClockEstimateOut | None
    inseparable: list[InseparableOut]
    axes: dict[str, AxisComparisonOut]
    pointing: list[PointingPartsOut]
    corrections: list[CorrectionOut]
    parameters: list[ParameterOut]
    platform: PlatformDefinition | BodyPlatform | None
    warnings: list[str]
    provenance: ProvenanceOut


def comparison_json(
    comparison: "Comparison",
    pointing: "Sequence[sensors.PointingParts]",
    found: "sensors.PlatformFound | None",
    plan_id: str,
    provenance: ProvenanceOut,
) -> bytes:
    """The whole answer as UTF-8 JSON."""
    scenario, alignment = comparison.plan.scenario, comparison.alignment
    assumes = comparison.sensors.assumes
    ideal_s, ideal_drift = comparison.ideal_clock or (None, None)
    return to_json(
        ComparisonResponse(
            plan=plan_id,
            name=scenario.name,
            epoch=utc_text(comparison.plan.table.epoch_utc, 1),
            samples=samples_of(comparison),
            time_offset_s=_clock(alignment.offset_s, 9, assumes.earliest),
            clock_drift=_clock(alignment.drift, 15, assumes.earliest),
            common_offset_s=_clock_or_none(alignment.common_offset_s, 9, assumes.equally_late),
            ideal_offset_s=_clock_or_none(ideal_s, 9, assumes.ideal),
            ideal_drift=_clock_or_none(ideal_drift, 15, assumes.ideal),
            inseparable=[
                InseparableOut(members=list(one.names), correlation=round(one.correlation, 4))
                for one in comparison.inseparable
            ],
            axes={axis.name: axis_of(comparison, axis) for axis in comparison.axes},
            pointing=[_pointing(parts) for parts in pointing],
            corrections=[_correction(parts.correction) for parts in pointing],
            parameters=[_parameter(one) for one in found.parameters] if found else [],
            platform=found.platform if found else None,
            warnings=list(comparison.notes),
            provenance=provenance,
        )
    )


def _pointing(parts: "sensors.PointingParts") -> PointingPartsOut:
    return PointingPartsOut(
        at=utc_text(parts.epoch_utc),
        session=parts.session,
        measured=parts.measured,
        axes_arcsec=_arcsecs(parts.axes_rad),
        attitude_arcsec=[arcsec(one) for one in parts.attitude_rad],
        attitude_sigma_arcsec=[arcsec(one) for one in parts.attitude_sigma_rad],
        target_arcsec=_arcsecs(parts.target_rad),
    )


def _parameter(one: "sensors.Parameter") -> ParameterOut:
    return ParameterOut(
        name=one.name, planned=one.planned_value, found=one.found_value, sigma=one.sigma
    )


def _correction(correction: AttitudeCorrection) -> CorrectionOut:
    return CorrectionOut(
        epoch=utc_text(correction.epoch, 6),
        turn_body_deg=list(correction.turn_body_deg),
        covariance_deg2=[list(row) for row in correction.covariance_deg2],
    )


def _clock(found: "Estimate", decimals: int, assumes: str) -> ClockEstimateOut:
    return fill(ClockEstimateOut, estimate(found, decimals), assumes=assumes)


def _clock_or_none(
    found: "Estimate | None", decimals: int, assumes: str
) -> ClockEstimateOut | None:
    return None if found is None else _clock(found, decimals, assumes)


def _arcsecs(angle_rad: Sequence[float] | Array | None) -> list[float] | None:
    return None if angle_rad is None else [arcsec(float(one)) for one in angle_rad]
