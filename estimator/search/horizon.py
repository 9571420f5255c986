"""Picks, of the nadirs voted for, the horizon that stands up to every test."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from estimator.camera import HorizonCamera
from estimator.errors import Reason
from estimator.images import Frame
from estimator.search.edges import Edges
from estimator.search.plausibility import unusable_frame
from estimator.search.trial import Search, SearchResult, View, blank_part, try_attitude
from planner.base.arrays import Array

# The nadirs that the edges of all cameras vote for, with no attitude known.
#
# A limb ray d whose bright side lies along t (a unit vector across d) has its nadir at
# n = d cos(eta) + t sin(eta), sin(eta) = (R + h) / |r|; two limb rays leave two nadirs, the
# meets of their cones.  Candidates from both kinds are scored by the edges they explain.
# The Earth is a sphere here: its flattening moves the limb by 0.05 deg, well inside the band.


@dataclass(frozen=True, kw_only=True)
class VoteOptions:
    """How edges vote for nadir."""

    pairs: int = 1500  # of edges, drawn: each gives nadir in two places
    candidates: int = 500  # of these, counted roughly
    counted: int = 30  # of the best, counted with all edges
    best: int = 5  # kept, to be tried
    # of the angle between an edge's gradient and nadir: a limb grows bright inwards
    gradient_cosine: float = 0.90
    band_rad: float = np.deg2rad(0.5)  # off the limb's angle, where an edge still counts
    apart_rad: float = np.deg2rad(1.0)  # nearer ones are one
    # of azimuth, in which edges count once: long ones count for their length
    bin_rad: float = np.deg2rad(4.0)


OPTIONS = VoteOptions()


@dataclass(frozen=True)
class _LimbCone:
    """The angle from nadir to limb, eta."""

    cosine: float
    sine: float


def vote(
    per_camera: list[Edges], eta_rad: float, predicted_body: Array | None, seed: int
) -> list[Array]:
    """Up to five nadirs (3,) in body axes, best first, none within 1 deg of a better one.

    Their score is the limb that speaks for them, in bins of 4 deg of azimuth.
    eta_rad: angle from nadir to limb.
    predicted_body: a nadir to be scored along with the others; it gets no credit.
    """
    edges = Edges(
        ray_body=np.concatenate([e.ray_body for e in per_camera]),
        inward_body=np.concatenate([e.inward_body for e in per_camera]),
        weight=np.concatenate([e.weight for e in per_camera]),
    )
    if len(edges) < 8:
        return []
    rng = np.random.default_rng(seed)
    cone = _LimbCone(float(np.cos(eta_rad)), float(np.sin(eta_rad)))
    chance = edges.weight**2 + 1e-9
    chance /= chance.sum()
    single = edges.at(rng.choice(len(edges), min(200, len(edges)), replace=False, p=chance))
    candidates = [cone.cosine * single.ray_body + cone.sine * single.inward_body]
    first, second = rng.choice(len(edges), (OPTIONS.pairs, 2), p=chance).T
    candidates.append(_shared_nadirs(edges.at(first), edges.at(second), cone.cosine))
    if predicted_body is not None:
        candidates.append(predicted_body[None])
    nadirs_body = np.concatenate(candidates)
    promising = nadirs_body[np.argsort(-_scores(nadirs_body, edges, cone))[: OPTIONS.counted]]
    scores = np.array([_coverage(nadir_body, edges, cone) for nadir_body in promising])
    best: list[Array] = []
    for k in np.argsort(-scores, kind="stable"):
        near = any(promising[k] @ better > np.cos(OPTIONS.apart_rad) for better in best)
        if scores[k] > 0.0 and not near:
            best.append(promising[k])
        if len(best) == OPTIONS.best:
            break
    return best


def _shared_nadirs(first: Edges, second: Edges, cosine: float) -> Array:
    """Nadirs at the given angle from both rays of each pair, where both gradients agree."""
    together = np.sum(first.ray_body * second.ray_body, axis=1)
    apart = np.flatnonzero((together < np.cos(np.deg2rad(4.0))) & (together > -0.999))
    first, second, together = first.at(apart), second.at(apart), together[apart]
    middle_body = (cosine / (1.0 + together))[:, None] * (first.ray_body + second.ray_body)
    across_body = np.cross(first.ray_body, second.ray_body)
    rest = 1.0 - np.sum(middle_body**2, axis=1)
    real = np.flatnonzero(rest > 0.0)
    side = np.sqrt(np.maximum(rest, 0.0)) / np.linalg.norm(across_body, axis=1)
    chosen = []
    for sign in (-1.0, 1.0):
        nadirs_body = (middle_body + sign * side[:, None] * across_body)[real]
        agree = np.ones(len(nadirs_body), dtype=bool)
        for edge in (first.at(real), second.at(real)):
            wanted_body = nadirs_body - cosine * edge.ray_body
            along = np.sum(wanted_body * edge.inward_body, axis=1)
            agree &= along > 0.9 * np.linalg.norm(wanted_body, axis=1)
        chosen.append(nadirs_body[agree])
    return np.concatenate(chosen)[: OPTIONS.candidates]


def _scores(nadirs_body: Array, edges: Edges, cone: _LimbCone) -> Array:
    """Weight of the edges each nadir (m, 3) explains, (m,); 1e-6 of precision are plenty."""
    single = nadirs_body.T.astype(np.float32)
    near = edges.ray_body.astype(np.float32) @ single
    near -= np.float32(cone.cosine)
    near *= near
    near *= np.float32(-((cone.sine * OPTIONS.band_rad) ** -2))
    near += np.float32(1.0)
    np.maximum(near, 0.0, out=near)
    inward = edges.inward_body.astype(np.float32) @ single
    near *= inward > np.float32(OPTIONS.gradient_cosine * cone.sine)
    return np.asarray(edges.weight.astype(np.float32) @ near, dtype=float)


def _coverage(nadir_body: Array, edges: Edges, cone: _LimbCone) -> float:
    """Bins of azimuth about the nadir that hold edges it explains, weighted by the best ones.

    Counting bins and not edges keeps a thick tangle of cloud edges from outvoting a thin limb.
    """
    off_rad = (edges.ray_body @ nadir_body - cone.cosine) / cone.sine
    inward = edges.inward_body @ nadir_body > OPTIONS.gradient_cosine * cone.sine
    near = (np.abs(off_rad) < OPTIONS.band_rad) & inward
    if not np.any(near):
        return 0.0
    first_body = np.cross(nadir_body, np.eye(3)[np.argmin(np.abs(nadir_body))])
    first_body /= np.linalg.norm(first_body)
    second_body = np.cross(nadir_body, first_body)
    azimuth_rad = np.arctan2(edges.ray_body[near] @ second_body, edges.ray_body[near] @ first_body)
    bins = ((azimuth_rad + np.pi) / OPTIONS.bin_rad).astype(int)
    strength = edges.weight[near] * (1.0 - (off_rad[near] / OPTIONS.band_rad) ** 2)
    best = np.zeros(bins.max() + 1)
    np.maximum.at(best, bins, strength)
    return float(best.sum())


_DISAGREE_SIGMA = 5.0
_SEED = 20161
_SHAPES = (Reason.NO_HORIZON, Reason.BROKEN_ARC, Reason.ELSEWHERE, Reason.RESIDUALS)
_UNEXPLAINED = (*_SHAPES, Reason.COLOUR)
_LIGHTS = (Reason.GLOWING_LAYER, Reason.BLURRED, Reason.SHARP, Reason.NO_SKY, Reason.SATURATED)
_GLARE = (*_UNEXPLAINED, *_LIGHTS, Reason.LIMB_HEIGHT)  # what the Sun's may look like
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
    reasons = [part.agreement.reason for part in parts]
    common = result.reason
    if common in _GLARE and Reason.SUN_IN_FRAME in reasons:
        common = Reason.SUN_IN_FRAME
    elif common in _UNEXPLAINED:
        common = next((one for one in reasons if one and one not in _UNEXPLAINED), common)
    return replace(result, reason=common, parts=parts)


def _plainer(reason: Reason | None, view: View, search: Search) -> Reason | None:
    around, c_predicted = search.around, search.c_body_from_itrf_predicted
    if reason not in _GLARE or not around.daylight:
        return reason
    if c_predicted is not None and around.is_sun_in_frame(view.camera, c_predicted):
        return Reason.SUN_IN_FRAME
    if reason in _UNEXPLAINED and reason is not Reason.RESIDUALS and not _has_sky(view.frame):
        return Reason.NO_SKY
    return reason


def _has_sky(frame: Frame) -> bool:
    seen = frame.grey[::2, ::2][frame.usable[::2, ::2]]
    if seen.size == 0:
        return True
    dark, bright = np.percentile(seen, [5.0, 99.0])
    return bool(dark < _SKY_SHARE * bright)
