"""Every possibility to image a request: its scans on a grid of start times.

Those that leave the camera's angles along and across the track are dropped; a request with none
left is refused with when it would come closest.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from planner.base import effort
from planner.base.arrays import Array, Mask
from planner.base.commands import COMMAND_STEP_S
from planner.base.errors import InfeasibleSlew, Unreachable
from planner.base.mrp import BodyMotion
from planner.motion.attitude.track import agility_limits
from planner.spacecraft.imaging.session import GroundArc, ImagingSession
from planner.spacecraft.requests import Request, StereoRequest
from planner.world.frames.time_scales import elapsed_s, shifted_utc, utc_text
from planner.world.targets.ground_path import GroundPathTarget
from planner.world.targets.imaging import AreaMode, CorridorMode, StereoMode


@dataclass(frozen=True, kw_only=True)
class CandidateOptions:
    """From which moments on what is asked for is tried."""

    # Between starts: at 2 s five dense sessions were worth 1 to 4 % less, at 0.4 s one of them 2 %
    # more for three times the work.
    grid_s: float = 1.0
    coarse_grid_s: float = 2.0
    # requests squared by the session's time, from which a fine grid has more paths than labels: a
    # hundred strips in 1,200 s were worth 0.5 % less at 1 s, for twice the work
    dense_per_s: float = 2.5
    told_at: int = 9  # instants of a scan that is refused,
    told_of: int = 3  # and at most so many of those
    told: float = 250.0  # of `effort`: to look what one of them lacks
    stereo_steps: int = 5  # starts tried before and after that of the exact angle,
    stereo_step_ticks: int = 2  # so far apart
    passing_rad: float = math.radians(3.0)  # along the track: abeam
    rounding_s: float = 1e-6  # a window may be given to the microsecond
    arc_at_start: float = 2.0  # of `effort`: to look at an arc scanned from one start,
    point_at_tick: float = 0.25  # and at one point of it
    held: float = 10.0  # of `effort`: to look whether the body can follow an arc from one start


OPTIONS = CandidateOptions()


class ScanStarts(NamedTuple):
    """From when on a scan may be imaged with all of it within the camera's angles, (n,), ascending.

    arc: its time is open.  entry_states, exit_states: as of `Slews`, (n, 11) each.  off_rad: by so
    much its largest angle along the track is off what would be best.
    """

    arc: GroundArc
    starts_s: Array
    entry_states: Array
    exit_states: Array
    off_rad: Array

    @property
    def stops_s(self) -> Array:
        """Of its scans."""
        return self.starts_s + self.arc.scan_s

    @property
    def look(self) -> tuple[int, int]:
        """Its request's number, and its own."""
        return self.arc.request, self.arc.look

    def only(self, kept: Mask) -> "ScanStarts":
        """Some of them."""
        return ScanStarts(self.arc, *(part[kept] for part in self[1:]))

    def begun(self, k: int) -> GroundArc:
        """The scan from the k-th of them on."""
        return replace(self.arc, start_s=float(self.starts_s[k]))


def grid_s(session: ImagingSession) -> float:
    """Between the starts tried."""
    is_dense = len(session.request.requests) ** 2 > OPTIONS.dense_per_s * session.duration_s
    return OPTIONS.coarse_grid_s if is_dense else OPTIONS.grid_s


def candidates(request: Request, number: int, session: ImagingSession) -> list[ScanStarts]:
    """Every scan of the number-th request, in each sense that it may have.

    Raises Unreachable when it is never seen, InfeasibleSlew when no scan of it keeps the limits.
    """
    try:
        orders = scan_orders(request, session)
        looks_s = _looks(request, orders, session)
    except ValueError as error:
        detail = f"{request.name!r}: {str(error).removeprefix('target.')}"
        raise Unreachable(detail, field=f"requests.{number}", limit="time") from None
    senses = list(zip(*orders, strict=True)) * (len(looks_s) // len(orders[0]))
    looks = [
        [
            one
            for arc in arcs
            for one in _from_starts(
                replace(arc, request=number, look=look), starts_s, request, session
            )
        ]
        for look, (arcs, starts_s) in enumerate(zip(senses, looks_s, strict=True))
    ]
    if not all(looks):  # half a pair is no image
        raise _never_seen(request, number, orders[0], session)
    for look in looks:
        if not any(held.any() for _, held in look):
            refused = [one.begun(k) for one, _ in look for k in range(len(one.starts_s))]
            raise _too_fast(refused, number, session)
    return [one.only(held) for look in looks for one, held in look if held.any()]


def scan_orders(request: Request, session: ImagingSession) -> list[list[GroundArc]]:
    """The request's arcs in each order and sense they may be scanned, times open (start_s = 0).

    As its mode lays them; by a reversible detector each the other way, too.
    Raises ValueError where there are more than the session has time for.
    """
    mode, window = request.as_mode(), session.window
    if isinstance(mode, AreaMode):
        mode = replace(mode, swath_m=session.spacecraft.swath_m, overlap=0.0)
    if isinstance(mode, StereoMode):  # whose looks are tried at more times than the mode's
        [(first, last)] = mode.lines
        paths = [mode.path_between(*mode.in_sense((first, last), window.passing))]
    else:
        paths = [scan.target for scan in mode.scans(window)]
    orders = [paths]
    if window.scanning.both_ways and not isinstance(mode, CorridorMode | StereoMode):
        orders.append([replace(path, points=path.points[::-1]) for path in paths])

    def arc(path: GroundPathTarget) -> GroundArc:
        first, last = ((point.longitude_deg, point.latitude_deg) for point in path.points)
        is_ahead = len(orders) == 1 or mode.in_sense((first, last), window.passing)[0] == first
        return GroundArc(path=path, backwards=not is_ahead)

    return [[arc(path) for path in order] for order in orders]


def _looks(
    request: Request, orders: list[list[GroundArc]], session: ImagingSession
) -> Sequence[Array]:
    """Starts tried of every look.

    Of a stereo pair where the strip's middle is look_angle_deg ahead (or from `start` on), and the
    same behind; or gap_s apart.
    """
    asked_s = None
    if request.start is not None:
        asked_s = _on_ticks(np.array([elapsed_s(request.start, session.epoch_utc)]))
    if not isinstance(request, StereoRequest):
        # A window as short as the scan is met too.
        opening_s = elapsed_s(request.window_start or session.epoch_utc, session.epoch_utc)
        opening_s = math.ceil(opening_s / COMMAND_STEP_S - 1e-6) * COMMAND_STEP_S
        starts_s = np.union1d(np.arange(0.0, session.duration_s, grid_s(session)), [opening_s])
        if asked_s is None:
            return [starts_s] * len(orders[0])
        return [asked_s, *[starts_s[starts_s > asked_s]] * (len(orders[0]) - 1)]
    [[arc]], mode = orders, request.as_mode()
    assert isinstance(mode, StereoMode)
    effort.charge(OPTIONS.point_at_tick * session.duration_s / COMMAND_STEP_S)
    if mode.gap_s is not None:
        passing_s = elapsed_s(mode.in_pass(session.window).start_utc, session.epoch_utc)
        first_s = np.array([passing_s]) if asked_s is None else asked_s
        return first_s, first_s + _on_ticks(mode.gap_s)
    steps = np.arange(-OPTIONS.stereo_steps, OPTIONS.stereo_steps + 1.0)
    shares = mode.looks if asked_s is None else mode.looks[1:]
    *early_s, second_s = (
        _on_ticks(start_s) + steps * COMMAND_STEP_S * OPTIONS.stereo_step_ticks
        for start_s, _ in mode.look_starts_s(arc.path, session.window, shares)
    )
    return early_s[0] if asked_s is None else asked_s, second_s


def _on_ticks(t_s: ArrayLike) -> Array:
    return np.asarray(np.round(np.divide(t_s, COMMAND_STEP_S)) * COMMAND_STEP_S)


def _from_starts(
    arc: GroundArc, starts_s: Array, request: Request, session: ImagingSession
) -> Iterator[tuple[ScanStarts, Mask]]:
    """From every start from which it is within the camera's angles, if any, and whether the body
    can then follow it within its limits."""
    window = session.window
    first_s = elapsed_s(request.window_start or window.start_utc, window.start_utc)
    first_s = max(first_s - OPTIONS.rounding_s, session.slews.settle_s)
    last_s = elapsed_s(request.window_stop or window.stop_utc, window.start_utc)
    last_s = min(last_s + OPTIONS.rounding_s, session.duration_s)
    effort.charge(OPTIONS.arc_at_start * len(starts_s))
    t_s = starts_s[(starts_s >= first_s) & (starts_s + arc.scan_s <= last_s)]
    in_reach, tilt_rad = _in_reach(arc, t_s, session)
    t_s, off_rad = t_s[in_reach], tilt_rad[in_reach]
    effort.charge(OPTIONS.held * len(t_s))
    if len(t_s):
        if isinstance(request, StereoRequest):  # the angle asked for is in their middle
            off_rad = np.abs(off_rad - np.median(off_rad))
        entries, exits = session.entries(arc, t_s), session.ends(arc, t_s, arc.scan_s)
        yield ScanStarts(arc, t_s, entries, exits, off_rad), session.holds(arc, t_s)


def _in_reach(arc: GroundArc, t_s: Array, session: ImagingSession) -> tuple[Mask, Array]:
    """Whether the camera can look at all of the arc, and the largest angle along the track."""
    spacecraft = session.spacecraft
    most_rad = np.deg2rad([spacecraft.along_max_deg, spacecraft.across_max_deg])[:, None]
    in_reach, tilt_rad = np.ones(len(t_s), dtype=bool), np.zeros(len(t_s))
    for share in (0.0, 0.5, 1.0):
        [r_point_itrf_m] = arc.point_itrf(np.array([share]))[0]
        seen = session.window.passing.look_angles(r_point_itrf_m, t_s + share * arc.scan_s)
        in_reach &= np.all(np.abs(seen) <= most_rad, axis=0)
        tilt_rad = np.maximum(tilt_rad, np.abs(seen[0]))
    return in_reach, tilt_rad


def _too_fast(refused: list[GroundArc], number: int, session: ImagingSession) -> InfeasibleSlew:
    """By the limit that the scan lacks most of which lacks least."""
    gyros, name = session.platform.gyros, session.request.requests[number].name
    assert gyros is not None  # as of every body of this front
    turns, tried = gyros.turns, refused[:: math.ceil(len(refused) / OPTIONS.told_of)]
    shares = min((_used_shares(one, session) for one in tried), key=np.max)
    rate_n_m_s = turns.torque_rate_max_n_m_s
    limit, than = (
        ("rate", f"faster than the {turns.rate_max_deg_s:.4g} deg/s about an axis"),
        ("torque", f"with more than the {turns.torque_max_n_m:g} N m"),
        ("torque rate", f"with a torque that changes by more than {rate_n_m_s:g} N m/s"),
    )[int(np.argmax(shares))]
    first = "unload momentum first, " if any(gyros.start_n_m_s) else ""
    return InfeasibleSlew(
        f"to scan {name!r} the body would have to turn {than} there are; {first}ask for "
        "another scan_speed_m_s or use another pass",
        field=f"requests.{number}",
        limit=limit,
    )


def _used_shares(arc: GroundArc, session: ImagingSession) -> Array:
    """The largest of rate, torque and torque rate along a scan, of those there are, (3,)."""
    effort.charge(OPTIONS.told)
    after_s = np.linspace(-session.slews.settle_s, arc.duration_s, OPTIONS.told_at)
    states = session.ends(arc, np.full(OPTIONS.told_at, arc.start_s), after_s)
    omega, alpha = states[:, 4:7], states[:, 7:10]
    body = BodyMotion(omega, alpha, np.gradient(alpha, after_s, axis=0))
    return np.asarray(agility_limits(session.platform).inscribed.shares(body).max(axis=0))


def require_together(
    options: list[ScanStarts],
    session: ImagingSession,
    fit: Callable[[list[ScanStarts]], bool],
) -> None:
    """Refuse a request whose looks, each of which can be imaged, can't all be.

    fit: whether some times of theirs have the slews between.
    """
    settle_s, number = session.slews.settle_s, options[0].arc.request
    looks_s = {one.look: settle_s + one.arc.scan_s for one in options}
    first_s = min(one.starts_s[0] for one in options) - settle_s
    last_s = max(one.stops_s[-1] for one in options)
    if len(looks_s) > 1 and (sum(looks_s.values()) > last_s - first_s or not fit(options)):
        request = session.request.requests[number]
        raise _never_seen(request, number, scan_orders(request, session)[0], session)


def _never_seen(
    request: Request, number: int, arcs: list[GroundArc], session: ImagingSession
) -> Unreachable:
    """Say when it would come closest, and at what angles."""
    spacecraft = session.spacecraft
    ends_itrf_m = np.concatenate([arc.point_itrf(np.array([0.0, 1.0]))[0] for arc in arcs])
    grid_s = np.arange(0.0, session.duration_s, 1.0)
    along_rad, across_rad = session.window.passing.look_angles(ends_itrf_m.mean(axis=0), grid_s)
    abeam = int(np.argmin(np.abs(along_rad)))
    at_utc = shifted_utc(session.epoch_utc, float(grid_s[abeam]))
    where = "the track doesn't pass it"
    if abs(along_rad[abeam]) < OPTIONS.passing_rad:
        where = (
            f"closest at {utc_text(at_utc, 1)}, {math.degrees(along_rad[abeam]):.1f} deg along and "
            f"{math.degrees(across_rad[abeam]):.1f} deg across the track"
        )
    takes, less = "it takes to scan", "shorten the request"
    if isinstance(request, StereoRequest):
        takes = "that each look takes"
        less += f", ask for a smaller {'look_angle_deg' if request.gap_s is None else 'gap_s'}"
    elif len(arcs) > 1:
        takes = f"that {len(arcs)} scans take, and the slews between"
    return Unreachable(
        f"{request.name!r} is never wholly within {spacecraft.along_max_deg:g} deg along and "
        f"{spacecraft.across_max_deg:g} deg across the track, in its window and session, for the "
        f"{sum(arc.duration_s for arc in arcs):.1f} s {takes}: {where}; move or widen the window, "
        f"{less} or use another pass",
        field=f"requests.{number}",
        limit="camera angles",
        at_utc=at_utc,
    )
