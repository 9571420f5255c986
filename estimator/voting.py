"""The nadirs that the edges of all cameras vote for, with no attitude known.

A limb ray d whose bright side lies along t (a unit vector across d) has its nadir at
n = d cos(eta) + t sin(eta), sin(eta) = (R + h) / |r|; two limb rays leave two nadirs, the
meets of their cones.  Candidates from both kinds are scored by the edges they explain.
The Earth is a sphere here: its flattening moves the limb by 0.05 deg, well inside the band.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from estimator.candidates import Edges
from planner.arrays import Array

_PAIRS = 1500
_CANDIDATES = 500
_COUNTED = 30
_BEST = 8
_GRADIENT_COSINE = 0.90
_APART_RAD = np.deg2rad(1.0)
_BIN_RAD = np.deg2rad(4.0)


@dataclass(frozen=True)
class Vote:
    """A nadir in body axes (3,) and how much limb speaks for it, in bins of 4 deg azimuth."""

    nadir_body: Array
    score: float


def vote(
    edges: list[Edges], eta_rad: float, band_rad: float, predicted_body: Array | None, seed: int
) -> list[Vote]:
    """Up to eight nadirs, best first, none within 1 deg of a better one.

    eta_rad: angle from nadir to limb.  band_rad: how far off it an edge still counts.
    predicted_body: a nadir to be scored along with the others; it gets no credit.
    """
    ray = np.concatenate([e.ray_body for e in edges])
    inward = np.concatenate([e.inward_body for e in edges])
    weight = np.concatenate([e.weight for e in edges])
    if len(ray) < 8:
        return []
    rng = np.random.default_rng(seed)
    cosine, sine = np.cos(eta_rad), np.sin(eta_rad)
    chance = weight**2 + 1e-9
    chance /= chance.sum()
    single = rng.choice(len(ray), min(200, len(ray)), replace=False, p=chance)
    candidates = [cosine * ray[single] + sine * inward[single]]
    candidates.append(_meets(ray, inward, rng.choice(len(ray), (_PAIRS, 2), p=chance), cosine))
    if predicted_body is not None:
        candidates.append(predicted_body[None])
    nadir = np.concatenate(candidates)
    found: list[Vote] = []
    rough = _scores(nadir, ray, inward, weight, cosine, sine, band_rad)
    order = np.argsort(-rough)[:_COUNTED]
    scored = [(_coverage(nadir[k], ray, inward, weight, cosine, sine, band_rad), k) for k in order]
    for score, k in sorted(scored, key=lambda pair: -pair[0]):
        near = any(nadir[k] @ other.nadir_body > np.cos(_APART_RAD) for other in found)
        if score > 0.0 and not near:
            found.append(Vote(nadir_body=nadir[k], score=float(score)))
        if len(found) == _BEST:
            break
    return found


def _meets(ray: Array, inward: Array, pair: NDArray[np.int64], cosine: float) -> Array:
    """Nadirs at the given angle from both rays of each pair, where both gradients agree."""
    a, b = ray[pair[:, 0]], ray[pair[:, 1]]
    together = np.sum(a * b, axis=1)
    apart = (together < np.cos(np.deg2rad(4.0))) & (together > -0.999)
    a, b, together, pair = a[apart], b[apart], together[apart], pair[apart]
    middle = (cosine / (1.0 + together))[:, None] * (a + b)
    across = np.cross(a, b)
    rest = 1.0 - np.sum(middle**2, axis=1)
    real = rest > 0.0
    side = np.sqrt(np.where(real, rest, 0.0)) / np.linalg.norm(across, axis=1)
    chosen = []
    for sign in (-1.0, 1.0):
        nadir = (middle + sign * side[:, None] * across)[real]
        agree = np.ones(len(nadir), dtype=bool)
        for k in (0, 1):
            d, t = ray[pair[real, k]], inward[pair[real, k]]
            wanted = nadir - cosine * d
            agree &= np.sum(wanted * t, axis=1) > 0.9 * np.linalg.norm(wanted, axis=1)
        chosen.append(nadir[agree])
    return np.concatenate(chosen)[:_CANDIDATES]


def _scores(
    nadir: Array,
    ray: Array,
    inward: Array,
    weight: Array,
    cosine: float,
    sine: float,
    band_rad: float,
) -> Array:
    """Weight of the edges each nadir explains, shape (m,); 1e-6 of precision are plenty."""
    single = nadir.T.astype(np.float32)
    near = ray.astype(np.float32) @ single
    near -= np.float32(cosine)
    near *= near
    near *= np.float32(-((sine * band_rad) ** -2))
    near += np.float32(1.0)
    np.maximum(near, 0.0, out=near)
    near *= inward.astype(np.float32) @ single > np.float32(_GRADIENT_COSINE * sine)
    return np.asarray(weight.astype(np.float32) @ near, dtype=float)


def _coverage(
    nadir: Array,
    ray: Array,
    inward: Array,
    weight: Array,
    cosine: float,
    sine: float,
    band_rad: float,
) -> float:
    """Bins of azimuth about the nadir that hold edges it explains, weighted by the best ones.

    Counting bins and not edges keeps a thick tangle of cloud edges from outvoting a thin limb.
    """
    off = (ray @ nadir - cosine) / sine
    near = (np.abs(off) < band_rad) & (inward @ nadir > _GRADIENT_COSINE * sine)
    if not np.any(near):
        return 0.0
    first = np.cross(nadir, np.eye(3)[np.argmin(np.abs(nadir))])
    first /= np.linalg.norm(first)
    second = np.cross(nadir, first)
    azimuth = np.arctan2(ray[near] @ second, ray[near] @ first)
    bins = ((azimuth + np.pi) / _BIN_RAD).astype(int)
    strength = weight[near] * (1.0 - (off[near] / band_rad) ** 2)
    best = np.zeros(bins.max() + 1)
    np.maximum.at(best, bins, strength)
    return float(best.sum())
