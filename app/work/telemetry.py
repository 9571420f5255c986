"""A child's work on telemetry: it is read and compared with a stored plan."""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import TYPE_CHECKING

from app.answers.members import ProvenanceOut
from app.answers.telemetry import comparison_json
from app.requests.telemetry import ComparisonRequest, SentSamples
from app.store.packed import unpack
from app.work.plan import stored_plan
from planner.base.errors import InvalidInput
from planner.inflight.telemetry.columns import ColumnMeaning, TelemetryColumn, meaning_of
from planner.inflight.telemetry.csv_reader import read_csv, utc_seconds
from planner.inflight.telemetry.figure import write_comparison_png, write_comparison_svg
from planner.inflight.telemetry.samples import Samples
from planner.output.export import Exporter
from planner.world.plan import FlightPlan

if TYPE_CHECKING:
    from planner.inflight.telemetry.attitude import PointingParts
    from planner.inflight.telemetry.compare import Comparison

PICTURES: dict[str, "Exporter[Comparison]"] = {
    "png": Exporter("plan and flight, drawn", "image/png", ".png", write_comparison_png),
    "svg": Exporter("the same in vectors", "image/svg+xml", ".svg", write_comparison_svg),
}


@dataclass(frozen=True, kw_only=True, eq=False)
class SentTelemetry:
    """What was asked, and its samples: of JSON, or the bytes of a CSV file."""

    request: ComparisonRequest
    samples: SentSamples | bytes


def compare_stored(
    plan_request: bytes,
    table_columns: bytes,
    sent: SentTelemetry,
    provenance: ProvenanceOut,
    picture: str | None,
    created_utc: datetime,
) -> bytes:
    """The answer as JSON, or a picture in the format asked for; raises Refusals."""
    comparison = compare_sent(stored_plan(plan_request, unpack(table_columns)), sent)
    if picture is not None:
        return PICTURES[picture].write(comparison, created_utc)
    return answer_json(comparison, sent.request, sent.request.plan, provenance)


def compare_sent(plan: FlightPlan, sent: SentTelemetry) -> "Comparison":
    """Raises Refusals."""
    from planner.inflight.telemetry.compare import compare

    return compare(plan, _samples(plan, sent))


def answer_json(
    comparison: "Comparison", request: ComparisonRequest, plan_id: str, provenance: ProvenanceOut
) -> bytes:
    """With what was measured beside the axes, and the platform found; raises Refusals."""
    from planner.inflight.telemetry.parameters import platform_found

    pointing = _pointing(comparison, request)
    found = platform_found(comparison, request.identify)
    return comparison_json(comparison, pointing, found, plan_id, provenance)


def _pointing(comparison: "Comparison", request: ComparisonRequest) -> list["PointingParts"]:
    from planner.inflight.telemetry.attitude import from_image, from_rotation

    plan = comparison.plan
    followed = [axis.followed for axis in comparison.axes]
    pointing = [
        from_rotation(plan, followed, one, f"corrections.{number}")
        for number, one in enumerate(request.corrections)
    ]
    pointing += [
        from_image(plan, followed, one, f"image_offsets.{number}")
        for number, one in enumerate(request.image_offsets)
    ]
    return sorted(pointing, key=lambda parts: parts.epoch_utc)


def _samples(plan: FlightPlan, sent: SentTelemetry) -> Samples:
    names = plan.scenario.platform.axis_names
    epoch_utc = sent.request.samples and sent.request.samples.epoch
    if isinstance(sent.samples, bytes):
        return read_csv(sent.samples, names, epoch_utc or None, plan.table.epoch_utc)
    since_utc = epoch_utc or plan.table.epoch_utc
    columns = tuple(
        TelemetryColumn(name=name, meaning=_meaning(name, names), value=value)
        for name, value in sent.samples.columns.items()
    )
    _require_each_once(columns, names)
    notes: tuple[str, ...] = ()
    t_s = sent.samples.t_s
    if t_s is None:
        t_s, notes = utc_seconds(sent.samples.utc, since_utc)
    return Samples(epoch_utc=since_utc, t_s=t_s, columns=columns, notes=notes)


def _meaning(name: str, axis_names: Sequence[str]) -> ColumnMeaning:
    meaning = meaning_of(name, axis_names)
    if meaning is None:
        raise _fault(
            name,
            "tells of no axis of this platform; give t_s, "
            + ", ".join(f"{axis}_deg or {axis}_rate_deg_s" for axis in axis_names),
        )
    return meaning


def _require_each_once(columns: Sequence[TelemetryColumn], axis_names: Sequence[str]) -> None:
    if not columns:
        raise _fault(f"{axis_names[0]}_deg", "is required, or a column of another axis or of rates")
    seen: dict[tuple[int, str], str] = {}
    for column in columns:
        key = (column.meaning.axis, column.meaning.kind)
        if key in seen:
            raise _fault(column.name, f"tells the same as {seen[key][:80]}; send one of them")
        seen[key] = column.name


def _fault(name: str, detail: str) -> InvalidInput:
    return InvalidInput(f"{name[:60]} {detail}", field=f"samples.{name}"[:80])
