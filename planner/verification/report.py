"""The verification report: margins, pointing errors, findings, a verdict."""

from datetime import datetime
from typing import Literal

from planner.base.answer_members import (
    Angle,
    Arcsec,
    Count,
    Elevation,
    HalfTurn,
    Internal,
    Km,
    NotNegative,
    Signed,
    Text,
    answer,
)
from planner.world.conditions import CadenceName, ConditionName
from planner.world.frames.time_scales import Utc
from planner.world.resources import ResourceName

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
    "exclusion",
    "off_nadir",
    "roll",
    "coverage",
    "torque",
    "momentum",
    "battery",
    "memory",
    ConditionName,
    CadenceName,
]
Given = Literal["orbit", "attitude", "target", "motion"]
GyroLimit = Literal[
    "torque", "momentum", "gimbal_rate", "gimbal_rate_needed", "singularity", "momentum_mismatch"
]
_UNITS: dict[Limit, str] = {
    "angle_min": "deg",
    "angle_max": "deg",
    "rate": "deg/s",
    "acceleration": "deg/s2",
    "acceleration_jump": "deg/s2",
    "jerk": "deg/s3",
}


@answer
class Finding:
    """One thing the verification found wrong or worth knowing.

    severity: an error fails the plan.
    limit: the property that was checked. E.g. `"rate"`.
    axis: its name; null when it is no single axis's. E.g. `"alpha"`.
    at_utc: time of the finding; UTC, null when it has no time. E.g. `"2015-02-27T17:36:10.000Z"`.
    detail: the finding in words. E.g. `"alpha reaches 3.1 deg/s, 0.1 deg/s past its limit of 3
    deg/s"`.
    """

    severity: Literal["error", "warning"] = "error"
    limit: Limit
    axis: str | None = None
    t_s: Internal[float | None] = None  # since the table's epoch
    at_utc: Utc | None = None  # the worst instant for limits, the first for structural faults
    detail: str


def table_fault(detail: str) -> Finding:
    """What is wrong with the table as a whole."""
    return Finding(limit="table", detail=detail)


@answer
class LimitMargin:
    """The closest an axis comes to a limit, anywhere on or between rows.

    limit: the most the axis may. [see `unit`]
    extreme: the nearest to it that the axis comes. [see `unit`]
    margin: distance from the limit; negative when the limit is broken. [see `unit`]
    unit: of limit, extreme and margin.
    t_s: time of the margin, since the table's epoch.
    at_utc: the same instant; UTC.
    """

    axis: Internal[str]
    kind: Internal[Limit]
    # Here in rad, rad/s, rad/s2 or rad/s3 by the kind; the limit on the magnitude, but for stops.
    # An acceleration's jump is its step from one cell to the next (from the initial acceleration at
    # row 0), bounded by what a plan within the jerk limit can show.
    limit: Angle
    extreme: Angle  # with its sign
    margin: Angle
    tolerance: Internal[float]  # by which the margin may be negative without being an error
    t_s: NotNegative
    at_utc: Utc

    @property
    def unit(self) -> Text:
        return _UNITS[self.kind]


@answer
class KeepOutMargin:
    """The least angle between the boresight and the axis of one cone of `slew.keep_out`.

    number: of the cone in the request, from 0. E.g. `0`.
    about: the body or direction at the cone's centre. E.g. `"the Sun"`.
    half_angle_rad: of the cone. E.g. `25.0`.
    away_min_rad: least angle between boresight and the cone's axis; null when the cone never counts
    (the Earth hides its body). E.g. `31.2`.
    margin_rad: least angle less the half angle; null when the cone never counts. E.g.
    `6.2`.
    at_utc: time of the least angle; UTC, null when the cone never counts. E.g.
    `"2015-02-27T17:36:10.000Z"`.
    """

    number: Count
    about: str
    half_angle_rad: HalfTurn
    away_min_rad: HalfTurn | None
    t_s: Internal[float | None]
    at_utc: Utc | None

    @property
    def margin_rad(self) -> Angle | None:
        return None if self.away_min_rad is None else self.away_min_rad - self.half_angle_rad


@answer
class MaskMargin:
    """The least angle between the boresight and one of the platform's `masks`.

    number: of the mask among the platform's, from 0. E.g. `0`.
    name: of the mask. E.g. `"radiator"`.
    asked_rad: angle from it that the boresight must keep, the mask's `margin_deg`. E.g. `1.0`.
    away_min_rad: least angle between boresight and the mask's region, negative inside, found to
    2 arcsec on and between rows. E.g. `4.2`.
    margin_rad: least angle less `asked_deg`; negative when the mask is entered. E.g. `3.2`.
    at_utc: time of the least angle; UTC. E.g. `"2015-02-27T17:36:10.000Z"`.
    """

    number: Count
    name: str
    asked_rad: HalfTurn
    away_min_rad: Angle
    t_s: Internal[float]
    at_utc: Utc

    @property
    def margin_rad(self) -> Angle:
        return self.away_min_rad - self.asked_rad


@answer
class ExclusionMargin:
    """The least that a body keeps of one of its exclusions, or its star trackers of theirs.

    name: the exclusion's, or `star_trackers`. E.g. `"radiator"`.
    margin_rad: least angle beyond the one asked for, negative when it is entered; null when it
    never counts. E.g. `12.5`.
    at_utc: time of it; UTC, null when it never counts. E.g. `"2026-06-01T10:44:20.000Z"`.
    """

    name: str
    margin_rad: Angle | None
    t_s: Internal[float | None]
    at_utc: Utc | None


@answer
class Reserve:
    """The least that a battery, a memory or the wheels keep from their limit.

    name: of the resource; of a momentum with the axis of the body.
    unit: of limit, extreme and margin. E.g. `"Wh"`.
    limit: the least charge of a battery, else the capacity. [see `unit`] E.g. `110.0`.
    extreme: the nearest that it comes. [see `unit`] E.g. `121.5`.
    margin: distance from the limit; negative when it is passed. [see `unit`] E.g. `11.5`.
    last: held when the table ends. [see `unit`] E.g. `160.0`.
    at_utc: time of the nearest; UTC. E.g. `"2026-06-01T10:44:20.000Z"`.
    """

    name: ResourceName
    unit: str
    limit: NotNegative
    extreme: Signed
    margin: Signed
    last: Signed
    t_s: Internal[float]
    at_utc: Utc


@answer
class GyroMargin:
    """The least that a body's gyros keep from one limit, anywhere on or between rows.

    name: torque and momentum, by length; `gimbal_rate` as the table tells it, `gimbal_rate_needed`
    as the torque asks at least; `singularity`, the smallest singular value of the gyros' torque
    directions; `momentum_mismatch`, between what the gimbals hold and what the motion asks. E.g.
    `"torque"`.
    unit: of limit, extreme and margin. E.g. `"N m"`.
    limit: the most that may be; of a singularity 0, the least. [see `unit`] E.g. `15.0`.
    extreme: the nearest that it comes. [see `unit`] E.g. `13.2`.
    margin: distance from the limit; negative when it is passed. [see `unit`] E.g. `1.8`.
    at_utc: time of the nearest; UTC. E.g. `"2026-06-01T10:44:20.000Z"`.
    """

    name: GyroLimit
    unit: Literal["N m", "N m s", "deg/s", "1"]
    limit: NotNegative
    extreme: NotNegative
    t_s: Internal[float]
    at_utc: Utc

    @property
    def margin(self) -> Signed:
        return self.extreme if self.name == "singularity" else self.limit - self.extreme


@answer
class ConditionMargin:
    """The least that a session keeps of one of the request's conditions.

    name: the condition, by its field. E.g. `"max_off_nadir_deg"`.
    unit: of limit, extreme and margin. E.g. `"deg"`.
    limit: the value asked for; of `carrier_light` 0, the Sun's centre on the limb; of `duty_cycle`
    its `imaging_max_s`. [see `unit`] E.g. `45.0`.
    extreme: the nearest that it comes to its limit, or the farthest beyond. [see `unit`] E.g.
    `31.2`.
    margin: distance from the limit; negative when it is passed. While the Earth hides the Sun or
    Moon to keep away from, the angle by which it does. [see `unit`] E.g. `13.8`.
    at_utc: time of it; UTC. E.g. `"2026-06-01T10:44:20.000Z"`.
    """

    name: str
    unit: Literal["deg", "m", "s"]
    limit: Signed
    extreme: Signed
    margin: Signed
    t_s: Internal[float]
    at_utc: Utc


@answer
class SlowStretch:
    """An axis commanded below its least smooth drive rate, where friction may shake it.

    axis: name of the axis.
    start_utc: from when; UTC.
    stop_utc: until when; UTC.
    """

    axis: str
    start_s: Internal[float]
    stop_s: Internal[float]
    start_utc: Utc
    stop_utc: Utc


@answer
class OffTarget:
    """A stretch over which the boresight is more than 0.1 arcsec off the target.

    start_utc: from when; UTC. E.g. `"2015-02-27T17:36:58.000Z"`.
    stop_utc: until when; UTC. E.g. `"2015-02-27T17:37:06.000Z"`.
    max_rad: farthest off. E.g. `640.2`.
    """

    start_utc: Utc
    stop_utc: Utc
    max_rad: Arcsec


@answer
class SessionReport:
    """The pointing errors of one session, by the independent verification.

    Of a test motion: the larger of the axes' deviations from it.

    session: its number, from 0.
    start_utc: from when on it is held; UTC.
    stop_utc: until when; UTC.
    max_rad: largest angle between boresight and target.
    max_at_utc: time of it; UTC.
    rms_rad: of the angle over the session.
    rows_max_rad: largest angle on the table's rows.
    between_rows_max_rad: largest angle between the rows.
    ground_max_m: largest error on the target's horizontal plane; null below its horizon, and unless
    the target is on the Earth.
    across_max_m: largest error at the target across the line of sight; null unless the target is on
    the Earth.
    elevation_min_rad: least elevation of the carrier in the target's sky; null unless the target is
    on the Earth.
    range_min_m: least distance; null for a star.
    closest_at_utc: time of it; UTC, null unless the target is on the Earth.
    range_max_m: greatest distance; null unless the target is on the Earth.
    limb_clearance_min_rad: least angle above the limb raised by the target's grazing altitude; null
    unless the target is in the sky. E.g. `12.4`.
    limb_clearance_min_at_utc: time of it; UTC. E.g. `"2015-02-27T17:37:50.000Z"`.
    refraction_max_rad: largest bending of the ray; null unless the target is in the sky. E.g.
    `0.1`.
    allowed_rad: 0.1, or with `keyhole` `nearest` the circle inside the frame.
    off_target: spans in which the session is tracked only as near as the limits allow, with
    `keyhole` `nearest`.
    slow_stretches: spans in which an axis moves slower than its drive runs smoothly.
    conditions: of the request's conditions, the least that the session keeps of each.
    """

    session: Count
    start_utc: Utc  # the row at or before its start
    stop_utc: Utc  # the row at or after its stop
    max_rad: Arcsec
    max_t_s: Internal[float]
    max_at_utc: Utc
    rms_rad: Arcsec
    rows_max_rad: Arcsec
    between_rows_max_rad: Arcsec
    # Of a target on the Earth: elevations geodetic, without refraction, distances geometric, both
    # ends at the same instant.
    ground_max_m: NotNegative | None = None  # the miss carried along the line of sight
    across_max_m: NotNegative | None = None
    elevation_min_rad: Elevation | None = None
    elevation_min_utc: Internal[datetime | None] = None
    elevation_max_rad: Internal[float | None] = None
    elevation_max_utc: Internal[datetime | None] = None
    range_min_m: Km | None = None  # of a target in the sky, too
    closest_at_utc: Utc | None = None
    range_max_m: Km | None = None
    # Of one in the sky; the limb is the ellipsoid's, the bending the standard atmosphere's.
    limb_clearance_min_rad: Angle | None = None
    limb_clearance_min_at_utc: Utc | None = None
    refraction_max_rad: Arcsec | None = None
    allowed_rad: Arcsec
    off_target: tuple[OffTarget, ...] = ()  # in order of time
    slow_stretches: tuple[SlowStretch, ...]  # in order of axis, then of time
    conditions: tuple[ConditionMargin, ...] = ()


@answer
class VerificationReport:
    """The verdict of a judge that shares no code with the planner's geometry and solver.

    passed: true when the table may be flown.
    findings: faults, and what is worth knowing.
    taken_as_given: inputs that the verification did not derive for itself.
    """

    passed: bool
    findings: tuple[Finding, ...]
    # "orbit": the carrier's states; "attitude": the rotations of a law other than lvlh and inertial
    # (aem, harmonic); "target": where a target moves over the Earth or the sky (ground_moving,
    # ground_path, any mode the judge doesn't know), though not how it then appears; "motion": the
    # angles and rates a test motion prescribes.  Published data (IERS, DE421, Hipparcos) count as
    # known; the judge reads them by itself.
    taken_as_given: tuple[Given, ...]
    # Answers have the rest beside the verdict; empty when the table is too broken to fly.
    sessions: Internal[tuple[SessionReport, ...]]
    limits: Internal[tuple[LimitMargin, ...]]
    keep_out: Internal[tuple[KeepOutMargin, ...]] = ()
    masks: Internal[tuple[MaskMargin, ...]] = ()
    exclusions: Internal[tuple[ExclusionMargin, ...]] = ()
    resources: Internal[tuple[Reserve, ...]] = ()
    gyros: Internal[tuple[GyroMargin, ...]] = ()
    slow_stretches: Internal[tuple[SlowStretch, ...]] = ()  # outside of sessions, by axis, by time

    @property
    def margins(self) -> dict[str, dict[str, LimitMargin]]:
        """By axis, then by limit."""
        told: dict[str, dict[str, LimitMargin]] = {}
        for margin in self.limits:
            told.setdefault(margin.axis, {})[margin.kind] = margin
        return told
