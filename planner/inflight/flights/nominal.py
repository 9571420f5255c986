"""A session flown as planned: what its frames show, over time, and the head of its flights."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Array
from planner.inflight.flights.frames import FARTHEST_RAD
from planner.inflight.flights.outcomes import NominalSession
from planner.inflight.flights.request import FlightsRequest, MovingObject
from planner.inflight.flights.runs import fly_nominal
from planner.inflight.flights.scene import SessionScene
from planner.inflight.flights.summary import PlanFlights, SessionFlightsOut
from planner.inflight.simulation.gyros.report import worst_of
from planner.motion.pointing.frame import places_in_frame
from planner.planning.sessions.platforms.registry import mover_of
from planner.planning.sessions.uncertainty import OPTIONS as BUDGET_OPTIONS
from planner.world.frames.earth_orientation import c_itrf_from_eci
from planner.world.frames.geodesy import geodetic_from_itrf
from planner.world.frames.time_scales import Instants, utc_text
from planner.world.plan import FlightPlan
from planner.world.targets import EarthFixedTarget
from planner.world.targets.ground_sample import sample_along_m

# The ground around the target as frames show it: its scale, its turn, what moves on it.

_STEP_M = 1.0  # 0.5 arcsec from a low orbit, of which a double tells 1e-10
_STEP_RAD = 1e-6


@dataclass(frozen=True, kw_only=True, eq=False)
class GroundView:
    """At n instants of a session, flown as planned.

    ground_sample_across_m, ground_sample_along_m: of a pixel, across and along the lean of the
    line of sight, (n,); None for a target in the sky.
    north_rad: from the frame's first side towards its second, unwrapped, (n,); of a target in the
    sky the celestial north.  scale: what a metre to the east and to the north moves in the image
    (tangents), (n, 2, 2), the last index the way; None for a target in the sky.
    """

    ground_sample_across_m: Array | None
    ground_sample_along_m: Array | None
    north_rad: Array
    scale: Array | None


def ground_view(scene: SessionScene, t_s: Array, position: Array) -> GroundView:
    """Without errors.  t_s: (n,), on the scene's epoch.  position: (n, c), the platform's then.

    The scale is that of a plane through the target.
    """
    platform, target = scene.scenario.platform, scene.target
    instants = Instants(scene.instants.epoch_utc, t_s)
    states = scene.ephemeris.states(instants)
    seen = target.apparent(instants, states)
    q_base_from_eci = scene.flyer.q_base_from_eci(instants, states)

    def place(direction_eci: Array) -> Array:
        unit = direction_eci / np.linalg.norm(direction_eci, axis=1, keepdims=True)
        return places_in_frame(platform, position, q_base_from_eci.apply(unit))

    middle = place(seen.direction_eci)
    if not isinstance(target, EarthFixedTarget):
        pole = np.array([0.0, 0.0, 1.0])
        north = place(seen.direction_eci + _STEP_RAD * pole) - middle
        return GroundView(
            ground_sample_across_m=None,
            ground_sample_along_m=None,
            north_rad=np.unwrap(np.arctan2(north[:, 1], north[:, 0])),
            scale=None,
        )
    east_eci, north_eci = _ways_eci(target, instants)
    to_target_m = seen.range_m[:, None] * seen.direction_eci
    scale = np.stack(
        [(place(to_target_m + _STEP_M * way) - middle) / _STEP_M for way in (east_eci, north_eci)],
        axis=2,
    )
    sine = np.sin(seen.clearance_rad + math.radians(target.min_elevation_deg))
    return GroundView(
        ground_sample_across_m=seen.range_m * platform.camera.pixel_rad,
        ground_sample_along_m=sample_along_m(sine, seen.range_m, platform.camera.pixel_rad),
        north_rad=np.unwrap(np.arctan2(scale[:, 1, 1], scale[:, 0, 1])),
        scale=scale,
    )


def shift_px(view: GroundView, moving_object: MovingObject, pixel_rad: float) -> Array:
    """How far it has moved over the ground in the image from one frame to the next, (n,).

    At n instants, as the view is then; NaN for a target in the sky, beside which nothing drives.
    """
    if view.scale is None:
        return np.full(len(view.north_rad), np.nan)
    course_rad = math.radians(moving_object.course_deg)
    way = np.array([math.sin(course_rad), math.cos(course_rad)])
    moved = view.scale @ (moving_object.speed_m_s * moving_object.interval_s * way)
    return np.asarray(np.linalg.norm(moved, axis=1) / pixel_rad)


def _ways_eci(target: EarthFixedTarget, instants: Instants) -> tuple[Array, Array]:
    """East and north at the target, unit vectors (n, 3)."""
    latitude_rad, longitude_rad, _ = geodetic_from_itrf(target.r_target_itrf_m(instants))
    sin_lat, cos_lat = np.sin(latitude_rad), np.cos(latitude_rad)
    sin_lon, cos_lon = np.sin(longitude_rad), np.cos(longitude_rad)
    east = np.stack([-sin_lon, cos_lon, np.zeros_like(sin_lon)], axis=1)
    north = np.stack([-sin_lat * cos_lon, -sin_lat * sin_lon, cos_lat], axis=1)
    c = c_itrf_from_eci(instants)
    return np.einsum("nji,nj->ni", c, east), np.einsum("nji,nj->ni", c, north)


SHOWN_MAX = 300  # frames: what a picture has room for


def nominal_session(scene: SessionScene, moving_object: MovingObject | None) -> NominalSession:
    """Without errors of orbit, attitude and clock; drives and vibration do what theirs do."""
    frames, range_m, position, saturated_s, rate_error_rad_s, gyro_numbers = fly_nominal(scene)
    lost = frames.error_rad > FARTHEST_RAD
    position[lost] = scene.commanded(frames.begins_s[lost])
    view = ground_view(scene, frames.begins_s, position)
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
        rate_error_rad_s=columns(rate_error_rad_s),
        gyros=worst_of(gyro_numbers[None]),
        saturated_s=saturated_s,
    )


def flights_as_planned(
    plan: FlightPlan, scenes: Sequence[SessionScene], plan_id: str, asked: FlightsRequest
) -> PlanFlights:
    """What there is to tell before any disturbed run."""
    sessions, warnings = [], []
    for scene in scenes:
        budget = mover_of(plan.scenario).budget(scene.ephemeris, plan.table, scene.number)
        assert budget is not None  # of a target that can be seen
        nominal = nominal_session(scene, asked.moving_object)
        sessions.append(
            SessionFlightsOut(
                session=scene.number,
                label=plan.scenario.sessions[scene.number].label,
                budget_probability_in_frame=budget.probability_in_frame,
                nominal=nominal,
            )
        )
        saturated = zip(plan.scenario.platform.dof_names, nominal.saturated_s, strict=True)
        warnings += [
            f"session {scene.number + 1}: flown as planned, the drive of {axis} gives all its "
            f"torque for {saturated_s:.1f} s and falls behind its table; raise its drive's "
            "torque_reserve, or lower its friction or cable_tension_deg_s2, if the platform's are "
            "other than assumed"
            for axis, saturated_s in saturated
            if saturated_s > 0.0
        ]
    return PlanFlights(
        plan=plan_id,
        runs=asked.runs,
        seed=asked.seed,
        epoch=utc_text(plan.table.epoch_utc, 1),
        sessions=tuple(sessions),
        warnings=tuple(warnings),
    )
