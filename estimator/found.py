"""Cameras' parts, views and a session's bias, as answers hold them."""

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from estimator.check import AttitudeCheck, Verdict
from estimator.errors import Reason
from planner.base.answer_members import (
    Angle,
    AngleSize,
    Count,
    HalfTurn,
    Internal,
    Member,
    Schema,
    Share,
    Text,
    answer,
    written,
)
from planner.base.arrays import Array
from planner.base.correction import CorrectionOut
from planner.world.frames.time_scales import Utc


class ToldWord(Member):
    """A reason, told by its name as a word."""

    def __get_pydantic_core_schema__(self, source: object, handler: object) -> Schema:
        return written(lambda reason: reason.name.lower(), {"type": "str"})


ReasonWord = Annotated[Reason, ToldWord()]
Turn = Annotated[float, Member("deg", 0.0, 360.0, decimals=9)]
Direction = Annotated[Array, Member("", -1.0, 1.0, decimals=9)]
Directions = Annotated[Array, Member("", -1.0, 1.0, decimals=9, axes=2)]
AnglesBoth = Annotated[Array, Member("deg", decimals=9)]
CovarianceDeg2 = Annotated[Array, Member("deg2", decimals=12, axes=2)]


@answer
class CameraReport:
    """One camera's part in the estimate.

    name: the camera's, as the request gives it.
    used: true when its frame was used.
    reason: the reason for leaving it out, as a word; null when it was used. E.g. `"all_black"`.
    explanation: the reason in full; null when it was used. E.g. `"the frame is black"`.
    arc_deg: limb found, as azimuth about nadir.
    residual_px: rms distance of the limb points from the fit; null without one.
    limb_px: those points, (n, 2).
    overlay_png: the annotated frame as a PNG in base64, when `overlay` was asked for: limb points
    used in green, the predicted limb in orange. E.g. `"iVBORw0KGgo="`.
    """

    name: str
    used: bool
    reason: ReasonWord | None
    explanation: str | None
    arc_deg: Annotated[float, Member("", 0.0, 360.0, decimals=9)]
    residual_px: Annotated[float, Member("", 0.0, decimals=4)] | None
    limb_px: Internal[Array]
    overlay_png: str | None = None


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


@answer
class MeasuredNadir:
    """Nadir as it is measured, or why it is not.

    geocentric and geodetic: None when the verdict is `not_observable`, for `reason`.
    Without a predicted attitude the limb measures geodetic nadir; the heading, and so geocentric
    nadir up to 0.19 deg beside it, comes from the sunlight along the limb: to some 10 deg where
    colour is kept pixel by pixel, hardly in grey.  The covariance holds what is left open.
    """

    verdict: Verdict
    reason: ReasonWord | None = None
    geocentric: Internal[Nadir | None] = None
    geodetic: Internal[Nadir | None] = None

    @property
    def explanation(self) -> Text | None:
        return self.reason and self.reason.value

    @property
    def nadir_body(self) -> Direction | None:
        return self.geocentric.nadir_body if self.geocentric else None

    @property
    def nadir_geodetic_body(self) -> Direction | None:
        return self.geodetic.nadir_body if self.geodetic else None

    @property
    def axes_body(self) -> Directions | None:
        return self.geocentric.axes_body if self.geocentric else None

    @property
    def covariance_rad2(self) -> CovarianceDeg2 | None:
        return self.geocentric.covariance_rad2 if self.geocentric else None

    @property
    def sigma_rad(self) -> AngleSize | None:
        return self.geocentric.sigma_rad if self.geocentric else None

    @property
    def geodetic_axes_body(self) -> Directions | None:
        return self.geodetic.axes_body if self.geodetic else None

    @property
    def geodetic_covariance_rad2(self) -> CovarianceDeg2 | None:
        return self.geodetic.covariance_rad2 if self.geodetic else None

    @property
    def geodetic_sigma_rad(self) -> AngleSize | None:
        return self.geodetic.sigma_rad if self.geodetic else None


@answer
class VerticalEstimate(MeasuredNadir):
    """The answer to a HorizonRequest.

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

    limb_height_m: Annotated[float, Member("km", decimals=3)] | None = None
    limb_height_sigma_m: Annotated[float, Member("km", 0.0, decimals=3)] | None = None
    check: AttitudeCheck | None = None
    correction: CorrectionOut | None = None
    cameras: tuple[CameraReport, ...]
    warnings: tuple[str, ...] = ()


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
class HorizonView:
    """The view of one camera at one instant.

    at_utc: the instant; UTC.
    camera: the camera's name.
    usable: true when an estimate from its frame will be of use.
    reason: the reason why not, as a word; null when it is usable.
    explanation: the reason in full; null when it is usable.
    limb_in_frame: true when any of the limb is in the frame.
    arc_rad: limb in frame, as azimuth about nadir.
    lit_arc_rad: the part of that arc that is in daylight and away from the Sun.
    lit: true when any of the arc is in daylight and away from the Sun.
    sun_angle_rad: of the Sun from the boresight.
    sun_in_frame: true when the Sun's disk is in the frame.
    sigma_rad: expected 1-sigma of geocentric nadir by this camera alone; null when it is not
    usable.
    limb_px: (n, 2), of a daylight limb 17.5 km high (or the body's own), NaN where out of frame.
    line_px: the limb's line, [x, y]: x right, y down, pixel centres at whole numbers.
    """

    at_utc: Utc
    camera: str
    usable: bool
    reason: ReasonWord | None
    explanation: str | None
    limb_in_frame: bool
    arc_rad: Turn
    lit_arc_rad: Turn
    lit: bool
    sun_angle_rad: HalfTurn
    sun_in_frame: bool
    sigma_rad: AngleSize | None
    limb_px: Internal[Array]

    @property
    def line_px(self) -> Annotated[Array, Member(decimals=2, axes=2, called="limb_px")]:
        """Those points of it that are known."""
        return self.limb_px[np.all(np.isfinite(self.limb_px), axis=1)]


@answer
class HorizonCheck:
    """One camera's use in one session, seen at its start, middle and stop.

    session: its number, from 0. E.g. `0`.
    camera: the camera's name. E.g. `"ahead"`.
    usable: true when its frames will be of use at all three. E.g. `true`.
    reason: of the first that is not usable, as a word; null when all are. E.g. `"low_sun"`.
    explanation: the reason in full; null when all are usable. E.g.
    `"the Sun is too low at the craft"`.
    views: at the three instants.
    """

    session: Count
    camera: str
    usable: bool
    reason: ReasonWord | None
    explanation: str | None
    views: tuple[HorizonView, ...]


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
class SeriesReport:
    """Measured minus predicted nadir over the frames that could be used; null without any.

    used: how many those are.
    bias_rad: (2,), along and across as in `AttitudeCheck`.
    covariance_rad2: of the bias, (2, 2): the limb's height errs alike in all frames of a session,
    so the bias is no surer than one frame.
    scatter_rad: (2,), rms about the bias, jitter and limb roughness.
    probability: that errors of the stated sizes make so large a bias.
    """

    verdict: Verdict
    used: Count
    bias_rad: AnglesBoth | None
    covariance_rad2: CovarianceDeg2 | None
    scatter_rad: AnglesBoth | None
    probability: Share | None
