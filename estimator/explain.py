"""Plain reasons why frames showed no horizon: the Sun in them, or no sky."""

from dataclasses import replace

import numpy as np

from estimator.errors import Reason
from estimator.prediction import sun_in_frame
from estimator.search import FoundHorizon, Search, View

_UNEXPLAINED = (Reason.NO_HORIZON, Reason.BROKEN_ARC, Reason.ELSEWHERE, Reason.RESIDUALS)
# The sky's brightness against the brightest in the frame: dark ocean in full sun has more.
_SKY_SHARE = 0.12


def explain_reasons(horizon: FoundHorizon, views: list[View], search: Search) -> FoundHorizon:
    """The horizon, its cameras' reasons replaced where there is a plainer one."""
    reasons = [
        _plainer(camera.reason, view, search)
        for camera, view in zip(horizon.cameras, views, strict=True)
    ]
    cameras = tuple(
        replace(camera, reason=reason)
        for camera, reason in zip(horizon.cameras, reasons, strict=True)
    )
    common = horizon.reason
    if common in _UNEXPLAINED:
        common = next((reason for reason in reasons if reason not in _UNEXPLAINED), common)
    return replace(horizon, reason=common, cameras=cameras)


def _plainer(reason: Reason | None, view: View, search: Search) -> Reason | None:
    if reason not in _UNEXPLAINED or not search.daylight:
        return reason
    if search.c_predicted is not None and sun_in_frame(
        view.camera, search.around, search.c_predicted
    ):
        return Reason.SUN_IN_FRAME
    if reason is not Reason.RESIDUALS and not _has_sky(view):
        return Reason.NO_SKY
    return reason


def _has_sky(view: View) -> bool:
    seen = view.frame.grey[::2, ::2][view.frame.usable[::2, ::2]]
    if seen.size == 0:
        return True
    dark, bright = np.percentile(seen, [5.0, 99.0])
    return bool(dark < _SKY_SHARE * bright)
