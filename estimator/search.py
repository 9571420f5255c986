"""Picks, of the nadirs voted for, the horizon that stands up to every test."""

from dataclasses import dataclass, replace

import numpy as np

from estimator.camera import HorizonCamera
from estimator.candidates import Edges, find_edges
from estimator.errors import Reason
from estimator.gates import (
    MIN_ARC_OF_ALL_RAD,
    MIN_ARC_UNPREDICTED_RAD,
    CameraFit,
    darkness,
    is_dark_within,
    is_glowing_layer,
    is_sun_vague,
    is_too_sharp,
    judge_camera,
    judge_height,
    judge_low_sun,
    unusable_frame,
    well_lit,
)
from estimator.heading import Sunlight, limb_brightness, limb_colour
from estimator.images import Frame
from estimator.limb import LimbPoints, find_limb
from estimator.nadir import Fit, Prior, attitude_facing, attitude_with_nadir, fit, possible_fits
from estimator.prior import air_scale_m
from estimator.request import Surroundings
from estimator.tone import fade_ratio, linear
from estimator.voting import vote
from planner.arrays import Array

_BAND_RAD = np.deg2rad(0.5)
_FIRST_WINDOW_RAD = np.deg2rad(1.4)
_WINDOWS_RAD = (np.deg2rad(0.7), np.deg2rad(0.6))
_TRIED = 5
_PROMISING = 0.25
# Headings tried, and by how much the brightness may speak against one, in chi-square.
_FIRST_HEADINGS, _HEADINGS = (8, 4.0), (16, 14.0)
_THINNED = 8
_UNFITTED_COST = 1e12
_DISAGREE_SIGMA = 5.0
_SEED = 20161


@dataclass(frozen=True)
class View:
    """What one camera contributes: its frame, and why it was set aside before the search."""

    camera: HorizonCamera
    frame: Frame
    unusable: Reason | None


@dataclass(frozen=True)
class FoundHorizon:
    """The horizon found, or why none was.

    fits: the fit, or one for each heading tried with its weight when no heading was known.
    cameras: one per view; points likewise, empty ones for views not used.
    """

    reason: Reason | None
    fits: tuple[tuple[float, Fit], ...]
    cameras: tuple[CameraFit, ...]
    points: tuple[LimbPoints, ...]

    @property
    def best(self) -> Fit:
        return _best(self.fits)


@dataclass(frozen=True)
class Search:
    """Everything that stays the same while nadirs are tried."""

    around: Surroundings
    prior: Prior
    c_predicted: Array | None

    @property
    def heading_known(self) -> bool:
        return self.c_predicted is not None

    @property
    def daylight(self) -> bool:
        return self.around.body.limb_height_km is None

    def start(self, nadir_body: Array) -> Array:
        if self.c_predicted is None:
            return attitude_facing(nadir_body, self.around.limb)
        return attitude_with_nadir(self.c_predicted, nadir_body, self.around.limb)


def look(frame: Frame, camera: HorizonCamera) -> View:
    return View(camera=camera, frame=frame, unusable=unusable_frame(frame))


def find_horizon(views: list[View], search: Search) -> FoundHorizon:
    """The best horizon in all views together."""
    if search.daylight:
        too_dark = darkness(search.around.limb, search.around.sun_itrf)
        if too_dark is not None:
            return _none(views, too_dark)
    if all(view.unusable is not None for view in views):
        return _none(views, views[0].unusable or Reason.NO_HORIZON)
    if search.daylight and not search.heading_known and is_sun_vague(search.around):
        return _none(views, Reason.HEADING_UNKNOWN)
    edges = [
        find_edges(view.frame, view.camera, _SEED + k) if view.unusable is None else None
        for k, view in enumerate(views)
    ]
    found = _best_of_votes(views, edges, search)
    if found.reason is not None:
        return found
    return _with_no_dissent(found, views, edges, search)


def _best_of_votes(views: list[View], edges: list[Edges | None], search: Search) -> FoundHorizon:
    limb, prior = search.around.limb, search.prior
    eta_rad = float(np.arcsin((limb.mean_radius_m + prior.height_m) / limb.range_m))
    predicted = None
    if search.c_predicted is not None:
        predicted = search.c_predicted @ limb.nadir_geodetic_itrf
    votes = vote([e for e in edges if e is not None], eta_rad, _BAND_RAD, predicted, _SEED)
    failed: list[FoundHorizon] = []
    for candidate in votes[:_TRIED]:
        tried = _try(views, search, search.start(candidate.nadir_body))
        if tried.reason is None:
            return tried
        failed.append(tried)
    if not failed:
        return _none(views, Reason.NO_HORIZON)
    return max(failed, key=lambda h: sum(c.arc_rad for c in h.cameras))


def _try(views: list[View], search: Search, c_body_from_itrf: Array) -> FoundHorizon:
    """Fit the limb from a trial attitude, judge it, and keep the cameras that pass."""
    limb, prior = search.around.limb, search.prior
    active = [view.unusable is None for view in views]
    points, result = _first_fit(views, search, c_body_from_itrf, active)
    if search.daylight:
        decoded = _decode(views, points, result, search)
        if decoded is not None:
            views = decoded
            points, result = _first_fit(views, search, result.c_body_from_itrf, active)
    cameras = _judge(views, points, result, search)
    if all(c.arc_rad < _PROMISING * p.arc_rad for c, p in zip(cameras, points, strict=True)):
        return _failure(points, result, cameras)
    if search.daylight:
        cameras = [
            replace(c, reason=_no_lit_earth(view, p, search, result)) if on else c
            for on, c, view, p in zip(active, cameras, views, points, strict=True)
        ]
        active = [on and c.reason is None for on, c in zip(active, cameras, strict=True)]
    if not any(active):
        return _failure(points, result, cameras)
    for window in _WINDOWS_RAD:
        c, height = result.c_body_from_itrf, result.height_m
        points = _all_points(views, search, c, height, window, active)
        result = fit(points, limb, c, prior)
        judged = _judge(views, points, result, search)
        cameras = _keep_reasons(judged, cameras, active)
        active = [on and c.reason is None for on, c in zip(active, cameras, strict=True)]
        if not any(active):
            return _failure(points, result, cameras)
    if not all(active):
        points = [p if on else _without_points(p) for p, on in zip(points, active, strict=True)]
    fits = _all_headings(views, points, result.c_body_from_itrf, search, *_HEADINGS)
    judged = _judge(views, points, fit(points, limb, _best(fits).c_body_from_itrf, prior), search)
    cameras = _keep_reasons(judged, cameras, active)
    horizon = FoundHorizon(reason=None, fits=fits, cameras=tuple(cameras), points=tuple(points))
    return replace(horizon, reason=_verdict(horizon, search))


def _first_fit(
    views: list[View], search: Search, c_body_from_itrf: Array, active: list[bool]
) -> tuple[list[LimbPoints], Fit]:
    height = search.prior.height_m
    points = _all_points(views, search, c_body_from_itrf, height, _FIRST_WINDOW_RAD, active)
    c = c_body_from_itrf
    if not search.heading_known:
        c = _best(_all_headings(views, points, c, search, *_FIRST_HEADINGS)).c_body_from_itrf
    return points, fit(points, search.around.limb, c, search.prior)


def _decode(
    views: list[View], points: list[LimbPoints], rough: Fit, search: Search
) -> list[View] | None:
    """The views with their tone curves undone, or None where files hold light as it is.

    The cameras of one craft store alike, so they are judged together.
    """
    ratios = [
        fade_ratio(view.frame, p, view.camera, search.around.limb, rough)
        for view, p in zip(views, points, strict=True)
        if view.unusable is None
    ]
    known = [ratio for ratio in ratios if ratio is not None]
    if not known or float(np.mean(known)) <= 1.0:
        return None
    return [replace(view, frame=linear(view.frame)) for view in views]


def _all_points(
    views: list[View],
    search: Search,
    c: Array,
    height: float,
    window_rad: float,
    active: list[bool],
) -> list[LimbPoints]:
    scale_m = air_scale_m(search.around)
    return [
        _points(view, search, c, height, window_rad, scale_m, on)
        for view, on in zip(views, active, strict=True)
    ]


def _points(
    view: View,
    search: Search,
    c: Array,
    height: float,
    window_rad: float,
    scale_m: float,
    active: bool,
) -> LimbPoints:
    limb = search.around.limb
    points = find_limb(view.frame, view.camera, limb, c, height, window_rad, scale_m)
    if not active:
        return _without_points(points)
    # Without a prediction the first window's brightness has told the Sun's side by now.
    facing_known = search.heading_known or window_rad < _FIRST_WINDOW_RAD
    if search.daylight and facing_known and len(points):
        direction = limb.directions_itrf(points.azimuth_rad, height)
        lit = well_lit(limb, direction, height, search.around.sun_itrf)
        points = replace(points, found=points.found & lit, blocked=points.blocked | ~lit)
    return points


def _all_headings(
    views: list[View],
    points: list[LimbPoints],
    c_body_from_itrf: Array,
    search: Search,
    tried: int,
    dull: float,
) -> tuple[tuple[float, Fit], ...]:
    """The fit, or without a known heading those from headings all round, with weights."""
    limb, prior = search.around.limb, search.prior
    if search.heading_known:
        return ((1.0, fit(points, limb, c_body_from_itrf, prior)),)
    prior = replace(prior, heading_sigma_rad=np.pi / tried)
    nadir_body = c_body_from_itrf @ limb.nadir_geodetic_itrf
    points = [p.every(_THINNED) for p in points]
    headings = np.arange(tried) * (2.0 * np.pi / tried)
    facing = [attitude_facing(nadir_body, limb, heading) for heading in headings]
    clues = _sunlight(views, points, search, nadir_body)
    costs = np.array([clues.cost(c, prior.height_m) for c in facing])
    facing = [c for c, cost in zip(facing, costs - costs.min(), strict=True) if cost < dull]
    fits = [one for c in facing for one in possible_fits(fit(points, limb, c, prior), limb)]
    cost = np.array([min(f.cost, _UNFITTED_COST) for f in fits])
    cost = cost + [clues.cost(f.c_body_from_itrf, f.height_m) for f in fits]
    weight = np.exp(-0.5 * (cost - cost.min()))
    return tuple((float(w), f) for w, f in zip(weight / weight.sum(), fits, strict=True))


def _sunlight(
    views: list[View], points: list[LimbPoints], search: Search, nadir_body: Array
) -> Sunlight:
    limb, sun = search.around.limb, search.around.sun_itrf
    if not search.daylight:
        return Sunlight(limb, sun, None, None)
    cameras, frames = [v.camera for v in views], [v.frame for v in views]
    reach_m = limb.touch_range_m(search.prior.height_m)
    return Sunlight(
        limb,
        sun,
        limb_brightness(points, frames, cameras),
        limb_colour(points, frames, cameras, nadir_body, reach_m),
    )


def _best(fits: tuple[tuple[float, Fit], ...]) -> Fit:
    return max(fits, key=lambda weighted: weighted[0])[1]


def _judge(
    views: list[View], points: list[LimbPoints], result: Fit, search: Search
) -> list[CameraFit]:
    reach_m = search.around.limb.touch_range_m(result.height_m)
    judged = []
    for view, p, residual, tolerance in zip(
        views, points, result.residual_rad, result.tolerance_rad, strict=True
    ):
        verdict = judge_camera(p, residual, tolerance, view.camera, reach_m)
        pixel_m = view.camera.rad_per_px * reach_m
        passed = verdict.reason is None
        if search.daylight and passed and is_too_sharp(p, verdict.inlier, pixel_m):
            verdict = replace(verdict, reason=Reason.SHARP)
        judged.append(replace(verdict, reason=view.unusable or verdict.reason))
    return judged


def _no_lit_earth(view: View, points: LimbPoints, search: Search, rough: Fit) -> Reason | None:
    """Why what a camera shows can't be air before the sunlit Earth."""
    dark = is_dark_within(view.frame, view.camera, points, search.around, rough)
    return Reason.GLOWING_LAYER if dark or is_glowing_layer(points) else None


def _keep_reasons(
    judged: list[CameraFit], before: list[CameraFit], active: list[bool]
) -> list[CameraFit]:
    """The latest judgement; cameras set aside earlier keep why."""
    return [
        new if on else replace(new, reason=old.reason, arc_rad=old.arc_rad)
        for new, old, on in zip(judged, before, active, strict=True)
    ]


def _verdict(horizon: FoundHorizon, search: Search) -> Reason | None:
    """What speaks against the horizon as a whole."""
    good = [c for c in horizon.cameras if c.reason is None]
    if not good:
        return next(c.reason for c in horizon.cameras)
    predicted = search.heading_known or not search.daylight
    least_rad = MIN_ARC_OF_ALL_RAD if predicted else MIN_ARC_UNPREDICTED_RAD
    if sum(c.arc_rad for c in good) < least_rad:
        return Reason.SHORT_ARC
    if search.daylight:
        vague = judge_low_sun(horizon.best, search.around)
        if vague is not None:
            return vague
    limb_height_km = search.around.body.limb_height_km
    return judge_height(
        horizon.best,
        None if limb_height_km is None else limb_height_km * 1e3,
        search.prior.height_sigma_m,
    )


def _with_no_dissent(
    found: FoundHorizon, views: list[View], edges: list[Edges | None], search: Search
) -> FoundHorizon:
    """Refuse when a camera that was left out sees a good horizon of its own elsewhere."""
    best = found.best
    nadir_body = best.c_body_from_itrf @ search.around.limb.nadir_itrf
    for k, camera_fit in enumerate(found.cameras):
        if camera_fit.reason is None or views[k].unusable is not None:
            continue
        alone = _best_of_votes([views[k]], [edges[k]], search)
        if alone.reason is not None:
            continue
        other = alone.best
        angle = np.linalg.norm(other.c_body_from_itrf @ search.around.limb.nadir_itrf - nadir_body)
        spread = np.sqrt(np.trace(best.covariance[:2, :2]) + np.trace(other.covariance[:2, :2]))
        if angle > _DISAGREE_SIGMA * spread:
            cameras = list(found.cameras)
            cameras[k] = replace(camera_fit, reason=Reason.CAMERAS_DISAGREE)
            return replace(found, reason=Reason.CAMERAS_DISAGREE, cameras=tuple(cameras))
    return found


def _without_points(points: LimbPoints) -> LimbPoints:
    return replace(points, found=np.zeros(len(points), dtype=bool))


def _failure(points: list[LimbPoints], result: Fit, cameras: list[CameraFit]) -> FoundHorizon:
    reasons = [c.reason for c in cameras if c.reason is not None]
    longest = max(cameras, key=lambda c: c.arc_rad)
    return FoundHorizon(
        reason=longest.reason or (reasons[0] if reasons else Reason.NO_HORIZON),
        fits=((1.0, result),),
        cameras=tuple(cameras),
        points=tuple(points),
    )


def _none(views: list[View], reason: Reason) -> FoundHorizon:
    cameras = tuple(
        CameraFit(
            reason=view.unusable or reason,
            arc_rad=0.0,
            residual_px=float("nan"),
            inlier=np.zeros(0, dtype=bool),
        )
        for view in views
    )
    return FoundHorizon(reason=reason, fits=(), cameras=cameras, points=())
