"""The verification report: margins, pointing errors, findings, a verdict."""

from dataclasses import dataclass
from datetime import datetime
from typing import Literal

Limit = Literal[
    "angle_min",
    "angle_max",
    "rate",
    "acceleration",
    "jerk",
    "acceleration_jump",
    "pointing",
    "motion",
    "elevation",
    "occlusion",
    "table",
    "initial_state",
    "final_state",
    "keep_out",
    "coverage",
]
Given = Literal["orbit", "attitude", "target", "motion"]


@dataclass(frozen=True, kw_only=True)
class Finding:
    """One thing wrong with a table; an `error`, as all but one kind are, fails it.

    limit: which promise breaks; axis: None when it isn't one axis's.
    t_s: seconds since the table's epoch, and the same instant in UTC: the worst instant for
    limits, the first for structural faults; None when the fault has no instant.
    """

    severity: Literal["error", "warning"] = "error"
    limit: Limit
    axis: str | None = None
    t_s: float | None = None
    at_utc: datetime | None = None
    detail: str


@dataclass(frozen=True, kw_only=True)
class LimitMargin:
    """The closest one axis comes to one limit, anywhere along the Hermite between rows.

    limit_value, extreme, margin: rad, rad/s, rad/s2 or rad/s3 by the kind of limit; margin
    is negative when the limit is broken.  extreme keeps its sign, limit_value is the bound
    on the magnitude, except for the two angle stops.
    acceleration_jump: step of the acceleration from one cell to the next (from the initial
    acceleration at row 0), bounded by what a plan within the jerk limit can show.
    """

    axis: str
    limit: Limit
    limit_value: float
    extreme: float
    margin: float
    t_s: float
    at_utc: datetime


@dataclass(frozen=True, kw_only=True)
class PointingError:
    """Angle between boresight and apparent target over a set of instants.

    Of a session that prescribes how the axes move: the larger of the axes' deviations.
    """

    max_rad: float
    rms_rad: float
    max_t_s: float
    max_utc: datetime


@dataclass(frozen=True, kw_only=True)
class EarthFixedView:
    """How an Earth-fixed target is seen over a session.

    elevation_*_rad: of the carrier in the target's sky, geodetic, without refraction.
    range_*_m: geometric, both ends at the same instant.
    miss_across_max_m: pointing error at the target, across the line of sight.
    miss_on_ground_max_m: the same carried along the line of sight onto the target's
    horizontal plane; None when the target's horizon hides the carrier at some instant.
    """

    elevation_min_rad: float
    elevation_min_utc: datetime
    elevation_max_rad: float
    elevation_max_utc: datetime
    range_min_m: float
    range_min_utc: datetime
    range_max_m: float
    miss_across_max_m: float
    miss_on_ground_max_m: float | None


@dataclass(frozen=True, kw_only=True)
class SkyView:
    """How a target beyond the Earth is seen over a session.

    limb_clearance_min_rad: least angle from the limb of the ellipsoid raised by the target's
    grazing altitude, negative behind it.
    range_min_m: None for a star.  refraction_max_rad: by how much the standard atmosphere of
    the limb lifts the target at most; 0 unless asked for.
    """

    limb_clearance_min_rad: float
    limb_clearance_min_utc: datetime
    range_min_m: float | None
    refraction_max_rad: float


@dataclass(frozen=True, kw_only=True)
class KeepOutMargin:
    """How near the boresight comes to the axis of one cone, by the scenario's number of it.

    away_min_rad, t_s, at_utc: least angle from the axis at an instant when the cone counts;
    None when it never does.
    """

    number: int
    about: str
    half_angle_rad: float
    away_min_rad: float | None
    t_s: float
    at_utc: datetime


@dataclass(frozen=True, kw_only=True)
class MaskMargin:
    """How near the boresight comes to one mask of the platform, by its number there.

    asked_rad: how far it must stay away.  away_min_rad, t_s, at_utc: the least distance from the
    polygon, negative inside, and when.
    """

    number: int
    name: str
    asked_rad: float
    away_min_rad: float
    t_s: float
    at_utc: datetime


@dataclass(frozen=True, kw_only=True)
class SlowStretch:
    """An axis commanded below its least smooth drive rate: allowed, but it will oscillate."""

    axis: str
    start_s: float
    stop_s: float
    start_utc: datetime
    stop_utc: datetime


@dataclass(frozen=True, kw_only=True)
class OffTarget:
    """A stretch over which the boresight is farther off than an exact track's 0.1 arcsec."""

    start_utc: datetime
    stop_utc: datetime
    max_rad: float


@dataclass(frozen=True, kw_only=True)
class SessionReport:
    """One session, judged from the row at or before its start to the row at or after its stop.

    at_rows, between_rows, overall: over the rows, over the instants between them, over both.
    allowed_rad: the pointing error the session may have.  off_target: spans in which it is tracked
    as near as the limits allow, in order of time.
    view: None where the session prescribes how the axes move instead of where to look.
    slow_stretches: in order of axis, then of time.
    """

    number: int
    start_utc: datetime
    stop_utc: datetime
    at_rows: PointingError
    between_rows: PointingError
    overall: PointingError
    view: EarthFixedView | SkyView | None
    slow_stretches: tuple[SlowStretch, ...]
    allowed_rad: float
    off_target: tuple[OffTarget, ...] = ()


@dataclass(frozen=True, kw_only=True)
class VerificationReport:
    """The verdict on one command table.

    passed: no finding is an error.
    taken_as_given: the inputs the judge did not derive again.  "orbit": the carrier's states;
    "attitude": the rotations of a law other than lvlh and inertial (aem, harmonic); "target":
    where a target moves over the Earth or the sky (ground_moving, ground_path, any mode the
    judge doesn't know), though not how it then appears; "motion": the angles and rates a
    test motion prescribes.  Published data (IERS, DE421, Hipparcos) count as known; the
    judge reads them by itself.
    sessions, limits, slow_stretches: empty when the table's structure is too broken to fly.
    slow_stretches: outside of all sessions, in order of axis, then of time.
    """

    passed: bool
    findings: tuple[Finding, ...]
    sessions: tuple[SessionReport, ...]
    limits: tuple[LimitMargin, ...]
    taken_as_given: tuple[Given, ...]
    keep_out: tuple[KeepOutMargin, ...] = ()
    masks: tuple[MaskMargin, ...] = ()
    slow_stretches: tuple[SlowStretch, ...] = ()
