"""The answer to a search for windows: degrees, UTC text, plain numbers."""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from datetime import datetime
from typing import Annotated, Any, NamedTuple

import numpy as np
from pydantic import Field

from app.answers.members import BUILT_ON_FIRST_USE, ProvenanceOut, to_json
from app.answers.ranges import (
    Count,
    ElevationDeg,
    ElevationOrLimbDeg,
    HalfTurnDeg,
    NotNegative,
    Share,
    Signed,
)
from app.answers.target_sky import PlaceOut, TargetSkyOut, places_out, skies_out
from planner.base.arrays import Array
from planner.base.assumed import Assumed
from planner.planning.opportunities import Opportunities, Sightings
from planner.planning.opportunities.closing import Unseen
from planner.world.frames.time_scales import Instants, utc_text

DECIMALS = 6  # 1e-6 deg is 4 milliarcsec, 1e-6 km a millimetre

Branch = Annotated[int, Field(ge=0, le=1)]
Column = list[Any]


class _Sighting:
    """How a target is seen; null where a number has no meaning or no end.

    at: time of this view; UTC.
    elevation_deg: of the carrier in the target's sky; of a target in space its height above the
    raised limb.
    range_km: distance; null for a star.
    off_nadir_deg: of the line of sight from the geocentric nadir.
    ground_sample_across_m: width of a pixel on the ground, across the lean of the line of sight;
    null for a target in space.
    ground_sample_along_m: length of a pixel on the ground, along the lean of the line of sight;
    null for a target in space, and where a pixel reaches the horizon (below some 0.1 deg).
    sun_elevation_deg: in the target's sky, null for a target in space.
    sun_separation_deg: of the line of sight from the Sun's centre.
    moon_separation_deg: of the line of sight from the Moon's centre.
    angles_deg: of the axes, by name.
    rates_deg_s: of the axes, by name.
    """


@dataclass(frozen=True, kw_only=True)
class SightingOut(_Sighting):
    """A target seen at an instant; null where a number has no meaning or no end."""

    at: str
    elevation_deg: ElevationOrLimbDeg
    range_km: NotNegative | None
    off_nadir_deg: HalfTurnDeg
    ground_sample_across_m: NotNegative | None
    ground_sample_along_m: NotNegative | None
    sun_elevation_deg: ElevationDeg | None
    sun_separation_deg: HalfTurnDeg
    moon_separation_deg: HalfTurnDeg
    angles_deg: dict[str, Signed | None]
    rates_deg_s: dict[str, Signed | None]


@dataclass(frozen=True, kw_only=True)
class SightingsOut(_Sighting):
    """The members of a sighting as arrays, at instants spread evenly from rise to set."""

    at: list[str]
    elevation_deg: list[ElevationOrLimbDeg]
    range_km: list[NotNegative | None]
    off_nadir_deg: list[HalfTurnDeg]
    ground_sample_across_m: list[NotNegative | None]
    ground_sample_along_m: list[NotNegative | None]
    sun_elevation_deg: list[ElevationDeg | None]
    sun_separation_deg: list[HalfTurnDeg]
    moon_separation_deg: list[HalfTurnDeg]
    angles_deg: dict[str, list[Signed | None]]
    rates_deg_s: dict[str, list[Signed | None]]


@dataclass(frozen=True, kw_only=True)
class SessionTimesOut:
    """Times that a plan's session takes as they stand.

    start: first row; UTC.
    stop: last row; UTC.
    """

    start: str
    stop: str


@dataclass(frozen=True, kw_only=True)
class PassWindow:
    """One stretch in which all conditions hold for a target.

    target: id of the target, as the request gives it.
    rise: start of the window; UTC.
    set: end of the window; UTC.
    duration_s: from rise to set.
    session: the longest, up to six hours, over which the axes can follow by one pair of angles, on
    the rows of a command table; null where there is none.
    opened_by: the condition that is met from `rise` on; "interval" is the request's own start.
    closed_by: the condition that is met until `set`; "interval" is the request's own stop.
    highest_at: time of the greatest elevation; UTC.
    highest_deg: greatest elevation.
    closest: the view at the least range; of a target in space, at its greatest height above the
    limb.
    through: the view at instants spread evenly from rise to set.
    place: place of the target as the carrier culminates; null for a target in space.
    sky: the pass as pass tables have it: rise, culmination and set with azimuth and elevation, Sun
    and local solar time; null for a target in space.
    """

    target: str
    rise: str
    set: str
    duration_s: NotNegative
    session: SessionTimesOut | None
    opened_by: str
    closed_by: str
    highest_at: str
    highest_deg: ElevationOrLimbDeg
    closest: SightingOut
    through: SightingsOut
    place: PlaceOut | None
    sky: TargetSkyOut | None


@dataclass(frozen=True, kw_only=True)
class WindowOut(PassWindow):
    """One stretch in which all conditions hold for a target.

    branch: the pair of axis angles that is given, 0 or 1, of the two that point at the target: the
    one with less turn of the inner axis.
    branches: the pairs that keep within the stops through the window (none where the axes would
    have to change over).
    probability_in_frame: that the target stays inside the camera's frame over the whole session, as
    a plan of it says; null where there is no session, for the windows of a plan's view, and for the
    latest windows where there are more than 500. E.g. `0.68`.
    """

    branch: Branch
    branches: list[Branch]
    probability_in_frame: Share | None


@dataclass(frozen=True, kw_only=True)
class OpportunitiesHead:
    """What is known of a search beside its windows.

    name: as the request gives it. E.g. `"cities in daylight"`.
    start: of the time searched; UTC.
    stop: of the time searched; UTC.
    unseen: targets without any window, and why.
    assumed: places of the targets that the request gives by name only.
    warnings: cautions to read before relying on it. E.g.
    `["the elements' epoch 2015-02-27T11:40:53Z is 9.0 days from the farthest instant asked for"]`.
    """

    __pydantic_config__ = BUILT_ON_FIRST_USE

    name: str
    start: str
    stop: str
    unseen: Sequence[Unseen | str]
    assumed: list[Assumed]
    warnings: list[str]
    provenance: ProvenanceOut


@dataclass(frozen=True, kw_only=True)
class OpportunitiesResponse(OpportunitiesHead):
    """Windows in the order of the request's targets, each target's in order of time.

    id: of what was found, as its address names it.
    windows: all there are.
    """

    id: str
    windows: list[WindowOut]
    unseen: list[Unseen]


@dataclass(frozen=True, kw_only=True)
class WindowsPage:
    """Some of the windows found.

    windows: those of this page.
    next: `cursor` of what comes after; null at the end. E.g. `100`.
    """

    __pydantic_config__ = BUILT_ON_FIRST_USE

    windows: list[WindowOut]
    next: Count | None


class FoundWindows(NamedTuple):
    """An answer in parts. head: an `OpportunitiesHead`; windows: one JSON object each."""

    head: bytes
    windows: list[bytes]


def found_windows(
    result: Opportunities,
    name: str,
    provenance: ProvenanceOut,
    windows: Sequence[PassWindow],
    unseen: Sequence[Unseen | str],
) -> FoundWindows:
    """The answer without its id."""
    head = OpportunitiesHead(
        name=name,
        start=utc_text(result.start_utc),
        stop=utc_text(result.stop_utc),
        unseen=unseen,
        assumed=list(result.assumed),
        warnings=list(result.warnings),
        provenance=provenance,
    )
    return FoundWindows(to_json(head), [to_json(window) for window in windows])


def whole_opportunities(search_id: str, found: FoundWindows) -> bytes:
    """An OpportunitiesResponse as UTF-8 JSON."""
    windows = b",".join(found.windows)
    return b"".join(
        [b'{"id":', to_json(search_id), b",", found.head[1:-1], b',"windows":[', windows, b"]}"]
    )


def windows_out(result: Opportunities, probability: Array | float = np.nan) -> list[WindowOut]:
    """All windows, in order; probability: in frame over the session of each, NaN where unknown."""
    columns = pass_columns(result) | {
        "probability_in_frame": _numbers(np.broadcast_to(probability, len(result.windows))),
        "branch": result.windows.branch.tolist(),
        "branches": [np.flatnonzero(usable).tolist() for usable in result.windows.branches],
    }
    return [WindowOut(**row) for row in rows_of(columns)]


def pass_columns(result: Opportunities) -> dict[str, Column]:
    """By the names of a `PassWindow`."""
    windows = result.windows
    return {
        "target": [result.ids[row] for row in windows.target],
        "rise": times_of(result.start_utc, windows.rise_s),
        "set": times_of(result.start_utc, windows.set_s),
        "duration_s": _numbers(windows.set_s - windows.rise_s),
        "session": _sessions(result),
        "opened_by": windows.opened_by.tolist(),
        "closed_by": windows.closed_by.tolist(),
        "highest_at": times_of(result.start_utc, windows.highest_s),
        "highest_deg": _numbers(np.degrees(windows.highest_rad)),
        "closest": _sightings(SightingOut, result, windows.closest),
        "through": _sightings(SightingsOut, result, windows.through),
        "place": places_out(windows.sky),
        "sky": skies_out(result.start_utc, windows.sky),
    }


def _sessions(result: Opportunities) -> Column:
    times_s = result.windows.sessions_s(result.start_utc)
    fits = ~np.isnan(times_s[:, 0])
    starts, stops = (times_of(result.start_utc, column[fits]) for column in times_s.T)
    sessions: Column = [None] * len(fits)
    for window, start, stop in zip(np.flatnonzero(fits), starts, stops, strict=True):
        sessions[window] = SessionTimesOut(start=start, stop=stop)
    return sessions


def _sightings(
    kind: type[SightingOut] | type[SightingsOut], result: Opportunities, seen: Sightings
) -> Column:
    columns: dict[str, Column] = {
        "at": times_of(result.start_utc, seen.t_s),
        "range_km": _numbers(seen.range_m / 1e3),
        "ground_sample_across_m": _numbers(seen.ground_sample_across_m),
        "ground_sample_along_m": _numbers(seen.ground_sample_along_m),
        "angles_deg": _by_axis(result.axis_names, seen.angle_rad),
        "rates_deg_s": _by_axis(result.axis_names, seen.rate_rad_s),
    }
    for field in fields(kind):
        if field.name not in columns:
            radians = getattr(seen, field.name.replace("_deg", "_rad"))
            columns[field.name] = _numbers(np.degrees(radians))
    return [kind(**row) for row in rows_of(columns)]


def _by_axis(axis_names: tuple[str, str], motion_rad: Array) -> Column:
    """motion_rad: shape (..., 2), rad or rad/s."""
    return rows_of(
        {name: _numbers(np.degrees(motion_rad[..., axis])) for axis, name in enumerate(axis_names)}
    )


def rows_of(columns: dict[str, Column]) -> list[dict[str, Any]]:
    return [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]


def times_of(start_utc: datetime, t_s: Array) -> Column:
    texts = np.array(Instants(start_utc, t_s.ravel()).utc_text(3), dtype=object)
    column: Column = texts.reshape(t_s.shape).tolist()
    return column


def _numbers(numbers: Array) -> Column:
    rounded = np.round(numbers, DECIMALS) + 0.0  # no -0.0
    known = np.isfinite(rounded)
    cells = rounded if known.all() else rounded.astype(object)
    cells[~known] = None
    column: Column = cells.tolist()
    return column
