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
