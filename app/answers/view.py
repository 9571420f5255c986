"""The view of a plan: columns over time, in degrees and metres."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from app.answers.members import BUILT_ON_FIRST_USE, ProvenanceOut, degrees, to_json
from app.answers.opportunities import WindowOut, windows_out
from app.answers.ranges import Count, NotNegative, Signed
from planner.base.answer_members import answer
from planner.motion.pointing.angles import keyholes_rad
from planner.output.view.columns import (
    AxisMotion,
    BaselineSlew,
    BodyTrack,
    BoresightTrace,
    CarrierTrack,
    ConeTrace,
    FootprintTrace,
    MaskTrace,
    PointingTrace,
    SkyTrack,
    TargetTrack,
)
from planner.output.view.orbit import OrbitTrack
from planner.world.frames.time_scales import utc_text
from planner.world.plan import SegmentKind
from planner.world.platforms import AxisLimits

if TYPE_CHECKING:
    from planner.output.view import PlanView


@answer
class OrbitTrackResponse(OrbitTrack):
    """The carrier over some days, and the Sun."""

    provenance: ProvenanceOut


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


@answer
class ViewedTarget(TargetTrack):
    """One session's target over the whole table; null where a number has no meaning.

    A target with a timetable of its own appears in its session only, a test motion not at all.

    windows: spans in which it can be seen, from half an hour before the session to half an hour
    after.
    """

    windows: list[WindowOut]


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
    sky: null where every target is on the Earth.
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
    axes: dict[str, AxisMotion]
    limits: dict[str, AxisBoundsOut]
    keyholes_deg: list[Signed]
    frame_deg: list[NotNegative]
    carrier: CarrierTrack
    boresight: BoresightTrace
    footprint: FootprintTrace
    sun: BodyTrack
    moon: BodyTrack
    targets: list[ViewedTarget]
    pointing: PointingTrace
    keep_out: tuple[ConeTrace, ...]
    masks: tuple[MaskTrace, ...]
    sky: SkyTrack | None
    baseline: tuple[BaselineSlew, ...]


def view_json(view: "PlanView", plan_id: str, pixel_arcsec: float, *, verified: bool) -> bytes:
    """The whole answer as UTF-8 JSON."""
    scenario, table = view.plan.scenario, view.plan.table
    segments = [view.plan.segments[number] for number in view.segment.tolist()]
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
            axes=view.axes,
            limits={
                name: _bounds(limits)
                for name, limits in zip(table.axis_names, scenario.axis_limits, strict=True)
            },
            keyholes_deg=[degrees(at_rad) for at_rad in keyholes_rad(scenario.platform)],
            frame_deg=[degrees(2.0 * half_rad) for half_rad in scenario.platform.frame_half_rad],
            carrier=view.carrier,
            boresight=view.boresight,
            footprint=view.footprint,
            sun=view.sun,
            moon=view.moon,
            targets=[
                ViewedTarget(**vars(track), windows=[] if windows is None else windows_out(windows))
                for track, windows in zip(view.targets, view.windows, strict=True)
            ],
            pointing=view.pointing,
            keep_out=view.keep_out,
            masks=view.masks,
            sky=view.sky,
            baseline=view.baseline,
        )
    )


def _bounds(limits: AxisLimits) -> AxisBoundsOut:
    low_rad, high_rad = limits.bounds[0]
    return AxisBoundsOut(
        angle_min_deg=degrees(low_rad),
        angle_max_deg=degrees(high_rad),
        rate_max_deg_s=degrees(limits.rate_max_rad_s),
        acceleration_max_deg_s2=degrees(limits.acceleration_max_rad_s2),
        jerk_max_deg_s3=degrees(limits.jerk_max_rad_s3),
    )
