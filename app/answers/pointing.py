"""Pointing errors, the view of the target and the pointing budget of each session, as answered."""

import math
from dataclasses import dataclass
from typing import Any

from app.answers.members import fill
from app.answers.ranges import Count, ElevationDeg, NotNegative, Share, Signed
from planner.planning.sessions.budget import Contribution
from planner.verification import EarthFixedView, SessionReport, SkyView
from planner.world.frames.time_scales import utc_text

ARCSEC_PER_RAD = math.degrees(1.0) * 3600.0


@dataclass(frozen=True, kw_only=True)
class SlowStretchOut:
    """An axis commanded below its least smooth drive rate, where friction may shake it.

    axis: name of the axis.
    start: from when; UTC.
    stop: until when; UTC.
    """

    axis: str
    start: str
    stop: str


@dataclass(frozen=True, kw_only=True)
class OffTargetOut:
    """A stretch over which the boresight is more than 0.1 arcsec off the target.

    start: from when; UTC. E.g. `"2015-02-27T17:36:58.000Z"`.
    stop: until when; UTC. E.g. `"2015-02-27T17:37:06.000Z"`.
    max_arcsec: farthest off. E.g. `640.2`.
    """

    start: str
    stop: str
    max_arcsec: NotNegative


@dataclass(frozen=True, kw_only=True)
class PointingOut:
    """The pointing errors of one session, by the independent verification.

    Of a test motion: the larger of the axes' deviations from it.

    session: its number, from 0.
    start: from when on it is held; UTC.
    stop: until when; UTC.
    max_arcsec: largest angle between boresight and target.
    max_at: time of it; UTC.
    rms_arcsec: of the angle over the session.
    rows_max_arcsec: largest angle on the table's rows.
    between_rows_max_arcsec: largest angle between the rows.
    ground_max_m: largest error on the target's horizontal plane; null below its horizon, and unless
    the target is on the Earth.
    across_max_m: largest error at the target across the line of sight; null unless the target is on
    the Earth.
    elevation_min_deg: least elevation of the carrier in the target's sky; null unless the target is
    on the Earth.
    range_min_km: least distance; null for a star.
    closest_at: time of it; UTC, null unless the target is on the Earth.
    range_max_km: greatest distance; null unless the target is on the Earth.
    limb_clearance_min_deg: least angle above the limb raised by the target's grazing altitude; null
    unless the target is in the sky. E.g. `12.4`.
    limb_clearance_min_at: time of it; UTC. E.g. `"2015-02-27T17:37:50.000Z"`.
    refraction_max_arcsec: largest bending of the ray; null unless the target is in the sky. E.g.
    `0.1`.
    allowed_arcsec: 0.1, or with `keyhole` `nearest` the circle inside the frame.
    off_target: spans in which the session is tracked only as near as the limits allow, with
    `keyhole` `nearest`.
    slow_stretches: spans in which an axis moves slower than its drive runs smoothly.
    """

    session: Count
    start: str
    stop: str
    max_arcsec: NotNegative
    max_at: str
    rms_arcsec: NotNegative
    rows_max_arcsec: NotNegative
    between_rows_max_arcsec: NotNegative
    ground_max_m: NotNegative | None = None
    across_max_m: NotNegative | None = None
    elevation_min_deg: ElevationDeg | None = None
    range_min_km: NotNegative | None = None
    closest_at: str | None = None
    range_max_km: NotNegative | None = None
    limb_clearance_min_deg: Signed | None = None
    limb_clearance_min_at: str | None = None
    refraction_max_arcsec: NotNegative | None = None
    allowed_arcsec: NotNegative
    off_target: list[OffTargetOut]
    slow_stretches: list[SlowStretchOut]


def pointing_out(session: SessionReport) -> PointingOut:
    """One session's error and geometry."""
    return PointingOut(
        session=session.number,
        start=utc_text(session.start_utc),
        stop=utc_text(session.stop_utc),
        max_arcsec=session.overall.max_rad * ARCSEC_PER_RAD,
        max_at=utc_text(session.overall.max_utc),
        rms_arcsec=session.overall.rms_rad * ARCSEC_PER_RAD,
        rows_max_arcsec=session.at_rows.max_rad * ARCSEC_PER_RAD,
        between_rows_max_arcsec=session.between_rows.max_rad * ARCSEC_PER_RAD,
        **_view(session.view),
        allowed_arcsec=session.allowed_rad * ARCSEC_PER_RAD,
        off_target=[
            fill(OffTargetOut, stretch, max_arcsec=stretch.max_rad * ARCSEC_PER_RAD)
            for stretch in session.off_target
        ],
        slow_stretches=[fill(SlowStretchOut, slow) for slow in session.slow_stretches],
    )


def _view(view: EarthFixedView | SkyView | None) -> dict[str, Any]:
    match view:
        case EarthFixedView():
            return {
                "ground_max_m": view.miss_on_ground_max_m,
                "across_max_m": view.miss_across_max_m,
                "elevation_min_deg": math.degrees(view.elevation_min_rad),
                "range_min_km": view.range_min_m / 1e3,
                "closest_at": utc_text(view.range_min_utc),
                "range_max_km": view.range_max_m / 1e3,
            }
        case SkyView():
            far_m = view.range_min_m
            return {
                "range_min_km": None if far_m is None else far_m / 1e3,
                "limb_clearance_min_deg": math.degrees(view.limb_clearance_min_rad),
                "limb_clearance_min_at": utc_text(view.limb_clearance_min_utc),
                "refraction_max_arcsec": view.refraction_max_rad * ARCSEC_PER_RAD,
            }
        case None:
            return {}


@dataclass(frozen=True, kw_only=True)
class UncertaintyOut:
    """1-sigma pointing error of one session, per image axis at its worst instant.

    What the table can't know: the errors of orbit, attitude, Earth orientation, clock and drives.

    session: its number, from 0.
    sigma_arcsec: all contributions together.
    ground_m: the same across the line of sight at the target; null for a target in the sky.
    probability_in_frame: that the target stays inside the camera's frame over the whole session,
    from where the table holds it.
    contributions: cause by cause.
    """

    session: Count
    sigma_arcsec: NotNegative
    ground_m: NotNegative | None
    probability_in_frame: Share
    contributions: list[Contribution]
