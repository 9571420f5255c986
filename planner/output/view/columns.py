"""The columns of a view, as answers tell them; each array has an entry a row, NaN where none is."""

from typing import Annotated

from planner.base.answer_members import (
    Angle,
    Angles,
    AngleSize,
    Count,
    HalfTurn,
    HalfTurns,
    Heights,
    Internal,
    Latitudes,
    Lengths,
    Longitudes,
    Member,
    Motions,
    NotNegative,
    Times,
    answer,
)
from planner.base.arrays import Array, Mask
from planner.planning.opportunities import Opportunities
from planner.world.frames.time_scales import RowUtc, Utc
from planner.world.plan import FlightPlan, SegmentKind
from planner.world.resources import ResourceName

_Arcsecs = Annotated[Array, Member("arcsec", 0.0, decimals=4, gaps=True)]


@answer
class CarrierTrack:
    """The point below the carrier; null where its orbit isn't known.

    latitude_rad: geodetic, WGS84, north positive.
    longitude_rad: WGS84, east positive.
    height_m: of the carrier above the ellipsoid.
    sunlit_share: of the Sun's disk that the Earth doesn't hide from the carrier: 0 in the shadow.
    """

    latitude_rad: Latitudes
    longitude_rad: Longitudes
    height_m: Heights
    sunlit_share: Annotated[Array, Member(least=0.0, greatest=1.0, decimals=6, gaps=True)]


@answer
class BoresightTrace:
    """Direction and footprint of the camera.

    latitude_rad: of the point where the boresight meets the WGS84 ellipsoid; null where it passes
    the Earth by.
    longitude_rad: of that point; east positive.
    range_m: to that point.
    off_nadir_rad: of the boresight from the geocentric nadir.
    along_track_rad: of the boresight ahead of the nadir, in the plane of the orbit. E.g.
    `[12.1, 11.8]`.
    across_track_rad: of the boresight from that plane, to the right of the flight. E.g.
    `[-3.2, -3.1]`.
    sun_separation_rad: of the boresight from the Sun's centre.
    moon_separation_rad: of the boresight from the Moon's centre.
    """

    latitude_rad: Latitudes
    longitude_rad: Longitudes
    range_m: Lengths
    off_nadir_rad: HalfTurns
    along_track_rad: Angles
    across_track_rad: Angles
    sun_separation_rad: HalfTurns
    moon_separation_rad: HalfTurns


@answer
class FootprintTrace:
    """The corners of the camera's frame on the WGS84 ellipsoid, four a row, in order around it.

    latitude_rad: of each corner; null where its ray passes the Earth by.
    longitude_rad: of each corner; east positive.
    """

    latitude_rad: Annotated[Array, Member("deg", -90.0, 90.0, decimals=6, axes=2, gaps=True)]
    longitude_rad: Annotated[Array, Member("deg", -180.0, 180.0, decimals=6, axes=2, gaps=True)]


@answer
class BodyTrack:
    """The Sun or the Moon.

    latitude_rad: of the place that has it overhead (90 deg from the Sun's runs the terminator).
    longitude_rad: of that place; east positive.
    above_limb_rad: of its centre above the Earth's limb, seen from the carrier, without refraction;
    negative where the Earth hides it.
    """

    latitude_rad: Latitudes
    longitude_rad: Longitudes
    above_limb_rad: Angles


@answer
class SkyDirection:
    """A direction from the carrier in GCRF axes, a place on a chart of stars.

    right_ascension_rad: 0 to 360. E.g. `[101.287, 101.287]`.
    declination_rad: north positive. E.g. `[-16.716, -16.716]`.
    """

    right_ascension_rad: Annotated[Array, Member("deg", 0.0, 360.0, decimals=6, gaps=True)]
    declination_rad: Latitudes


@answer
class SkyTrack:
    """Directions from the carrier, for a chart of the sky.

    boresight: of the camera.
    nadir: of the Earth's centre.
    sun: of its centre.
    moon: of its centre.
    targets: of each session's target in space; null for one on the Earth.
    keep_out: of the axis of each cone of the request. E.g. `[]`.
    """

    boresight: SkyDirection
    nadir: SkyDirection
    sun: SkyDirection
    moon: SkyDirection
    targets: tuple[SkyDirection, ...]
    keep_out: tuple[SkyDirection, ...]


@answer
class AxisMotion:
    """The motion of one axis, or of a body about one of its own, with a number for each row.

    Acceleration and jerk of an axis are those of the cubic that is flown from the row to the
    table's next; they jump from row to row.  Jerk of a body is the mean up to the table's next row.

    angle_rad: of the axis; null of a body, whose axes turn with it.
    rate_rad_s: of the axis.
    acceleration_rad_s2: of the axis.
    jerk_rad_s3: of the axis.
    """

    angle_rad: Annotated[Array, Member("deg", decimals=9, gaps=True)]
    rate_rad_s: Motions
    acceleration_rad_s2: Motions
    jerk_rad_s3: Motions


@answer
class BaselineSlew:
    """The paper's spline in the place of one slew, between the same states in the same time.

    session: number of the session it leads to, from 0; null to the final state.
    t_s: since the table's epoch.
    axes: motion of each axis.
    """

    session: Count | None
    t_s: Times
    axes: dict[str, AxisMotion]


@answer
class TargetTrack:
    """One session's target over the whole table; null where a number has no meaning.

    A target with a timetable of its own appears in its session only, a test motion not at all.

    session: its number, from 0.
    name: name of the session.
    mode: of the target.
    start_utc: of the session, as it is flown; UTC.
    stop_utc: of the session, as it is flown; UTC.
    latitude_rad: of the target, geodetic, WGS84; null in space.
    longitude_rad: of the target, east positive; null in space.
    height_m: of the target above the ellipsoid; null in space.
    azimuth_rad: of the carrier in the target's sky, clockwise from north, 0 to 360; null in space.
    elevation_rad: of the carrier in the target's sky, without refraction; of a target in space its
    height above the raised limb.
    range_m: distance; null for a star.
    off_nadir_rad: of the line of sight to the target from the geocentric nadir.
    ground_sample_across_m: width of a pixel on the ground, across the lean of the line of sight;
    null in space and below the horizon.
    ground_sample_along_m: length of a pixel on the ground, along the lean of the line of sight;
    null in space, below the horizon and within 0.1 deg above, where a pixel has no end.
    sun_elevation_rad: of the Sun's centre in the target's sky, without refraction; null in space.
    sun_separation_rad: of the line of sight to the target from the Sun's centre.
    moon_separation_rad: of the line of sight to the target from the Moon's centre.
    """

    session: Count
    name: str
    mode: str
    start_utc: Utc
    stop_utc: Utc
    in_session: Internal[Mask]  # where it is to be held
    latitude_rad: Latitudes
    longitude_rad: Longitudes
    height_m: Heights
    azimuth_rad: Annotated[Array, Member("deg", 0.0, 360.0, decimals=6, gaps=True)]
    elevation_rad: Annotated[Array, Member("deg", -90.0, 180.0, decimals=6, gaps=True)]
    range_m: Lengths
    off_nadir_rad: HalfTurns
    ground_sample_across_m: Lengths
    ground_sample_along_m: Lengths
    sun_elevation_rad: Latitudes
    sun_separation_rad: HalfTurns
    moon_separation_rad: HalfTurns
    error_rad: Internal[Array]  # between the boresight and its apparent direction


@answer
class PointingTrace:
    """Pointing error and its tolerance; null outside the sessions.

    error_rad: between the boresight and the session's target, on the row.
    sigma_major_rad: half the long axis of the 1-sigma ellipse of the target in the image.
    sigma_minor_rad: half its short axis.
    major_turn_rad: of the long axis, from the frame's first side towards its second.
    """

    error_rad: _Arcsecs
    sigma_major_rad: _Arcsecs
    sigma_minor_rad: _Arcsecs
    major_turn_rad: HalfTurns


@answer
class ConeTrace:
    """One cone of `slew.keep_out`.

    number: of the cone in the request, from 0. E.g. `0`.
    about: the body or direction at the cone's centre. E.g. `"the Sun"`.
    half_angle_rad: of the cone. E.g. `25.0`.
    separation_rad: of the boresight from the cone's axis. E.g. `[61.2, 61.1]`.
    counts: true where the cone is in force; one about a body lapses while the Earth hides it. E.g.
    `[true, true]`.
    outline_t_s: times of the outlines, since the table's epoch. E.g. `[0.0, 10.0]`.
    outline_rad: per axis, for each of these times, for each of the two ways of pointing there: axis
    angles around the cone's side, the first point again at the end; null where no angles point
    there. E.g. `{"alpha": [[[10.0, null]]], "beta": [[[20.0, null]]]}`.
    """

    number: Count
    about: str
    half_angle_rad: HalfTurn
    separation_rad: HalfTurns
    counts: tuple[bool | None, ...]
    outline_t_s: Times
    outline_rad: dict[str, Annotated[Array, Member("deg", decimals=3, axes=3, gaps=True)]]


@answer
class MaskTrace:
    """One of the platform's `masks`, which are fixed to its base: its outline stays where it is.

    number: of the mask among the platform's, from 0. E.g. `0`.
    name: of the mask. E.g. `"radiator"`.
    asked_rad: angle from it that the boresight must keep, the mask's `margin_deg`. E.g. `1.0`.
    away_rad: of the boresight from the mask's region; negative inside. E.g. `[14.2, 13.9]`.
    outline_platform: unit vectors in the platform frame around the region, without what is asked,
    the first again at the end. E.g. `[[0.0, 0.6, 0.8], [0.0, 0.8, 0.6], [0.6, 0.0, 0.8], [0.0, 0.6,
    0.8]]`.
    outline_rad: per axis, for each of the two ways of pointing there, axis angles at these points;
    null where no angles point there. E.g. `{"alpha": [[10.0, null]], "beta": [[20.0, null]]}`.
    """

    number: Count
    name: str
    asked_rad: HalfTurn
    away_rad: Annotated[Array, Member("deg", decimals=6)]
    outline_platform: Annotated[Array, Member(decimals=6, axes=2)]
    outline_rad: dict[str, Annotated[Array, Member("deg", decimals=3, axes=2, gaps=True)]]


@answer
class ExclusionTrace:
    """One of a body's `exclusions`, or its star trackers together.

    name: of the exclusion; star_trackers of the trackers. E.g. `"radiator"`.
    away_from: the body, edge or reflection that it avoids, or the body that it stays near. E.g.
    `"the Sun"`.
    imaging_only: true where it counts only while the camera images. E.g. `false`.
    margin_rad: by how much it is kept; negative where it is not, 180 where there is nothing to keep
    away from, or near. E.g. `[14.2, 13.9]`.
    """

    name: str
    away_from: str
    imaging_only: bool
    margin_rad: Angles


@answer
class ResourceTrace:
    """The level of a battery, a memory or the wheels about one axis.

    name: of the resource; of a momentum with the axis of the body.
    unit: of limit, capacity and level. E.g. `"Wh"`.
    limit: the least charge of a battery, else the capacity. [see `unit`] E.g. `110.0`.
    capacity: the most that it holds. [see `unit`] E.g. `180.0`.
    level: charge of a battery, data in a memory, momentum either way. [see `unit`] E.g. `[160.0,
    159.2]`.
    """

    name: ResourceName
    unit: str
    limit: NotNegative
    capacity: NotNegative
    level: Annotated[Array, Member(decimals=6)]


@answer
class GyroTrace:
    """The gyros of a body, as its table has them.

    gimbal_rad: angles of the four gimbals. E.g. `[[60.1, -60.0, 119.9, -120.0]]`.
    gimbal_rate_rad_s: their rates until the table's next row. E.g. `[[0.1, 0.0, -0.2, 0.1]]`.
    momentum_n_m_s: of the rotors, in body axes. E.g. `[[0.1, -0.2, 11.4]]`.
    gimbal_rate_max_rad_s: of each gimbal. E.g. `57.3`.
    momentum_max_n_m_s: length of the momentum that turns may take the gyros to. E.g. `60.0`.
    """

    gimbal_rad: Annotated[Array, Member("deg", decimals=9, axes=2)]
    gimbal_rate_rad_s: Annotated[Array, Member("deg", decimals=9, axes=2)]
    momentum_n_m_s: Annotated[Array, Member(decimals=6, axes=2)]
    gimbal_rate_max_rad_s: AngleSize
    momentum_max_n_m_s: NotNegative


@answer
class AxisBounds:
    """Limits of one axis, or of a body about one of its own, where magnitudes bound the whole.

    angle_min_rad: its lower stop; null of a body.
    angle_max_rad: its upper stop; null of a body.
    rate_max_rad_s: in either sense.
    acceleration_max_rad_s2: in either sense.
    jerk_max_rad_s3: in either sense.
    """

    angle_min_rad: Angle | None
    angle_max_rad: Angle | None
    rate_max_rad_s: AngleSize
    acceleration_max_rad_s2: AngleSize
    jerk_max_rad_s3: AngleSize


@answer
class PlanView:
    """The view of a plan as columns, with a value for each row shown.

    epoch_utc: of row 0; UTC.
    step_s: from row to row shown; the table's last row is shown too.
    pixel_arcsec: angle that a pixel covers, for which ground samples are given.
    t_s: of each row, since the epoch.
    activity: activity of the platform from the row on.
    session: number of the session that belongs to, from 0; null on the way to the final state.
    axes: motion of each axis, by its name; of a body about its axes x, y and z.
    limits: limits of each axis, by its name.
    keyholes_rad: angles of the second axis at which the boresight lies in the plane of both: near
    them the first must turn fast; none of a body. E.g. `[-90.0, 90.0]`.
    frame_rad: the camera's field of view along the frame's first side and its second. E.g.
    `[2.6, 1.7]`.
    targets: of each session.
    keep_out: of each cone of the request.
    masks: of each of the platform's.
    exclusions: of each of a body's, then of its star trackers.
    resources: of battery, memory and wheels, where the request has them.
    gyros: of a body that they turn; null of others.
    sky: null where every target is on the Earth.
    baseline: of each slew; empty where the plan is the baseline itself, or a body's.
    """

    plan: Internal[FlightPlan]
    epoch_utc: RowUtc
    step_s: NotNegative
    pixel_arcsec: NotNegative
    t_s: Times
    activity: tuple[SegmentKind, ...]
    session: tuple[Count | None, ...]
    axes: dict[str, AxisMotion]
    limits: dict[str, AxisBounds]
    keyholes_rad: tuple[Angle, ...]
    frame_rad: tuple[AngleSize, ...]
    carrier: CarrierTrack
    boresight: BoresightTrace
    footprint: FootprintTrace
    sun: BodyTrack
    moon: BodyTrack
    targets: tuple[TargetTrack, ...]
    windows: Internal[tuple[Opportunities | None, ...]]  # of each session's target
    pointing: PointingTrace
    keep_out: tuple[ConeTrace, ...]
    masks: tuple[MaskTrace, ...]
    exclusions: tuple[ExclusionTrace, ...]
    resources: tuple[ResourceTrace, ...]
    gyros: GyroTrace | None
    sky: SkyTrack | None
    baseline: tuple[BaselineSlew, ...]
