"""Tests of whether what was fitted is the limb, or only looks like one."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from estimator.camera import HorizonCamera
from estimator.errors import Reason
from estimator.images import Frame
from estimator.limb.points import LimbPoints
from estimator.nadir.fit import Fit
from estimator.request import Body
from estimator.surroundings import Surroundings
from planner.base.arrays import Array


@dataclass(frozen=True, kw_only=True)
class PlausibilityOptions:
    """What a limb must look like to be believed."""

    min_arc_rad: float = np.deg2rad(5.0)  # of one camera: less curves by no more than its noise
    min_arc_of_all_rad: float = np.deg2rad(10.0)  # of all cameras together
    # Less than this any blurred ellipse can match; only a predicted attitude vouches for less.
    min_arc_unpredicted_rad: float = np.deg2rad(30.0)
    inlier_sigma: float = 3.4  # of a point's own: farther off it is something else
    min_share_of_arc: float = 0.35  # of the columns in which a limb could be seen, to fit
    min_inliers: float = 0.60  # of the points found, to fit
    # Rms residual over what the limb's roughness and the noise make: a wrong shape has more.
    max_misfit: float = 1.35
    min_contrast: float = 0.35  # of disc against sky, at the median
    # Daylight limbs, lens and smoothing included, make 7-14 km, also under a low Sun.
    max_width_m: float = 20e3
    max_width_px: float = 3.0  # or so many pixels, where they are wide
    black: float = 0.02  # of full scale: with nothing brighter there is no limb
    # of the edge's brightness, behind it: a thin layer, as airglow, has dark behind it
    lit_behind: float = 0.78
    saturated_share: float = 0.85  # of a frame: with more nothing can be told
    # Directions along a vertical plane, against the limb's angle from nadir: in the sky,
    sky_at: float = 1.03
    rim_at: float = 0.99  # at the disc's rim,
    disc_at: tuple[float, ...] = tuple(np.linspace(0.95, 0.3, 14))  # and across the disc
    as_dark: float = 0.04  # as the sky, of the rim's brightness over it
    looks: int = 32  # such planes, evenly along the limb
    dark_share: float = 0.25  # a dark solar panel may well hide a tenth
    # A limb is as wide as air's scale height, 7.6 km; a camera's contrast curve has left 4.2 km
    # of it,
    sharpest_m: float = 3.2e3
    sharpest_clipped_m: float = 2.5e3  # overexposure less
    lens_px: float = 0.76  # a lens blurs a step as well, with the pixel itself
    # from the lens that is stated: an error of up to 1 %, any alike, is 1.73 at most
    most_bent_sigma: float = 2.5
    height_m: tuple[float, float] = (2e3, 45e3)  # daylight limbs lie between, overexposed ones too
    # 1-sigma of a tilt that the limb's lean leaves: with more the Sun must be known
    vague_rad: float = np.deg2rad(0.15)


OPTIONS = PlausibilityOptions()


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
    if top < max(OPTIONS.black, 2.0 * frame.step):
        return Reason.ALL_BLACK
    if float(np.mean(seen > 0.985)) > OPTIONS.saturated_share:
        return Reason.SATURATED
    return None


def judge_camera(
    points: LimbPoints,
    residual_rad: Array,
    tolerance_rad: Array,
    camera: HorizonCamera,
    around: Surroundings,
    height_m: float,
) -> CameraFit:
    """One camera's limb against the joint fit, which puts the limb at height_m."""
    with np.errstate(invalid="ignore"):
        inlier = points.found & (np.abs(residual_rad) < OPTIONS.inlier_sigma * tolerance_rad)
    rms_rad = float(np.sqrt(np.mean(residual_rad[inlier] ** 2))) if inlier.any() else np.nan
    reason = _gap_reason(points, inlier)
    if reason is None:
        misfit = np.sqrt(np.mean((residual_rad[inlier] / tolerance_rad[inlier]) ** 2))
        pixel_m = camera.rad_per_px * around.limb.touch_range_m(height_m)
        if misfit > OPTIONS.max_misfit:
            reason = Reason.RESIDUALS
        else:
            reason = _profile_reason(points, inlier, pixel_m, around.daylight)
    return CameraFit(
        reason=reason,
        arc_rad=float(np.sum(inlier)) * points.step_rad,
        residual_px=rms_rad / camera.rad_per_px,
        inlier=inlier,
    )


def _gap_reason(points: LimbPoints, inlier: NDArray[np.bool_]) -> Reason | None:
    """Why the columns that fit are too few."""
    if points.arc_rad < OPTIONS.min_arc_rad:
        return Reason.SHORT_ARC if len(points) else Reason.ELSEWHERE
    open_columns = max(int(np.sum(~points.blocked)), 1)
    found, fitting = int(np.sum(points.found)), int(np.sum(inlier))
    if found < 0.1 * open_columns:
        return Reason.NO_HORIZON
    if (
        fitting < OPTIONS.min_share_of_arc * open_columns
        or fitting / max(found, 1) < OPTIONS.min_inliers
    ):
        return Reason.RESIDUALS if found > 0.7 * open_columns else Reason.BROKEN_ARC
    return Reason.SHORT_ARC if fitting * points.step_rad < OPTIONS.min_arc_rad else None


def _profile_reason(
    points: LimbPoints, inlier: NDArray[np.bool_], pixel_m: float, daylight: bool
) -> Reason | None:
    """Why the edge that fits is no air before a dark sky; pixel_m: at the limb."""
    if np.median(points.width_m[inlier]) > max(OPTIONS.max_width_m, OPTIONS.max_width_px * pixel_m):
        return Reason.BLURRED
    if np.median(points.contrast[inlier]) < OPTIONS.min_contrast:
        return Reason.NO_SKY
    clipped = np.mean(points.clipped[inlier]) > 0.5
    least_m = OPTIONS.sharpest_clipped_m if clipped else OPTIONS.sharpest_m
    own_m2 = np.median(points.width_m[inlier] ** 2) - points.smooth_m**2
    too_sharp = own_m2 < least_m**2 + (OPTIONS.lens_px * pixel_m) ** 2
    return Reason.SHARP if daylight and too_sharp else None


def is_glowing_layer(points: LimbPoints) -> bool:
    """Whether what was found is a shell of light with the night behind it.

    points: from a window that reaches 45 km inwards.  The sunlit Earth stays nearly as bright
    behind its limb (0.85 and more; 0.7 over a dark sea in thin air); airglow falls to 0.5-0.75.
    """
    if not points.found.any():
        return False
    return bool(np.median(points.behind_ratio[points.found]) < OPTIONS.lit_behind)


def is_dark_within(
    frame: Frame, camera: HorizonCamera, points: LimbPoints, around: Surroundings, fit: Fit
) -> bool:
    """Whether much of the disc behind the limb found is as dark as the sky.

    Past the limb lies the Earth, all the way down, and under a high Sun it is bright.
    """
    limb = around.limb
    if not points.found.any() or around.is_sun_vague:
        return False
    found_body = points.ray_body[points.found]
    edge_itrf = found_body[:: max(1, len(found_body) // OPTIONS.looks)] @ fit.c_body_from_itrf
    angle_rad = np.arccos(np.clip(edge_itrf @ limb.nadir_itrf, -1.0, 1.0))[:, None]
    across_itrf = (edge_itrf - np.cos(angle_rad) * limb.nadir_itrf) / np.sin(angle_rad)
    looks_rad = (
        np.array([OPTIONS.sky_at, OPTIONS.rim_at, *OPTIONS.disc_at])[:, None, None] * angle_rad
    )
    ray_itrf = np.cos(looks_rad) * limb.nadir_itrf + np.sin(looks_rad) * across_itrf
    xy_px = camera.pixels(ray_itrf.reshape(-1, 3) @ fit.c_body_from_itrf.T)
    seen = camera.sees(xy_px)
    x, y = np.rint(xy_px[seen]).astype(int).T
    level = np.full(len(xy_px), np.nan)
    level[seen] = np.where(frame.usable[y, x], frame.grey[y, x], np.nan)
    sky, rim, *disc = level.reshape(len(looks_rad), -1)
    known = np.isfinite(disc) & np.isfinite(sky) & np.isfinite(rim)
    with np.errstate(invalid="ignore"):
        dark = known & (disc < sky + OPTIONS.as_dark * (rim - sky))
    return bool(np.sum(dark) > OPTIONS.dark_share * max(int(np.sum(known)), 1))


def judge_height(result: Fit, body: Body) -> Reason | None:
    """Whether lens and limb's height are those that daylight or the request allow."""
    if result.bent_sigma > OPTIONS.most_bent_sigma:
        return Reason.RESIDUALS
    low_m, high_m = OPTIONS.height_m
    if body.limb_height_km is not None and body.limb_height_sigma_km is not None:
        reach_m = 5.0 * (body.limb_height_sigma_km * 1e3) + 2e3
        middle_m = body.limb_height_km * 1e3
        low_m, high_m = middle_m - reach_m, middle_m + reach_m
    return None if low_m <= result.height_m <= high_m else Reason.LIMB_HEIGHT


def judge_low_sun(result: Fit, around: Surroundings) -> Reason | None:
    """Whether a limb under a low Sun left the vertical too uncertain to be called measured."""
    vague = around.daylight and around.is_sun_vague and result.tilt_sigma_rad > OPTIONS.vague_rad
    return Reason.LOW_SUN if vague else None
