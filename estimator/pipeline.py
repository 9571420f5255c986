"""From images to the nadir, its uncertainty, and its agreement with the planned attitude."""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from estimator.check import Verdict, across_axes, check_attitude
from estimator.errors import InvalidCamera
from estimator.found import CameraReport, Nadir, VerticalEstimate
from estimator.images import Pixels, blue_is_sharp, prepare
from estimator.limb.geometry import Limb
from estimator.nadir.fit import Doubt, Fit
from estimator.nadir.prior import prior_of
from estimator.request import HorizonRequest
from estimator.search.horizon import find_horizon
from estimator.search.trial import Search, SearchResult
from estimator.surroundings import Surroundings
from planner.base.arrays import Array
from planner.world.frames.earth_orientation import earth_orientation_warnings
from planner.world.frames.time_scales import Instants


def estimate_vertical(images: Sequence[Pixels], request: HorizonRequest) -> VerticalEstimate:
    """Nadir in body axes from one image per camera, in the request's order.

    images: as `decode_image` returns them.  Raises InvalidCamera or InvalidImage when their
    number or sizes don't fit; whatever the pictures show, the answer is an estimate.
    """
    if len(images) != len(request.cameras):
        raise InvalidCamera(
            f"{len(images)} images for {len(request.cameras)} cameras; send one per camera",
            field="images",
        )
    blue = request.body.limb_height_km is None and all(map(blue_is_sharp, images))
    frames = [
        prepare(image, camera, f"images.{k}", blue=blue)
        for k, (image, camera) in enumerate(zip(images, request.cameras, strict=True))
    ]
    around = Surroundings(request.epoch, request.position, request.body)
    predicted = request.predicted
    search = Search(
        around=around,
        prior=replace(
            prior_of(around, None if predicted is None else predicted.sigma_deg, blue),
            rate_body_rad_s=tuple(np.deg2rad(request.rate_body_deg_s).tolist()),
            rate_sigma_rad_s=float(np.deg2rad(request.rate_sigma_deg_s)),
        ),
        c_body_from_itrf_predicted=(
            None if predicted is None else around.c_body_from_itrf(predicted)
        ),
    )
    return _answer(find_horizon(frames, request.cameras, search), request, search)


def _answer(horizon: SearchResult, request: HorizonRequest, search: Search) -> VerticalEstimate:
    cameras = tuple(
        CameraReport(
            name=part.view.camera.name,
            used=horizon.reason is None and part.used,
            reason=part.agreement.reason,
            explanation=part.agreement.reason and part.agreement.reason.value,
            arc_deg=float(np.rad2deg(part.agreement.arc_rad)),
            residual_px=None
            if math.isnan(part.agreement.residual_px)
            else part.agreement.residual_px,
            limb_px=part.points.xy_px[part.agreement.inlier],
        )
        for part in horizon.parts
    )
    if horizon.reason is not None:
        return VerticalEstimate(
            verdict=Verdict.NOT_OBSERVABLE, reason=horizon.reason, cameras=cameras
        )
    limb = search.around.limb
    geocentric = _nadir(horizon.fits, limb, limb.nadir_itrf)
    best = horizon.best
    check = None
    if request.predicted is not None and search.c_body_from_itrf_predicted is not None:
        check = check_attitude(
            geocentric.nadir_body,
            geocentric.covariance_rad2,
            search.c_body_from_itrf_predicted @ limb.nadir_itrf,
            float(np.deg2rad(request.predicted.sigma_deg)),
        )
    return VerticalEstimate(
        verdict=Verdict.MEASURED if check is None else check.verdict,
        geocentric=geocentric,
        geodetic=_nadir(horizon.fits, limb, limb.nadir_geodetic_itrf),
        limb_height_m=best.height_m,
        limb_height_sigma_m=float(np.sqrt(best.covariance_matrix[3, 3])),
        check=check,
        correction=None if check is None else check.correction(request.epoch),
        cameras=cameras,
        warnings=_warnings(request, cameras, horizon.fits),
    )


def _warnings(
    request: HorizonRequest, cameras: tuple[CameraReport, ...], fits: tuple[Fit, ...]
) -> tuple[str, ...]:
    warnings = []
    if request.predicted is None:
        warnings.append(
            "no attitude was predicted, so the heading is known only from the sunlight along the "
            "limb: geodetic nadir is measured, geocentric less surely, as its covariance says; "
            "give `predicted` to have both"
        )
    warnings += [
        f"the limb's shape speaks for {doubt.value}; nadir and covariance count on that"
        for doubt in Doubt
        if sum(one.weight for one in fits if one.doubt is doubt) > 0.5
    ]
    left_out = [camera.name for camera in cameras if not camera.used]
    if left_out:
        warnings.append(f"cameras left out: {', '.join(left_out)}")
    return (*warnings, *earth_orientation_warnings(Instants(request.epoch, np.zeros(1))))


def _nadir(fits: tuple[Fit, ...], limb: Limb, nadir_itrf: Array) -> Nadir:
    """A nadir and its covariance, over all headings tried by their weights."""
    mean_body = sum(one.weight * (one.c_body_from_itrf @ nadir_itrf) for one in fits)
    mean_body = np.asarray(mean_body) / np.linalg.norm(mean_body)
    axes_body = across_axes(mean_body)
    turns_itrf = np.cross(np.stack([*limb.axes_itrf, limb.nadir_itrf]), nadir_itrf)
    covariance_rad2 = np.zeros((2, 2))
    for one in fits:
        across_from_turns = -axes_body @ one.c_body_from_itrf @ turns_itrf.T
        off_rad = axes_body @ (one.c_body_from_itrf @ nadir_itrf)
        turns_rad2 = one.covariance_matrix[:3, :3]
        own_rad2 = across_from_turns @ turns_rad2 @ across_from_turns.T
        covariance_rad2 += one.careful_weight * (own_rad2 + np.outer(off_rad, off_rad))
    return Nadir(nadir_body=mean_body, axes_body=axes_body, covariance_rad2=covariance_rad2)
