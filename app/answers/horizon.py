"""The answers about the horizon: estimates, predictions and pictures."""

import base64
import math
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from itertools import zip_longest
from typing import TYPE_CHECKING, Any

import numpy as np

from app.answers.horizon_view import ViewOut
from app.answers.members import BUILT_ON_FIRST_USE, DECIMALS, ProvenanceOut, degrees, fill
from estimator.check import AttitudeCheck, Verdict
from estimator.errors import Reason
from planner.base.answer_members import DirectionPart, NotNegative, Signed, TurnDeg
from planner.base.arrays import Array
from planner.world.frames.time_scales import utc_text

if TYPE_CHECKING:
    from estimator.pipeline import CameraReport, Nadir, VerticalEstimate
    from estimator.prediction import HorizonPrediction

PIXEL_DECIMALS = 2


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


@dataclass(frozen=True, kw_only=True)
class CameraOut:
    """One camera's part in the estimate.

    name: the camera's, as the request gives it.
    used: true when its frame was used.
    reason: the reason for leaving it out, as a word; null when it was used. E.g. `"all_black"`.
    explanation: the reason in full; null when it was used. E.g. `"the frame is black"`.
    arc_deg: limb found, as azimuth about nadir.
    residual_px: rms distance of the limb points from the fit; null without one.
    overlay_png: the annotated frame as a PNG in base64, when `overlay` was asked for: limb points
    used in green, the predicted limb in orange. E.g. `"iVBORw0KGgo="`.
    """

    name: str
    used: bool
    reason: str | None
    explanation: str | None
    arc_deg: TurnDeg
    residual_px: NotNegative | None
    overlay_png: str | None


@dataclass(frozen=True, kw_only=True)
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
    covariance_deg2: of geocentric nadir on `axes_body`.
    sigma_deg: rms of geocentric nadir's angle to the true one.
    geodetic_axes_body: two unit vectors across geodetic nadir, along which its errors are given.
    geodetic_covariance_deg2: of geodetic nadir on `geodetic_axes_body`.
    geodetic_sigma_deg: rms of geodetic nadir's angle to the true one.
    limb_height_km: height of the limb above the ellipsoid that was reckoned with.
    limb_height_sigma_km: its 1-sigma.
    check: the measured nadir against the predicted one; null without a prediction.
    correction: the same as `attitude.corrections` of a plan takes it; null without a prediction.
    cameras: each one's part, in the request's order.
    warnings: cautions to read before relying on it. E.g.
    `["cameras left out: right"]`.
    """

    __pydantic_config__ = BUILT_ON_FIRST_USE

    verdict: Verdict
    reason: str | None
    explanation: str | None
    nadir_body: list[DirectionPart] | None
    nadir_geodetic_body: list[DirectionPart] | None
    axes_body: list[list[DirectionPart]] | None
    covariance_deg2: list[list[Signed]] | None
    sigma_deg: NotNegative | None
    geodetic_axes_body: list[list[DirectionPart]] | None
    geodetic_covariance_deg2: list[list[Signed]] | None
    geodetic_sigma_deg: NotNegative | None
    limb_height_km: Signed | None
    limb_height_sigma_km: NotNegative | None
    check: AttitudeCheck | None
    correction: CorrectionOut | None
    cameras: list[CameraOut]
    warnings: list[str]
    provenance: ProvenanceOut


@dataclass(frozen=True, kw_only=True)
class PredictionResponse:
    """One view per instant and camera.

    views: instants in the order asked for, cameras within each.
    warnings: cautions to read before relying on it. E.g.
    `["the elements' epoch 2015-02-27T11:40:53Z is 9.0 days from the farthest instant asked for"]`.
    """

    views: list[ViewOut]
    warnings: list[str]
    provenance: ProvenanceOut


@dataclass(frozen=True, kw_only=True)
class PictureOut:
    """A rendered picture and its truth.

    image_png: the picture, a PNG in base64.
    at: time of the exposure; UTC.
    position_itrf_km: of the camera, as an estimate's request takes it.
    q_body_from_eci_xyzw: attitude, as an estimate's request takes it.
    nadir_body: geocentric, a unit vector.
    nadir_geodetic_body: normal to the ellipsoid, a unit vector.
    """

    image_png: str
    at: str
    position_itrf_km: list[Signed]
    q_body_from_eci_xyzw: list[DirectionPart]
    nadir_body: list[DirectionPart]
    nadir_geodetic_body: list[DirectionPart]


def estimate_out(
    estimate: "VerticalEstimate",
    epoch_utc: datetime,
    overlays: Sequence[bytes],
    provenance: ProvenanceOut,
) -> EstimateResponse:
    """epoch_utc: of the images.  overlays: PNG files, one per camera, or none at all."""
    geocentric, geodetic, check = estimate.geocentric, estimate.geodetic, estimate.check
    pictures: list[str | None] = [base64.b64encode(png).decode("ascii") for png in overlays]
    return fill(
        EstimateResponse,
        estimate,
        **_why(estimate.reason),
        nadir_body=geocentric and numbers_of(geocentric.nadir_body),
        nadir_geodetic_body=geodetic and numbers_of(geodetic.nadir_body),
        **_on_its_axes(geocentric),
        **_on_its_axes(geodetic, "geodetic_"),
        limb_height_km=_kilometres(estimate.limb_height_m),
        limb_height_sigma_km=_kilometres(estimate.limb_height_sigma_m),
        correction=check
        and CorrectionOut(
            epoch=utc_text(epoch_utc),
            turn_body_deg=numbers_of(np.rad2deg(check.turn_body_rad)),
            covariance_deg2=covariance_deg2(check.turn_covariance_rad2),
        ),
        cameras=[
            _camera(report, overlay_png)
            for report, overlay_png in zip_longest(estimate.cameras, pictures)
        ],
        provenance=provenance,
    )


def view_out(view: "HorizonPrediction", at: str) -> ViewOut:
    """In degrees."""
    seen = view.limb_px[np.all(np.isfinite(view.limb_px), axis=1)]
    return fill(
        ViewOut,
        view,
        at=at,
        usable=view.reason is None,
        **_why(view.reason),
        limb_in_frame=view.arc_rad > 0.0,
        lit=view.lit_arc_rad > 0.0,
        limb_px=rows_of(seen, PIXEL_DECIMALS),
        decimals=DECIMALS,
    )


def _camera(report: "CameraReport", overlay_png: str | None) -> CameraOut:
    return fill(
        CameraOut,
        report,
        **_why(report.reason),
        arc_deg=round(report.arc_deg, DECIMALS),
        residual_px=None if math.isnan(report.residual_px) else round(report.residual_px, 4),
        overlay_png=overlay_png,
    )


def _on_its_axes(nadir: "Nadir | None", kind: str = "") -> dict[str, Any]:
    """The members that tell how sure a nadir of one kind is, null without it."""
    return {
        f"{kind}axes_body": nadir and rows_of(nadir.axes_body),
        f"{kind}covariance_deg2": nadir and covariance_deg2(nadir.covariance_rad2),
        f"{kind}sigma_deg": nadir and degrees(nadir.sigma_rad),
    }


def word(reason: Reason | None) -> str | None:
    """As the answers name it."""
    return None if reason is None else reason.name.lower()


def _why(reason: Reason | None) -> dict[str, Any]:
    return {"reason": word(reason), "explanation": None if reason is None else reason.value}


def _kilometres(height_m: float | None) -> float | None:
    return None if height_m is None else round(height_m / 1e3, 3)


def covariance_deg2(covariance_rad2: Array) -> list[list[float]]:
    """Of two angles, in square degrees."""
    return rows_of(covariance_rad2 * math.degrees(1.0) ** 2, 12)


def numbers_of(numbers: Array, decimals: int = DECIMALS) -> list[float]:
    """A vector as plain numbers."""
    return [round(float(number), decimals) + 0.0 for number in numbers]


def rows_of(numbers: Array, decimals: int = DECIMALS) -> list[list[float]]:
    """The rows of a matrix as plain numbers."""
    return [numbers_of(row, decimals) for row in numbers]
