"""Telemetry: the request with its samples, the comparison with a stored plan, and the answer."""

import json
from dataclasses import dataclass
from datetime import datetime
from typing import TYPE_CHECKING, Any, NamedTuple

from app.answers.members import BUILT_ON_FIRST_USE, ProvenanceOut, to_json
from app.requests.json_reader import JsonReader, json_document
from app.store.packed import unpack
from app.work.plan import stored_plan
from planner.base.errors import FieldError, InvalidRequest
from planner.inflight.telemetry.figure import write_comparison_png, write_comparison_svg
from planner.inflight.telemetry.findings import ComparisonFound
from planner.inflight.telemetry.request import ComparisonRequest
from planner.inflight.telemetry.samples import (
    Samples,
    SentSamples,
    read_csv,
    samples_of,
    sent_samples,
)
from planner.inflight.telemetry.table import write_comparison_csv
from planner.output.export import Exporter
from planner.world.plan import FlightPlan

if TYPE_CHECKING:
    from planner.inflight.telemetry.compare import Comparison

_COLUMN_SCHEMA: dict[str, Any] = {
    "type": "array",
    "items": {"anyOf": [{"type": "number"}, {"type": "null"}]},
    "description": "A measured column, a number or null per time tag: NAME_deg and NAME_rate_deg_s "
    "for each axis NAME of the platform, or a body's q_1 to q_4 and omega_body_deg_s_x, _y, _z; "
    "angles also in rad, mrad, arcmin, arcsec.",
}


def _add_columns(schema: dict[str, Any]) -> None:
    schema["$defs"]["TelemetrySamples"]["additionalProperties"] = _COLUMN_SCHEMA


COMPARISON_READER = JsonReader(ComparisonRequest, add_to_schema=_add_columns)


@dataclass(frozen=True, kw_only=True)
class ComparisonResponse(ComparisonFound):
    """Telemetry beside the plan that was flown."""

    __pydantic_config__ = BUILT_ON_FIRST_USE

    provenance: ProvenanceOut


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
    if not csv:
        return _read_with_samples(body)
    request = COMPARISON_READER.read(body)
    if request.samples is not None and (request.samples.t_s or request.samples.utc):
        detail = "stands in the CSV file; leave it out here"
        raise InvalidRequest(FieldError(field="samples.t_s", detail=detail))
    return SentTelemetry(request, csv[0])


def _read_with_samples(body: bytes) -> SentTelemetry:
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
            detail = f"names {own[:60]!r}, which samples doesn't hold"
            raise InvalidRequest(FieldError(field=f"columns.{name}"[:80], detail=detail))
    name_by_own = {own: name for name, own in request.columns.items()}
    columns = {name_by_own.get(name, name): sent[name] for name in sent}
    return SentTelemetry(request, sent_samples(columns))


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
    found = comparison.found(request)
    return to_json(ComparisonResponse(**vars(found), provenance=provenance))


def _samples(plan: FlightPlan, sent: SentTelemetry) -> Samples:
    from planner.inflight.telemetry.platforms.registry import sensors_of

    contract, plan_epoch_utc = sensors_of(plan).contract, plan.table.epoch_utc
    epoch_utc = sent.request.samples.epoch if sent.request.samples else None
    if isinstance(sent.samples, bytes):
        return read_csv(sent.samples, contract, epoch_utc, plan_epoch_utc, sent.request.columns)
    return samples_of(sent.samples, contract, epoch_utc or plan_epoch_utc)
