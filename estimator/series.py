"""The attitude over a session's frames, and its bias, if there is one."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from estimator.check import INCONSISTENT_BELOW, Verdict, chance_of
from estimator.pipeline import VerticalEstimate
from planner.arrays import Array


@dataclass(frozen=True)
class SeriesReport:
    """Measured minus predicted nadir over the frames that could be used.

    t_s (n,); off_rad (n, 2): along and across as in `AttitudeCheck`.  bias_rad (2,), with
    covariance (2, 2): the limb's height errs alike in all frames of a session, so the bias is
    no surer than one frame.  scatter_rad (2,): rms about the bias, jitter and limb roughness.
    """

    verdict: Verdict
    t_s: Array
    off_rad: Array
    bias_rad: Array
    covariance_rad2: Array
    scatter_rad: Array
    probability: float


def summarise_series(
    t_s: Sequence[float], estimates: Sequence[VerticalEstimate], sigma_rad: float
) -> SeriesReport:
    """Estimates made against predictions, and the predictions' own 1-sigma."""
    used = [
        (t, e.check, e.geocentric)
        for t, e in zip(t_s, estimates, strict=True)
        if e.check is not None and e.geocentric is not None
    ]
    if not used:
        none = np.zeros((0, 2))
        return SeriesReport(
            verdict=Verdict.NOT_OBSERVABLE,
            t_s=np.zeros(0),
            off_rad=none,
            bias_rad=np.full(2, np.nan),
            covariance_rad2=np.full((2, 2), np.nan),
            scatter_rad=np.full(2, np.nan),
            probability=float("nan"),
        )
    off_rad = np.array([[check.along_rad, check.across_rad] for _, check, _ in used])
    covariances_rad2 = np.array([nadir.covariance_rad2 for _, _, nadir in used])
    weight = np.array([1.0 / np.trace(covariance_rad2) for covariance_rad2 in covariances_rad2])
    weight /= weight.sum()
    bias_rad = weight @ off_rad
    covariance_rad2 = np.einsum("n,nij->ij", weight, covariances_rad2)
    probability = chance_of(bias_rad, covariance_rad2, sigma_rad)
    consistent = probability >= INCONSISTENT_BELOW
    return SeriesReport(
        verdict=Verdict.CONSISTENT if consistent else Verdict.INCONSISTENT,
        t_s=np.array([t for t, _, _ in used]),
        off_rad=off_rad,
        bias_rad=bias_rad,
        covariance_rad2=covariance_rad2,
        scatter_rad=np.sqrt(weight @ (off_rad - bias_rad) ** 2),
        probability=probability,
    )
