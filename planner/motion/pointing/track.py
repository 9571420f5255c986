"""The motion of the axes that keeps the boresight on a target, and whether they can."""

import itertools
import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from planner.base.arrays import Array, Mask
from planner.base.errors import Refusal, TrackBreaksLimit, Unreachable, figures
from planner.motion.pointing.angles import axis_angles, axis_motion, singular_margin_rad
from planner.motion.pointing.hermite import (
    HermiteRange,
    beyond_limits,
    cubic_and_row_range,
    quintic_motion,
)
from planner.motion.pointing.line_of_sight import LineOfSight
from planner.world.frames.time_scales import utc_text
from planner.world.platforms import AxisLimits, TwoAxisPlatform

TURN_RAD = 2.0 * math.pi
SINGULAR_RAD = 1e-6  # nearer to the plane of the axes the angles lose the 0.1 arcsec
LIMIT_TOLERANCE = 1e-9  # of the limit: rounding of degrees to radians
LIMITS = ("angle", "rate", "acceleration", "jerk")


@dataclass(frozen=True, kw_only=True)
class AxisTrack:
    """Axis motion along a target, continuous: angles are never wrapped.

    t_s: (n,), rows on the clock of the line of sight: the session, and the time around it
    over which the target can be followed within the limits too.
    axis_states: angle, rate and acceleration (rad, s), (3, n, 2).  los: what is followed; None
    where the motion itself is asked for.
    """

    axis_names: tuple[str, str]
    t_s: Array
    axis_states: Array
    los: LineOfSight | None = None

    def motion(self, t_s: Array) -> tuple[Array, Array, Array]:
        """Angle, rate, acceleration, each (k, 2), at t_s (k,) within the rows."""
        return quintic_motion(t_s, self.t_s, *self.axis_states)


class _Break(NamedTuple):
    """The first limit a track breaks in its session, row counted in the line of sight."""

    axis: str
    limit: str
    row: int
    value: float
    bound: float


def track_candidates(
    platform: TwoAxisPlatform,
    los: LineOfSight,
    session_start_s: float,
    session_stop_s: float,
    start_angle_rad: Array,
) -> tuple[AxisTrack, ...]:
    """Every way to follow the target within stops and limits, the preferred one first.

    los: rows that cover the session and may reach before and after it; uniform step.
    session_*_s: on the clock of los.instants.  start_angle_rad: (2,), where the axes are
    before the slew.  A way is a branch of `axis_angles` and a number of whole turns per
    axis, one choice for the whole session.  Preferred is the shortest slew (largest
    distance over rate limit of the axes), then the smaller inner angle (Sumarokov 2016,
    p. 88).  Limits are tested on the flown cubic Hermite, so between rows too; the acceleration
    also as it is on rows, where a slew may have to begin or end with it.
    Raises Unreachable (no angles, or none within the stops) and TrackBreaksLimit (rate,
    acceleration or jerk) when there is no way.
    """
    t_s = los.instants.t_s
    first, last = _session_rows(t_s, session_start_s, session_stop_s)
    angles, reachable = axis_angles(platform, los.los_base)
    if not reachable[first:last].all():
        raise _refuse_unreachable(platform, los, reachable[first:last], first)

    branches: list[_Branch] = []
    for branch_rad in angles:
        margin = singular_margin_rad(platform, branch_rad, los.los_base)
        usable = reachable & (margin > SINGULAR_RAD)  # NaN margins where unreachable
        if not usable[first:last].all():
            raise _refuse_singular(platform, los, int(first + np.argmin(margin[first:last])))
        here = _run_with(usable, first, last)
        session = slice(first - here.start, last - here.start)
        branches.append(_Branch(here, session, np.unwrap(branch_rad[here], axis=0)))
    # What passes a stop is followed on only to say what else is wrong with it.
    within = [branch.is_within_stops(platform.axis_limits) for branch in branches]
    ways, breaks = _tracks_in_limits(platform, los, itertools.compress(branches, within))
    if not ways and not all(within):
        ways, breaks = _tracks_in_limits(platform, los, branches)
    if not ways:
        raise _best_refusal(los, breaks)
    return tuple(
        sorted(ways, key=lambda way: _way_cost(way, platform, session_start_s, start_angle_rad))
    )


def held_cells(platform: TwoAxisPlatform, los: LineOfSight) -> Iterator[tuple[Array, Mask]]:
    """Every way to point at the target: its angles (n, 2), and between which rows it is held.

    Cells (n - 1,) over which the motion keeps stops and limits.
    """
    step_s = float(los.instants.t_s[1] - los.instants.t_s[0])
    angles, reachable = axis_angles(platform, los.los_base)
    for branch_rad in angles:
        margin = singular_margin_rad(platform, branch_rad, los.los_base)
        usable = reachable & (margin > SINGULAR_RAD)
        unwrapped = np.unwrap(np.where(usable[:, None], branch_rad, 0.0), axis=0)
        rate, acceleration = axis_motion(
            platform,
            unwrapped,
            los.los_base,
            los.los_rate_base_per_s,
            los.los_acceleration_base_per_s2,
        )
        for angle_rad in _turns_to_stops(unwrapped, platform.axis_limits):
            ranges = cubic_and_row_range(step_s, angle_rad, rate, acceleration)
            beyond = beyond_limits(ranges, platform.axis_limits, LIMIT_TOLERANCE)
            yield angle_rad, usable[1:] & usable[:-1] & ~beyond.any(axis=(0, 2))


class _Branch(NamedTuple):
    """One of the ways of `axis_angles`, over the rows `here` of the line of sight.

    session: of those.  angle_rad: (n, 2), unwrapped.
    """

    here: slice
    session: slice
    angle_rad: Array

    def is_within_stops(self, limits: tuple[AxisLimits, ...]) -> bool:
        """Whether some number of whole turns keeps the session's rows within the stops."""
        return all(turns_within_stops(self.angle_rad[self.session], limits, LIMIT_TOLERANCE))


def _tracks_in_limits(
    platform: TwoAxisPlatform, los: LineOfSight, branches: Iterable[_Branch]
) -> tuple[list[AxisTrack], list[_Break]]:
    """The tracks that keep all limits, and what the others break."""
    t_s = los.instants.t_s
    ways: list[AxisTrack] = []
    breaks: list[_Break] = []
    for here, session, unwrapped in branches:
        rate, acceleration = axis_motion(
            platform,
            unwrapped,
            los.los_base[here],
            los.los_rate_base_per_s[here],
            los.los_acceleration_base_per_s2[here],
        )
        for angle_rad in _whole_turns(unwrapped, session, platform.axis_limits):
            axis_states = np.stack([angle_rad, rate, acceleration])
            ranges = cubic_and_row_range(float(t_s[1] - t_s[0]), *axis_states)
            beyond = beyond_limits(ranges, platform.axis_limits, LIMIT_TOLERANCE)
            session_break = _first_break(platform, ranges, beyond, session)
            if session_break is not None:
                breaks.append(session_break._replace(row=here.start + session_break.row))
                continue
            cells = _run_with(np.asarray(~beyond.any(axis=(0, 2))), session.start, session.stop - 1)
            rows = slice(cells.start, cells.stop + 1)
            ways.append(
                AxisTrack(
                    axis_names=platform.axis_names,
                    t_s=t_s[here][rows],
                    axis_states=axis_states[:, rows],
                    los=los,
                )
            )
    return ways, breaks


def _session_rows(t_s: Array, start_s: float, stop_s: float) -> tuple[int, int]:
    """Slice of the rows that enclose the session; a bug, not a refusal, if they don't."""
    first = int(np.searchsorted(t_s, start_s + 1e-9, side="right")) - 1
    last = int(np.searchsorted(t_s, stop_s - 1e-9, side="left")) + 1
    if first < 0 or last > len(t_s):
        raise IndexError(f"line of sight {t_s[0]}..{t_s[-1]} s, session {start_s}..{stop_s} s")
    return first, max(last, first + 2)


def _run_with(usable: Mask, first: int, last: int) -> slice:
    """The run of usable rows (or cells) that contains first..last-1."""
    lost_before = np.flatnonzero(~usable[:first])
    lost_after = np.flatnonzero(~usable[last:])
    start = int(lost_before[-1]) + 1 if lost_before.size else 0
    stop = last + int(lost_after[0]) if lost_after.size else len(usable)
    return slice(start, stop)


def _whole_turns(
    angle_rad: Array, session: slice, limits: tuple[AxisLimits, ...]
) -> Iterator[Array]:
    """The motion with each number of whole turns that fits the stops, else the nearest one."""
    choices = []
    low_rad, high_rad = angle_rad[session].min(axis=0), angle_rad[session].max(axis=0)
    fitting = turns_within_stops(angle_rad[session], limits, LIMIT_TOLERANCE)
    for fits, low, high, limit in zip(fitting, low_rad, high_rad, limits, strict=True):
        middle = (limit.angle_min_rad + limit.angle_max_rad) / 2.0
        nearest = round((middle - (low + high) / 2.0) / TURN_RAD)
        choices.append(fits or (nearest,))
    for turns in itertools.product(*choices):
        yield angle_rad + TURN_RAD * np.array(turns)


def _turns_to_stops(angle_rad: Array, limits: tuple[AxisLimits, ...]) -> Iterator[Array]:
    """The motion with each number of whole turns that brings any of it within the stops."""
    choices = [
        range(
            math.ceil((limit.angle_min_rad - angle.max()) / TURN_RAD),
            math.floor((limit.angle_max_rad - angle.min()) / TURN_RAD) + 1,
        )
        for angle, limit in zip(angle_rad.T, limits, strict=True)
    ]
    for turns in itertools.product(*choices):
        yield angle_rad + TURN_RAD * np.array(turns)


def turns_within_stops(
    angle_rad: Array, limits: tuple[AxisLimits, ...], tolerance_share: float
) -> list[range]:
    """Whole turns, axis by axis, by which angles (n, m) may be moved and keep the stops.

    tolerance_share: of a turn, by which they may pass a stop.
    """
    choices = []
    for angle, limit in zip(angle_rad.T, limits, strict=True):
        least = math.ceil((limit.angle_min_rad - angle.min()) / TURN_RAD - tolerance_share)
        most = math.floor((limit.angle_max_rad - angle.max()) / TURN_RAD + tolerance_share)
        choices.append(range(least, most + 1))
    return choices


def _first_break(
    platform: TwoAxisPlatform, ranges: HermiteRange, beyond: Mask, session: slice
) -> _Break | None:
    """The break of the angle, else of the rate, ..., in the session; beyond: as `beyond_limits`."""
    broken = np.argwhere(beyond[:, session.start : session.stop - 1])
    if not broken.size:
        return None
    order, cell, axis = broken[0].tolist()
    row = session.start + cell
    least, greatest = ranges[order][:, row, axis].tolist()
    low, high = platform.axis_limits[axis].bounds[order]
    is_under = least < low - LIMIT_TOLERANCE * (high - low)
    value, bound = (least, low) if is_under else (greatest, high)
    return _Break(platform.axis_names[axis], LIMITS[order], row, value, bound)


def _way_cost(
    way: AxisTrack, platform: TwoAxisPlatform, session_start_s: float, start_angle_rad: Array
) -> tuple[float, float]:
    angle = way.motion(np.array([session_start_s]))[0][0]
    rate_max = np.array([limits.rate_max_rad_s for limits in platform.axis_limits])
    effort_s = float(np.max(np.abs(angle - start_angle_rad) / rate_max))
    return round(effort_s, 6), float(abs(angle[1]))


def _refuse_unreachable(
    platform: TwoAxisPlatform, los: LineOfSight, reachable: Mask, first: int
) -> Unreachable:
    lost = np.flatnonzero(~reachable)
    start, stop = (los.instants.utc(first + int(lost[end])) for end in (0, -1))
    share = len(lost) / len(reachable)
    percent = "less than 1%" if share < 0.01 else f"{share:.0%}"
    return Unreachable(
        f"no pair of axis angles of {platform.name} points at the target for {percent} of "
        f"the session, between {utc_text(start)} and {utc_text(stop)}; choose other times, or turn "
        "the carrier so that the target leaves the dead cone of the axes",
        at_utc=start,
    )


def _refuse_singular(platform: TwoAxisPlatform, los: LineOfSight, row: int) -> Unreachable:
    at_utc = los.instants.utc(row)
    return Unreachable(
        f"at {utc_text(at_utc)} the line of sight lies in the plane of the axes of "
        f"{platform.name}, a singular direction: the {platform.outer_name} angle is not "
        "determined there; choose another time or turn the carrier slightly",
        axis=platform.outer_name,
        at_utc=at_utc,
    )


def _best_refusal(los: LineOfSight, breaks: list[_Break]) -> Refusal:
    """The way that got nearest: a rate or acceleration that breaks lies within the stops."""
    order = {"angle": 0, "jerk": 1, "acceleration": 2, "rate": 3}
    worst = max(breaks, key=lambda found: (order[found.limit], found.row))
    at_utc = los.instants.utc(worst.row)
    value_deg, bound_deg = math.degrees(worst.value), math.degrees(worst.bound)
    value, bound = figures(value_deg, bound_deg), figures(bound_deg, value_deg)
    if worst.limit == "angle":
        return Unreachable(
            f"{worst.axis} would have to turn to {value} deg at "
            f"{utc_text(at_utc)}, beyond its stop at {bound} deg, and the "
            "other ways to point there pass a stop too; choose other times",
            axis=worst.axis,
            limit="angle",
            at_utc=at_utc,
        )
    unit = {"rate": "deg/s", "acceleration": "deg/s2", "jerk": "deg/s3"}[worst.limit]
    return TrackBreaksLimit(
        f"following the target needs {value.lstrip('-')} {unit} of {worst.axis} "
        f"at {utc_text(at_utc)}, more than the {bound.lstrip('-')} {unit} it has; "
        "choose a pass farther from the singular direction of the axes, a shorter session, or "
        '"keyhole": "nearest"',
        axis=worst.axis,
        limit=worst.limit,
        at_utc=at_utc,
    )
