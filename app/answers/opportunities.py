"""The answer to a request for opportunities: degrees, UTC text, plain numbers."""

from dataclasses import dataclass, fields
from datetime import datetime
from typing import Annotated, Any

import numpy as np
from pydantic import Field

from app.answers.members import ProvenanceOut, to_json
from app.answers.ranges import ElevationDeg, ElevationOrLimbDeg, HalfTurnDeg, NotNegative, Signed
from planner.arrays import Array
from planner.assumed import Assumed
from planner.frames.time_scales import Instants, utc_text
from planner.opportunities import Opportunities, Sightings

DECIMALS = 6  # 1e-6 deg is 4 milliarcsec, 1e-6 km a millimetre

Branch = Annotated[int, Field(ge=0, le=1)]
Column = list[Any]


class _Sighting:
    """How a target is seen; null where a number has no meaning or no end.

    at: when it is seen so; UTC.
    elevation_deg: of the carrier in the target's sky; of a target in space its height above the
    raised limb.
    range_km: distance; null for a star.
    off_nadir_deg: of the line of sight from the geocentric nadir.
    ground_sample_across_m: width of a pixel on the ground, across the lean of the line of sight;
    null for a target in space.
    ground_sample_along_m: length of a pixel on the ground, along the lean of the line of sight;
    null for a target in space.
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
class WindowOut:
    """One stretch in which all conditions hold for a target.

    target: id of the target, as the request gives it.
    rise: when it begins; UTC.
    set: when it ends; UTC.
    duration_s: from rise to set.
    session: the longest on the rows of a command table, null where the window is too short for one.
    opened_by: the condition that is met from `rise` on; "interval" is the request's own start.
    closed_by: the condition that is met until `set`; "interval" is the request's own stop.
    highest_at: when the elevation is greatest; UTC.
    highest_deg: greatest elevation.
    closest: the view at the least range; of a target in space, at its greatest height above the
    limb.
    through: the view at instants spread evenly from rise to set.
    branch: which of the two pairs of axis angles that point at the target is told, 0 or 1: the one
    with less turn of the inner axis.
    branches: which pairs keep within the stops through the window (none where the axes would have
    to change over).
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
    branch: Branch
    branches: list[Branch]


@dataclass(frozen=True, kw_only=True)
class OpportunitiesResponse:
    """Windows in the order of the request's targets, each target's in order of time.

    start: of the time searched; UTC.
    stop: of the time searched; UTC.
    windows: all there are.
    unseen: ids of the targets without any window. E.g. `["Reykjavik"]`.
    assumed: where the targets are that the request gives by name only.
    warnings: what one should know before relying on it. E.g.
    `["the elements' epoch 2015-02-27T11:40:53Z is 9.0 days from the plan"]`.
    """

    start: str
    stop: str
    windows: list[WindowOut]
    unseen: list[str]
    assumed: list[Assumed]
    warnings: list[str]
    provenance: ProvenanceOut


def opportunities_json(result: Opportunities, provenance: ProvenanceOut) -> bytes:
    """The whole answer as UTF-8 JSON."""
    return to_json(
        OpportunitiesResponse(
            start=utc_text(result.start_utc),
            stop=utc_text(result.stop_utc),
            windows=windows_out(result),
            unseen=[
                result.ids[row]
                for row in np.setdiff1d(np.arange(len(result.ids)), result.windows.target)
            ],
            assumed=list(result.assumed),
            warnings=list(result.warnings),
            provenance=provenance,
        )
    )


def windows_out(result: Opportunities) -> list[WindowOut]:
    """All windows, in order."""
    windows = result.windows
    columns: dict[str, Column] = {
        "target": [result.ids[row] for row in windows.target],
        "rise": _utc(result.start_utc, windows.rise_s),
        "set": _utc(result.start_utc, windows.set_s),
        "duration_s": _numbers(windows.set_s - windows.rise_s),
        "session": _sessions(result),
        "opened_by": windows.opened_by.tolist(),
        "closed_by": windows.closed_by.tolist(),
        "highest_at": _utc(result.start_utc, windows.highest_s),
        "highest_deg": _numbers(np.degrees(windows.highest_rad)),
        "closest": _sightings(SightingOut, result, windows.closest),
        "through": _sightings(SightingsOut, result, windows.through),
        "branch": windows.branch.tolist(),
        "branches": [np.flatnonzero(usable).tolist() for usable in windows.branches],
    }
    return [WindowOut(**row) for row in _rows(columns)]


def _sessions(result: Opportunities) -> Column:
    times_s = result.windows.sessions_s(result.start_utc)
    fits = ~np.isnan(times_s[:, 0])
    starts, stops = (_utc(result.start_utc, column[fits]) for column in times_s.T)
    sessions: Column = [None] * len(fits)
    for window, start, stop in zip(np.flatnonzero(fits), starts, stops, strict=True):
        sessions[window] = SessionTimesOut(start=start, stop=stop)
    return sessions


def _sightings(
    kind: type[SightingOut] | type[SightingsOut], result: Opportunities, seen: Sightings
) -> Column:
    columns: dict[str, Column] = {
        "at": _utc(result.start_utc, seen.t_s),
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
    return [kind(**row) for row in _rows(columns)]


def _by_axis(axis_names: tuple[str, str], motion_rad: Array) -> Column:
    """motion_rad: shape (..., 2), rad or rad/s."""
    return _rows(
        {name: _numbers(np.degrees(motion_rad[..., axis])) for axis, name in enumerate(axis_names)}
    )


def _rows(columns: dict[str, Column]) -> list[dict[str, Any]]:
    return [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]


def _utc(start_utc: datetime, t_s: Array) -> Column:
    texts = np.array(Instants(start_utc, t_s.ravel()).utc_text(3), dtype=object)
    column: Column = texts.reshape(t_s.shape).tolist()
    return column


def _numbers(numbers: Array) -> Column:
    rounded = np.round(numbers, DECIMALS) + 0.0  # no -0.0
    cells = rounded.astype(object)
    cells[~np.isfinite(rounded)] = None
    column: Column = cells.tolist()
    return column
