"""A child's work for the view of a stored plan, and for the ground track of an orbit."""

from dataclasses import dataclass
from datetime import datetime

from app.answers.members import ProvenanceOut, to_json
from app.answers.view import OrbitTrackResponse, view_json
from app.store.packed import unpack
from app.work.plan import require_verified_table, stored_plan
from planner.output.export import EXPORTERS, Exporter
from planner.output.view import VIEW_EXPORTERS
from planner.output.view.orbit import OrbitTrackRequest, track_orbit
from planner.world.plan import FlightPlan

DRAWN: dict[str, Exporter[FlightPlan]] = {
    name: exporter for name, exporter in EXPORTERS.items() if exporter.shows
}


@dataclass(frozen=True, kw_only=True)
class AskedView:
    """Of which plan, and how.

    verified: whether its verification passed.  format_name: None for JSON.
    step_s: None to have it chosen.  pixel_arcsec: None for the platform's camera's.  created_utc:
    the date a file states.
    """

    plan_id: str
    verified: bool
    format_name: str | None
    step_s: float | None
    pixel_arcsec: float | None
    created_utc: datetime


def stored_plan_view(request: bytes, table_columns: bytes, asked: AskedView) -> bytes:
    """Raises InvalidInput for the step, OutsideCoverage, and Unverified of all but JSON."""
    from planner.output.view import view_plan

    packed = unpack(table_columns)
    plan = stored_plan(request, packed)
    pixel_arcsec = asked.pixel_arcsec or plan.scenario.platform.camera.pixel_arcsec
    if asked.format_name is None:
        view = view_plan(plan, asked.step_s, pixel_arcsec)
        return view_json(view, asked.plan_id, verified=asked.verified)
    require_verified_table(packed)
    if asked.format_name in DRAWN:
        return DRAWN[asked.format_name].write(plan, asked.created_utc)
    view = view_plan(plan, asked.step_s, pixel_arcsec)
    return VIEW_EXPORTERS[asked.format_name].write(view, asked.created_utc)


def orbit_track_json(request: OrbitTrackRequest, provenance: ProvenanceOut) -> bytes:
    """Raises OutsideCoverage."""
    return to_json(OrbitTrackResponse(**vars(track_orbit(request)), provenance=provenance))
