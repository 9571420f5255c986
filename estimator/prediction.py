"""Predicted sight of a horizon camera under a planned attitude: a usable limb, or why not."""

from dataclasses import replace

import numpy as np

from estimator.camera import HorizonCamera
from estimator.errors import Reason
from estimator.found import HorizonView
from estimator.limb.points import ideal_points
from estimator.limb.projection import LimbProjection
from estimator.nadir.fit import fit
from estimator.nadir.prior import prior_of
from estimator.search.plausibility import OPTIONS as PLAUSIBILITY_OPTIONS
from estimator.surroundings import Surroundings
from planner.base.rotation import Rotation

_COLUMNS = 48


def predict_horizon(
    camera: HorizonCamera,
    around: Surroundings,
    q_body_from_eci: Rotation,
    attitude_sigma_deg: float = 0.5,
) -> HorizonView:
    """What a camera sees from `around` with the body at one attitude."""
    prior = prior_of(around, attitude_sigma_deg, blue=False)
    limb = around.limb
    c_body_from_itrf = q_body_from_eci.as_matrix() @ around.c_itrf_from_eci.T
    projection = LimbProjection(camera, limb, c_body_from_itrf, prior.height_m)
    azimuth_rad, step_rad = projection.visible()
    thin = max(1, len(azimuth_rad) // _COLUMNS)
    azimuth_rad, step_rad = azimuth_rad[::thin], step_rad * thin
    lit = np.ones(len(azimuth_rad), dtype=bool)
    if around.daylight and len(azimuth_rad):
        lit = around.well_lit(azimuth_rad, prior.height_m)
    points = ideal_points(camera, projection.ray_body(azimuth_rad), azimuth_rad, lit, step_rad)
    lit_arc_rad = step_rad * float(np.sum(lit))
    reason = around.darkness() if around.daylight else None
    if len(points) == 0:
        reason = Reason.NOT_IN_FRAME
    elif reason is None and lit_arc_rad < PLAUSIBILITY_OPTIONS.min_arc_of_all_rad:
        short = points.arc_rad < PLAUSIBILITY_OPTIONS.min_arc_of_all_rad
        reason = Reason.SHORT_ARC if short else Reason.LOW_SUN
    sigma_rad = None
    if reason is None:
        # The scatter with which the limb follows the model, not the model, sets the accuracy.
        result = fit([points], limb, c_body_from_itrf, replace(prior, sun_itrf=None))
        sigma_rad = result.tilt_sigma_rad
    sun_cosine = c_body_from_itrf @ around.sun_itrf @ camera.boresight_body
    return HorizonView(
        at_utc=around.epoch,
        camera=camera.name,
        usable=reason is None,
        reason=reason,
        explanation=reason and reason.value,
        limb_in_frame=points.arc_rad > 0.0,
        arc_rad=points.arc_rad,
        lit_arc_rad=lit_arc_rad,
        lit=lit_arc_rad > 0.0,
        sun_angle_rad=float(np.arccos(np.clip(sun_cosine, -1.0, 1.0))),
        sun_in_frame=around.is_sun_in_frame(camera, c_body_from_itrf),
        limb_px=points.xy_px,
        sigma_rad=sigma_rad,
    )
