"""The answer to a comparison of telemetry: arcsec, seconds and UTC by the plan's clock."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

from app.answers.horizon import CorrectionOut
from app.answers.members import BUILT_ON_FIRST_USE, ProvenanceOut, to_json
from planner.base.answer_members import Member
from planner.inflight.telemetry.estimates import ClockEstimate, Estimate, Inseparable
from planner.inflight.telemetry.findings import AxisComparison, SamplesUse
from planner.inflight.telemetry.platforms.sensors import Parameter, PointingParts
from planner.world.attitude.corrections import AttitudeCorrection
from planner.world.frames.time_scales import utc_text
from planner.world.platforms import BodyPlatform, PlatformDefinition

if TYPE_CHECKING:
    from planner.inflight.telemetry.compare import Comparison
    from planner.inflight.telemetry.platforms.sensors import PlatformFound

Offset = Annotated[ClockEstimate, Member(decimals=9)]
Drift = Annotated[ClockEstimate, Member(decimals=15)]


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
    provenance: ProvenanceOut


def comparison_json(
    comparison: "Comparison",
    pointing: list[PointingParts],
    found: "PlatformFound | None",
    plan_id: str,
    provenance: ProvenanceOut,
) -> bytes:
    alignment, assumes = comparison.alignment, comparison.sensors.assumes
    common_s = alignment.common_offset_s
    ideal_s, ideal_drift = comparison.ideal_clock or (None, None)
    return to_json(
        ComparisonResponse(
            plan=plan_id,
            name=comparison.plan.scenario.name,
            epoch=utc_text(comparison.plan.table.epoch_utc, 1),
            samples=comparison.samples,
            time_offset_s=_clock(alignment.offset_s, assumes.earliest),
            clock_drift=_clock(alignment.drift, assumes.earliest),
            common_offset_s=_clock(common_s, assumes.equally_late) if common_s else None,
            ideal_offset_s=_clock(ideal_s, assumes.ideal) if ideal_s else None,
            ideal_drift=_clock(ideal_drift, assumes.ideal) if ideal_drift else None,
            inseparable=comparison.inseparable,
            axes={axis.name: axis for axis in comparison.axes},
            pointing=pointing,
            corrections=[_correction(parts.correction) for parts in pointing],
            parameters=found.parameters if found else (),
            platform=found.platform if found else None,
            warnings=comparison.notes,
            provenance=provenance,
        )
    )


def _clock(found: Estimate, assumes: str) -> ClockEstimate:
    return ClockEstimate(value=found.value, sigma=found.sigma, assumes=assumes)


def _correction(correction: AttitudeCorrection) -> CorrectionOut:
    return CorrectionOut(
        epoch=utc_text(correction.epoch, 6),
        turn_body_deg=list(correction.turn_body_deg),
        covariance_deg2=[list(row) for row in correction.covariance_deg2],
    )
