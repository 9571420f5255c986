"""The carrier's attitude error from measurements of the horizon or the target beside the axes.

Angles and rates of the axes are told relative to the carrier: by themselves they say nothing of
its attitude.  A measured rotation (of a horizon estimate) says where the target was besides; a
target found in the frame says how far axes and attitude were off together, of which the axes'
part is known.  What is left then is the attitude's, but for errors of the orbit, the mount and
the target's own place, which no frame tells apart.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Literal

import numpy as np

from planner.base.arrays import Array
from planner.base.errors import InvalidInput
from planner.base.rotation import Rotation
from planner.inflight.telemetry.following import Followed
from planner.inflight.telemetry.motion import PlannedMotion
from planner.inflight.telemetry.request import ImageOffset
from planner.motion.pointing.angles import boresight_platform, carried_axes
from planner.world.attitude.corrections import AttitudeCorrection
from planner.world.frames.time_scales import Instants, elapsed_s, utc_text
from planner.world.plan import FlightPlan
from planner.world.platforms import TwoAxisPlatform

UNMEASURED_DEG2 = 32_400.0  # 180 deg: the turn about the line of sight
_NEAR_S = 2.0  # of a sample, for the axes' error to be known


@dataclass(frozen=True, kw_only=True)
class PointingParts:
    """How far the target was from the frame's centre and why, along the frame's two sides.

    axes_rad: the boresight's error by the axes alone, None where there is no telemetry of both.
    attitude_rad: by which the attitude moved the target, beyond what the plan reckoned with.
    attitude_sigma_rad: of each.
    target_rad: of the target in the frame: attitude less axes; None without axes.
    correction: the attitude against its law without corrections, as a plan takes it.
    """

    epoch_utc: datetime
    session: int | None
    measured: Literal["rotation", "image"]
    axes_rad: tuple[float, float] | None
    attitude_rad: tuple[float, float]
    attitude_sigma_rad: tuple[float, float]
    target_rad: tuple[float, float] | None
    correction: AttitudeCorrection


def from_rotation(
    plan: FlightPlan, followed: Sequence[Followed], measured: AttitudeCorrection, field: str
) -> PointingParts:
    """Of a horizon estimate of the same session, its turn against the law without corrections."""
    t_s = _time_within(plan, measured.epoch, field)
    platform = plan.scenario.platform
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
        epoch_utc=measured.epoch,
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
    platform = plan.scenario.platform
    planned_rad, off_rad = _angles(plan, followed, t_s)
    sides, boresight = _frame(platform, planned_rad)
    axes = _axes_part(platform, planned_rad, off_rad, sides)
    if axes is None:
        raise InvalidInput(
            f"there are no angles of both axes within {_NEAR_S:g} s of {utc_text(found.epoch)}, so "
            "that what the frame shows can't be told from what the axes did; leave it out",
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
    covariance = found.sigma_deg**2 * across + UNMEASURED_DEG2 * np.outer(line_body, line_body)
    covariance = 0.5 * (covariance + covariance.T)
    x, y, z = np.rad2deg(total.as_rotvec()).tolist()
    rows = [tuple(row) for row in covariance.tolist()]
    return PointingParts(
        epoch_utc=found.epoch,
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
    count = len(plan.scenario.platform.axis_names)
    planned_rad = np.array(
        [[PlannedMotion(plan.table, axis).angle_rad(np.array([t_s]))[0] for axis in range(count)]]
    )
    off_rad = np.full((1, count), np.nan)
    for one in followed:
        is_near = np.min(np.abs(one.t_s - t_s)) <= _NEAR_S
        if one.basis == "angles" and is_near:
            off_rad[0, one.motion.axis] = np.interp(t_s, one.t_s, one.error_rad)
    return planned_rad, off_rad if np.isfinite(off_rad).all() else None


def _frame(platform: TwoAxisPlatform, angle_rad: Array) -> tuple[Array, Array]:
    """The frame's two sides in the platform frame, (2, 3), and the boresight, (3,)."""
    [boresight] = boresight_platform(platform, angle_rad)
    [inner] = carried_axes(platform, angle_rad)[1]
    along = inner - (inner @ boresight) * boresight
    along /= np.linalg.norm(along)
    across = np.cross(boresight, along)
    c, s = np.cos(platform.frame_turn_rad), np.sin(platform.frame_turn_rad)
    return np.array([c * along + s * across, c * across - s * along]), boresight


def _axes_part(
    platform: TwoAxisPlatform, planned_rad: Array, off_rad: Array | None, side_directions: Array
) -> Array | None:
    if off_rad is None:
        return None
    [flown] = boresight_platform(platform, planned_rad + off_rad)
    [planned] = boresight_platform(platform, planned_rad)
    return np.asarray(side_directions @ (flown - planned))


def _reckoned_turn_rad(plan: FlightPlan, epoch_utc: datetime) -> Array:
    """By which the plan's own corrections had turned the law then, (3,)."""
    instants = Instants(epoch_utc, np.zeros(1))
    return np.asarray(plan.scenario.attitude.turn_rad(instants)[0])


def _pair(value: Array | None) -> tuple[float, float] | None:
    return None if value is None else _two(value)


def _two(value: Array) -> tuple[float, float]:
    return float(value[0]), float(value[1])
