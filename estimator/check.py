"""Agreement of the measured vertical with the planned attitude."""

import math
from datetime import datetime
from enum import StrEnum

import numpy as np

from planner.base.answer_members import Angle, HalfTurn, Internal, Share, answer
from planner.base.arrays import Array
from planner.base.correction import CorrectionOut
from planner.world.frames.time_scales import utc_text

INCONSISTENT_BELOW = 1e-3


class Verdict(StrEnum):
    """Result of the check by the images; `measured` when there was no attitude to compare with."""

    CONSISTENT = "consistent"
    INCONSISTENT = "inconsistent"
    NOT_OBSERVABLE = "not_observable"
    MEASURED = "measured"


@answer
class AttitudeCheck:
    """The measured nadir against the predicted one.

    The turn about nadir is not measured.

    angle_rad: between them.
    along_rad: its part on the first of `axes_body`, from the prediction to the measurement.
    across_rad: its part on the second of `axes_body`, from the prediction to the measurement.
    probability: that errors of the stated sizes differ by as much or more.
    turn_body_rad: rotation vector from the predicted body to the measured one, none of it about
    nadir.
    turn_covariance_rad2: (3, 3), of the measurement alone, pi about nadir.
    """

    angle_rad: HalfTurn
    along_rad: Angle
    across_rad: Angle
    probability: Share
    turn_body_rad: Internal[Array]
    turn_covariance_rad2: Internal[Array]

    @property
    def verdict(self) -> Verdict:
        ok = self.probability >= INCONSISTENT_BELOW
        return Verdict.CONSISTENT if ok else Verdict.INCONSISTENT

    def correction(self, epoch_utc: datetime) -> CorrectionOut:
        """As a plan's attitude takes it."""
        covariance_deg2 = self.turn_covariance_rad2 * math.degrees(1.0) ** 2
        return CorrectionOut(
            epoch=utc_text(epoch_utc),
            turn_body_deg=(np.round(np.degrees(self.turn_body_rad), 9) + 0.0).tolist(),
            covariance_deg2=(np.round(covariance_deg2, 12) + 0.0).tolist(),
        )


def across_axes(nadir_body: Array) -> Array:
    """Two unit vectors (2, 3) across a nadir: body X, or Y where nadir is along X, made square
    to it, and the third that completes a right-handed set with nadir last."""
    start_body = np.array([1.0, 0.0, 0.0])
    if abs(nadir_body[0]) > 0.9:
        start_body = np.array([0.0, 1.0, 0.0])
    first_body = start_body - (start_body @ nadir_body) * nadir_body
    first_body /= np.linalg.norm(first_body)
    return np.stack([first_body, np.cross(nadir_body, first_body)])


def check_attitude(
    nadir_body: Array, covariance_rad2: Array, predicted_body: Array, sigma_rad: float
) -> AttitudeCheck:
    """covariance_rad2: (2, 2) on `across_axes(nadir_body)`; sigma_rad: of the prediction."""
    sine = np.linalg.norm(np.cross(nadir_body, predicted_body))
    angle_rad = float(np.arctan2(sine, nadir_body @ predicted_body))
    sideways_rad = across_axes(nadir_body) @ predicted_body
    length = float(np.linalg.norm(sideways_rad))
    # From the prediction to the measurement.
    offset_rad = -(sideways_rad * (angle_rad / length) if length > 0.0 else sideways_rad)
    # Turning the body by w takes a direction n that is fixed in space to n + w x n.
    turns_body = np.cross(nadir_body, across_axes(nadir_body))
    about_nadir_rad2 = np.pi**2 * np.outer(nadir_body, nadir_body)
    return AttitudeCheck(
        angle_rad=angle_rad,
        along_rad=float(offset_rad[0]),
        across_rad=float(offset_rad[1]),
        probability=chance_of(offset_rad, covariance_rad2, sigma_rad),
        turn_body_rad=offset_rad @ turns_body,
        turn_covariance_rad2=turns_body.T @ covariance_rad2 @ turns_body + about_nadir_rad2,
    )


def chance_of(offset_rad: Array, covariance_rad2: Array, sigma_rad: float) -> float:
    """Probability of an offset (2,) as large or larger by errors of these sizes."""
    combined_rad2 = covariance_rad2 + sigma_rad**2 * np.eye(2)
    distance2 = float(offset_rad @ np.linalg.solve(combined_rad2, offset_rad))
    return math.exp(-distance2 / 2.0)  # chi-square, two degrees of freedom
