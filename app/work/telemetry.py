"""Telemetry: the request with its samples, the comparison with a stored plan, and the answer."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import numpy as np

from app.answers.members import BUILT_ON_FIRST_USE, ProvenanceOut, to_json
from app.requests.json_reader import JsonReader, json_document
from app.store.packed import unpack
from app.work.plan import stored_plan
from planner.base.answer_members import Member
from planner.base.arrays import Array
from planner.base.errors import FieldError, InvalidRequest
from planner.inflight.telemetry.estimates import ClockEstimate, Estimate, Inseparable
from planner.inflight.telemetry.figure import write_comparison_png, write_comparison_svg
from planner.inflight.telemetry.findings import AxisComparison, SamplesUse
from planner.inflight.telemetry.platforms.sensors import Parameter, PointingParts
from planner.inflight.telemetry.request import ComparisonRequest
from planner.inflight.telemetry.samples import OPTIONS, Samples, read_csv, samples_of
from planner.inflight.telemetry.table import write_comparison_csv
from planner.output.export import Exporter
from planner.world.attitude.corrections import CorrectionOut
from planner.world.frames.time_scales import utc_text
from planner.world.plan import FlightPlan
from planner.world.platforms import BodyPlatform, PlatformDefinition

if TYPE_CHECKING:
    from planner.inflight.telemetry.compare import Comparison

_TIMES = ("t_s", "utc")
_COLUMN_SCHEMA: dict[str, Any] = {
    "type": "array",
    "items": {"anyOf": [{"type": "number"}, {"type": "null"}]},
    "description": "A measured column, a number or null per time tag: NAME_deg and NAME_rate_deg_s "
    "for each axis NAME of the platform, or a body's q_1 to q_4 and omega_body_deg_s_x, _y, _z; "
    "angles also in rad, mrad, arcmin, arcsec.",
}


@dataclass(frozen=True, kw_only=True, eq=False)
class SentSamples:
    """Of JSON.  t_s: (n,), NaN for null; None where utc tells the time.  columns: (n,) each."""

    t_s: Array | None
    utc: tuple[str, ...]
    columns: Mapping[str, Array]


def _add_columns(schema: dict[str, Any]) -> None:
    schema["$defs"]["TelemetrySamples"]["additionalProperties"] = _COLUMN_SCHEMA


COMPARISON_READER = JsonReader(ComparisonRequest, add_to_schema=_add_columns)


def read_comparison_request(body: bytes) -> tuple[ComparisonRequest, SentSamples]:
    """JSON with its samples; raises InvalidRequest."""
    document = json_document(body)
    samples = document.get("samples") if isinstance(document, dict) else None
    if not isinstance(document, dict) or not isinstance(samples, dict):
        COMPARISON_READER.read(body)
        detail = "is required: t_s and columns; or send CSV by multipart, as the part samples"
        raise InvalidRequest(FieldError(field="samples", detail=detail))
    sent = {name: samples[name] for name in samples if name != "epoch"}
    rest = {name: samples[name] for name in samples if name == "epoch"}
    request = COMPARISON_READER.read(json.dumps(document | {"samples": rest}).encode())
    for name, own in request.columns.items():
        if own not in sent:
            raise _fault(f"columns.{name}"[:80], f"names {own[:60]!r}, which samples doesn't hold")
    name_by_own = {own: name for name, own in request.columns.items()}
    return request, _sent({name_by_own.get(name, name): sent[name] for name in sent})


def read_comparison_head(body: bytes) -> ComparisonRequest:
    """What goes with CSV: all but the columns; raises InvalidRequest."""
    request = COMPARISON_READER.read(body)
    if request.samples is not None and (request.samples.t_s or request.samples.utc):
        detail = "stands in the CSV file; leave it out here"
        raise InvalidRequest(FieldError(field="samples.t_s", detail=detail))
    return request


def _sent(members: dict[str, Any]) -> SentSamples:
    if len(members) > (most := OPTIONS.json_columns_max):
        raise _fault("samples", f"has {len(members)} columns; at most {most} are read")
    times = [name for name in _TIMES if members.get(name)]
    if len(times) != 1:
        raise _fault("samples.t_s", "is required, or utc instead: a time tag for each sample")
    utc = members.pop("utc", None) or []
    if not (isinstance(utc, list) and all(isinstance(text, str) for text in utc)):
        raise _fault("samples.utc", "must be a list of texts such as 2015-02-27T17:36:20.000Z")
    t_s = members.pop("t_s", None)
    count = len(utc or t_s) if isinstance(utc or t_s, list) else 0
    if count > OPTIONS.rows_max:
        raise _fault(
            f"samples.{times[0]}", f"has {count} tags; at most {OPTIONS.rows_max} are read"
        )
    columns = {name: _column(name, value) for name, value in members.items()}
    for name, column in columns.items():
        if len(column) != count:
            raise _fault(
                f"samples.{name}"[:80],
                f"must have a value for each of the {count} time tags, null where there is none; "
                f"it has {len(column)}",
            )
    return SentSamples(t_s=None if utc else _column("t_s", t_s), utc=tuple(utc), columns=columns)


def _column(name: str, value: object) -> Array:
    field = f"samples.{name}"[:80]
    if not isinstance(value, list):
        raise _fault(field, "must be a list of numbers, null where there is none")
    kinds = {*map(type, value)}
    if not kinds <= {int, float, type(None)}:
        number = next(k for k, one in enumerate(value) if type(one) not in (int, float, type(None)))
        raise _fault(f"{field}.{number}", "must be a number, or null where there is none")
    try:
        return np.array(value, dtype=np.float64)
    except OverflowError:
        raise _fault(field, "holds a whole number too large to be measured") from None


def _fault(field: str, detail: str) -> InvalidRequest:
    return InvalidRequest(FieldError(field=field, detail=detail))


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


def _clock(found: Estimate, assumes: str) -> ClockEstimate:
    return ClockEstimate(value=found.value, sigma=found.sigma, assumes=assumes)


FILES: dict[str, "Exporter[Comparison]"] = {
    "csv": Exporter("plan and flight, sample by sample", "text/csv", ".csv", write_comparison_csv),
    "png": Exporter("plan and flight, drawn", "image/png", ".png", write_comparison_png),
    "svg": Exporter("the same in vectors", "image/svg+xml", ".svg", write_comparison_svg),
}


class SentTelemetry(NamedTuple):
    """What was asked, and its samples: of JSON, or the bytes of a CSV file."""

    request: ComparisonRequest
    samples: SentSamples | bytes


def read_sent(body: bytes, *csv: bytes) -> SentTelemetry:
    """The request, its samples in it or beside it in a CSV file; raises InvalidRequest."""
    if csv:
        return SentTelemetry(read_comparison_head(body), csv[0])
    return SentTelemetry(*read_comparison_request(body))


def compare_stored(
    plan_request: bytes,
    table_columns: bytes,
    sent: SentTelemetry,
    provenance: ProvenanceOut,
    format_name: str | None,
    created_utc: datetime,
) -> bytes:
    """The answer as JSON, or a file in the format asked for; raises Refusals."""
    comparison = compare_sent(stored_plan(plan_request, unpack(table_columns)), sent)
    if format_name is not None:
        return FILES[format_name].write(comparison, created_utc)
    return answer_json(comparison, sent.request, provenance)


def compare_sent(plan: FlightPlan, sent: SentTelemetry) -> "Comparison":
    from planner.inflight.telemetry.compare import compare

    return compare(plan, _samples(plan, sent))


def answer_json(
    comparison: "Comparison", request: ComparisonRequest, provenance: ProvenanceOut
) -> bytes:
    """With what was measured beside the axes, and the platform found; raises Refusals."""
    sensors, alignment = comparison.sensors, comparison.alignment
    pointing = sensors.pointing(comparison, request.corrections, request.image_offsets)
    found = sensors.found(comparison, request.identify)
    assumes, common_s = sensors.assumes, alignment.common_offset_s
    ideal_s, ideal_drift = comparison.ideal_clock or (None, None)
    return to_json(
        ComparisonResponse(
            plan=request.plan,
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
            corrections=[parts.correction.told for parts in pointing],
            parameters=found.parameters if found else (),
            platform=found.platform if found else None,
            warnings=comparison.notes,
            provenance=provenance,
        )
    )


def _samples(plan: FlightPlan, sent: SentTelemetry) -> Samples:
    from planner.inflight.telemetry.platforms.registry import sensors_of

    contract, plan_epoch_utc = sensors_of(plan).contract, plan.table.epoch_utc
    epoch_utc = sent.request.samples.epoch if sent.request.samples else None
    if isinstance(sent.samples, bytes):
        return read_csv(sent.samples, contract, epoch_utc, plan_epoch_utc, sent.request.columns)
    values = sent.samples
    return samples_of(values.t_s, values.utc, values.columns, contract, epoch_utc or plan_epoch_utc)
