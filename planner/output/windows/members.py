"""The members of windows as answers tell them: degrees, UTC text, plain numbers."""

from dataclasses import dataclass, field
from typing import Annotated, Any

from planner.base.answer_members import (
    Count,
    ElevationDeg,
    ElevationOrLimbDeg,
    HalfTurnDeg,
    LongitudeDeg,
    Member,
    NotNegative,
    Share,
    Signed,
    TurnDeg,
)

Branch = Annotated[int, Member(least=0, greatest=1)]


def not_included() -> Any:  # noqa: ANN401 (in place of a member of any type)
    """What stands for a member that is missing unless `include` asks for it."""
    return None


@dataclass(frozen=True, kw_only=True)
class SkyPointOut:
    """The carrier and the Sun in the target's sky at one instant, without refraction.

    at: time of the point; UTC.
    azimuth_deg: of the carrier, clockwise from north.
    elevation_deg: of the carrier.
    sun_azimuth_deg: of the Sun's centre, clockwise from north.
    sun_elevation_deg: of the Sun's centre: day above 0.
    local_solar_time: apparent, as a sundial at the target shows it, in hours, minutes and seconds.
    """

    at: str
    azimuth_deg: TurnDeg
    elevation_deg: ElevationDeg
    sun_azimuth_deg: TurnDeg
    sun_elevation_deg: ElevationDeg
    local_solar_time: str


@dataclass(frozen=True, kw_only=True)
class TargetSkyOut:
    """A pass in the target's sky, as pass tables have it.

    rise: as the window opens.
    culmination: highest point of the carrier within the window.
    set: as the window closes.
    """

    rise: SkyPointOut
    culmination: SkyPointOut
    set: SkyPointOut


@dataclass(frozen=True, kw_only=True)
class PlaceOut:
    """Place of the target as the carrier culminates.

    latitude_deg: geodetic, WGS84; north positive.
    longitude_deg: WGS84; east positive.
    height_m: above the WGS84 ellipsoid.
    """

    latitude_deg: ElevationDeg
    longitude_deg: LongitudeDeg
    height_m: Signed


class _Sighting:
    """How a target is seen; null where a number has no meaning or no end.

    at: time of this view; UTC.
    elevation_deg: of the carrier in the target's sky; of one in space its height above the limb.
    range_km: distance; null for a star.
    off_nadir_deg: of the line of sight from the geocentric nadir.
    ground_sample_across_m: width of a pixel on the ground, across the lean of the line of sight;
    null for a target in space.
    ground_sample_along_m: length of a pixel on the ground, along the lean of the line of sight;
    null for a target in space, and where a pixel reaches the horizon (below some 0.1 deg).
    sun_elevation_deg: in the target's sky, null for a target in space.
    sun_separation_deg: of the line of sight from the Sun's centre.
    moon_separation_deg: of the line of sight from the Moon's centre.
    angles_deg: of the axes, by name; of a body's line of sight, along and across the track.
    rates_deg_s: of these angles, by name.
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
class ScanOut:
    """A scan of an imaging mode: `session` and this target and roll are a session of a plan.

    part: counted from 1, of the mode's scans in this pass. E.g. `1`.
    parts: the mode's scans in this pass. E.g. `2`.
    first_start: soonest start of a session of it; UTC, null where there is none. E.g.
    `"2024-06-01T10:00:05.800Z"`.
    last_start: latest start of a session of it; UTC, null where there is none. E.g.
    `"2024-06-01T10:02:42.800Z"`.
    target: the line, as a target of a session. E.g. `{"mode": "ground_path", "speed_m_s": 5454.5,
    "points": [{"latitude_deg": 20.487, "longitude_deg": -12.39}, {"latitude_deg": 21.018,
    "longitude_deg": -12.507}]}`.
    roll: rule by which a body lies on it; null for two axes. E.g.
    `{"rule": "lines_across_motion"}`.
    """

    part: Count
    parts: Count
    first_start: str | None
    last_start: str | None
    target: dict[str, Any]
    roll: dict[str, Any] | None


@dataclass(frozen=True, kw_only=True)
class WindowOut:
    """One stretch in which all conditions hold for a target.

    target: id of the target, as the request gives it.
    rise: start of the window; UTC. Of a scan the soonest that it can begin.
    set: end of the window; UTC. Of a scan the end of that which begins last.
    duration_s: from rise to set.
    session: the longest, up to six hours, that can be held, on a table's rows; null for none. Of a
    scan one from end to end, halfway through the starts there are.
    opened_by: the condition that is met from `rise` on; "interval" is the request's own start,
    "look" the time of a look of a stereo, "directions.NAME" one of `conditions.directions`,
    "exclusions.NAME" one of the platform's, "star_trackers" those.
    closed_by: the condition that is met until `set`; "interval" is the request's own stop. Of a
    scan that which a later start would not meet.
    highest_at: time of the greatest elevation; with `view`; UTC.
    highest_deg: greatest elevation; with `view`.
    closest: the view at the least range; of a target in space, at its greatest height above the
    limb; with `view`.
    through: the view at instants spread evenly from rise to set; with `view`.
    place: place of the target as the carrier culminates; null for a target in space; with `view`.
    sky: the pass as pass tables have it: rise, culmination and set with azimuth and elevation, Sun
    and local solar time; null for a target in space; with `view`.
    branch: the pair of axis angles that is given, 0 or 1, of the two that point at the target: the
    one with less turn of the inner axis; with `view`; a body has none.
    branches: the pairs that keep within the stops through the window (none where the axes would
    have to change over); with `view`; a body has none.
    probability_in_frame: that the target stays inside the camera's frame over the whole session, as
    a plan of it says; null where there is no session, and for the latest windows of a page where
    these are more than 500, of a body that wanders quickly fewer; with `probability`. E.g. `0.68`.
    clear_probability: of a sky without clouds at the middle; with `view` and `clouds`. E.g. `0.8`.
    scan: the scan that it is of, in requests with imaging modes; null for any other target.
    """

    target: str
    rise: str
    set: str
    duration_s: NotNegative
    session: SessionTimesOut | None
    opened_by: str
    closed_by: str
    highest_at: str = field(default_factory=not_included)
    highest_deg: ElevationOrLimbDeg = field(default_factory=not_included)
    closest: SightingOut = field(default_factory=not_included)
    through: SightingsOut = field(default_factory=not_included)
    place: PlaceOut | None = field(default_factory=not_included)
    sky: TargetSkyOut | None = field(default_factory=not_included)
    branch: Branch = field(default_factory=not_included)
    branches: list[Branch] = field(default_factory=not_included)
    probability_in_frame: Share | None = field(default_factory=not_included)
    clear_probability: Share | None = field(default_factory=not_included)
    scan: ScanOut | None = field(default_factory=not_included)
