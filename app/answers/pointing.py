"""How well each session's target is held, in what view, and the pointing budget, as answered."""

import math
from dataclasses import dataclass
from typing import Any

from app.answers.members import fill
from planner.frames.time_scales import utc_text
from planner.sessions.uncertainty import Contribution
from planner.verification import EarthFixedView, SessionReport, SkyView

ARCSEC_PER_RAD = math.degrees(1.0) * 3600.0


@dataclass(frozen=True, kw_only=True)
class SlowStretchOut:
    """An axis commanded below its least smooth drive rate, where friction may shake it."""

    axis: str
    start: str
    stop: str


@dataclass(frozen=True, kw_only=True)
class OffTargetOut:
    """A stretch over which the boresight is more than 0.1 arcsec off the target."""

    start: str
    stop: str
    max_arcsec: float


@dataclass(frozen=True, kw_only=True)
class PointingOut:
    """How well one session's target is held, by the independent verification.

    Of a test motion: the larger of the axes' deviations from it.
    allowed_arcsec: 0.1, or with `keyhole` `nearest` the circle inside the frame; off_target:
    where the session is then tracked only as near as the limits allow.
    ground_max_m: the error on the target's horizontal plane; null below its horizon.
    across_max_m: the error at the target across the line of sight.
    ground_*, across_*, elevation_*, closest_at, range_max_km: null unless the target is on
    the Earth.  range_min_km: null for a star.  limb_clearance_min_deg: least angle above the
    limb raised by the target's grazing altitude; it and refraction_max_arcsec are null
    unless the target is in the sky.
    """

    session: int
    start: str
    stop: str
    max_arcsec: float
    max_at: str
    rms_arcsec: float
    rows_max_arcsec: float
    between_rows_max_arcsec: float
    ground_max_m: float | None = None
    across_max_m: float | None = None
    elevation_min_deg: float | None = None
    range_min_km: float | None = None
    closest_at: str | None = None
    range_max_km: float | None = None
    limb_clearance_min_deg: float | None = None
    limb_clearance_min_at: str | None = None
    refraction_max_arcsec: float | None = None
    allowed_arcsec: float
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

    What the table can't know: the errors of orbit, attitude, Earth orientation, clock and
    drives.  probability_in_frame: that the target stays inside the camera's frame over the
    whole session, from where the table holds it.
    """

    session: int
    sigma_arcsec: float
    ground_m: float | None
    probability_in_frame: float
    contributions: list[Contribution]
