"""Views of stored plans, as columns over time or drawn, and ground tracks of orbits."""

import json
from dataclasses import dataclass
from datetime import datetime

from app.answers.members import BUILT_ON_FIRST_USE, ProvenanceOut, from_store, to_json
from app.requests.json_reader import JsonReader
from app.store.packed import unpack
from app.work.plan import require_verified_table, stored_plan
from planner.base.answer_members import answer
from planner.output.export import EXPORTERS, Exporter
from planner.output.view import VIEW_EXPORTERS
from planner.output.view.columns import PlanView, TargetTrack
from planner.output.view.orbit import OrbitTrack, OrbitTrackRequest, track_orbit
from planner.output.windows.members import WindowOut
from planner.output.windows.rows import rows_json, window_columns
from planner.planning.opportunities import Opportunities
from planner.world.plan import FlightPlan

DRAWN: dict[str, Exporter[FlightPlan]] = {
    name: exporter for name, exporter in EXPORTERS.items() if exporter.shows
}
ORBIT_TRACK_READER = JsonReader(OrbitTrackRequest)


@answer
class OrbitTrackResponse(OrbitTrack):
    """The carrier over some days, and the Sun."""

    provenance: ProvenanceOut


@answer
class ViewedTarget(TargetTrack):
    """One session's target over the whole table; null where a number has no meaning.

    A target with a timetable of its own appears in its session only, a test motion not at all.

    windows: spans in which it can be seen, from half an hour before the session to half an hour
    after.
    """

    windows: list[WindowOut]


@answer
class PlanViewHead:
    """The plan that a view is of.

    id: of the plan, as its address names it.
    name: of the plan.
    platform: its name.
    verified: true when the plan's verification passed.
    """

    id: str
    name: str
    platform: str
    verified: bool


@answer
class PlanViewResponse(PlanView, PlanViewHead):
    """The view of a plan as columns, with a value for each row shown."""

    __pydantic_config__ = BUILT_ON_FIRST_USE

    targets: tuple[ViewedTarget, ...]


def view_json(view: PlanView, plan_id: str, *, verified: bool) -> bytes:
    scenario = view.plan.scenario
    targets = tuple(
        ViewedTarget(**vars(track), windows=[] if windows is None else _windows_out(windows))
        for track, windows in zip(view.targets, view.windows, strict=True)
    )
    return to_json(
        PlanViewResponse(
            id=plan_id,
            name=scenario.name,
            platform=scenario.platform.name,
            verified=verified,
            **vars(view) | {"targets": targets},
        )
    )


def _windows_out(found: Opportunities) -> list[WindowOut]:
    columns = window_columns(found.start_utc, found.ids, found, found.windows)
    return [from_store(WindowOut, json.loads(text)) for text in rows_json(columns)]


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
