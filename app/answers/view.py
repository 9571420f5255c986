"""The view of a plan: columns over time, in degrees and metres."""

import json

from app.answers.members import BUILT_ON_FIRST_USE, ProvenanceOut, from_store, to_json
from planner.base.answer_members import answer
from planner.output.view.columns import PlanView, TargetTrack
from planner.output.view.orbit import OrbitTrack
from planner.output.windows.members import WindowOut
from planner.output.windows.rows import rows_json, window_columns
from planner.planning.opportunities import Opportunities


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
