"""Sensors of two axes, and the attitude error and drives that a flight shows, for the next plan.

Angles and rates of the axes are told relative to the carrier: by themselves they say nothing of
its attitude.  A measured rotation (of a horizon estimate) says where the target was besides; a
target found in the frame says how far axes and attitude were off together, of which the axes'
part is known.  What is left then is the attitude's, but for errors of the orbit, the mount and
the target's own place, which no frame tells apart.

The drives' parameters are those with which the simulator makes the same of the table.  A delay
that the drives share looks like a clock that is ahead; here it is taken to be what the platform's
own drives have, and the rest the clock's.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from typing import TYPE_CHECKING

import numpy as np

from planner.base.arrays import Array
from planner.base.errors import InvalidInput
from planner.base.rotation import Rotation
from planner.inflight.simulation.candidates import IDENTIFIABLE
from planner.inflight.simulation.flight import fly
from planner.inflight.simulation.identification import identify
from planner.inflight.telemetry.alignment import AlignedColumn, align
from planner.inflight.telemetry.following import Followed, MotionBounds, PlannedMotion
from planner.inflight.telemetry.platforms.sensors import (
    ClockAssumptions,
    Parameter,
    PlatformFound,
    PointingParts,
    ReadColumns,
    ToldColumn,
)
from planner.inflight.telemetry.samples import (
    ColumnContract,
    ColumnMeaning,
    ImageOffset,
    TelemetryColumn,
    angle_meanings,
    other_units,
)
from planner.motion.pointing.frame import frame_axes
from planner.world.attitude.corrections import AttitudeCorrection
from planner.world.frames.time_scales import Instants, elapsed_s, utc_text
from planner.world.plan import FlightPlan
from planner.world.platforms import AxisDrive, PlatformGeometry, TwoAxisPlatform, definition_of
from planner.world.rules.two_axis import axes_of

if TYPE_CHECKING:
    from planner.inflight.telemetry.compare import Comparison


@dataclass(frozen=True, kw_only=True)
class NextPlanOptions:
    """What is unknown of an image, and how far parameters of drives are sought."""

    unmeasured_deg2: float = 32_400.0  # 180 deg: the turn about the line of sight
    near_s: float = 2.0  # of a sample, for the axes' error to be known
    table_max_s: float = 600.0  # flown about a hundred times, 0.3 s each
    samples_max: int = 20_000  # more are thinned: they tell no more of a drive
    room: float = 1.1  # above the fastest command at which an axis was seen to stick


OPTIONS = NextPlanOptions()
_LEAST_RATE = "rate_min_deg_s"


class AxisSensors:
    """Angles and rates of both axes; what they were sent as is what is compared."""

    assumes = ClockAssumptions(
        earliest="one axis is on time; bias, gain, friction and lag of each are estimated beside "
        "it",
        equally_late="both axes are equally late; bias, gain and friction are estimated beside it",
        ideal="no friction, no lag and gains of one, none of which is seen; each bias is estimated",
    )

    def __init__(self, plan: FlightPlan) -> None:
        self.plan = plan
        names = axes_of(plan.scenario).axis_names
        self.motions = tuple(PlannedMotion(plan.table, axis) for axis in range(len(names)))
        meanings: dict[str, ColumnMeaning] = {}
        for axis, name in enumerate(names):
            meanings |= angle_meanings(f"{name}_{{}}", axis, "angle")
            meanings |= angle_meanings(f"{name}_rate_{{}}_s", axis, "rate")
        wanted = [f"{name}_{one}" for name in names for one in ("deg", "rate_deg_s")]
        self.contract = ColumnContract(
            meanings=meanings,
            wanted=f"{', '.join(wanted)}, {other_units()}",
            least=f"an angle or a rate of {' or '.join(names)}",
            first=(f"{names[0]}_deg", "is required, or a column of another axis or of rates"),
            guesses=tuple((f"{name}_deg", name.lower()) for name in names),
        )

    @property
    def bounds(self) -> tuple[MotionBounds, ...]:
        """Stops, and the largest rates and accelerations."""
        return tuple(
            MotionBounds(
                angle_rad=(one.angle_min_rad, one.angle_max_rad),
                rate_rad_s=one.rate_max_rad_s,
                acceleration_rad_s2=one.acceleration_max_rad_s2,
            )
            for one in axes_of(self.plan.scenario).axis_limits
        )

    def read(self, columns: Sequence[TelemetryColumn], tag_s: Array) -> ReadColumns:
        """As they are."""
        names = self.plan.table.dof_names
        told = [
            ToldColumn(name=one.name, axis=names[read.axis], kind=read.kind, unit=read.unit)
            for one in columns
            for read in [one.meaning]
        ]
        return ReadColumns(columns, tuple(told))

    def pointing(
        self,
        comparison: Comparison,
        corrections: Sequence[AttitudeCorrection],
        image_offsets: Sequence[ImageOffset],
    ) -> list[PointingParts]:
        """Of each."""
        followed = [axis.followed for axis in comparison.axes]
        pointing = [
            from_rotation(self.plan, followed, one, f"corrections.{number}")
            for number, one in enumerate(corrections)
        ]
        pointing += [
            from_image(self.plan, followed, one, f"image_offsets.{number}")
            for number, one in enumerate(image_offsets)
        ]
        return sorted(pointing, key=lambda parts: parts.at_utc)

    def found(self, comparison: Comparison, names: Sequence[str]) -> PlatformFound | None:
        """The drives' parameters, and the least rates of axes that stuck."""
        return platform_found(comparison, names)


def from_rotation(
    plan: FlightPlan, followed: Sequence[Followed], measured: AttitudeCorrection, field: str
) -> PointingParts:
    """Of a horizon estimate of the same session, its turn against the law without corrections."""
    t_s = _time_within(plan, measured.epoch, field)
    platform = axes_of(plan.scenario)
    planned_rad, off_rad = _angles(plan, followed, t_s)
    sides, boresight = _frame(platform, planned_rad)
    axes = _axes_part(platform, planned_rad, off_rad, sides)
    known_rad = _reckoned_turn_rad(plan, measured.epoch)
    turn_body = (
        Rotation.from_rotvec(np.deg2rad(measured.turn_body_deg))
        * Rotation.from_rotvec(known_rad).inv()
    )
    mount = platform.q_platform_from_body
    shift = sides @ np.cross(mount.apply(turn_body.as_rotvec()), boresight)
    # The shift along a side is the turn about the other: e . (w x b) = w . (b x e).
    by_turn = mount.inv().apply(np.cross(boresight, sides))
    covariance_rad2 = np.deg2rad(np.deg2rad(measured.covariance_deg2))
    sigma = np.sqrt(np.einsum("ij,jk,ik->i", by_turn, covariance_rad2, by_turn))
    return PointingParts(
        at_utc=measured.epoch,
        session=_session_at(plan, t_s),
        measured="rotation",
        axes_rad=_pair(axes),
        attitude_rad=_two(shift),
        attitude_sigma_rad=_two(sigma),
        target_rad=None if axes is None else _two(shift - axes),
        correction=measured,
    )


def from_image(
    plan: FlightPlan, followed: Sequence[Followed], found: ImageOffset, field: str
) -> PointingParts:
    """Of the target in the frame; raises InvalidInput where no target is held or no axis known."""
    t_s = _time_within(plan, found.epoch, field)
    session = _session_at(plan, t_s)
    if session is None:
        raise InvalidInput(
            f"no target is held at {utc_text(found.epoch)}, so that a frame taken then says "
            "nothing; give frames of a session",
            field=f"{field}.epoch",
        )
    platform = axes_of(plan.scenario)
    planned_rad, off_rad = _angles(plan, followed, t_s)
    sides, boresight = _frame(platform, planned_rad)
    axes = _axes_part(platform, planned_rad, off_rad, sides)
    if axes is None:
        raise InvalidInput(
            f"there are no angles of both axes within {OPTIONS.near_s:g} s of "
            f"{utc_text(found.epoch)}, so that what the frame shows can't be told from what the "
            "axes did; leave it out",
            field=f"{field}.epoch",
        )
    in_frame = np.tan(np.deg2rad(found.offset_deg))
    shift = in_frame + axes
    # w x b = shift has the smallest solution w = b x shift.
    turn_platform = np.cross(boresight, shift @ sides)
    mount = platform.q_platform_from_body
    total = Rotation.from_rotvec(mount.inv().apply(turn_platform)) * Rotation.from_rotvec(
        _reckoned_turn_rad(plan, found.epoch)
    )
    line_body = mount.inv().apply(boresight)
    across = np.eye(3) - np.outer(line_body, line_body)
    along = np.outer(line_body, line_body)
    covariance = found.sigma_deg**2 * across + OPTIONS.unmeasured_deg2 * along
    covariance = 0.5 * (covariance + covariance.T)
    x, y, z = np.rad2deg(total.as_rotvec()).tolist()
    rows = [tuple(row) for row in covariance.tolist()]
    return PointingParts(
        at_utc=found.epoch,
        session=session,
        measured="image",
        axes_rad=_pair(axes),
        attitude_rad=_two(shift),
        attitude_sigma_rad=(np.deg2rad(found.sigma_deg),) * 2,
        target_rad=_two(in_frame),
        correction=AttitudeCorrection(
            epoch=found.epoch,
            turn_body_deg=(x, y, z),
            covariance_deg2=(rows[0], rows[1], rows[2]),
        ),
    )


def _time_within(plan: FlightPlan, epoch_utc: datetime, field: str) -> float:
    t_s, stop_s = elapsed_s(epoch_utc, plan.table.epoch_utc), float(plan.table.t_s[-1])
    if not 0.0 <= t_s <= stop_s:
        raise InvalidInput(
            f"lies outside the plan, which runs from {utc_text(plan.table.epoch_utc)} for "
            f"{stop_s:g} s, not at {utc_text(epoch_utc)}",
            field=f"{field}.epoch",
        )
    return t_s


def _session_at(plan: FlightPlan, t_s: float) -> int | None:
    epoch_utc = plan.table.epoch_utc
    for segment in plan.segments:
        start_s, stop_s = (elapsed_s(at, epoch_utc) for at in (segment.start_utc, segment.stop_utc))
        if segment.kind == "track" and start_s <= t_s <= stop_s:
            return segment.session
    return None


def _angles(
    plan: FlightPlan, followed: Sequence[Followed], t_s: float
) -> tuple[Array, Array | None]:
    """Planned angles and what the axes were off them, (1, 2) each; None without both."""
    count = len(axes_of(plan.scenario).axis_names)
    planned_rad = np.array(
        [[PlannedMotion(plan.table, axis).angle_rad(np.array([t_s]))[0] for axis in range(count)]]
    )
    off_rad = np.full((1, count), np.nan)
    for one in followed:
        is_near = np.min(np.abs(one.t_s - t_s)) <= OPTIONS.near_s
        if one.basis == "angles" and is_near:
            off_rad[0, one.motion.axis] = np.interp(t_s, one.t_s, one.error_rad)
    return planned_rad, off_rad if np.isfinite(off_rad).all() else None


def _frame(platform: PlatformGeometry, position: Array) -> tuple[Array, Array]:
    """The frame's two sides in the base's axes, (2, 3), and the boresight, (3,)."""
    [sides] = frame_axes(platform, position)
    return sides, np.cross(*sides)


def _axes_part(
    platform: PlatformGeometry, planned_rad: Array, off_rad: Array | None, side_directions: Array
) -> Array | None:
    if off_rad is None:
        return None
    flown, planned = (_frame(platform, at)[1] for at in (planned_rad + off_rad, planned_rad))
    return np.asarray(side_directions @ (flown - planned))


def _reckoned_turn_rad(plan: FlightPlan, epoch_utc: datetime) -> Array:
    """By which the plan's own corrections had turned the law then, (3,)."""
    instants = Instants(epoch_utc, np.zeros(1))
    return np.asarray(plan.scenario.law.turn_rad(instants)[0])


def _pair(value: Array | None) -> tuple[float, float] | None:
    return None if value is None else _two(value)


def _two(value: Array) -> tuple[float, float]:
    return float(value[0]), float(value[1])


def platform_found(comparison: Comparison, names: Sequence[str]) -> PlatformFound | None:
    """With the drives' parameters of these names, `axis.field`; None where nothing was found.

    Raises InvalidInput for names and plans that can't be identified.
    """
    platform = axes_of(comparison.plan.scenario)
    found: tuple[Parameter, ...] = ()
    if names:
        found, drives = _drives(comparison, names)
        platform = replace(platform, drives=drives)
    least = _least_rates(comparison)
    if not found and not least:
        return None
    limits = list(platform.axis_limits)
    for one in least:
        axis = platform.axis_names.index(one.name.rpartition(".")[0])
        limits[axis] = replace(limits[axis], rate_min_rad_s=math.radians(one.found))
    return PlatformFound(
        parameters=(*found, *least),
        platform=definition_of(platform.with_limits((limits[0], limits[1]))),
    )


def _least_rates(comparison: Comparison) -> list[Parameter]:
    """Of axes that stuck and slipped at commands that the platform takes for smooth."""
    found = []
    for axis in comparison.axes:
        motion = axis.followed.motion
        limits = axes_of(comparison.plan.scenario).axis_limits[motion.axis]
        fastest_rad_s = max((one.rate_rad_s for one in axis.stick_slip), default=0.0)
        if limits.rate_min_rad_s < fastest_rad_s < limits.rate_max_rad_s / OPTIONS.room:
            found.append(
                Parameter(
                    name=f"{axis.name}.{_LEAST_RATE}",
                    planned=math.degrees(limits.rate_min_rad_s),
                    found=math.degrees(OPTIONS.room * fastest_rad_s),
                    sigma=None,
                )
            )
    return found


def _drives(
    comparison: Comparison, names: Sequence[str]
) -> tuple[tuple[Parameter, ...], tuple[AxisDrive, AxisDrive]]:
    plan, platform = comparison.plan, axes_of(comparison.plan.scenario)
    _require_identifiable(names, platform, plan.table.t_s[-1])
    clean = comparison.clean
    t_s = comparison.alignment.t_s(clean.tag_s) + _own_delay_s(comparison)
    inside = (t_s >= 0.0) & (t_s <= plan.table.t_s[-1])
    rows = np.flatnonzero(inside)[:: -(-int(inside.sum()) // OPTIONS.samples_max)]
    angle_rad, rate_rad_s = (
        column[rows] if np.isfinite(column[rows]).any() else None
        for column in (clean.angle_rad, clean.rate_rad_s)
    )
    try:
        found = identify(plan.table, platform, t_s[rows], angle_rad, rate_rad_s, names)
    except ValueError as fault:
        raise InvalidInput(f"can't be found: {fault}", field="identify") from None
    sigma = np.sqrt(np.diag(found.covariance_parameters))
    parameters = tuple(
        Parameter(
            name=name,
            planned=_value(platform, name),
            found=float(value),
            sigma=float(error),
        )
        for name, value, error in zip(found.names, found.parameters, sigma, strict=True)
    )
    return parameters, found.drives


def _require_identifiable(names: Sequence[str], platform: TwoAxisPlatform, table_s: float) -> None:
    for number, name in enumerate(names):
        axis, _, field = name.rpartition(".")
        if axis not in platform.axis_names or field not in IDENTIFIABLE:
            raise InvalidInput(
                f"{name[:60]!r} is no parameter that a flight shows; name an axis "
                f"({', '.join(platform.axis_names)}), a dot and one of {', '.join(IDENTIFIABLE)}",
                field=f"identify.{number}",
            )
        if name in names[:number]:
            raise InvalidInput(f"{name!r} is named twice", field=f"identify.{number}")
    if table_s > OPTIONS.table_max_s:
        raise InvalidInput(
            f"parameters are found of plans up to {OPTIONS.table_max_s:g} s, not {table_s:g}: "
            "leave identify out, or compare with a plan of one session",
            field="identify",
        )


def _own_delay_s(comparison: Comparison) -> float:
    """By how much the platform's drives are late by themselves, as telemetry would show it."""
    table, platform = comparison.plan.table, axes_of(comparison.plan.scenario)
    flown = fly(table, platform)
    told = {one.followed.motion.axis for one in comparison.axes}
    channels = [
        AlignedColumn(
            motion=PlannedMotion(table, axis),
            kind="angle",
            tag_s=flown.t_s,
            value=flown.measured_angle_rad[:, axis],
        )
        for axis in sorted(told)
    ]
    return align(channels, 0.0, len(platform.axis_names)).offset_s.value


def _value(platform: TwoAxisPlatform, name: str) -> float:
    axis, _, field = name.rpartition(".")
    return float(getattr(platform.drives[platform.axis_names.index(axis)], field))
