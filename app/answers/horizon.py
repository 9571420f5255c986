"""The answers about the horizon: estimates, predictions, pictures and series."""

import base64
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from itertools import zip_longest
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np

from app.answers.members import BUILT_ON_FIRST_USE, ProvenanceOut
from estimator.check import AttitudeCheck, Verdict
from estimator.found import CameraReport, CovarianceDeg2, HorizonView, ReasonWord, SeriesReport
from planner.base.answer_members import Angle, AngleSize, Member, Signed, answer
from planner.base.arrays import Array
from planner.world.frames.time_scales import Utc, utc_text

if TYPE_CHECKING:
    from estimator.pipeline import Nadir, VerticalEstimate

Direction = Annotated[Array, Member("", -1.0, 1.0, decimals=9)]
Directions = Annotated[Array, Member("", -1.0, 1.0, decimals=9, axes=2)]


@dataclass(frozen=True, kw_only=True)
class CorrectionOut:
    """The measured turn of the body from the predicted one, as `attitude.corrections` of a plan
    takes it where the attitude predicted is that of its law.

    epoch: time of the measurement; UTC.
    turn_body_deg: the rotation vector from the predicted body to the measured one, body axes.
    covariance_deg2: of its components; 180 deg about nadir, which was not measured.
    """

    epoch: str
    turn_body_deg: list[Signed]
    covariance_deg2: list[list[Signed]]


@answer
class EstimateResponse:
    """The local vertical in body axes.

    verdict: result of the check of the attitude by the images.
    reason: the reason why nothing could be measured, as a word; null when it was. E.g.
    `"no_horizon"`.
    explanation: the reason in full; null when it was measured. E.g.
    `"too little of the limb was found"`.
    nadir_body: geocentric, a unit vector; null when the verdict is `not_observable`.
    nadir_geodetic_body: normal to the ellipsoid, a unit vector; null when the verdict is
    `not_observable`.
    axes_body: two unit vectors across geocentric nadir, along which its errors are given.
    covariance_rad2: of geocentric nadir on `axes_body`.
    sigma_rad: rms of geocentric nadir's angle to the true one.
    geodetic_axes_body: two unit vectors across geodetic nadir, along which its errors are given.
    geodetic_covariance_rad2: of geodetic nadir on `geodetic_axes_body`.
    geodetic_sigma_rad: rms of geodetic nadir's angle to the true one.
    limb_height_m: height of the limb above the ellipsoid that was reckoned with.
    limb_height_sigma_m: its 1-sigma.
    check: the measured nadir against the predicted one; null without a prediction.
    correction: the same as `attitude.corrections` of a plan takes it; null without a prediction.
    cameras: each one's part, in the request's order.
    warnings: cautions to read before relying on it. E.g.
    `["cameras left out: right"]`.
    """

    __pydantic_config__ = BUILT_ON_FIRST_USE

    verdict: Verdict
    reason: ReasonWord | None
    explanation: str | None
    nadir_body: Direction | None
    nadir_geodetic_body: Direction | None
    axes_body: Directions | None
    covariance_rad2: CovarianceDeg2 | None
    sigma_rad: AngleSize | None
    geodetic_axes_body: Directions | None
    geodetic_covariance_rad2: CovarianceDeg2 | None
    geodetic_sigma_rad: AngleSize | None
    limb_height_m: Annotated[float, Member("km", decimals=3)] | None
    limb_height_sigma_m: Annotated[float, Member("km", 0.0, decimals=3)] | None
    check: AttitudeCheck | None
    correction: CorrectionOut | None
    cameras: tuple[CameraReport, ...]
    warnings: tuple[str, ...]
    provenance: ProvenanceOut


@dataclass(frozen=True, kw_only=True)
class PredictionResponse:
    """One view per instant and camera.

    views: instants in the order asked for, cameras within each.
    warnings: cautions to read before relying on it. E.g.
    `["the elements' epoch 2015-02-27T11:40:53Z is 9.0 days from the farthest instant asked for"]`.
    """

    views: list[HorizonView]
    warnings: list[str]
    provenance: ProvenanceOut


@answer
class PictureOut:
    """A rendered picture and its truth.

    image_png: the picture, a PNG in base64.
    at_utc: time of the exposure; UTC.
    position_itrf_m: of the camera, as an estimate's request takes it.
    q_body_from_eci_xyzw: attitude, as an estimate's request takes it.
    nadir_body: geocentric, a unit vector.
    nadir_geodetic_body: normal to the ellipsoid, a unit vector.
    """

    image_png: str
    at_utc: Utc
    position_itrf_m: Annotated[Array, Member("km", decimals=9)]
    q_body_from_eci_xyzw: Annotated[Array, Member("", -1.0, 1.0, decimals=12)]
    nadir_body: Direction
    nadir_geodetic_body: Direction


@answer
class FrameNadir:
    """One frame; along and across as in an estimate's `check`, null where it has none."""

    at_utc: Utc
    verdict: Verdict
    reason: ReasonWord | None
    nadir_body: Direction | None
    sigma_rad: AngleSize | None
    along_rad: Angle | None
    across_rad: Angle | None


@answer
class SeriesResponse(SeriesReport):
    """The nadir over a session."""

    frames: tuple[FrameNadir, ...]
    provenance: ProvenanceOut


def estimate_out(
    estimate: "VerticalEstimate",
    epoch_utc: datetime,
    overlays: Sequence[bytes],
    provenance: ProvenanceOut,
) -> EstimateResponse:
    """epoch_utc: of the images.  overlays: PNG files, one per camera, or none at all."""
    geocentric, geodetic, check = estimate.geocentric, estimate.geodetic, estimate.check
    pictures: list[str | None] = [base64.b64encode(png).decode("ascii") for png in overlays]
    return EstimateResponse(
        verdict=estimate.verdict,
        reason=estimate.reason,
        explanation=estimate.reason and estimate.reason.value,
        nadir_body=geocentric.nadir_body if geocentric else None,
        nadir_geodetic_body=geodetic.nadir_body if geodetic else None,
        **_on_its_axes(geocentric),
        **_on_its_axes(geodetic, "geodetic_"),
        limb_height_m=estimate.limb_height_m,
        limb_height_sigma_m=estimate.limb_height_sigma_m,
        check=check,
        correction=None if check is None else _correction(check, epoch_utc),
        cameras=tuple(
            replace(report, overlay_png=overlay_png)
            for report, overlay_png in zip_longest(estimate.cameras, pictures)
        ),
        warnings=estimate.warnings,
        provenance=provenance,
    )


def _correction(check: AttitudeCheck, epoch_utc: datetime) -> CorrectionOut:
    covariance_deg2 = check.turn_covariance_rad2 * math.degrees(1.0) ** 2
    return CorrectionOut(
        epoch=utc_text(epoch_utc),
        turn_body_deg=(np.round(np.degrees(check.turn_body_rad), 9) + 0.0).tolist(),
        covariance_deg2=(np.round(covariance_deg2, 12) + 0.0).tolist(),
    )


def _on_its_axes(nadir: "Nadir | None", kind: str = "") -> dict[str, Any]:
    """The members that tell how sure a nadir of one kind is, null without it."""
    names = ("axes_body", "covariance_rad2", "sigma_rad")
    return {f"{kind}{name}": getattr(nadir, name, None) for name in names}
