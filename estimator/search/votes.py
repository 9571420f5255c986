"""The nadirs that the edges of all cameras vote for, with no attitude known.

A limb ray d whose bright side lies along t (a unit vector across d) has its nadir at
n = d cos(eta) + t sin(eta), sin(eta) = (R + h) / |r|; two limb rays leave two nadirs, the
meets of their cones.  Candidates from both kinds are scored by the edges they explain.
The Earth is a sphere here: its flattening moves the limb by 0.05 deg, well inside the band.
"""

from dataclasses import dataclass

import numpy as np

from estimator.search.edges import Edges
from planner.base.arrays import Array

_PAIRS = 1500
_CANDIDATES = 500
_COUNTED = 30
_BEST = 5
_GRADIENT_COSINE = 0.90
_BAND_RAD = np.deg2rad(0.5)  # off the limb's angle, where an edge still counts
_APART_RAD = np.deg2rad(1.0)
_BIN_RAD = np.deg2rad(4.0)


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
    first, second = rng.choice(len(edges), (_PAIRS, 2), p=chance).T
    candidates.append(_shared_nadirs(edges.at(first), edges.at(second), cone.cosine))
    if predicted_body is not None:
        candidates.append(predicted_body[None])
    nadirs_body = np.concatenate(candidates)
    promising = nadirs_body[np.argsort(-_scores(nadirs_body, edges, cone))[:_COUNTED]]
    scores = np.array([_coverage(nadir_body, edges, cone) for nadir_body in promising])
    best: list[Array] = []
    for k in np.argsort(-scores, kind="stable"):
        near = any(promising[k] @ better > np.cos(_APART_RAD) for better in best)
        if scores[k] > 0.0 and not near:
            best.append(promising[k])
        if len(best) == _BEST:
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
    return np.concatenate(chosen)[:_CANDIDATES]


def _scores(nadirs_body: Array, edges: Edges, cone: _LimbCone) -> Array:
    """Weight of the edges each nadir (m, 3) explains, (m,); 1e-6 of precision are plenty."""
    single = nadirs_body.T.astype(np.float32)
    near = edges.ray_body.astype(np.float32) @ single
    near -= np.float32(cone.cosine)
    near *= near
    near *= np.float32(-((cone.sine * _BAND_RAD) ** -2))
    near += np.float32(1.0)
    np.maximum(near, 0.0, out=near)
    inward = edges.inward_body.astype(np.float32) @ single
    near *= inward > np.float32(_GRADIENT_COSINE * cone.sine)
    return np.asarray(edges.weight.astype(np.float32) @ near, dtype=float)


def _coverage(nadir_body: Array, edges: Edges, cone: _LimbCone) -> float:
    """Bins of azimuth about the nadir that hold edges it explains, weighted by the best ones.

    Counting bins and not edges keeps a thick tangle of cloud edges from outvoting a thin limb.
    """
    off_rad = (edges.ray_body @ nadir_body - cone.cosine) / cone.sine
    inward = edges.inward_body @ nadir_body > _GRADIENT_COSINE * cone.sine
    near = (np.abs(off_rad) < _BAND_RAD) & inward
    if not np.any(near):
        return 0.0
    first_body = np.cross(nadir_body, np.eye(3)[np.argmin(np.abs(nadir_body))])
    first_body /= np.linalg.norm(first_body)
    second_body = np.cross(nadir_body, first_body)
    azimuth_rad = np.arctan2(edges.ray_body[near] @ second_body, edges.ray_body[near] @ first_body)
    bins = ((azimuth_rad + np.pi) / _BIN_RAD).astype(int)
    strength = edges.weight[near] * (1.0 - (off_rad[near] / _BAND_RAD) ** 2)
    best = np.zeros(bins.max() + 1)
    np.maximum.at(best, bins, strength)
    return float(best.sum())
