"""What a horizon camera will see under a planned attitude: a usable limb, or why not."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from estimator.camera import HorizonCamera
from estimator.errors import Reason
from estimator.gates import MIN_ARC_OF_ALL_RAD, darkness, well_lit
from estimator.limb import LimbPoints, visible_limb
from estimator.nadir import fit
from estimator.prior import prior_of
from estimator.request import PredictedAttitude, Surroundings
from planner.arrays import Array

_COLUMNS = 48
_EDGE_PX = 0.1


@dataclass(frozen=True)
class HorizonPrediction:
    """One camera's view at one instant.

    reason: None when the frame can be used.  arc_rad: limb in frame, as azimuth about nadir;
    lit_arc_rad: what of it stands in daylight, away from the Sun.  sun_angle_rad: from the
    boresight to the Sun; sun_in_frame says whether it shines in.  limb_px: (n, 2), in order
    along the limb, of a daylight limb 17.5 km high (or the body's own).  sigma_rad: expected
    rms error of geocentric nadir from this camera alone; None when unusable.
    """

    camera: str
    reason: Reason | None
    arc_rad: float
    lit_arc_rad: float
    sun_angle_rad: float
    sun_in_frame: bool
    limb_px: Array
    sigma_rad: float | None


def predict_horizon(
    camera: HorizonCamera,
    around: Surroundings,
    q_body_from_eci: Rotation,
    attitude_sigma_deg: float = 0.5,
) -> HorizonPrediction:
    """What a camera sees from `around` with the body at one attitude."""
    q = q_body_from_eci.as_quat()
    predicted = PredictedAttitude(
        q_body_from_eci_xyzw=(float(q[0]), float(q[1]), float(q[2]), float(q[3])),
        sigma_deg=attitude_sigma_deg,
    )
    prior = prior_of(around, predicted, blue=False)
    limb = around.limb
    c_body_from_itrf: Array = q_body_from_eci.as_matrix() @ around.c_itrf_from_eci.T
    azimuth, step_rad = visible_limb(camera, limb, c_body_from_itrf, prior.height_m)
    thin = max(1, len(azimuth) // _COLUMNS)
    azimuth, step_rad = azimuth[::thin], step_rad * thin
    direction = limb.directions_itrf(azimuth, prior.height_m)
    ray_body = direction @ c_body_from_itrf.T
    lit = np.ones(len(azimuth), dtype=bool)
    daylight = around.body.limb_height_km is None
    if daylight and len(azimuth):
        lit = well_lit(limb, direction, prior.height_m, around.sun_itrf)
    sun_body = c_body_from_itrf @ around.sun_itrf
    lit_arc_rad = step_rad * float(np.sum(lit))
    reason = darkness(limb, around.sun_itrf) if daylight else None
    if len(azimuth) == 0:
        reason = Reason.NOT_IN_FRAME
    elif reason is None and lit_arc_rad < MIN_ARC_OF_ALL_RAD:
        short = step_rad * len(azimuth) < MIN_ARC_OF_ALL_RAD
        reason = Reason.SHORT_ARC if short else Reason.LOW_SUN
    sigma_rad = None
    pixel = camera.pixels(ray_body)
    if reason is None:
        points = _ideal_points(camera, ray_body, pixel, azimuth, lit, step_rad)
        # The scatter with which the limb follows the model, not the model, sets the accuracy.
        result = fit([points], limb, c_body_from_itrf, replace(prior, sun_itrf=None))
        sigma_rad = float(np.sqrt(result.covariance[0, 0] + result.covariance[1, 1]))
    return HorizonPrediction(
        camera=camera.name,
        reason=reason,
        arc_rad=step_rad * len(azimuth),
        lit_arc_rad=lit_arc_rad,
        sun_angle_rad=float(np.arccos(np.clip(sun_body @ camera.boresight_body, -1.0, 1.0))),
        sun_in_frame=sun_in_frame(camera, around, c_body_from_itrf),
        limb_px=pixel,
        sigma_rad=sigma_rad,
    )


def sun_in_frame(camera: HorizonCamera, around: Surroundings, c_body_from_itrf: Array) -> bool:
    """Whether the Sun's middle shines into the frame, not hidden by the Earth."""
    pixel = camera.pixels((c_body_from_itrf @ around.sun_itrf)[None])
    return bool(camera.sees(pixel)[0]) and not _hidden(around)


def _hidden(around: Surroundings) -> bool:
    """Whether the Earth stands before the Sun."""
    limb = around.limb
    return bool(
        around.sun_itrf @ limb.nadir_itrf > np.sqrt(1.0 - (limb.mean_radius_m / limb.range_m) ** 2)
    )


def _ideal_points(
    camera: HorizonCamera,
    ray_body: Array,
    pixel: Array,
    azimuth: Array,
    lit: NDArray[np.bool_],
    step_rad: float,
) -> LimbPoints:
    one = np.ones(len(azimuth))
    no = np.zeros(len(azimuth), dtype=bool)
    return LimbPoints(
        ray_body=ray_body,
        bent_body=camera.bends_body(ray_body, False),
        pixel=pixel,
        azimuth_rad=azimuth,
        found=lit,
        blocked=no,
        clipped=no,
        sigma_rad=_EDGE_PX * camera.rad_per_px * one,
        width_m=one,
        contrast=one,
        slope=one,
        behind=one,
        step_rad=step_rad,
        smooth_m=0.0,
    )
