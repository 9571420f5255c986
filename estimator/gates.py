"""Tests of whether what was fitted is the limb, or only looks like one."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from estimator.camera import HorizonCamera
from estimator.errors import Reason
from estimator.images import Frame
from estimator.limb import LimbPoints
from estimator.limb_geometry import Limb
from estimator.nadir import Fit
from estimator.request import Surroundings
from planner.arrays import Array

MIN_ARC_RAD = np.deg2rad(5.0)
MIN_ARC_OF_ALL_RAD = np.deg2rad(10.0)
# Less than this any blurred ellipse can match; only a predicted attitude vouches for less.
MIN_ARC_UNPREDICTED_RAD = np.deg2rad(30.0)
_INLIER_SIGMA = 3.4
_MIN_SHARE_OF_ARC = 0.35
_MIN_INLIERS = 0.60
# Rms residual over what the limb's roughness and the noise make: a wrong shape has more.
_MAX_MISFIT = 1.35
_MIN_CONTRAST = 0.35
# Daylight limbs, lens and smoothing included, make 7-14 km, also under a low Sun.
_MAX_WIDTH_M = 20e3
_MAX_WIDTH_PX = 3.0
_BLACK = 0.02
_LIT_BEHIND = 0.78
_SATURATED_SHARE = 0.85
# Directions along a vertical plane, against the limb's angle from nadir.
_SKY_AT, _RIM_AT, _DISC_AT = 1.03, 0.99, tuple(np.linspace(0.95, 0.3, 14))
_AS_DARK, _LOOKS = 0.04, 32
_DARK_SHARE = 0.25  # a dark solar panel may well hide a tenth
# A limb is as wide as air's scale height, 7.6 km; a camera's contrast curve has left 4.2 km of
# it, overexposure less.  A lens blurs a step as well, by some 0.76 px with the pixel itself.
_SHARPEST_M, _SHARPEST_CLIPPED_M, _LENS_PX = 3.2e3, 2.5e3, 0.76
_SUN_LOW_RAD = np.deg2rad(5.0)
_SUN_LEAST = np.sin(np.deg2rad(3.0))
_SUN_NEAR_RAD = np.deg2rad(30.0)
_HEIGHT_M = (2e3, 45e3)
# Under a low Sun little of the limb is lit and its height leans: what is left may be too vague.
_SUN_VAGUE = np.sin(np.deg2rad(20.0))
_VAGUE_RAD = np.deg2rad(0.15)


@dataclass(frozen=True)
class CameraFit:
    """How one camera's limb agrees with the fit.

    reason: None when it does.  arc_rad: azimuth over which the limb was found where the fit
    says.  residual_px: rms about the fit.  inlier (n,): over the camera's columns.
    """

    reason: Reason | None
    arc_rad: float
    residual_px: float
    inlier: NDArray[np.bool_]


def unusable_frame(frame: Frame) -> Reason | None:
    """What already the brightness of a frame rules out."""
    seen = frame.grey[::2, ::2][frame.usable[::2, ::2]]
    if seen.size < 64:
        return Reason.NO_HORIZON
    top = float(np.percentile(seen, 99.7))
    if top < max(_BLACK, 2.0 * frame.step):
        return Reason.ALL_BLACK
    if float(np.mean(seen > 0.985)) > _SATURATED_SHARE:
        return Reason.SATURATED
    return None


def judge_camera(
    points: LimbPoints, residual: Array, tolerance: Array, camera: HorizonCamera, reach_m: float
) -> CameraFit:
    """One camera's limb against the joint fit."""
    with np.errstate(invalid="ignore"):
        inlier = points.found & (np.abs(residual) < _INLIER_SIGMA * tolerance)
    open_columns = max(int(np.sum(~points.blocked)), 1)
    arc = float(np.sum(inlier)) * points.step_rad
    rms = float(np.sqrt(np.mean(residual[inlier] ** 2))) if inlier.any() else np.nan
    residual_px = rms / camera.rad_per_px
    share_found = np.sum(inlier) / max(int(np.sum(points.found)), 1)
    reason: Reason | None = None
    if points.arc_rad < MIN_ARC_RAD:
        reason = Reason.SHORT_ARC if len(points) else Reason.ELSEWHERE
    elif np.sum(points.found) < 0.1 * open_columns:
        reason = Reason.NO_HORIZON
    elif np.sum(inlier) < _MIN_SHARE_OF_ARC * open_columns or share_found < _MIN_INLIERS:
        reason = (
            Reason.RESIDUALS if np.sum(points.found) > 0.7 * open_columns else (Reason.BROKEN_ARC)
        )
    elif arc < MIN_ARC_RAD:
        reason = Reason.SHORT_ARC
    else:
        width_m = float(np.median(points.width_m[inlier]))
        pixel_m = camera.rad_per_px * reach_m
        misfit = float(np.sqrt(np.mean((residual[inlier] / tolerance[inlier]) ** 2)))
        if misfit > _MAX_MISFIT:
            reason = Reason.RESIDUALS
        elif width_m > max(_MAX_WIDTH_M, _MAX_WIDTH_PX * pixel_m):
            reason = Reason.BLURRED
        elif float(np.median(points.contrast[inlier])) < _MIN_CONTRAST:
            reason = Reason.NO_SKY
    return CameraFit(reason=reason, arc_rad=arc, residual_px=residual_px, inlier=inlier)


def is_glowing_layer(points: LimbPoints) -> bool:
    """Whether what was found is a shell of light with the night behind it.

    points: from a window that reaches 45 km inwards.  The sunlit Earth stays as bright behind
    its limb (0.85 and more, over dark ocean too); airglow falls to 0.5-0.75.
    """
    return bool(points.found.any()) and float(np.median(points.behind[points.found])) < _LIT_BEHIND


def is_dark_within(
    frame: Frame, camera: HorizonCamera, points: LimbPoints, around: Surroundings, fit: Fit
) -> bool:
    """Whether much of the disc behind the limb found is as dark as the sky.

    Past the limb lies the Earth, all the way down, and under a high Sun it is bright.
    """
    limb = around.limb
    if not points.found.any() or is_sun_vague(around):
        return False
    found = points.ray_body[points.found]
    edge = found[:: max(1, len(found) // _LOOKS)] @ fit.c_body_from_itrf
    angle = np.arccos(np.clip(edge @ limb.nadir_itrf, -1.0, 1.0))[:, None]
    across = (edge - np.cos(angle) * limb.nadir_itrf) / np.sin(angle)
    shares = np.array([_SKY_AT, _RIM_AT, *_DISC_AT])[:, None, None]
    ray = np.cos(shares * angle) * limb.nadir_itrf + np.sin(shares * angle) * across
    pixel = camera.pixels(ray.reshape(-1, 3) @ fit.c_body_from_itrf.T)
    seen = camera.sees(pixel)
    x, y = np.rint(pixel[seen]).astype(int).T
    level = np.full(len(pixel), np.nan)
    level[seen] = np.where(frame.usable[y, x], frame.grey[y, x], np.nan)
    sky, rim, *disc = level.reshape(len(shares), -1)
    known = np.isfinite(disc) & np.isfinite(sky) & np.isfinite(rim)
    with np.errstate(invalid="ignore"):
        dark = known & (disc < sky + _AS_DARK * (rim - sky))
    return bool(np.sum(dark) > _DARK_SHARE * max(int(np.sum(known)), 1))


def is_too_sharp(points: LimbPoints, inlier: NDArray[np.bool_], pixel_m: float) -> bool:
    """Whether the edge fitted rises faster than the light of air can; pixel_m: at the limb."""
    clipped = float(np.mean(points.clipped[inlier])) > 0.5
    least_m = _SHARPEST_CLIPPED_M if clipped else _SHARPEST_M
    own_m2 = float(np.median(points.width_m[inlier] ** 2)) - points.smooth_m**2
    return own_m2 < least_m**2 + (_LENS_PX * pixel_m) ** 2


def judge_height(fit: Fit, limb_height_m: float | None, sigma_m: float) -> Reason | None:
    """limb_height_m: None for the daylight limb, else what the request says it is."""
    if limb_height_m is None:
        low, high = _HEIGHT_M
    else:
        reach = 5.0 * sigma_m + 2e3
        low, high = limb_height_m - reach, limb_height_m + reach
    return None if low <= fit.height_m <= high else Reason.LIMB_HEIGHT


def judge_low_sun(result: Fit, around: Surroundings) -> Reason | None:
    """Whether a limb under a low Sun left the vertical too uncertain to be called measured."""
    sigma_rad = float(np.sqrt(result.covariance[0, 0] + result.covariance[1, 1]))
    return Reason.LOW_SUN if is_sun_vague(around) and sigma_rad > _VAGUE_RAD else None


def well_lit(
    limb: Limb, direction_itrf: Array, height_m: float, sun_itrf: Array
) -> NDArray[np.bool_]:
    """Which limb points along (n, 3) stand where the daylight limb's height is known.

    Under a lower Sun the limb is that of twilight; near the Sun it is that of dust.
    """
    elevation = limb.sun_elevation_rad(direction_itrf, height_m, sun_itrf)
    from_sun = np.arccos(np.clip(direction_itrf @ sun_itrf, -1.0, 1.0))
    return np.asarray((elevation > _SUN_LOW_RAD) & (from_sun > _SUN_NEAR_RAD))


def is_sun_vague(around: Surroundings) -> bool:
    """Whether the Sun at the craft is so low that much of its limb is not in full daylight."""
    return bool(-around.limb.nadir_itrf @ around.sun_itrf < _SUN_VAGUE)


def darkness(limb: Limb, sun_itrf: Array) -> Reason | None:
    """Why the Sun at a craft allows no daylight limb, or None."""
    sine = float(-limb.nadir_itrf @ sun_itrf)
    if sine > _SUN_LEAST:
        return None
    # At the far limb the Sun stands higher by the angle that the limb is away.
    lit_as_far_as = float(np.arccos(limb.mean_radius_m / limb.range_m))
    return Reason.LOW_SUN if np.arcsin(sine) > -lit_as_far_as else Reason.NIGHT_SIDE
