"""The summary of a plan: its sessions with their targets, times, elevations and probabilities."""

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from app.answers.members import utc_or_none
from app.answers.ranges import Count, ElevationDeg, NotNegative, Share
from app.requests.listings import listing_of_scenario
from app.store.listing import Listing
from planner.planning.opportunities.ground_sample import sample_along_m
from planner.world.frames.time_scales import utc_text

if TYPE_CHECKING:
    from planner.planning.sessions.plan import Plan


@dataclass(frozen=True, kw_only=True)
class SessionSummaryOut:
    """One session as it is planned.

    session: its number, from 0.
    id: as the request gives it; null for none. E.g. `"LV-7"`.
    name: as the request gives it; null for none. E.g. `"Las Vegas, east"`.
    mode: of the target. E.g. `"ground"`.
    target: the target in a few words. E.g. `"36.1147, -115.1728"`.
    start: its first row; UTC.
    stop: its last row; UTC.
    best_elevation_deg: the carrier's highest in the target's sky during the session; null unless
    the target is on the Earth. E.g. `72.3`.
    best_at: time of it; UTC. E.g. `"2015-02-27T17:36:58.000Z"`.
    probability_in_frame: that the target stays inside the camera's frame over the whole session;
    null for a test motion. E.g. `0.97`.
    ground_sample_m: the longer side of a pixel of 0.678 arcsec on the ground where the carrier is
    nearest; null unless the target is on the Earth. E.g. `1.33`.
    """

    session: Count
    id: str | None
    name: str | None
    mode: str
    target: str
    start: str
    stop: str
    best_elevation_deg: ElevationDeg | None
    best_at: str | None
    probability_in_frame: Share | None
    ground_sample_m: NotNegative | None


@dataclass(frozen=True, kw_only=True)
class PlanSummaryOut:
    """Summary of a plan.

    name: as the request gives it.
    platform: the platform's name.
    targets: targets of its sessions, each once: names, or else ids, or else the target in a few
    words.
    start: of the first session; UTC.
    stop: of the last session; UTC.
    probability_in_frame: the least of any session's; null without any. E.g. `0.97`.
    sessions: in order of time.
    """

    name: str
    platform: str
    targets: list[str]
    start: str
    stop: str
    probability_in_frame: Share | None
    sessions: list[SessionSummaryOut]


def summary_out(plan: "Plan") -> PlanSummaryOut:
    """Of a plan as it was made."""
    listing = listing_of_plan(plan)
    sessions = plan.scenario.sessions
    return PlanSummaryOut(
        name=plan.scenario.name,
        platform=listing.platform,
        targets=list(listing.targets),
        start=utc_text(sessions[0].start),
        stop=utc_text(sessions[-1].stop),
        probability_in_frame=listing.probability_in_frame,
        sessions=[_session_out(plan, number) for number in range(len(sessions))],
    )


def _session_out(plan: "Plan", number: int) -> SessionSummaryOut:
    session, budget = plan.scenario.sessions[number], plan.budgets[number]
    seen = next((one for one in plan.verification.sessions if one.session == number), None)
    highest_rad = seen.elevation_max_rad if seen else None
    return SessionSummaryOut(
        session=number,
        id=session.id,
        name=session.name,
        mode=session.target.mode,
        target=session.target.label,
        start=utc_text(session.start),
        stop=utc_text(session.stop),
        best_elevation_deg=None if highest_rad is None else math.degrees(highest_rad),
        best_at=utc_or_none(seen.elevation_max_utc) if seen else None,
        probability_in_frame=None if budget is None else budget.probability_in_frame,
        ground_sample_m=None
        if highest_rad is None or seen is None or seen.range_min_m is None
        else _ground_sample_m(
            highest_rad, seen.range_min_m, plan.scenario.platform.camera.pixel_rad
        ),
    )


def _ground_sample_m(elevation_rad: float, range_m: float, pixel_rad: float) -> float | None:
    """The carrier is nearest and highest at once, to a few metres of the range."""
    sine = np.array(math.sin(elevation_rad))
    sample_m = float(sample_along_m(sine, np.array(range_m), pixel_rad))
    return None if math.isnan(sample_m) else sample_m


def listing_of_plan(plan: "Plan") -> Listing:
    """Of a plan as it was made."""
    told = [budget.probability_in_frame for budget in plan.budgets if budget is not None]
    listing = listing_of_scenario(plan.scenario)
    return replace(listing, probability_in_frame=min(told, default=None))
