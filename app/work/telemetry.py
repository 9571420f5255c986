"""A child's work on telemetry: it is read and compared with a stored plan."""

from datetime import datetime
from typing import TYPE_CHECKING, NamedTuple

from app.answers.members import ProvenanceOut
from app.answers.telemetry import comparison_json
from app.requests.telemetry import (
    ComparisonRequest,
    SentSamples,
    read_comparison_head,
    read_comparison_request,
)
from app.store.packed import unpack
from app.work.plan import stored_plan
from planner.inflight.telemetry.figure import write_comparison_png, write_comparison_svg
from planner.inflight.telemetry.samples import Samples, read_csv, samples_of
from planner.inflight.telemetry.table import write_comparison_csv
from planner.output.export import Exporter
from planner.world.plan import FlightPlan

if TYPE_CHECKING:
    from planner.inflight.telemetry.compare import Comparison

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
    sensors = comparison.sensors
    pointing = sensors.pointing(comparison, request.corrections, request.image_offsets)
    found = sensors.found(comparison, request.identify)
    return comparison_json(comparison, pointing, found, request.plan, provenance)


def _samples(plan: FlightPlan, sent: SentTelemetry) -> Samples:
    from planner.inflight.telemetry.platforms.registry import sensors_of

    contract, plan_epoch_utc = sensors_of(plan).contract, plan.table.epoch_utc
    epoch_utc = sent.request.samples.epoch if sent.request.samples else None
    if isinstance(sent.samples, bytes):
        return read_csv(sent.samples, contract, epoch_utc, plan_epoch_utc, sent.request.columns)
    values = sent.samples
    return samples_of(values.t_s, values.utc, values.columns, contract, epoch_utc or plan_epoch_utc)
