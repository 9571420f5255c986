"""One trial: the limb near a trial attitude, fitted to all cameras' frames and judged."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.special import logsumexp

from estimator.camera import HorizonCamera
from estimator.errors import Reason
from estimator.images import Frame
from estimator.limb.geometry import Limb
from estimator.limb.points import LimbPoints, find_limb, no_points
from estimator.limb.projection import LimbProjection
from estimator.nadir.fit import (
    Doubt,
    Fit,
    Prior,
    attitude_facing,
    attitude_with_nadir,
    fit,
    possible_fits,
)
from estimator.search.edges import Edges, find_edges
from estimator.search.plausibility import (
    OPTIONS as PLAUSIBILITY_OPTIONS,
)
from estimator.search.plausibility import (
    CameraFit,
    is_dark_within,
    is_glowing_layer,
    judge_camera,
    judge_height,
    judge_low_sun,
)
from estimator.search.sunlight import is_no_bluer_above, sunlight_along
from estimator.search.tone import fade_ratio, linear
from estimator.surroundings import Surroundings
from planner.base.arrays import Array


@dataclass(frozen=True, kw_only=True)
class TrialOptions:
    """How limbs are tried from a first guess of nadir to the last fit."""

    first_window_rad: float = np.deg2rad(1.4)  # to either side of the limb as guessed,
    # and as fitted, ever nearer
    windows_rad: tuple[float, float] = (np.deg2rad(0.7), np.deg2rad(0.6))
    promising: float = 0.25  # of the points' arc that must agree in one camera, to go on
    first_headings: int = 8  # tried where none is known,
    headings: int = 16  # and between the best of these
    # by how much the brightness may speak against a heading, in chi-square: between two of the
    # first, 45 deg apart, it changes by as much
    unlikely: float = 14.0
    # less that a heading's likelihood counts for the covariance: no model may know the air in view
    doubt: float = 2.0
    # one request in ten has another lens than stated, and one another shutter than not stated;
    # with twice as many, sigma grows by a sixth where all is as stated
    doubted_share: float = 0.1
    doubted_readout_s: float = 0.07  # rolling shutters take 10 to 100 ms
    thinned: int = 8  # points one is kept, while headings are compared
    layer_least_m: float = 70e3  # Airglow lies at 80 to 100 km; lower is no layer
    any_height_m: float = 50e3  # a limb's height is then as good as unknown before its fit:
    any_height_sigma_m: float = 50e3  # so widely
    sure_sigma: float = 2.0  # by which a height must be below a layer's
    unfitted_cost: float = 1e12  # of a fit that isn't one: above any that is, and finite


OPTIONS = TrialOptions()


@dataclass(frozen=True)
class View:
    """A camera and its frame.  unusable: why it can't take part, whatever the attitude."""

    camera: HorizonCamera
    frame: Frame
    unusable: Reason | None
    seed: int

    @cached_property
    def edges(self) -> Edges:
        return find_edges(self.frame, self.camera, self.seed)


@dataclass(frozen=True)
class CameraPart:
    """One camera's part in a trial.

    points: the limb it shows near the trial attitude; none found once it is set aside.
    agreement: with the fit; its reason is why the camera is set aside.
    """

    view: View
    points: LimbPoints
    agreement: CameraFit

    @property
    def used(self) -> bool:
        return self.agreement.reason is None

    def with_reason(self, reason: Reason | None) -> "CameraPart":
        return replace(self, agreement=replace(self.agreement, reason=reason))


@dataclass(frozen=True)
class Search:
    """Everything that stays the same while nadirs are tried."""

    around: Surroundings
    prior: Prior
    c_body_from_itrf_predicted: Array | None

    @property
    def heading_known(self) -> bool:
        return self.c_body_from_itrf_predicted is not None

    def projection(self, view: View, c_body_from_itrf: Array, height_m: float) -> LimbProjection:
        return LimbProjection(view.camera, self.around.limb, c_body_from_itrf, height_m)

    def start(self, nadir_body: Array) -> Array:
        """A c_body_from_itrf (3, 3) that puts geodetic nadir there."""
        if self.c_body_from_itrf_predicted is None:
            return attitude_facing(nadir_body, self.around.limb)
        return attitude_with_nadir(self.c_body_from_itrf_predicted, nadir_body, self.around.limb)


@dataclass(frozen=True)
class SearchResult:
    """The horizon found, or why none was.

    fits: the fit, or one for each heading tried when no heading was known; empty when nothing
    could be tried.  parts: one per view.
    """

    reason: Reason | None
    fits: tuple[Fit, ...]
    parts: tuple[CameraPart, ...]

    @property
    def best(self) -> Fit:
        return _likeliest(self.fits)

    @property
    def arc_rad(self) -> float:
        """Limb found by all cameras together."""
        return sum(part.agreement.arc_rad for part in self.parts)


def try_attitude(views: Sequence[View], search: Search, c_body_from_itrf: Array) -> SearchResult:
    """Fit the limb from a trial attitude, judge it, and keep the cameras that pass."""
    parts, result = _first_fit(views, search, c_body_from_itrf)
    if search.around.daylight and _is_tone_mapped(parts, result, search):
        views = [replace(view, frame=linear(view.frame)) for view in views]
        parts, result = _first_fit(views, search, result.c_body_from_itrf)
    first = _judge(parts, result, search)
    if all(part.agreement.arc_rad < OPTIONS.promising * part.points.arc_rad for part in first):
        return _failure(first, result)
    # In so wide a window only the night sets a camera aside.
    parts = [
        judged.with_reason(part.agreement.reason or _night_reason(judged, search, result))
        for part, judged in zip(parts, first, strict=True)
    ]
    for window_rad in OPTIONS.windows_rad:
        if not any(part.used for part in parts):
            return _failure(parts, result)
        c_body_from_itrf, height_m = result.c_body_from_itrf, result.height_m
        parts = [_look(part, search, c_body_from_itrf, height_m, window_rad) for part in parts]
        result, parts = _fit_and_judge(parts, search, c_body_from_itrf)
    if not any(part.used for part in parts):
        return _failure(parts, result)
    parts = [
        part if part.used else replace(part, points=part.points.without_edges()) for part in parts
    ]
    fits = _fits_all_round(parts, search, result.c_body_from_itrf, OPTIONS.headings, tuple(Doubt))
    _, parts = _fit_and_judge(parts, search, _likeliest(fits).c_body_from_itrf)
    horizon = SearchResult(None, fits, tuple(parts))
    return replace(horizon, reason=_common_reason(horizon, search))


def blank_part(view: View, reason: Reason | None) -> CameraPart:
    """A view in which no limb has been looked for, set aside where there is a reason."""
    points = no_points(view.camera)
    return CameraPart(view, points, CameraFit(reason, 0.0, float("nan"), points.found))


def _first_fit(
    views: Sequence[View], search: Search, c_body_from_itrf: Array
) -> tuple[list[CameraPart], Fit]:
    height_m = search.prior.height_m
    parts = [
        _look(
            blank_part(view, view.unusable),
            search,
            c_body_from_itrf,
            height_m,
            OPTIONS.first_window_rad,
        )
        for view in views
    ]
    if not search.heading_known:
        fits = _fits_all_round(parts, search, c_body_from_itrf, OPTIONS.first_headings)
        c_body_from_itrf = _likeliest(fits).c_body_from_itrf
    return parts, _fit(parts, search, c_body_from_itrf)


def _look(
    part: CameraPart, search: Search, c_body_from_itrf: Array, height_m: float, window_rad: float
) -> CameraPart:
    """The part with the limb points that lie within a window of where they should."""
    view, around = part.view, search.around
    projection = search.projection(view, c_body_from_itrf, height_m)
    points = find_limb(view.frame, projection, window_rad, around.air_scale_m)
    if not part.used:
        return replace(part, points=points.without_edges())
    # Without a prediction the first window's brightness tells the Sun's side for the next.
    facing_known = search.heading_known or window_rad < OPTIONS.first_window_rad
    if around.daylight and facing_known and len(points):
        lit = around.well_lit(points.azimuth_rad, height_m)
        points = replace(points, found=points.found & lit, blocked=points.blocked | ~lit)
    return replace(part, points=points)


def _fit(parts: Sequence[CameraPart], search: Search, c_body_from_itrf: Array) -> Fit:
    return fit([part.points for part in parts], search.around.limb, c_body_from_itrf, search.prior)


def _is_tone_mapped(parts: Sequence[CameraPart], rough: Fit, search: Search) -> bool:
    """Whether the files hold pictures for people instead of light.

    The cameras of one craft store alike, so they are judged together.
    """
    c_body_from_itrf, height_m = rough.c_body_from_itrf, rough.height_m
    ratios = [
        fade_ratio(p.view.frame, p.points, search.projection(p.view, c_body_from_itrf, height_m))
        for p in parts
        if p.used
    ]
    known = [ratio for ratio in ratios if ratio is not None]
    return bool(known) and float(np.mean(known)) > 1.0


def _fits_all_round(
    parts: Sequence[CameraPart],
    search: Search,
    c_body_from_itrf: Array,
    headings: int,
    doubts: Sequence[Doubt] = (),
) -> tuple[Fit, ...]:
    """The fits from the heading known, or from those all round, by the cameras as stated and by
    each doubt, with their weights."""
    limb, around = search.around.limb, search.around
    if search.heading_known:
        return _fits_near(parts, search, c_body_from_itrf, doubts)
    prior = replace(search.prior, heading_sigma_rad=np.pi / headings)
    nadir_body = c_body_from_itrf @ limb.nadir_geodetic_itrf
    points = [part.points.every(OPTIONS.thinned) for part in parts]
    frames, cameras = [part.view.frame for part in parts], [part.view.camera for part in parts]
    light = sunlight_along(points, frames, cameras, around, nadir_body, prior.height_m)
    turns_rad = np.arange(headings) * (2.0 * np.pi / headings)
    facing = [attitude_facing(nadir_body, limb, turn_rad) for turn_rad in turns_rad]
    costs = np.array([light.cost(c, prior.height_m) for c in facing])
    likely = [
        c for c, cost in zip(facing, costs - costs.min(), strict=True) if cost < OPTIONS.unlikely
    ]
    models = _models(points, parts, prior, doubts)
    rows = [
        row
        for c in likely
        for row in zip(*(possible_fits(f, limb) for f in _fits_of(models, limb, c)), strict=True)
    ]
    # Doubts move a fit by less than the light can tell.
    lit = [[light.cost(row[0].c_body_from_itrf, row[0].height_m)] for row in rows]
    return _weighed(rows, models, np.array(lit))


def _fits_near(
    parts: Sequence[CameraPart], search: Search, c_body_from_itrf: Array, doubts: Sequence[Doubt]
) -> tuple[Fit, ...]:
    models = _models([part.points for part in parts], parts, search.prior, doubts)
    return _weighed([_fits_of(models, search.around.limb, c_body_from_itrf)], models)


@dataclass(frozen=True)
class _Model:
    """Limb points and prior by the cameras as stated, or by one doubt; share: how likely, before
    anything is seen."""

    points: list[LimbPoints]
    prior: Prior
    doubt: Doubt | None
    share: float


def _models(
    points: list[LimbPoints], parts: Sequence[CameraPart], prior: Prior, doubts: Sequence[Doubt]
) -> list[_Model]:
    """As stated first."""
    stated = [part.view.camera for part in parts]
    # Neither the sign of what an unknown shutter sees of the rate is known nor its size.
    any_rate = replace(
        prior,
        rate_body_rad_s=(0.0, 0.0, 0.0),
        rate_sigma_rad_s=float(
            np.hypot(np.linalg.norm(prior.rate_body_rad_s), prior.rate_sigma_rad_s)
        ),
    )
    others = {
        Doubt.LENS: ([c.with_doubted_lens() for c in stated], prior),
        Doubt.SHUTTER: (
            [c.with_doubted_shutter(OPTIONS.doubted_readout_s) for c in stated],
            any_rate,
        ),
    }
    models = [
        _Model(
            [p.taken_by(camera) for p, camera in zip(points, cameras, strict=True)],
            own_prior,
            doubt,
            OPTIONS.doubted_share,
        )
        for doubt, (cameras, own_prior) in others.items()
        if doubt in doubts and cameras != stated
    ]
    return [_Model(points, prior, None, 1.0 - sum(model.share for model in models)), *models]


def _fits_of(models: Sequence[_Model], limb: Limb, c_body_from_itrf: Array) -> list[Fit]:
    fits: list[Fit] = []
    for model in models:
        # Doubts start where the fit of what is stated ended.
        start = fits[0].c_body_from_itrf if fits else c_body_from_itrf
        found = fit(model.points, limb, start, model.prior)
        fits.append(replace(found, doubt=model.doubt))
    return fits


def _weighed(
    rows: Sequence[Sequence[Fit]], models: Sequence[_Model], light_cost: Array | float = 0.0
) -> tuple[Fit, ...]:
    """Fits with their weights: a row for each heading, a column for each model."""
    cost = np.array([[min(f.cost, OPTIONS.unfitted_cost) for f in row] for row in rows])
    log_likely = -0.5 * (cost + light_cost) + np.log([model.share for model in models])
    log_heading = logsumexp(log_likely, axis=1, keepdims=True)
    careful = log_likely - log_heading + log_heading / OPTIONS.doubt
    weight, careful_weight = (np.exp(x - logsumexp(x)) for x in (log_likely, careful))
    return tuple(
        replace(f, weight=float(weight[k, m]), careful_weight=float(careful_weight[k, m]))
        for k, row in enumerate(rows)
        for m, f in enumerate(row)
    )


def _likeliest(fits: Sequence[Fit]) -> Fit:
    return max(fits, key=lambda one: one.weight)


def _judge(parts: Sequence[CameraPart], result: Fit, search: Search) -> list[CameraPart]:
    """How each camera agrees with the fit; those set aside earlier keep why, and their arc."""
    judged = []
    for part, residual_rad, tolerance_rad in zip(
        parts, result.residual_rad, result.tolerance_rad, strict=True
    ):
        agreement = judge_camera(
            part.points,
            residual_rad,
            tolerance_rad,
            part.view.camera,
            search.around,
            result.height_m,
        )
        if not part.used:
            agreement = replace(
                agreement, reason=part.agreement.reason, arc_rad=part.agreement.arc_rad
            )
        judged.append(replace(part, agreement=agreement))
    return judged


def _fit_and_judge(
    parts: Sequence[CameraPart], search: Search, c_body_from_itrf: Array
) -> tuple[Fit, list[CameraPart]]:
    """By the cameras as stated, or by the likeliest doubt where a limb fits none so."""
    result = _fit(parts, search, c_body_from_itrf)
    judged = _judge(parts, result, search)
    unfit = (part.agreement.reason is Reason.RESIDUALS for part in judged)
    if any(part.used and misfits for part, misfits in zip(parts, unfit, strict=True)):
        result = _likeliest(_fits_near(parts, search, result.c_body_from_itrf, tuple(Doubt)))
        judged = _judge(parts, result, search)
    return result, judged


def _night_reason(part: CameraPart, search: Search, rough: Fit) -> Reason | None:
    """Why what a camera shows can't be air before the sunlit Earth."""
    if not search.around.daylight:
        return None
    view, points = part.view, part.points
    dark = is_dark_within(view.frame, view.camera, points, search.around, rough)
    if dark or (is_glowing_layer(points) and not _curves_as_low(part, search, rough)):
        return Reason.GLOWING_LAYER
    limb = search.around.limb
    nadir_body, reach_m = rough.c_body_from_itrf @ limb.nadir_itrf, limb.touch_range_m(0.0)
    foreign = is_no_bluer_above(points, view.frame, view.camera, nadir_body, reach_m)
    return Reason.COLOUR if foreign else None


def _curves_as_low(part: CameraPart, search: Search, rough: Fit) -> bool:
    """Whether the limb's curvature alone says that it lies lower than any glowing layer."""
    prior = replace(
        search.prior, height_m=OPTIONS.any_height_m, height_sigma_m=OPTIONS.any_height_sigma_m
    )
    free = _fit((part,), replace(search, prior=prior), rough.c_body_from_itrf)
    sigma_m = float(np.sqrt(free.covariance_matrix[3, 3]))
    return free.height_m + OPTIONS.sure_sigma * sigma_m < OPTIONS.layer_least_m


def _common_reason(horizon: SearchResult, search: Search) -> Reason | None:
    """What speaks against the horizon as a whole."""
    if not any(part.used for part in horizon.parts):
        return horizon.parts[0].agreement.reason
    around = search.around
    predicted = search.heading_known or not around.daylight
    least_rad = (
        PLAUSIBILITY_OPTIONS.min_arc_of_all_rad
        if predicted
        else PLAUSIBILITY_OPTIONS.min_arc_unpredicted_rad
    )
    if sum(part.agreement.arc_rad for part in horizon.parts if part.used) < least_rad:
        return Reason.SHORT_ARC
    return judge_low_sun(horizon.best, around) or judge_height(horizon.best, around.body)


def _failure(parts: Sequence[CameraPart], result: Fit) -> SearchResult:
    """Nothing found, for the reason of the camera that showed most of a limb."""
    longest = max(parts, key=lambda part: part.agreement.arc_rad)
    reasons = [longest.agreement.reason, *(part.agreement.reason for part in parts)]
    reason = next((one for one in reasons if one is not None), Reason.NO_HORIZON)
    return SearchResult(reason, (result,), tuple(parts))
