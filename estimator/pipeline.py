"""From images to the nadir, its uncertainty, and its agreement with the planned attitude."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from estimator.check import AttitudeCheck, Verdict, across_axes, check_attitude
from estimator.errors import InvalidCamera, Reason
from estimator.explain import explain_reasons
from estimator.images import Pixels, blue_is_sharp, prepare
from estimator.limb_geometry import Limb
from estimator.nadir import Fit
from estimator.prior import predicted_c_body_from_itrf, prior_of
from estimator.request import HorizonRequest, Surroundings
from estimator.search import FoundHorizon, Search, find_horizon, look
from planner.arrays import Array
from planner.frames.earth_orientation import earth_orientation_warning
from planner.frames.time_scales import Instants


@dataclass(frozen=True)
class CameraReport:
    """One camera's part: whether it was used, why not, its arc and its rms residual."""

    name: str
    used: bool
    reason: Reason | None
    arc_deg: float
    residual_px: float
    limb_px: Array


@dataclass(frozen=True)
class Nadir:
    """One definition of nadir in body axes.

    covariance_rad2: (2, 2) on the unit vectors `axes_body` (2, 3) across the nadir.
    """

    nadir_body: Array
    axes_body: Array
    covariance_rad2: Array

    @property
    def sigma_rad(self) -> float:
        """Rms of the angle between this nadir and the true one."""
        return float(np.sqrt(np.trace(self.covariance_rad2)))


@dataclass(frozen=True)
class VerticalEstimate:
    """The answer to a HorizonRequest.

    geocentric and geodetic: None when the verdict is `not_observable`, for `reason`.
    Without a predicted attitude the limb measures geodetic nadir; the heading, and so geocentric
    nadir up to 0.19 deg beside it, comes from the sunlight along the limb: to some 10 deg where
    colour is kept pixel by pixel, hardly in grey.  The covariance holds what is left open.
    """

    verdict: Verdict
    reason: Reason | None
    geocentric: Nadir | None
    geodetic: Nadir | None
    limb_height_m: float | None
    limb_height_sigma_m: float | None
    check: AttitudeCheck | None
    cameras: tuple[CameraReport, ...]
    warnings: tuple[str, ...]


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
    c_predicted = None
    if request.predicted is not None:
        c_predicted = predicted_c_body_from_itrf(around, request.predicted)
    search = Search(
        around=around,
        prior=prior_of(around, request.predicted, blue),
        c_predicted=c_predicted,
    )
    views = [look(frame, camera) for frame, camera in zip(frames, request.cameras, strict=True)]
    horizon = explain_reasons(find_horizon(views, search), views, search)
    return _answer(horizon, request, around, c_predicted)


def _answer(
    horizon: FoundHorizon, request: HorizonRequest, around: Surroundings, c_predicted: Array | None
) -> VerticalEstimate:
    cameras = tuple(
        CameraReport(
            name=camera.name,
            used=horizon.reason is None and judged.reason is None,
            reason=judged.reason,
            arc_deg=float(np.rad2deg(judged.arc_rad)),
            residual_px=judged.residual_px,
            limb_px=(
                horizon.points[k].pixel[judged.inlier] if horizon.points else np.zeros((0, 2))
            ),
        )
        for k, (camera, judged) in enumerate(zip(request.cameras, horizon.cameras, strict=True))
    )
    if horizon.reason is not None:
        return VerticalEstimate(
            verdict=Verdict.NOT_OBSERVABLE,
            reason=horizon.reason,
            geocentric=None,
            geodetic=None,
            limb_height_m=None,
            limb_height_sigma_m=None,
            check=None,
            cameras=cameras,
            warnings=(),
        )
    limb = around.limb
    geocentric = _nadir(horizon.fits, limb, limb.nadir_itrf)
    geodetic = _nadir(horizon.fits, limb, limb.nadir_geodetic_itrf)
    best = horizon.best
    check = None
    if request.predicted is not None and c_predicted is not None:
        check = check_attitude(
            geocentric.nadir_body,
            geocentric.covariance_rad2,
            c_predicted @ limb.nadir_itrf,
            float(np.deg2rad(request.predicted.sigma_deg)),
        )
    return VerticalEstimate(
        verdict=Verdict.MEASURED if check is None else check.verdict,
        reason=None,
        geocentric=geocentric,
        geodetic=geodetic,
        limb_height_m=best.height_m,
        limb_height_sigma_m=float(np.sqrt(best.covariance[3, 3])),
        check=check,
        cameras=cameras,
        warnings=_warnings(request, cameras),
    )


def _warnings(request: HorizonRequest, cameras: tuple[CameraReport, ...]) -> tuple[str, ...]:
    said = []
    if request.predicted is None:
        said.append(
            "no attitude was predicted, so the heading is known only from the sunlight along the "
            "limb: geodetic nadir is measured, geocentric less surely, as its covariance says; "
            "give `predicted` to have both"
        )
    left_out = [camera.name for camera in cameras if not camera.used]
    if left_out:
        said.append(f"cameras left out: {', '.join(left_out)}")
    orientation = earth_orientation_warning(Instants(request.epoch, np.zeros(1)))
    return (*said, orientation) if orientation else tuple(said)


def _nadir(fits: tuple[tuple[float, Fit], ...], limb: Limb, nadir_itrf: Array) -> Nadir:
    """A nadir and its covariance, over all headings tried by their weights."""
    mean = sum(w * (f.c_body_from_itrf @ nadir_itrf) for w, f in fits)
    mean = np.asarray(mean) / np.linalg.norm(mean)
    axes = across_axes(mean)
    turns = np.cross(np.stack([*limb.axes_itrf, limb.nadir_itrf]), nadir_itrf)
    covariance = np.zeros((2, 2))
    for weight, one in fits:
        to_body = -axes @ one.c_body_from_itrf @ turns.T
        off = axes @ (one.c_body_from_itrf @ nadir_itrf)
        covariance += weight * (to_body @ one.covariance[:3, :3] @ to_body.T + np.outer(off, off))
    return Nadir(nadir_body=mean, axes_body=axes, covariance_rad2=covariance)
