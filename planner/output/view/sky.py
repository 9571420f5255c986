"""Directions in the sky, seen from the carrier, of a plan that looks at targets in space."""

import numpy as np

from planner.base.arrays import Array
from planner.output.view.columns import SkyDirection, SkyTrack
from planner.output.view.scene import PlanScene
from planner.world.targets import SkyTarget
from planner.world.targets.session_target import SessionTarget


def sky_track(scene: PlanScene, unknown: int) -> SkyTrack | None:
    """None where every target is on the Earth.

    unknown: number of the view's rows before those of the scene, which get NaN.
    """
    sessions = scene.plan.scenario.sessions
    if not any(isinstance(session.target, SkyTarget) for session in sessions):
        return None
    bodies_m = {body: scene.r_body_eci_m(body) for body in ("sun", "moon")}
    r_sat_eci_m = scene.states.r_sat_eci_m
    cone_axes_eci = (
        scene.q_base_from_eci.inv().apply(scene.keep_out_axis(cone)[0])
        for cone in scene.plan.scenario.slew.keep_out
    )
    return SkyTrack(
        boresight=_direction(scene.boresight_eci, unknown),
        nadir=_direction(-r_sat_eci_m, unknown),
        sun=_direction(bodies_m["sun"] - r_sat_eci_m, unknown),
        moon=_direction(bodies_m["moon"] - r_sat_eci_m, unknown),
        targets=tuple(
            _direction(_toward_eci(scene, session.target), unknown) for session in sessions
        ),
        keep_out=tuple(_direction(axis, unknown) for axis in cone_axes_eci),
    )


def _toward_eci(scene: PlanScene, target: SessionTarget) -> Array:
    """NaN of what isn't in space, (n, 3)."""
    if not isinstance(target, SkyTarget):
        return np.full_like(scene.boresight_eci, np.nan)
    return target.apparent(scene.instants, scene.states).direction_eci


def _direction(vector_eci: Array, unknown: int) -> SkyDirection:
    """Of vectors (n, 3) of any length."""
    x, y, z = np.concatenate([np.full((unknown, 3), np.nan), vector_eci]).T
    return SkyDirection(
        right_ascension_rad=np.arctan2(y, x) % (2.0 * np.pi),
        declination_rad=np.arctan2(z, np.hypot(x, y)),
    )
