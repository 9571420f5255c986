"""A session flown as planned, by nominal drives: what its frames show, over time."""

from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Array, Mask
from planner.inflight.flights.frames import FARTHEST_RAD
from planner.inflight.flights.ground_view import ground_view, shift_px
from planner.inflight.flights.request import MovingObject
from planner.inflight.flights.runs import Fly, fly_nominal
from planner.inflight.flights.scene import SessionScene
from planner.planning.sessions.uncertainty import OPTIONS as BUDGET_OPTIONS

SHOWN_MAX = 300  # frames: what a picture has room for


@dataclass(frozen=True, kw_only=True, eq=False)
class NominalSession:
    """Frames of a session; columns (n,) hold every `every`-th of them.

    frames, held, sharp: how many are taken, hold the target, and are sharp as well.
    t_s: when each shown begins, since the table's epoch.  error_rad, error_m: the largest angle
    between boresight and target, and that across the line of sight at the target; None in the sky.
    smear_px: while the shutter is open.  holds: whether the target is inside.
    north_rad: from the frame's first side towards its second.  turn_rad: the largest turn of the
    view from a frame to the next of all.  ground_sample_*_m: of a pixel; None in the sky.
    moving_object_ground_m, moving_object_px: how far what was asked about moves from one frame of
    its series to the next, at each frame shown; None without.  saturated_s: (2,), how long each
    drive gives all it has.  Where a target is lost beside the camera, the view is that of the
    commanded angles.
    """

    frames: int
    held: int
    sharp: int
    t_s: Array
    error_rad: Array
    error_m: Array | None
    smear_px: Array
    holds: Mask
    north_rad: Array
    turn_rad: float
    ground_sample_across_m: Array | None
    ground_sample_along_m: Array | None
    moving_object_ground_m: float | None
    moving_object_px: Array | None
    saturated_s: Array


def nominal_session(
    scene: SessionScene, fly: Fly, moving_object: MovingObject | None
) -> NominalSession:
    """Without errors of orbit, attitude and clock; the drives do what theirs do."""
    frames, range_m, angle_rad, saturated_s = fly_nominal(scene, fly)
    lost = frames.error_rad > FARTHEST_RAD
    angle_rad[lost] = scene.commanded_rad(frames.begins_s[lost])
    view = ground_view(scene, frames.begins_s, angle_rad)
    shown = slice(None, None, -(-len(frames.begins_s) // SHOWN_MAX))
    on_earth = bool((range_m < BUDGET_OPTIONS.range_max_m).all())
    moves = moving_object is not None and view.scale is not None

    def columns(numbers: Array | None) -> Array | None:
        return None if numbers is None else numbers[shown]

    return NominalSession(
        frames=len(frames.begins_s),
        held=int(frames.holds.sum()),
        sharp=int(frames.is_sharp.sum()),
        t_s=frames.begins_s[shown],
        error_rad=frames.error_rad[shown],
        error_m=(frames.error_rad * range_m)[shown] if on_earth else None,
        smear_px=frames.smear_px[shown],
        holds=frames.holds[shown],
        north_rad=view.north_rad[shown],
        turn_rad=float(np.abs(np.diff(view.north_rad)).max(initial=0.0)),
        ground_sample_across_m=columns(view.ground_sample_across_m),
        ground_sample_along_m=columns(view.ground_sample_along_m),
        moving_object_ground_m=moving_object.speed_m_s * moving_object.interval_s
        if moving_object and moves
        else None,
        moving_object_px=shift_px(view, moving_object, scene.scenario.platform.camera.pixel_rad)[
            shown
        ]
        if moving_object and moves
        else None,
        saturated_s=saturated_s,
    )
