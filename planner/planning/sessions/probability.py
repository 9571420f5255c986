"""The probability that a sum of independent errors stays within a frame."""

import math
from collections.abc import Sequence
from functools import cache

import numpy as np
from numpy.typing import NDArray

from planner.base.arrays import Array
from planner.world.orbits.accuracy import GAUSS, NormalMixture

DRAWS = 1 << 14
EVERY = 4  # instants, of which one is looked at first
SHORT_ROUNDS = 2e-5  # of a place's parts: 26 roundings of 6e-8, points of at most 8


def probability_inside(
    offsets_rad: Array,
    half_rad: Array,
    known_rad: Array,
    swings_rad: Sequence[Array] = (),
    along: NormalMixture = GAUSS,
    *,
    every: int = 1,
) -> float:
    """Probability that a sum of independent errors never leaves the frame.

    offsets_rad: shape (m, n, 2), where a 1-sigma constant error of each of m causes puts the
    target in the image at n instants.  half_rad: shape (2,).  known_rad: (n, 2), where the target
    is without errors.  swings_rad: (2, n, 2) of each sinusoid, times 1 / sqrt(2) what it puts
    there when its phase is 0 and a quarter turn, every phase as likely.  along: the distribution
    of the last cause; the others follow Gauss's.
    By 16384 quasi-random points, good to 0.003 (0.001 where few are lost), or each `every`-th.
    Source: Genz and Bretz 2009, section 4.2 (Richtmyer lattices).
    """
    if not (half_rad > 0.0).all():
        return 0.0
    known = np.broadcast_to(known_rad / half_rad, offsets_rad.shape[1:])
    parts = np.concatenate(
        [offsets_rad / half_rad, *(s / half_rad for s in swings_rad), known[None]]
    )
    points, short, lengths = _points(len(offsets_rad), len(swings_rad), every)
    if along != GAUSS:
        points = mixture_points(points, len(offsets_rad) - 1, along)
        short, lengths = points.astype(np.float32), np.linalg.norm(points, axis=0)
    # A few instants tell nearly all draws: between them none goes farther from a straight line
    # than its parts bend, times its length.
    instants = np.arange(len(known))
    few = np.append(instants[:-1:EVERY], instants[-1])
    before = np.searchsorted(few, instants, side="right") - 1
    after = np.minimum(before + 1, len(few) - 1)
    share = ((instants - few[before]) / np.maximum(few[after] - few[before], 1))[:, None]
    bend = parts - (1.0 - share) * parts[:, few[before]] - share * parts[:, few[after]]
    rounds = SHORT_ROUNDS * (1.0 + np.abs(parts).sum(axis=0).max())
    bends = np.linalg.norm(bend[:-1], axis=0).max() * lengths + np.abs(bend[-1]).max()
    farthest = _farthest_points(parts[:, few], short)
    inside = farthest < 1.0 - rounds - bends
    near = np.flatnonzero(~inside & ~(farthest > 1.0 + rounds))
    inside[near] = _farthest_points(parts, points[:, near]) <= 1.0
    return float(np.mean(inside))


def probability_wandering(
    offsets_rad: Array,
    half_rad: Array,
    known_rad: Array,
    t_s: Array,
    sigma_rad: float,
    half_life_s: float,
    along: NormalMixture = GAUSS,
    *,
    every: int = 1,
) -> float:
    """As `probability_inside`, with an error in both axes that forgets half of itself in a time.

    t_s: of the n instants.  sigma_rad: of that error, in each axis a Gauss-Markov process of the
    second order, whose rate is finite as a spacecraft's is; its correlation after z / `decay_rate`
    is (1 + z) exp(-z).
    By 4096 paths in steps of an eighth of its half-life, good to 0.01.
    Source: Gelb 1974, Applied Optimal Estimation, table 2.2-1.
    """
    if not (half_rad > 0.0).all():
        return 0.0
    lasts_s = float(t_s[-1] - t_s[0])
    steps = max(1, math.ceil(8.0 * lasts_s / half_life_s))
    parts = np.concatenate([offsets_rad / half_rad, (known_rad / half_rad)[None]])
    points = lattice_points(len(offsets_rad), 0)[:, :: EVERY * every]
    points = mixture_points(points, len(offsets_rad) - 1, along)
    points = np.vstack([points, np.ones(points.shape[1])])
    # Of the error and its rate over the decay rate, each of unit variance.
    z = decay_rate_per_s(half_life_s) * lasts_s / steps
    kept = math.exp(-z) * np.array([[1.0 + z, z], [-z, 1.0 - z]])
    variances, directions = np.linalg.eigh(np.eye(2) - kept @ kept.T)
    drawn = directions * np.sqrt(np.maximum(variances, 0.0))
    random = np.random.default_rng(0)
    wander = random.standard_normal((2, 2 * points.shape[1]))
    sigma = (sigma_rad / half_rad)[:, None]
    stays = np.ones(points.shape[1], dtype=bool)
    for at_s in np.linspace(t_s[0], t_s[-1], steps + 1):
        after = min(max(int(np.searchsorted(t_s, at_s)), 1), len(t_s) - 1)
        share = (at_s - t_s[after - 1]) / (t_s[after] - t_s[after - 1])
        here = (1.0 - share) * parts[:, after - 1] + share * parts[:, after]
        place = here.T @ points + sigma * wander[0].reshape(2, -1)
        stays &= (np.abs(place) <= 1.0).all(axis=0)
        wander = kept @ wander + drawn @ random.standard_normal(wander.shape)
    return float(np.mean(stays))


def decay_rate_per_s(half_life_s: float) -> float:
    """Of that process, which is half as it was after a time: (1 + z) exp(-z) is a half there."""
    return 1.6783469900166605 / half_life_s


def _farthest_points(part_shares: Array, points: "NDArray[np.floating]") -> Array:
    """The farthest offset at each point, in its precision, shape (points.shape[1],).

    part_shares: (m + 1, n, 2) of a frame's half, the last where the target is without errors.
    """
    in_half_frames = part_shares.reshape(len(part_shares), -1).astype(points.dtype)
    places = in_half_frames[:-1].T @ points
    places += in_half_frames[-1][:, None]
    return np.asarray(np.abs(places, out=places).max(axis=0))


def mixture_points(scores: Array, row: int, mixture: NormalMixture) -> Array:
    """Points of the lattice whose row, normal so far, follows the mixture."""
    found = scores.copy()
    found[row] = mixture.scores(scores[row])
    return found


@cache
def _points(normal: int, phases: int, every: int) -> tuple[Array, NDArray[np.float32], Array]:
    """The lattice, the same in half as long numbers, which take half the time, and its points'
    lengths."""
    points = lattice_points(normal, phases)[:, ::every]
    return points, np.ascontiguousarray(points, np.float32), np.linalg.norm(points, axis=0)


@cache
def lattice_points(normal: int, phases: int) -> Array:
    """A Richtmyer lattice mapped to unit variances and to circles of radius sqrt(2).

    Shape (normal + 2 phases, DRAWS).
    """
    # SciPy's special functions take 0.1 s to import, which only a plan should pay.
    from scipy.special import ndtri

    primes = np.array([2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37])[: normal + phases]
    if len(primes) < normal + phases:
        raise ValueError(f"at most 12 causes can be drawn, not {normal + phases}")
    lattice = np.outer(np.arange(DRAWS) + 0.5, np.sqrt(primes)) % 1.0
    phase_rad = 2.0 * np.pi * lattice[:, normal:, None]
    circles = np.sqrt(2.0) * np.concatenate([np.cos(phase_rad), np.sin(phase_rad)], axis=2)
    points = np.hstack([ndtri(lattice[:, :normal]), circles.reshape(DRAWS, 2 * phases)])
    return np.ascontiguousarray(points.T)
