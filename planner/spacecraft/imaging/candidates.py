"""Every possibility to image a request: its scans on a grid of start times.

Those that leave the camera's angles along and across the track are dropped; a request with none
left is refused with when it would come closest.
"""

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from planner.base import effort
from planner.base.arrays import Array, Mask
from planner.base.commands import COMMAND_STEP_S
from planner.base.errors import InfeasibleSlew, Unreachable, figures
from planner.base.mrp import BodyMotion
from planner.motion.attitude.track import agility_limits
from planner.planning.label_search import COMPLETES, OPENS, WHOLE
from planner.spacecraft.imaging.session import GroundArc, ImagingSession
from planner.spacecraft.requests import (
    AreaRequest,
    CorridorRequest,
    ImagingRequest,
    Request,
    StereoRequest,
)
from planner.world.frames.time_scales import elapsed_s, shifted_utc, utc_text
from planner.world.targets.geojson import Position
from planner.world.targets.imaging import OPTIONS as MODES
from planner.world.targets.imaging import ImagingMode
from planner.world.targets.strips import strip_pattern


@dataclass(frozen=True, kw_only=True)
class CandidateOptions:
    """From which moments on what is asked for is tried."""

    # Between starts: at 2 s five dense sessions were worth 1 to 4 % less, at 0.4 s one of four 2 %
    # more for half as much work again.
    grid_s: float = 1.0
    coarse_grid_s: float = 2.0
    # requests squared by the session's time, up to which the pairs of a fine grid take a fifth of
    # the work there is at most
    dense_per_s: float = 2.5
    stereo_steps: int = 5  # starts tried before and after that of the exact angle,
    stereo_step_ticks: int = 2  # so far apart
    # a slew's time hangs on where its goal has moved meanwhile: the first guess,
    slew_guess_s: float = 10.0
    slew_rounds: int = 3  # and how often it is bettered
    passing_rad: float = math.radians(3.0)  # along the track: abeam
    rounding_s: float = 1e-6  # a window may be given to the microsecond
    arc_at_start: float = 5.0  # of `effort`: to look at an arc scanned from one start,
    point_at_tick: float = 0.25  # and at one point of it
    load_step_s: float = 2.0  # between instants whose loads are looked at: 0.1 % of a rate's peak
    # of a limit: the slews onto and from a scan keep a little less than that
    used_max: float = 0.99
    load: float = 3.0  # of `effort`: to look at the loads of one instant


OPTIONS = CandidateOptions()


@dataclass(frozen=True, kw_only=True, eq=False)
class Candidate:
    """One possibility to image a request: arcs in order of time, all within the camera's angles.

    request: its number in the session.  part: as of `label_search`, others may come between the
    two looks of a stereo pair.  entry_state, exit_state: as of `Slews`, (11,)
    each, of the first arc and the last one.  tilt_rad: largest angle along the track.
    used_shares: largest of the limits of rate and acceleration while it is scanned.
    """

    request: int
    part: int
    arcs: tuple[GroundArc, ...]
    entry_state: Array
    exit_state: Array
    tilt_rad: float
    used_shares: tuple[float, float] = (0.0, 0.0)

    @property
    def start_s(self) -> float:
        return self.arcs[0].start_s

    @property
    def stop_s(self) -> float:
        return self.arcs[-1].start_s + self.arcs[-1].ticks * COMMAND_STEP_S


def candidates(request: Request, number: int, session: ImagingSession) -> list[Candidate]:
    """Every candidate of the number-th request.

    Raises Unreachable when it is never seen, InfeasibleSlew when no scan of it keeps the limits.
    """
    layout = _layout(request, session)
    if layout.least_s > session.duration_s:
        count = "one scan" if layout.scans == 1 else f"{layout.scans} scans"
        raise Unreachable(
            f"{request.name!r} takes {count}, which with the slews between last at least "
            f"{layout.least_s:.1f} s, longer than the session's {session.duration_s:.1f} s; ask "
            "for less at a time or for a longer session",
            field=f"requests.{number}",
            limit="time",
        )
    looks = [
        [
            one
            for arcs in orders
            for one in _from_starts(arcs, starts_s, (number, part), request, session)
        ]
        for part, orders, starts_s in _looks(request, session)
    ]
    if not all(looks):  # half a pair is no image
        raise _never_seen(request, number, layout, session)
    kept = [[one for one in look if max(one.used_shares) <= OPTIONS.used_max] for look in looks]
    overloaded = [look for look, left in zip(looks, kept, strict=True) if not left]
    if overloaded:
        raise _overloaded(request, number, overloaded, session)
    return [one for look in kept for one in look]


class _Layout(NamedTuple):
    """Lines that a request has scanned, as a session of any platform in that mode; how many scans
    it is, and no less than the time they and the slews between take."""

    mode: ImagingMode
    lines: Iterable[tuple[Position, Position]]
    scans: int
    least_s: float


def _layout(request: Request, session: ImagingSession) -> _Layout:
    """Of an area parallel strips over the polygon's bounding box in scan direction."""
    mode = request.as_mode()
    lines: Iterable[tuple[Position, Position]]
    if isinstance(request, AreaRequest):
        pattern = strip_pattern(
            request.geometry.coordinates,
            request.height_m,
            request.azimuth_deg,
            session.passing.velocity_passing,
            session.spacecraft.swath_m,
            session.spacecraft.swath_m,
        )
        ends_m, count = np.array([pattern.from_m, pattern.to_m]), pattern.count
        strips = (pattern.positions(ends_m, pattern.aside_m(k)) for k in range(count))
        lines = ((first, last) for first, last in strips)
        scan_s = count * (pattern.to_m - pattern.from_m) / request.scan_speed_m_s
    else:
        lines = list(pairwise(request.geometry.coordinates))
        looks = 2 if isinstance(request, StereoRequest) else 1
        count = looks * len(lines)
        scan_s = looks * sum(mode.path_between(*ends).duration_s for ends in lines)
    slews_s = (count - 1) * max(session.slews.settle_s, COMMAND_STEP_S)
    return _Layout(mode, lines, count, scan_s + slews_s)


def scan_orders(request: Request, session: ImagingSession) -> list[list[GroundArc]]:
    """The request's arcs in each order and sense they may be scanned, times open (start_s = 0).

    A corridor's legs as they are given, other arcs in the sense of flight; by a reversible
    detector to and fro.
    """
    mode, lines, _, _ = _layout(request, session)
    if isinstance(request, CorridorRequest):
        return [[GroundArc(path=mode.path_between(*ends)) for ends in lines]]
    forward = [mode.in_sense(ends, session.passing) for ends in lines]
    senses = [[GroundArc(path=mode.path_between(*ends)) for ends in forward]]
    if not session.platform.camera.both_ways:
        return senses
    senses.append(
        [GroundArc(path=mode.path_between(*ends[::-1]), backwards=True) for ends in forward]
    )
    return [[senses[(k + first) % 2][k] for k in range(len(forward))] for first in (0, 1)]


def _looks(
    request: Request, session: ImagingSession
) -> Iterator[tuple[int, list[list[GroundArc]], Array]]:
    """Parts of a request: number, arcs in every order, and the starts tried.

    Of a stereo pair where the strip's middle is look_angle_deg ahead (or from `start` on), and the
    same behind; or gap_s apart.
    """
    orders = scan_orders(request, session)
    asked_s = None
    if request.start is not None:
        asked_s = _on_ticks(np.array([elapsed_s(request.start, session.epoch_utc)]))
    is_dense = len(session.request.requests) ** 2 > OPTIONS.dense_per_s * session.duration_s
    apart_s = OPTIONS.coarse_grid_s if is_dense else OPTIONS.grid_s
    grid_s = np.arange(0.0, session.duration_s, apart_s)
    if not isinstance(request, StereoRequest):
        if asked_s is None and request.window_start is not None:
            # A window as short as the scan is met too.
            opening_s = elapsed_s(request.window_start, session.epoch_utc)
            grid_s = np.union1d(
                grid_s, [math.ceil(opening_s / COMMAND_STEP_S - 1e-6) * COMMAND_STEP_S]
            )
        yield WHOLE, orders, grid_s if asked_s is None else asked_s
        return
    [arc] = orders[0]
    tick_s = np.arange(0.0, session.duration_s, COMMAND_STEP_S)
    effort.charge(OPTIONS.point_at_tick * len(tick_s))
    along_rad, _ = session.passing.look_angles(_point_itrf_m(arc, 0.5), tick_s)

    def starts_s_at(angle_deg: float, earlier_s: float = 0.0) -> Array:
        middle_s = tick_s[[np.argmin(np.abs(along_rad - math.radians(angle_deg)))]]
        return _on_ticks(middle_s - earlier_s - 0.5 * arc.duration_s)

    steps = np.arange(-OPTIONS.stereo_steps, OPTIONS.stereo_steps + 1.0)
    steps_s = steps * COMMAND_STEP_S * OPTIONS.stereo_step_ticks
    angle_deg, gap_s = request.look_angle_deg or MODES.look_angle_deg, request.gap_s
    if gap_s is None:
        first_s, second_s = (starts_s_at(one_deg) + steps_s for one_deg in (angle_deg, -angle_deg))
        yield OPENS, [[arc]], first_s if asked_s is None else asked_s
    else:
        first_s = starts_s_at(0.0, 0.5 * gap_s) if asked_s is None else asked_s
        second_s = first_s + _on_ticks(gap_s)
        yield OPENS, [[arc]], first_s
    yield COMPLETES, [[arc]], second_s


def _on_ticks(t_s: ArrayLike) -> Array:
    return np.asarray(np.round(np.divide(t_s, COMMAND_STEP_S)) * COMMAND_STEP_S)


def _from_starts(
    arcs: list[GroundArc],
    starts_s: Array,
    number_part: tuple[int, int],
    request: ImagingRequest,
    session: ImagingSession,
) -> Iterator[Candidate]:
    """The arcs one after another from every start where all are within the camera's angles."""
    first_s, last_s = _window_s(request, session)
    t_s, tilt_rad = starts_s, np.zeros(len(starts_s))
    begins_s = np.empty((0, len(starts_s)))  # of each arc so far, for each start still open
    used = np.zeros((2, len(starts_s)))
    exit_states: Array | None = None
    for arc in arcs:
        effort.charge(OPTIONS.arc_at_start * len(t_s))
        if exit_states is not None:
            t_s = _after_slew_s(exit_states, t_s, arc, session)
        scan_s = arc.ticks * COMMAND_STEP_S
        kept = np.flatnonzero((t_s >= first_s) & (t_s + scan_s <= last_s))
        in_reach, along_rad = _in_reach(arc, t_s[kept], scan_s, session)
        kept = kept[in_reach]
        if not kept.size:
            return
        begins_s = np.vstack([begins_s[:, kept], t_s[kept]])
        tilt_rad = np.maximum(tilt_rad[kept], along_rad[in_reach])
        used = np.maximum(used[:, kept], _used_shares(arc, t_s[kept], scan_s, session))
        t_s = t_s[kept] + scan_s
        exit_states = session.ends(arc, begins_s[-1], scan_s)
    assert exit_states is not None
    entry_states = session.entries(arcs[0], begins_s[0])
    for k in range(len(t_s)):
        yield Candidate(
            request=number_part[0],
            part=number_part[1],
            arcs=tuple(
                replace(arc, start_s=float(begin_s))
                for arc, begin_s in zip(arcs, begins_s[:, k], strict=True)
            ),
            entry_state=entry_states[k],
            exit_state=exit_states[k],
            tilt_rad=float(tilt_rad[k]),
            used_shares=(float(used[0, k]), float(used[1, k])),
        )


def _window_s(request: ImagingRequest, session: ImagingSession) -> tuple[float, float]:
    """First and last moment of the request's window within the session."""
    opens_s, closes_s = (
        None if utc is None else elapsed_s(utc, session.epoch_utc)
        for utc in (request.window_start, request.window_stop)
    )
    first_s = 0.0 if opens_s is None else max(opens_s - OPTIONS.rounding_s, 0.0)
    if closes_s is None:
        return first_s, session.duration_s
    return first_s, min(closes_s + OPTIONS.rounding_s, session.duration_s)


def _after_slew_s(exit_states: Array, t_s: Array, arc: GroundArc, session: ImagingSession) -> Array:
    """Starts of the next arc, by slews that leave the scans before at t_s."""
    starts_s = t_s + OPTIONS.slew_guess_s
    for _ in range(OPTIONS.slew_rounds):
        entry_states = session.entries(arc, np.clip(starts_s, 0.0, session.duration_s))
        starts_s = t_s + session.slews.ticks(exit_states, entry_states) * COMMAND_STEP_S
    return np.asarray(starts_s)


def _used_shares(arc: GroundArc, begins_s: Array, scan_s: float, session: ImagingSession) -> Array:
    """Shares of the limits of rate and acceleration, (2, n), most used from when each scan is
    settled onto until it is left."""
    limits, settle_s = agility_limits(session.platform), session.slews.settle_s
    count = math.ceil((settle_s + scan_s + COMMAND_STEP_S) / OPTIONS.load_step_s) + 1
    effort.charge(OPTIONS.load * count * len(begins_s))
    used = np.zeros((2, len(begins_s)))
    for after_s in np.linspace(-settle_s, scan_s + COMMAND_STEP_S, count).tolist():
        _, rate, acceleration, _ = np.split(
            session.ends(arc, begins_s, after_s), [4, 7, 10], axis=1
        )
        motion = BodyMotion(rate, acceleration, np.zeros_like(rate))
        used = np.maximum(used, limits.shares(motion)[:, :2].T)
    return used


def _in_reach(
    arc: GroundArc, t_s: Array, scan_s: float, session: ImagingSession
) -> tuple[Mask, Array]:
    """Whether the camera can look at all of the arc, and the largest angle along the track."""
    spacecraft = session.spacecraft
    most_rad = np.deg2rad([spacecraft.along_max_deg, spacecraft.across_max_deg])[:, None]
    in_reach, tilt_rad = np.ones(len(t_s), dtype=bool), np.zeros(len(t_s))
    for share in (0.0, 0.5, 1.0):
        seen = session.passing.look_angles(_point_itrf_m(arc, share), t_s + share * scan_s)
        in_reach &= np.all(np.abs(seen) <= most_rad, axis=0)
        tilt_rad = np.maximum(tilt_rad, np.abs(seen[0]))
    return in_reach, tilt_rad


def _point_itrf_m(arc: GroundArc, share: float) -> Array:
    return np.asarray(arc.point_itrf(np.array([share]))[0][0])


def _overloaded(
    request: Request, number: int, looks: Iterable[list[Candidate]], session: ImagingSession
) -> InfeasibleSlew:
    """What the scan that comes nearest to the limits asks for, of looks that none can scan."""
    used = max((min((one.used_shares for one in look), key=max) for look in looks), key=max)
    gyros = session.platform.gyros
    assert gyros is not None  # as of every body of this front
    worst = used.index(max(used))
    limit, most, text = (
        ("rate", gyros.turns.rate_max_deg_s, "turn the body at {} deg/s about an axis"),
        ("torque", gyros.turns.torque_max_n_m, "take {} N m of the gyros"),
    )[worst]
    first = "unload momentum first, " if any(gyros.start_n_m_s) else ""
    told = text.format(figures(used[worst] * most, OPTIONS.used_max * most))
    return InfeasibleSlew(
        f"scanning {request.name!r} would {told} at least, more than {OPTIONS.used_max:.0%} of the "
        f"{most:.4g} there are; {first}ask for another scan_speed_m_s or use another pass",
        field=f"requests.{number}",
        limit=limit,
    )


def _never_seen(
    request: Request, number: int, layout: _Layout, session: ImagingSession
) -> Unreachable:
    """Say when it would come closest, and at what angles."""
    spacecraft, (arcs, *_) = session.spacecraft, scan_orders(request, session)
    ends_itrf_m = np.concatenate([arc.point_itrf(np.array([0.0, 1.0]))[0] for arc in arcs])
    grid_s = np.arange(0.0, session.duration_s, 1.0)
    along_rad, across_rad = session.passing.look_angles(ends_itrf_m.mean(axis=0), grid_s)
    abeam = int(np.argmin(np.abs(along_rad)))
    at_utc = shifted_utc(session.epoch_utc, float(grid_s[abeam]))
    where = "the track doesn't pass it"
    if abs(along_rad[abeam]) < OPTIONS.passing_rad:
        where = (
            f"closest at {utc_text(at_utc, 1)}, {math.degrees(along_rad[abeam]):.1f} deg along and "
            f"{math.degrees(across_rad[abeam]):.1f} deg across the track"
        )
    least, less = f"{layout.least_s:.1f} s", "shorten the request"
    takes = f"{least} that {layout.scans} scans, with the slews between, take at least"
    if isinstance(request, StereoRequest):
        takes = f"{arcs[0].duration_s:.1f} s that each look takes"
        less += f", ask for a smaller {'look_angle_deg' if request.gap_s is None else 'gap_s'}"
    elif layout.scans == 1:
        takes = f"{least} it takes to scan"
    return Unreachable(
        f"{request.name!r} is never wholly within {spacecraft.along_max_deg:g} deg along and "
        f"{spacecraft.across_max_deg:g} deg across the track, in its window and session, for the "
        f"{takes}: {where}; move or widen the window, {less} or use another pass",
        field=f"requests.{number}",
        limit="camera angles",
        at_utc=at_utc,
    )
