"""When could each request be imaged?  Request -> looks on a grid of start times.

A candidate is one way to fulfil a request: its ground arcs with their times.  Those that
leave the +-45/+-30 deg of the camera are dropped; a request with none left is refused with
the nearest alternative.
"""

import math
from dataclasses import dataclass, replace
from datetime import datetime
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from planner import effort
from planner.arrays import Array
from planner.errors import Unreachable
from planner.frames.earth_orientation import c_itrf_from_eci, itrf_from_eci_state
from planner.frames.geodesy import c_enu_from_itrf, geodetic_from_itrf, itrf_from_geodetic
from planner.frames.time_scales import Instants, elapsed_s, shifted_utc, utc_text
from planner.orbits import Ephemeris
from planner.spacecraft.imaging.ground_arc import GroundArc, arc_attitude, look_angles
from planner.spacecraft.requests import (
    AreaRequest,
    CorridorRequest,
    ImagingRequest,
    Request,
    StereoRequest,
    StripRequest,
)
from planner.spacecraft.table import TICK_S
from planner.spacecraft.turns.turn_time import MovingEnds, TurnTime
from planner.spacecraft.vehicle.definition import AgileSpacecraft

GRID_S = 2.0
PASSING_RAD = math.radians(3.0)  # along the track: abeam
# Of `planner.effort`: to look at an arc scanned from one start, and at one point of it.
ARC_AT_START, POINT_AT_TICK = 5.0, 0.25


@dataclass(frozen=True, kw_only=True)
class Candidate:
    """One way to image a request: arcs in order of time, all within the camera's angles.

    entry, exit: attitude and rate at the first arc's start and the last one's end, n = 1.
    part: 0 for a whole request, 1 and 2 for the two looks of a stereo pair (which may have
    others between).  tilt_rad: largest angle along the track.
    """

    request: int
    part: int
    arcs: tuple[GroundArc, ...]
    entry: MovingEnds
    exit: MovingEnds
    tilt_rad: float

    @property
    def start_s(self) -> float:
        return self.arcs[0].start_s

    @property
    def stop_s(self) -> float:
        return self.arcs[-1].start_s + on_ticks(self.arcs[-1]) * TICK_S


@dataclass(frozen=True, kw_only=True)
class ImagingSession:
    """What all requests share: orbit, epoch, length and spacecraft of a session."""

    ephemeris: Ephemeris
    epoch_utc: datetime
    duration_s: float
    spacecraft: AgileSpacecraft
    turn_time: TurnTime

    def instants(self, t_s: Array) -> Instants:
        return Instants(self.epoch_utc, t_s)


def candidates(request: Request, number: int, session: ImagingSession) -> list[Candidate]:
    """Every candidate of a request.  Raises Unreachable when there is none."""
    if isinstance(request, StereoRequest):
        return _stereo(request, number, session)
    chains = _chains(request, session)
    starts_s = _start_times(request, session)
    found: list[Candidate] = []
    for chain in chains:
        found += _timed(chain, starts_s, number, request, session)
    if not found:
        raise _unreachable(request, number, session)
    return found


def _start_times(request: ImagingRequest, session: ImagingSession) -> Array:
    if request.start is not None:
        asked = elapsed_s(request.start, session.epoch_utc)
        return np.array([round(asked / TICK_S) * TICK_S])
    grid = np.arange(0.0, session.duration_s, GRID_S)
    if request.window_start is None:
        return grid
    first_s = elapsed_s(request.window_start, session.epoch_utc)
    opening_s = math.ceil(first_s / TICK_S - 1e-6) * TICK_S
    return np.union1d(grid, [opening_s])  # a window as short as the scan is met too


def _chains(request: Request, session: ImagingSession) -> list[list[GroundArc]]:
    """Arcs in the order they may be scanned, times yet open (start_s = 0)."""
    if isinstance(request, AreaRequest):
        arcs = _strips(request, session)
    elif isinstance(request, StripRequest | CorridorRequest):
        arcs = _legs(request)
    else:
        arcs = []
    forward = [_along_flight(arc, session) for arc in arcs]
    if isinstance(request, CorridorRequest):
        return [arcs]
    if not session.spacecraft.camera.reversible:
        return [forward]
    other = [_reversed(arc) for arc in forward]
    zigzag = [forward[i] if i % 2 == 0 else other[i] for i in range(len(arcs))]
    zagzig = [other[i] if i % 2 == 0 else forward[i] for i in range(len(arcs))]
    return [zigzag, zagzig]


def _arc(a: tuple[float, ...], b: tuple[float, ...], request: ImagingRequest) -> GroundArc:
    arc = GroundArc(
        latitude_rad=(math.radians(a[1]), math.radians(b[1])),
        longitude_rad=(math.radians(a[0]), math.radians(b[0])),
        height_m=request.height_m,
        start_s=0.0,
        duration_s=1.0,
    )
    return replace(arc, duration_s=arc.length_m() / request.scan_speed_m_s)


def _legs(request: StripRequest | CorridorRequest | StereoRequest) -> list[GroundArc]:
    points = request.geometry.coordinates
    return [_arc(a, b, request) for a, b in pairwise(points)]


def _strips(request: AreaRequest, session: ImagingSession) -> list[GroundArc]:
    """Parallel strips over the polygon's bounding box in scan direction."""
    ring = np.deg2rad([p[:2] for p in request.geometry.coordinates[0][:-1]])
    corners = itrf_from_geodetic(ring[:, 1], ring[:, 0], request.height_m)
    latitude, longitude, _ = geodetic_from_itrf(corners.mean(axis=0))
    origin = itrf_from_geodetic(latitude, longitude, request.height_m)
    enu = c_enu_from_itrf(latitude, longitude)
    local = (corners - origin) @ enu.T
    if request.azimuth_deg is None:
        azimuth = _side_azimuth(local, _track_azimuth(origin, enu, session))
    else:
        azimuth = math.radians(request.azimuth_deg)
    along = np.array([math.sin(azimuth), math.cos(azimuth), 0.0])
    across = np.array([math.cos(azimuth), -math.sin(azimuth), 0.0])
    low, high = (local @ along).min(), (local @ along).max()
    left, right = (local @ across).min(), (local @ across).max()
    swath_m = session.spacecraft.camera.swath_m
    count = max(1, math.ceil((right - left) / swath_m - 1e-3))
    middle = 0.5 * (left + right)
    arcs = []
    for k in range(count):
        offset = middle + (k - 0.5 * (count - 1)) * swath_m
        ends = [origin + (s * along + offset * across) @ enu for s in (low, high)]
        lat, lon, _ = geodetic_from_itrf(np.array(ends))
        lon_deg, lat_deg = np.rad2deg(lon), np.rad2deg(lat)
        arcs.append(_arc((lon_deg[0], lat_deg[0]), (lon_deg[1], lat_deg[1]), request))
    return arcs


def _side_azimuth(local: Array, track_rad: float) -> float:
    """Azimuth of the side of the polygon nearest the track's, if within 10 deg, else the track's.

    Strips along a side cover a rectangle without one too many.
    """
    sides = np.roll(local, -1, axis=0) - local
    off = np.arctan2(sides[:, 0], sides[:, 1]) - track_rad
    off = (off + 0.5 * np.pi) % np.pi - 0.5 * np.pi
    nearest = float(off[np.argmin(np.abs(off))])
    return track_rad + (nearest if abs(nearest) < math.radians(10.0) else 0.0)


def _track_azimuth(r_itrf_m: Array, enu: Array, session: ImagingSession) -> float:
    """Azimuth of the satellite's motion over ground where it passes closest, rad."""
    instants = session.instants(np.arange(0.0, session.duration_s + 1.0, 5.0))
    states = session.ephemeris.states(instants)
    r, v = itrf_from_eci_state(states.r_sat_eci_m, states.v_sat_eci_m_s, instants)
    nearest = int(np.argmin(np.linalg.norm(r - r_itrf_m, axis=1)))
    east, north, _ = enu @ v[nearest]
    return math.atan2(east, north)


def _along_flight(arc: GroundArc, session: ImagingSession) -> GroundArc:
    """The arc in the sense of the flight."""
    ends, _ = arc.point_itrf(np.array([0.0, 1.0]))
    instants = session.instants(np.arange(0.0, session.duration_s + 1.0, 20.0))
    states = session.ephemeris.states(instants)
    r, v = itrf_from_eci_state(states.r_sat_eci_m, states.v_sat_eci_m_s, instants)
    nearest = int(np.argmin(np.linalg.norm(r - ends[0], axis=1)))
    if (ends[1] - ends[0]) @ v[nearest] >= 0.0:
        return arc
    return replace(arc, latitude_rad=arc.latitude_rad[::-1], longitude_rad=arc.longitude_rad[::-1])


def _reversed(arc: GroundArc) -> GroundArc:
    return replace(
        arc,
        latitude_rad=arc.latitude_rad[::-1],
        longitude_rad=arc.longitude_rad[::-1],
        backwards=not arc.backwards,
    )


def on_ticks(arc: GroundArc) -> int:
    """Ticks that cover the arc's duration."""
    return math.ceil(arc.duration_s / TICK_S - 1e-6)


def _timed(
    chain: list[GroundArc],
    starts_s: Array,
    number: int,
    request: ImagingRequest,
    session: ImagingSession,
) -> list[Candidate]:
    """The chain at every start time where all its arcs are within the camera's angles."""
    first_s, last_s = _bounds(request, session)
    times, tilt = starts_s, np.zeros(len(starts_s))
    begins = np.empty((0, len(starts_s)))
    exits: MovingEnds | None = None
    for arc in chain:
        effort.spend(ARC_AT_START * len(times))
        if exits is not None:
            times = _after_turn(exits, times, arc, session)
        span_s = on_ticks(arc) * TICK_S
        kept = np.flatnonzero((times >= first_s) & (times + span_s <= last_s))
        in_reach, along = _in_reach(arc, times[kept], span_s, session)
        kept = kept[in_reach]
        if not kept.size:
            return []
        begins = np.vstack([begins[:, kept], times[kept]])
        tilt = np.maximum(tilt[kept], along[in_reach])
        times = times[kept] + span_s
        exits = _scan(arc, span_s / arc.duration_s, times, session)
    assert exits is not None
    entries = _scan(chain[0], 0.0, begins[0], session)
    return [
        Candidate(
            request=number,
            part=0,
            arcs=tuple(
                replace(arc, start_s=float(begin_s))
                for arc, begin_s in zip(chain, begins[:, k], strict=True)
            ),
            entry=entries[k : k + 1],
            exit=exits[k : k + 1],
            tilt_rad=float(tilt[k]),
        )
        for k in range(len(times))
    ]


def _bounds(request: ImagingRequest, session: ImagingSession) -> tuple[float, float]:
    """Of its window within the session; a window may be told to the microsecond."""
    first_s, last_s = 0.0, session.duration_s
    if request.window_start is not None:
        first_s = max(first_s, elapsed_s(request.window_start, session.epoch_utc) - 1e-6)
    if request.window_stop is not None:
        last_s = min(last_s, elapsed_s(request.window_stop, session.epoch_utc) + 1e-6)
    return first_s, last_s


def _after_turn(exits: MovingEnds, times: Array, arc: GroundArc, session: ImagingSession) -> Array:
    """Start of the next arc: the turn's time depends on it, so three rounds."""
    starts = times + 10.0
    for _ in range(3):
        safe = np.clip(starts, 0.0, session.duration_s)
        entries = _scan(arc, 0.0, safe, session)
        starts = times + session.turn_time.ticks(exits, entries) * TICK_S
    return np.asarray(starts)


def _scan(arc: GroundArc, share: float, times: Array, session: ImagingSession) -> MovingEnds:
    """The arc's point at `share` under the slit at each time, and the scan's rate there (by
    differences over a tick: 1e-6 rad/s)."""
    later = session.instants(times + TICK_S)
    n, ahead = len(times), share + TICK_S / arc.duration_s
    now = arc_attitude(arc, np.full(n, share), session.ephemeris, session.instants(times))
    then = arc_attitude(arc, np.full(n, ahead), session.ephemeris, later)
    return MovingEnds(now.as_quat(), (then * now.inv()).as_rotvec() / TICK_S)


def _in_reach(
    arc: GroundArc, times: Array, span_s: float, session: ImagingSession
) -> tuple[NDArray[np.bool_], Array]:
    """Whether the camera can look at all of the arc, and the largest angle along the track."""
    camera = session.spacecraft.camera
    ok, tilt = np.ones(len(times), dtype=bool), np.zeros(len(times))
    for share in (0.0, 0.5, 1.0):
        along, across = _angles(arc, share, times + share * span_s, session)
        ok &= np.abs(along) <= math.radians(camera.along_max_deg)
        ok &= np.abs(across) <= math.radians(camera.across_max_deg)
        tilt = np.maximum(tilt, np.abs(along))
    return ok, tilt


def _angles(
    arc: GroundArc, share: float, times: Array, session: ImagingSession
) -> tuple[Array, Array]:
    """Along and across angle of one point of the arc; behind the horizon: pi."""
    point, _ = arc.point_itrf(np.array([share]))
    return angles_to(point[0], times, session)


def angles_to(point: Array, times: Array, session: ImagingSession) -> tuple[Array, Array]:
    """Along and across angle of an ITRF point (3,); behind the horizon: pi."""
    instants = session.instants(times)
    along, across = look_angles(
        np.broadcast_to(point, (len(times), 3)), session.ephemeris, instants
    )
    states = session.ephemeris.states(instants)
    r_itrf = np.einsum("nij,nj->ni", c_itrf_from_eci(instants), states.r_sat_eci_m)
    hidden = np.sum((r_itrf - point) * point, axis=1) < 0.0
    return np.where(hidden, np.pi, along), np.where(hidden, np.pi, across)


def _stereo(request: StereoRequest, number: int, session: ImagingSession) -> list[Candidate]:
    """Two looks: where the strip's middle is look_angle_deg ahead (or at `start`), and the same
    behind."""
    arc = _along_flight(_legs(request)[0], session)
    grid = np.arange(0.0, session.duration_s, TICK_S)
    effort.spend(POINT_AT_TICK * len(grid))
    along, _ = _angles(arc, 0.5, grid, session)
    found: list[Candidate] = []
    for part, angle in ((1, request.look_angle_deg), (2, -request.look_angle_deg)):
        middle = float(grid[np.argmin(np.abs(along - math.radians(angle)))])
        start = round((middle - 0.5 * arc.duration_s) / TICK_S) * TICK_S
        nudged = np.asarray(start + np.arange(-5.0, 6.0) * TICK_S * 2)
        if part == 1 and request.start is not None:
            nudged = _start_times(request, session)
        looks = _timed([arc], nudged, number, request, session)
        found += [replace(look, part=part) for look in looks]
    if {c.part for c in found} != {1, 2}:
        raise _unreachable(request, number, session)
    return found


def middle_of(request: Request, session: ImagingSession) -> tuple[Array, float]:
    """A point in the middle of a request, ITRF, and the time its scans take."""
    arcs = _legs(request) if isinstance(request, StereoRequest) else _chains(request, session)[0]
    ends = np.concatenate([arc.point_itrf(np.array([0.0, 1.0]))[0] for arc in arcs])
    middle = ends.mean(axis=0)
    return middle, sum(arc.duration_s for arc in arcs)


def _unreachable(request: Request, number: int, session: ImagingSession) -> Unreachable:
    """Say when it would come closest, and at what angles."""
    camera = session.spacecraft.camera
    middle, scan_s = middle_of(request, session)
    grid = np.arange(0.0, session.duration_s, 1.0)
    along, across = angles_to(middle, grid, session)
    best = int(np.argmin(np.abs(along)))
    at_utc = shifted_utc(session.epoch_utc, float(grid[best]))
    where = (
        f"closest at {utc_text(at_utc, 1)}, {math.degrees(along[best]):.1f} deg along and "
        f"{math.degrees(across[best]):.1f} deg across the track"
        if abs(along[best]) < PASSING_RAD
        else "the track doesn't pass it"
    )
    return Unreachable(
        f"{request.name!r} is never wholly within {camera.along_max_deg:g} deg along and "
        f"{camera.across_max_deg:g} deg across the track, in its window and session, for the "
        f"{scan_s:.1f} s it takes to scan: {where}; move or widen the window, shorten the "
        "request or use another pass",
        field=f"requests.{number}",
        limit="camera angles",
        at_utc=at_utc,
    )
