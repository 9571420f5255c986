"""The attitude over a session's frames, and its bias, if there is one."""

from collections.abc import Sequence

import numpy as np

from estimator.check import INCONSISTENT_BELOW, Verdict, chance_of
from estimator.found import FrameNadir, SeriesReport, VerticalEstimate
from estimator.request import HorizonRequest


def summarise_series(estimates: Sequence[VerticalEstimate], sigma_rad: float) -> SeriesReport:
    """Estimates made against predictions, and the predictions' own 1-sigma."""
    used = [
        (e.check, e.geocentric)
        for e in estimates
        if e.check is not None and e.geocentric is not None
    ]
    if not used:
        return SeriesReport(
            verdict=Verdict.NOT_OBSERVABLE,
            used=0,
            bias_rad=None,
            covariance_rad2=None,
            scatter_rad=None,
            probability=None,
        )
    off_rad = np.array([[check.along_rad, check.across_rad] for check, _ in used])
    covariances_rad2 = np.array([nadir.covariance_rad2 for _, nadir in used])
    weight = np.array([1.0 / np.trace(covariance_rad2) for covariance_rad2 in covariances_rad2])
    weight /= weight.sum()
    bias_rad = weight @ off_rad
    covariance_rad2 = np.einsum("n,nij->ij", weight, covariances_rad2)
    probability = chance_of(bias_rad, covariance_rad2, sigma_rad)
    consistent = probability >= INCONSISTENT_BELOW
    return SeriesReport(
        verdict=Verdict.CONSISTENT if consistent else Verdict.INCONSISTENT,
        used=len(used),
        bias_rad=bias_rad,
        covariance_rad2=covariance_rad2,
        scatter_rad=np.sqrt(weight @ (off_rad - bias_rad) ** 2),
        probability=probability,
    )


def frame_nadir(request: HorizonRequest, estimate: VerticalEstimate) -> FrameNadir:
    check = estimate.check
    return FrameNadir(
        at_utc=request.epoch,
        verdict=estimate.verdict,
        reason=estimate.reason,
        nadir_body=estimate.nadir_body,
        sigma_rad=estimate.sigma_rad,
        along_rad=check.along_rad if check else None,
        across_rad=check.across_rad if check else None,
    )
