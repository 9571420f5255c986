"""Picks, of the nadirs voted for, the horizon that stands up to every test."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from estimator.camera import HorizonCamera
from estimator.errors import Reason
from estimator.images import Frame
from estimator.search.plausibility import unusable_frame
from estimator.search.trial import Search, SearchResult, View, blank_part, try_attitude
from estimator.search.votes import vote

_DISAGREE_SIGMA = 5.0
_SEED = 20161
_UNEXPLAINED = (Reason.NO_HORIZON, Reason.BROKEN_ARC, Reason.ELSEWHERE, Reason.RESIDUALS)
# The sky's brightness against the brightest in the frame: dark ocean in full sun has more.
_SKY_SHARE = 0.12


def find_horizon(
    frames: Sequence[Frame], cameras: Sequence[HorizonCamera], search: Search
) -> SearchResult:
    """The best horizon in all frames together, or the plainest reason why there is none."""
    views = [
        View(camera, frame, unusable_frame(frame), _SEED + k)
        for k, (frame, camera) in enumerate(zip(frames, cameras, strict=True))
    ]
    refusal = _hopeless(views, search)
    if refusal is not None:
        found = _none(views, refusal)
    else:
        found = _best_of_votes(views, search)
        if found.reason is None:
            found = _refuse_contradiction(found, views, search)
    return _explain(found, views, search)


def _hopeless(views: Sequence[View], search: Search) -> Reason | None:
    """Why no horizon need be looked for."""
    around = search.around
    too_dark = around.darkness() if around.daylight else None
    if too_dark is not None:
        return too_dark
    if all(view.unusable is not None for view in views):
        return views[0].unusable
    if around.daylight and not search.heading_known and around.is_sun_vague:
        return Reason.HEADING_UNKNOWN
    return None


def _best_of_votes(views: Sequence[View], search: Search) -> SearchResult:
    """The first horizon that passes; otherwise the failure that found most of a limb."""
    limb = search.around.limb
    eta_rad = float(np.arcsin((limb.mean_radius_m + search.prior.height_m) / limb.range_m))
    c_predicted = search.c_body_from_itrf_predicted
    predicted_body = None if c_predicted is None else c_predicted @ limb.nadir_geodetic_itrf
    edges = [view.edges for view in views if view.unusable is None]
    failures: list[SearchResult] = []
    for nadir_body in vote(edges, eta_rad, predicted_body, _SEED):
        result = try_attitude(views, search, search.start(nadir_body))
        if result.reason is None:
            return result
        failures.append(result)
    if not failures:
        return _none(views, Reason.NO_HORIZON)
    return max(failures, key=lambda failure: failure.arc_rad)


def _refuse_contradiction(
    found: SearchResult, views: Sequence[View], search: Search
) -> SearchResult:
    """Refuse when a camera that was set aside sees a good horizon of its own elsewhere."""
    best, nadir_itrf = found.best, search.around.limb.nadir_itrf
    nadir_body = best.c_body_from_itrf @ nadir_itrf
    for k, (view, part) in enumerate(zip(views, found.parts, strict=True)):
        if part.used or view.unusable is not None:
            continue
        alone = _best_of_votes([view], search)
        if alone.reason is not None:
            continue
        angle_rad = np.linalg.norm(alone.best.c_body_from_itrf @ nadir_itrf - nadir_body)
        spread_rad = np.hypot(best.tilt_sigma_rad, alone.best.tilt_sigma_rad)
        if angle_rad > _DISAGREE_SIGMA * spread_rad:
            parts = list(found.parts)
            parts[k] = part.with_reason(Reason.CAMERAS_DISAGREE)
            return replace(found, reason=Reason.CAMERAS_DISAGREE, parts=tuple(parts))
    return found


def _none(views: Sequence[View], reason: Reason) -> SearchResult:
    return SearchResult(
        reason, (), tuple(blank_part(view, view.unusable or reason) for view in views)
    )


def _explain(result: SearchResult, views: Sequence[View], search: Search) -> SearchResult:
    """The result, its reasons replaced where there is a plainer one."""
    parts = tuple(
        part.with_reason(_plainer(part.agreement.reason, view, search))
        for part, view in zip(result.parts, views, strict=True)
    )
    common = result.reason
    if common in _UNEXPLAINED:
        reasons = [part.agreement.reason for part in parts]
        common = next((reason for reason in reasons if reason not in _UNEXPLAINED), common)
    return replace(result, reason=common, parts=parts)


def _plainer(reason: Reason | None, view: View, search: Search) -> Reason | None:
    around, c_predicted = search.around, search.c_body_from_itrf_predicted
    if reason not in _UNEXPLAINED or not around.daylight:
        return reason
    if c_predicted is not None and around.is_sun_in_frame(view.camera, c_predicted):
        return Reason.SUN_IN_FRAME
    if reason is not Reason.RESIDUALS and not _has_sky(view.frame):
        return Reason.NO_SKY
    return reason


def _has_sky(frame: Frame) -> bool:
    seen = frame.grey[::2, ::2][frame.usable[::2, ::2]]
    if seen.size == 0:
        return True
    dark, bright = np.percentile(seen, [5.0, 99.0])
    return bool(dark < _SKY_SHARE * bright)
