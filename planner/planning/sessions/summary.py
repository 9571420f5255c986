"""The summary of a plan: its sessions with their targets, times, elevations and probabilities."""

import math
from typing import Annotated

import numpy as np

from planner.base.answer_members import Count, Member, NotNegative, Share, answer
from planner.planning.sessions.plan import Plan
from planner.world.frames.time_scales import Instants, Utc, elapsed_s
from planner.world.scenario import Scenario, Session
from planner.world.targets import EarthFixedTarget
from planner.world.targets.ground_sample import sample_along_m


@answer
class SessionSummary:
    """One session as it is planned.

    session: its number, from 0.
    id: as the request gives it; null for none. E.g. `"LV-7"`.
    name: as the request gives it; null for none. E.g. `"Las Vegas, east"`.
    of: id of the imaging mode's session that it was made from; null for none. E.g. `"area"`.
    mode: of the target. E.g. `"ground"`.
    target: the target in a few words. E.g. `"near Las Vegas (36.1147, -115.1728)"`.
    start_utc: its first row; UTC.
    stop_utc: its last row; UTC.
    best_elevation_rad: the carrier's highest in the target's sky during the session; null unless
    the target is on the Earth. E.g. `72.3`.
    best_at_utc: time of it; UTC. E.g. `"2015-02-27T17:36:58.000Z"`.
    probability_in_frame: that the target stays inside the camera's frame over the whole session;
    null for a test motion and at a station. E.g. `0.97`.
    clear_probability: that no cloud stands over the target at the middle of the session, by
    `clouds`; null where these say nothing. E.g. `0.8`.
    ground_sample_m: the longer side of a pixel of 0.678 arcsec on the ground where the carrier is
    nearest; null unless the target is imaged on the Earth. E.g. `1.33`.
    """

    session: Count
    id: str | None
    name: str | None
    of: str | None
    mode: str
    target: str
    start_utc: Utc
    stop_utc: Utc
    best_elevation_rad: Annotated[float, Member("deg", -90.0, 90.0)] | None
    best_at_utc: Utc | None
    probability_in_frame: Share | None
    clear_probability: Share | None
    ground_sample_m: NotNegative | None


@answer
class PlanSummary:
    """Summary of a plan.

    name: as the request gives it.
    platform: the platform's name.
    targets: targets of its sessions, each once: names, or else ids, or else the target in a few
    words.
    start_utc: of the first session; UTC.
    stop_utc: of the last session; UTC.
    probability_in_frame: the least of any session's; null without any. E.g. `0.97`.
    sessions: in order of time.
    """

    name: str
    platform: str
    targets: tuple[str, ...]
    start_utc: Utc
    stop_utc: Utc
    probability_in_frame: Share | None
    sessions: tuple[SessionSummary, ...]


def summarise(plan: Plan) -> PlanSummary:
    """Of a plan as it was made."""
    scenario = plan.scenario
    return PlanSummary(
        name=scenario.name,
        platform=scenario.platform.name,
        targets=tuple(dict.fromkeys(one.label for one in scenario.sessions if one.label)),
        start_utc=scenario.sessions[0].start,
        stop_utc=scenario.sessions[-1].stop,
        probability_in_frame=plan.probability_in_frame,
        sessions=tuple(_summarise_session(plan, number) for number in range(len(plan.budgets))),
    )


def _summarise_session(plan: Plan, number: int) -> SessionSummary:
    session = plan.scenario.sessions[number]
    seen = next((one for one in plan.verification.sessions if one.session == number), None)
    highest_rad, nearest_m = (seen.elevation_max_rad, seen.range_min_m) if seen else (None, None)
    pixel_rad = plan.scenario.platform.camera.pixel_rad
    return SessionSummary(
        session=number,
        id=session.id,
        name=session.name,
        of=session.of,
        mode=session.target.mode,
        target=session.target.label,
        start_utc=session.start,
        stop_utc=session.stop,
        best_elevation_rad=highest_rad,
        best_at_utc=seen.elevation_max_utc if seen else None,
        probability_in_frame=plan.probability_of(number),
        clear_probability=_clear_probability(plan.scenario, session),
        ground_sample_m=None
        if highest_rad is None or nearest_m is None or not session.target.images
        else _ground_sample_m(highest_rad, nearest_m, pixel_rad),
    )


def _clear_probability(scenario: Scenario, session: Session) -> float | None:
    target = session.target
    if scenario.clouds is None or not isinstance(target, EarthFixedTarget) or not target.images:
        return None
    middle_s = 0.5 * elapsed_s(session.stop, session.start)
    at = Instants(session.start, np.array([middle_s]))
    clear = float(scenario.clouds.clear_over(target.r_target_itrf_m(at), at)[0])
    return None if math.isnan(clear) else clear


def _ground_sample_m(elevation_rad: float, range_m: float, pixel_rad: float) -> float | None:
    """The carrier is nearest and highest at once, to a few metres of the range."""
    sine = np.array(math.sin(elevation_rad))
    sample_m = float(sample_along_m(sine, np.array(range_m), pixel_rad))
    return None if math.isnan(sample_m) else sample_m
