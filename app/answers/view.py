"""The view of a plan: columns over time, in degrees and metres."""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from app.answers.columns import columns_of, numbers
from app.answers.mask_trace import MaskTraceOut, mask_trace_out
from app.answers.members import BUILT_ON_FIRST_USE, DECIMALS, degrees, to_json
from app.answers.opportunities import WindowOut, windows_out
from app.answers.ranges import (
    Count,
    ElevationDeg,
    ElevationOrLimbDeg,
    HalfTurnDeg,
    LatitudeDeg,
    LongitudeDeg,
    NotNegative,
    Share,
    Signed,
    TurnDeg,
)
from planner.motion.pointing.angles import keyholes_rad
from planner.world.frames.time_scales import utc_text
from planner.world.plan import SegmentKind
from planner.world.platforms import AxisLimits

if TYPE_CHECKING:
    from planner.output.view import PlanView
    from planner.output.view.cones import ConeTrace
    from planner.output.view.motion import AxesMotion, BaselineSlew


@dataclass(frozen=True, kw_only=True)
class AxisMotionOut:
    """The motion of one axis, with a number for each row.

    Acceleration and jerk are those of the cubic that is flown from the row to the table's next;
    they jump from row to row.

    angle_deg: of the axis.
    rate_deg_s: of the axis.
    acceleration_deg_s2: of the axis.
    jerk_deg_s3: of the axis.
    """

    angle_deg: list[Signed]
    rate_deg_s: list[Signed]
    acceleration_deg_s2: list[Signed]
    jerk_deg_s3: list[Signed]


@dataclass(frozen=True, kw_only=True)
class AxisBoundsOut:
    """Limits of one axis.

    angle_min_deg: its lower stop.
    angle_max_deg: its upper stop.
    rate_max_deg_s: in either sense.
    acceleration_max_deg_s2: in either sense.
    jerk_max_deg_s3: in either sense.
    """

    angle_min_deg: Signed
    angle_max_deg: Signed
    rate_max_deg_s: NotNegative
    acceleration_max_deg_s2: NotNegative
    jerk_max_deg_s3: NotNegative


@dataclass(frozen=True, kw_only=True)
class CarrierTrackOut:
    """The point below the carrier; null where its orbit isn't known.

    latitude_deg: geodetic, WGS84, north positive.
    longitude_deg: WGS84, east positive.
    height_m: of the carrier above the ellipsoid.
    sunlit_share: of the Sun's disk that the Earth doesn't hide from the carrier: 0 in the shadow.
    """

    latitude_deg: list[LatitudeDeg | None]
    longitude_deg: list[LongitudeDeg | None]
    height_m: list[Signed | None]
    sunlit_share: list[Share | None]


@dataclass(frozen=True, kw_only=True)
class BoresightTraceOut:
    """Direction and footprint of the camera.

    latitude_deg: of the point where the boresight meets the WGS84 ellipsoid; null where it passes
    the Earth by.
    longitude_deg: of that point; east positive.
    range_m: to that point.
    off_nadir_deg: of the boresight from the geocentric nadir.
    sun_separation_deg: of the boresight from the Sun's centre.
    moon_separation_deg: of the boresight from the Moon's centre.
    """

    latitude_deg: list[LatitudeDeg | None]
    longitude_deg: list[LongitudeDeg | None]
    range_m: list[NotNegative | None]
    off_nadir_deg: list[HalfTurnDeg | None]
    sun_separation_deg: list[HalfTurnDeg | None]
    moon_separation_deg: list[HalfTurnDeg | None]


@dataclass(frozen=True, kw_only=True)
class FootprintTraceOut:
    """The corners of the camera's frame on the WGS84 ellipsoid, four a row, in order around it.

    latitude_deg: of each corner; null where its ray passes the Earth by.
    longitude_deg: of each corner; east positive.
    """

    latitude_deg: list[list[LatitudeDeg | None]]
    longitude_deg: list[list[LongitudeDeg | None]]


@dataclass(frozen=True, kw_only=True)
class BodyTrackOut:
    """The Sun or the Moon.

    latitude_deg: of the place that has it overhead (90 deg from the Sun's runs the terminator).
    longitude_deg: of that place; east positive.
    above_limb_deg: of its centre above the Earth's limb, seen from the carrier, without refraction;
    negative where the Earth hides it.
    """

    latitude_deg: list[LatitudeDeg | None]
    longitude_deg: list[LongitudeDeg | None]
    above_limb_deg: list[Signed | None]


@dataclass(frozen=True, kw_only=True)
class TargetTrackOut:
    """One session's target over the whole table; null where a number has no meaning.

    A target with a timetable of its own appears in its session only, a test motion not at all.

    session: its number, from 0.
    name: name of the session.
    mode: of the target.
    start: of the session, as it is flown; UTC.
    stop: of the session, as it is flown; UTC.
    latitude_deg: of the target, geodetic, WGS84; null in space.
    longitude_deg: of the target, east positive; null in space.
    height_m: of the target above the ellipsoid; null in space.
    azimuth_deg: of the carrier in the target's sky, clockwise from north, 0 to 360; null in space.
    elevation_deg: of the carrier in the target's sky, without refraction; of a target in space its
    height above the raised limb.
    range_m: distance; null for a star.
    off_nadir_deg: of the line of sight to the target from the geocentric nadir.
    ground_sample_across_m: width of a pixel on the ground, across the lean of the line of sight;
    null in space and below the horizon.
    ground_sample_along_m: length of a pixel on the ground, along the lean of the line of sight;
    null in space, below the horizon and within 0.1 deg above, where a pixel has no end.
    sun_elevation_deg: of the Sun's centre in the target's sky, without refraction; null in space.
    sun_separation_deg: of the line of sight to the target from the Sun's centre.
    moon_separation_deg: of the line of sight to the target from the Moon's centre.
    windows: spans in which it can be seen, from half an hour before the session to half an hour
    after.
    """

    session: Count
    name: str
    mode: str
    start: str
    stop: str
    latitude_deg: list[LatitudeDeg | None]
    longitude_deg: list[LongitudeDeg | None]
    height_m: list[Signed | None]
    azimuth_deg: list[TurnDeg | None]
    elevation_deg: list[ElevationOrLimbDeg | None]
    range_m: list[NotNegative | None]
    off_nadir_deg: list[HalfTurnDeg | None]
    ground_sample_across_m: list[NotNegative | None]
    ground_sample_along_m: list[NotNegative | None]
    sun_elevation_deg: list[ElevationDeg | None]
    sun_separation_deg: list[HalfTurnDeg | None]
    moon_separation_deg: list[HalfTurnDeg | None]
    windows: list[WindowOut]


@dataclass(frozen=True, kw_only=True)
class PointingTraceOut:
    """Pointing error and its tolerance; null outside the sessions.

    error_arcsec: between the boresight and the session's target, on the row.
    sigma_major_arcsec: half the long axis of the 1-sigma ellipse of the target in the image.
    sigma_minor_arcsec: half its short axis.
    major_turn_deg: of the long axis, from the frame's first side towards its second.
    """

    error_arcsec: list[NotNegative | None]
    sigma_major_arcsec: list[NotNegative | None]
    sigma_minor_arcsec: list[NotNegative | None]
    major_turn_deg: list[HalfTurnDeg | None]


@dataclass(frozen=True, kw_only=True)
class ConeTraceOut:
    """One cone of `slew.keep_out`.

    number: of the cone in the request, from 0. E.g. `0`.
    about: the body or direction at the cone's centre. E.g. `"the Sun"`.
    half_angle_deg: of the cone. E.g. `25.0`.
    separation_deg: of the boresight from the cone's axis. E.g. `[61.2, 61.1]`.
    counts: true where the cone is in force; one about a body lapses while the Earth hides it. E.g.
    `[true, true]`.
    outline_t_s: times of the outlines, since the table's epoch. E.g. `[0.0, 10.0]`.
    outline_deg: per axis, for each of these times, for each of the two ways of pointing there: axis
    angles around the cone's side, the first point again at the end; null where no angles point
    there. E.g. `{"alpha": [[[10.0, null]]], "beta": [[[20.0, null]]]}`.
    """

    number: Count
    about: str
    half_angle_deg: HalfTurnDeg
    separation_deg: list[HalfTurnDeg | None]
    counts: list[bool | None]
    outline_t_s: list[NotNegative]
    outline_deg: dict[str, list[list[list[Signed | None]]]]


@dataclass(frozen=True, kw_only=True)
class BaselineSlewOut:
    """The paper's spline in the place of one slew, between the same states in the same time.

    session: number of the session it leads to, from 0; null to the final state.
    t_s: since the table's epoch.
    axes: motion of each axis.
    """

    session: Count | None
    t_s: list[NotNegative]
    axes: dict[str, AxisMotionOut]


@dataclass(frozen=True, kw_only=True)
class PlanViewResponse:
    """The view of a plan as columns, with a value for each row shown.

    id: of the plan, as its address names it.
    name: of the plan.
    platform: its name.
    verified: true when the plan's verification passed.
    epoch: of row 0; UTC.
    step_s: from row to row shown; the table's last row is shown too.
    pixel_arcsec: angle that a pixel covers, for which ground samples are given.
    t_s: of each row, since the epoch.
    activity: activity of the platform from the row on.
    session: number of the session that belongs to, from 0; null on the way to the final state.
    axes: motion of each axis, by its name.
    limits: limits of each axis, by its name.
    keyholes_deg: angles of the second axis at which the boresight lies in the plane of both: near
    them the first must turn fast. E.g. `[-90.0, 90.0]`.
    frame_deg: the camera's field of view along the frame's first side and its second. E.g.
    `[2.6, 1.7]`.
    targets: of each session.
    keep_out: of each cone of the request.
    masks: of each of the platform's.
    baseline: of each slew; empty where the plan is the baseline itself.
    """

    __pydantic_config__ = BUILT_ON_FIRST_USE

    id: str
    name: str
    platform: str
    verified: bool
    epoch: str
    step_s: NotNegative
    pixel_arcsec: NotNegative
    t_s: list[NotNegative]
    activity: list[SegmentKind]
    session: list[Count | None]
    axes: dict[str, AxisMotionOut]
    limits: dict[str, AxisBoundsOut]
    keyholes_deg: list[Signed]
    frame_deg: list[NotNegative]
    carrier: CarrierTrackOut
    boresight: BoresightTraceOut
    footprint: FootprintTraceOut
    sun: BodyTrackOut
    moon: BodyTrackOut
    targets: list[TargetTrackOut]
    pointing: PointingTraceOut
    keep_out: list[ConeTraceOut]
    masks: list[MaskTraceOut]
    baseline: list[BaselineSlewOut]


def view_json(view: "PlanView", plan_id: str, pixel_arcsec: float, *, verified: bool) -> bytes:
    """The whole answer as UTF-8 JSON."""
    scenario, table = view.plan.scenario, view.plan.table
    segments = [view.plan.segments[number] for number in view.segment.tolist()]
    unknown = view.first_known
    return to_json(
        PlanViewResponse(
            id=plan_id,
            name=scenario.name,
            platform=scenario.platform.name,
            verified=verified,
            epoch=utc_text(table.epoch_utc, 1),
            step_s=view.step_s,
            pixel_arcsec=pixel_arcsec,
            t_s=view.t_s.tolist(),
            activity=[segment.kind for segment in segments],
            session=[segment.session for segment in segments],
            axes=_axes(table.axis_names, view.axes),
            limits={
                name: _bounds(limits)
                for name, limits in zip(table.axis_names, scenario.axis_limits, strict=True)
            },
            keyholes_deg=[degrees(at_rad) for at_rad in keyholes_rad(scenario.platform)],
            frame_deg=[degrees(2.0 * half_rad) for half_rad in scenario.platform.frame_half_rad],
            carrier=columns_of(CarrierTrackOut, view.carrier, unknown),
            boresight=columns_of(BoresightTraceOut, view.boresight, unknown),
            footprint=columns_of(FootprintTraceOut, view.footprint, unknown),
            sun=columns_of(BodyTrackOut, view.sun, unknown),
            moon=columns_of(BodyTrackOut, view.moon, unknown),
            targets=_targets(view),
            pointing=columns_of(PointingTraceOut, view.pointing, unknown),
            keep_out=[_cone(table.axis_names, cone, unknown) for cone in view.keep_out],
            masks=[mask_trace_out(table.axis_names, mask) for mask in view.masks],
            baseline=[_baseline(table.axis_names, slew) for slew in view.baseline],
        )
    )


def _targets(view: "PlanView") -> list[TargetTrackOut]:
    sessions = view.plan.scenario.sessions
    return [
        columns_of(
            TargetTrackOut,
            track,
            view.first_known,
            session=track.session,
            name=track.name,
            mode=track.mode,
            start=utc_text(sessions[track.session].start),
            stop=utc_text(sessions[track.session].stop),
            windows=[] if windows is None else windows_out(windows),
        )
        for track, windows in zip(view.targets, view.windows, strict=True)
    ]


def _axes(axis_names: tuple[str, ...], motion: "AxesMotion") -> dict[str, AxisMotionOut]:
    """Of each axis by its name."""
    return {
        name: AxisMotionOut(
            **{
                told: numbers(getattr(motion, ours)[:, axis], math.degrees(1.0), DECIMALS)
                for told, ours in (
                    ("angle_deg", "angle_rad"),
                    ("rate_deg_s", "rate_rad_s"),
                    ("acceleration_deg_s2", "acceleration_rad_s2"),
                    ("jerk_deg_s3", "jerk_rad_s3"),
                )
            }
        )
        for axis, name in enumerate(axis_names)
    }


def _bounds(limits: AxisLimits) -> AxisBoundsOut:
    low_rad, high_rad = limits.bounds[0]
    return AxisBoundsOut(
        angle_min_deg=degrees(low_rad),
        angle_max_deg=degrees(high_rad),
        rate_max_deg_s=degrees(limits.rate_max_rad_s),
        acceleration_max_deg_s2=degrees(limits.acceleration_max_rad_s2),
        jerk_max_deg_s3=degrees(limits.jerk_max_rad_s3),
    )


def _cone(axis_names: tuple[str, ...], cone: "ConeTrace", unknown_rows: int) -> ConeTraceOut:
    return columns_of(
        ConeTraceOut,
        cone,
        unknown_rows,
        number=cone.number,
        about=cone.about,
        half_angle_deg=degrees(cone.half_angle_rad),
        outline_t_s=cone.outline_t_s.tolist(),
        outline_deg={
            name: numbers(cone.outline_rad[..., axis], math.degrees(1.0), 3)
            for axis, name in enumerate(axis_names)
        },
    )


def _baseline(axis_names: tuple[str, ...], slew: "BaselineSlew") -> BaselineSlewOut:
    return BaselineSlewOut(
        session=slew.session, t_s=slew.t_s.tolist(), axes=_axes(axis_names, slew.motion)
    )
