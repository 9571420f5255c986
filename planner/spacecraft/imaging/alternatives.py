"""What nearly what was asked can be imaged?  Alternatives to a refused session, tried by planning.

Nearest first: another time, another session, the same lines moved towards the track, less
momentum in the gyros.  What is told has been planned and judged.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from datetime import datetime

import numpy as np

from planner.errors import InfeasibleSlew, InvalidInput, OutsideCoverage, Refusal, Unreachable
from planner.frames.earth_orientation import itrf_from_eci_state
from planner.frames.geodesy import WGS84_A_M, c_enu_from_itrf, geodetic_from_itrf
from planner.frames.time_scales import elapsed_s, shifted_utc, utc_text
from planner.spacecraft.imaging.candidates import (
    PASSING_RAD,
    Candidate,
    ImagingSession,
    angles_to,
    candidates,
    middle_of,
)
from planner.spacecraft.requests import (
    SESSION_MAX_S,
    GeoLineString,
    GeoPolygon,
    ImagingPlanRequest,
    Position,
    Request,
)
from planner.spacecraft.table import TICK_S

TRIED_MAX = 4
BEFORE_S, AFTER_S = 90.0, 60.0  # to turn onto the first look and back after the last
ORBIT_S = 6000.0
MUCH = 0.6  # of the sphere: then it is the momentum that makes turns slow
MOMENTUM_SHARES = (0.9, 0.75, 0.5, 0.25, 0.0)
MOVED_MORE_KM = (5.0, 25.0, 75.0)  # the line's ends stand further out than its middle

MakeSession = Callable[[ImagingPlanRequest], ImagingSession]


@dataclass(frozen=True, kw_only=True)
class Alternative:
    """A request worth trying, and how to say so.  start, stop: of its imaging."""

    request: ImagingPlanRequest
    text: str
    start_utc: datetime | None = None
    stop_utc: datetime | None = None


def refusal_with_way_out(
    request: ImagingPlanRequest,
    why: Refusal,
    make_session: MakeSession,
    works: Callable[[ImagingPlanRequest], bool],
) -> Refusal:
    """The refusal with the nearest alternative that works; as it is when none of those tried
    does."""
    options: Iterator[Alternative]
    stored = float(np.linalg.norm(request.settings.momentum_n_m_s))
    much = MUCH * request.definition().slew.momentum_sphere_n_m_s
    if why.limit == "momentum" or (isinstance(why, InfeasibleSlew) and stored > much):
        options = _less_momentum(request)
    elif isinstance(why, InvalidInput):
        return why
    else:
        options = _alternatives(request, _number(why), make_session)
    found = next((option for option in options if works(option.request)), None)
    if found is None:
        return why
    kind = next(k for k in (Unreachable, InfeasibleSlew, InvalidInput) if isinstance(why, k))
    return kind(
        f"{why.detail}; nearest that was tried and works: {found.text}",
        field=why.field,
        limit=why.limit,
        at_utc=why.at_utc,
        earliest_feasible_start_utc=found.start_utc,
        feasible_stop_utc=found.stop_utc,
    )


def _number(why: Refusal) -> int:
    """Of the request at fault; the first when the refusal is about all of them."""
    last = (why.field or "").rpartition(".")[2]
    return int(last) if last.isdigit() else 0


def _less_momentum(request: ImagingPlanRequest) -> Iterator[Alternative]:
    momentum = np.array(request.settings.momentum_n_m_s)
    stored = float(np.linalg.norm(momentum))
    sphere = request.definition().slew.momentum_sphere_n_m_s
    for share in MOMENTUM_SHARES:
        if share * sphere >= stored:
            continue
        x, y, z = (momentum * (share * sphere / stored)).tolist()
        settings = replace(request.settings, momentum_n_m_s=(x, y, z))
        yield Alternative(
            request=replace(request, settings=settings, simulation_runs=0),
            text=f"{share * sphere:.0f} N m s in the same direction",
        )


def _alternatives(
    request: ImagingPlanRequest, number: int, make_session: MakeSession
) -> Iterator[Alternative]:
    one = request.requests[number]
    free = replace(one, start=None, window_start=None, window_stop=None)
    _, scan_s = middle_of(free, make_session(request))
    if scan_s > SESSION_MAX_S:
        return
    for margin_s in (0.0, 600.0, ORBIT_S):
        times = _other_times(request, one, free, margin_s, make_session)
        if times:
            yield from times
            return
    yield from _moved(request, free, make_session)


def _wider(request: ImagingPlanRequest, margin_s: float) -> Iterator[ImagingPlanRequest]:
    """The session with so much more before and behind it, in pieces no longer than allowed."""
    begin, end = -margin_s, elapsed_s(request.stop, request.start) + margin_s
    count = int(np.ceil((end - begin) / SESSION_MAX_S))
    step = np.floor((end - begin) / count)
    for k in range(count):
        first = shifted_utc(request.start, begin + k * step)
        yield replace(request, start=first, stop=shifted_utc(first, step))


def _other_times(
    request: ImagingPlanRequest,
    one: Request,
    free: Request,
    margin_s: float,
    make_session: MakeSession,
) -> list[Alternative]:
    """The times nearest to those asked for, each as a window that holds nothing else."""
    found: list[tuple[float, datetime, datetime]] = []
    for wide in _wider(request, margin_s):
        try:
            session = make_session(wide)
            options = candidates(free, 0, session)
        except (Unreachable, OutsideCoverage):
            continue
        for start_s, stop_s in _spans(options):
            start = shifted_utc(wide.start, start_s)
            stop = shifted_utc(wide.start, stop_s)
            found.append((_distance_s(request, one, start, stop), start, stop))
    found.sort(key=lambda item: item[0])
    return [_at_time(request, free, start, stop) for _, start, stop in found[:TRIED_MAX]]


def _spans(options: list[Candidate]) -> list[tuple[float, float]]:
    """Start and stop of every way to image a request; of a stereo pair, from look to look."""
    first = [c for c in options if c.part == 1]
    if not first:
        return [(c.start_s, c.stop_s) for c in options]
    second = [c for c in options if c.part == 2]
    return [(a.start_s, b.stop_s) for a in first for b in second if b.start_s > a.stop_s]


def _distance_s(
    request: ImagingPlanRequest, one: Request, start: datetime, stop: datetime
) -> float:
    """By how much what was asked would have to give: its start, or its window or session."""
    if one.start is not None:
        return abs(elapsed_s(start, one.start))
    first = one.window_start or shifted_utc(request.start, BEFORE_S)
    last = one.window_stop or shifted_utc(request.stop, -AFTER_S)
    return max(elapsed_s(first, start), 0.0) + max(elapsed_s(stop, last), 0.0)


def _at_time(
    request: ImagingPlanRequest, free: Request, start: datetime, stop: datetime
) -> Alternative:
    early_s = max(0.0, BEFORE_S - elapsed_s(start, request.start))
    late_s = max(0.0, AFTER_S - elapsed_s(request.stop, stop))
    session_start = shifted_utc(request.start, -TICK_S * np.ceil(early_s / TICK_S))
    session_stop = shifted_utc(request.stop, late_s)
    if elapsed_s(session_stop, session_start) > SESSION_MAX_S:
        session_start = shifted_utc(start, -BEFORE_S)
        session_stop = shifted_utc(stop, AFTER_S)
    text = (
        f"{free.name!r} in a window from {utc_text(start, 1)} to {utc_text(stop, 1)} "
        f"({elapsed_s(stop, start):.1f} s)"
    )
    if (session_start, session_stop) != (request.start, request.stop):
        text += f" in a session from {utc_text(session_start, 1)} to {utc_text(session_stop, 1)}"
    return Alternative(
        request=replace(
            request,
            start=session_start,
            stop=session_stop,
            requests=(replace(free, window_start=start, window_stop=stop),),
            simulation_runs=0,
        ),
        text=text,
        start_utc=start,
        stop_utc=stop,
    )


def _moved(
    request: ImagingPlanRequest, free: Request, make_session: MakeSession
) -> Iterator[Alternative]:
    """The same lines shifted over the ground, straight towards the track."""
    approach = _closest_approach(free, make_session(request))
    if approach is None:
        return
    outside_m, towards = approach
    for more_km in MOVED_MORE_KM:
        shift_km = outside_m / 1e3 + more_km
        moved = _shifted(free, towards, shift_km)
        yield Alternative(
            request=replace(request, requests=(moved,), simulation_runs=0),
            text=f"{free.name!r} moved {shift_km:.0f} km towards the ground track, its first "
            f"position at {_first(moved)}",
        )


def _first(moved: Request) -> str:
    geometry = moved.geometry
    ring = geometry.coordinates[0] if isinstance(geometry, GeoPolygon) else geometry.coordinates
    position = ring[0]
    return f"[{position[0]:.4f}, {position[1]:.4f}]"


def _shifted(free: Request, towards: tuple[float, float], shift_km: float) -> Request:
    """towards: unit vector east, north."""
    north_deg = np.degrees(1e3 * shift_km / WGS84_A_M) * towards[1]

    def position(p: Position) -> Position:
        latitude = np.radians(p[1] + 0.5 * north_deg)
        east_deg = np.degrees(1e3 * shift_km / WGS84_A_M / np.cos(latitude)) * towards[0]
        longitude = (p[0] + east_deg + 180.0) % 360.0 - 180.0
        return (float(longitude), float(np.clip(p[1] + north_deg, -89.0, 89.0)))

    if isinstance(free.geometry, GeoPolygon):
        ring = tuple(position(p) for p in free.geometry.coordinates[0])
        return replace(free, geometry=GeoPolygon(coordinates=(ring,)))
    line = tuple(position(p) for p in free.geometry.coordinates)
    return replace(free, geometry=GeoLineString(coordinates=line))


def _closest_approach(
    request: Request, session: ImagingSession
) -> tuple[float, tuple[float, float]] | None:
    """How far over the ground the request's middle lies outside the camera's reach when the
    track passes it, m, and the way to the track there (east, north); None when it doesn't pass.
    """
    middle, _ = middle_of(request, session)
    latitude, longitude, _ = geodetic_from_itrf(middle)
    grid = np.arange(0.0, session.duration_s, 1.0)
    along, _ = angles_to(middle, grid, session)
    best = int(np.argmin(np.abs(along)))
    if abs(along[best]) > PASSING_RAD:
        return None
    instants = session.instants(grid[best : best + 1])
    states = session.ephemeris.states(instants)
    r, _ = itrf_from_eci_state(states.r_sat_eci_m, states.v_sat_eci_m_s, instants)
    up = r[0] / np.linalg.norm(r[0])
    # On a sphere under the satellite: sin(angle at it) r = sin(angle at the ground point) R.
    limit = math.radians(session.spacecraft.camera.across_max_deg)
    earth_m = float(np.linalg.norm(middle))
    sine = min(math.sin(limit) * float(np.linalg.norm(r[0])) / earth_m, 1.0)
    reach_m = (math.asin(sine) - limit) * earth_m
    away_m = math.acos(float(np.clip(up @ middle / earth_m, -1.0, 1.0))) * earth_m
    east, north, _ = c_enu_from_itrf(float(latitude), float(longitude)) @ (up * earth_m - middle)
    size = math.hypot(east, north)
    return max(away_m - reach_m, 0.0), (east / size, north / size)
