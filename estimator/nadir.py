"""The attitude about the vertical that fits all cameras' limb points best, and how well.

Gauss-Newton on the angles between limb rays and the cone of an ellipsoid's limb, with
Tukey's weights; unknowns are two tilts, the heading (held by its prior, since a round limb
hardly shows it), the limb's height, how strongly it rises under a low Sun, how it leans along
the Sun's azimuth and bends across it, the same of each overexposed camera by itself, and each
camera's focal length and distortion where nobody measured them.
The limb's roughness is common to neighbouring columns: n columns within 5 deg of azimuth
carry the information of one.
Source: Christian 2017 for the cone; Beaton and Tukey 1974 for the weights.
"""

from dataclasses import dataclass, replace

import numpy as np

from estimator.limb import LimbPoints
from estimator.limb_geometry import Limb
from estimator.limb_height import sun_rise_m
from planner.arrays import Array

ROUGHNESS_M = 0.8e3
CORRELATED_RAD = np.deg2rad(5.0)
_TUKEY = 4.685
_STEPS = 8
_CONVERGED_RAD = 2e-6  # 0.4 arcsec
_SETTLED = 1e-3  # of what was known beforehand
_SLICE, _SLICES = 0.75, 2  # width in sigmas, and how many to each side
_STILL_RAD = 1e-3  # a step that moves no lift by more than a few metres

# How far the limb's rise under a low Sun may differ from its model: as a whole, which the
# images themselves can tell, and from place to place.
_RISE_SIGMA = 0.7
_RISE_SCATTER = 0.2

# Overexposed, the limb is where its light saturates the camera: twice the light moves it up by
# ln 2 scale heights, 5 km, in every camera by its own exposure; and along the limb's arc as the
# Rayleigh scattering 1 + cos^2 and the dust do.
_CLIPPED_SHARE = 0.3
_CLIPPED_M, _CLIPPED_LEAN_M, _CLIPPED_BEND_M = 5e3, 3e3, 2e3


@dataclass(frozen=True)
class Prior:
    """What is known beforehand: the limb's height, and the heading to 1-sigma.

    lean_sigma_m: of the height's slope along the Sun's azimuth.  bend_sigma_m: of its part that
    repeats twice around the limb, along the Sun against across it.
    sun_itrf: None where the limb doesn't follow the Sun.
    """

    height_m: float
    height_sigma_m: float
    heading_sigma_rad: float
    lean_sigma_m: float
    bend_sigma_m: float
    roughness_m: float
    sun_itrf: Array | None


@dataclass(frozen=True)
class Fit:
    """c_body_from_itrf (3, 3), limb height, and the covariance of tilt about the limb's east and
    north axes, turn about nadir (rad), height (m), the rise under a low Sun over its model, the
    limb's lean and bend by the Sun's azimuth (m), by how much overexposed cameras' limbs are
    higher, lean and bend (m), and unmeasured lenses' focal lengths and distortions.

    residual_rad: per camera, over its columns, NaN where nothing was found.
    tolerance_rad: their expected 1-sigma.  cost: minus twice the log likelihood.
    """

    c_body_from_itrf: Array
    height_m: float
    covariance: Array
    residual_rad: tuple[Array, ...]
    tolerance_rad: tuple[Array, ...]
    cost: float


def attitude_facing(nadir_body: Array, limb: Limb, heading_rad: float = 0.0) -> Array:
    """A c_body_from_itrf (3, 3) that puts geodetic nadir along a body direction (3,)."""
    nadir = limb.nadir_geodetic_itrf
    first = limb.axes_itrf[0] - (limb.axes_itrf[0] @ nadir) * nadir
    first /= np.linalg.norm(first)
    itrf = np.stack([first, np.cross(nadir, first), nadir])
    helper = np.eye(3)[np.argmin(np.abs(nadir_body))]
    one = np.cross(nadir_body, helper)
    one /= np.linalg.norm(one)
    two = np.cross(nadir_body, one)
    cosine, sine = np.cos(heading_rad), np.sin(heading_rad)
    body = np.stack([cosine * one + sine * two, cosine * two - sine * one, nadir_body])
    return np.asarray(body.T @ itrf)


def attitude_with_nadir(c_body_from_itrf: Array, nadir_body: Array, limb: Limb) -> Array:
    """The attitude turned by the least angle so that geodetic nadir lies along (3,)."""
    have = c_body_from_itrf @ limb.nadir_geodetic_itrf
    axis = np.cross(have, nadir_body)
    cosine = float(have @ nadir_body)
    if cosine < -0.999999:
        return attitude_facing(nadir_body, limb)
    k = _cross(axis)
    return np.asarray((np.eye(3) + k + k @ k / (1.0 + cosine)) @ c_body_from_itrf)


def fit(points: list[LimbPoints], limb: Limb, c_body_from_itrf: Array, prior: Prior) -> Fit:
    """The best attitude and limb height from a trial attitude near it."""
    used = [p for p in points if np.any(p.found)]
    if not used:
        return _without_fit(points, c_body_from_itrf, prior)
    ray_body = np.concatenate([p.ray_body[p.found] for p in used])
    edge_rad = np.concatenate([p.sigma_rad[p.found] for p in used])
    crowd = np.concatenate([columns_per_patch(p)[p.found] for p in used])
    clipped = _clipped_columns(used)
    bent_body = _bent(used)
    axes = np.stack([*limb.axes_itrf, limb.nadir_itrf])
    reach_m = limb.touch_range_m(prior.height_m)
    by_m = (limb.cone(prior.height_m + 50.0) - limb.cone(prior.height_m - 50.0)) / 100.0
    c = c_body_from_itrf.copy()
    # Besides the tilts: turn, height, and what lifts the limb from place to place.
    expected, sigma = _expected_unknowns(prior, clipped.shape[1], bent_body.shape[2])
    free = expected.copy()
    known = sigma**-2
    # Out of this range it will be refused; within it, there is a limb to compare with.
    reach_sigma_m = 10.0 * max(prior.height_sigma_m, 1.0)
    scale, moved = np.inf, np.inf
    for _ in range(_STEPS):
        d = ray_body @ c
        if moved > _STILL_RAD:
            lifts, rough_m = _lifts(d, clipped, limb, prior, float(free[1]))
        inside, by_ray, by_height = _inside(limb, by_m, d, float(free[1]))
        by_lens = np.einsum("ni,nik->nk", by_ray @ c.T, bent_body)
        own = np.column_stack([by_height[:, None] * lifts, by_lens])
        jacobian = np.column_stack([np.cross(d, by_ray) @ axes.T, by_height, own])
        residual = inside + own @ free[2:]
        one = np.hypot(edge_rad, rough_m / reach_m)
        weight = _tukey(residual, one, scale)
        scale = max(1.0, 1.4826 * float(np.median(np.abs(residual) / one)))
        spread2 = edge_rad**2 + crowd * (rough_m / reach_m) ** 2
        weighted = jacobian * (weight / spread2)[:, None]
        normal = weighted.T @ jacobian + np.diag([1.0, 1.0, *known])
        gradient = weighted.T @ residual
        gradient[2:] += known * (free - expected)
        step = -np.linalg.solve(normal + 1e-9 * np.diag(np.diag(normal)), gradient)
        step[:3] = np.clip(step[:3], -0.05, 0.05)
        c = c @ _rotation(axes.T @ step[:3]).T
        free = free + step[2:]
        free[1] = np.clip(free[1], expected[1] - reach_sigma_m, expected[1] + reach_sigma_m)
        moved = float(np.max(np.abs(step[:3])))
        settled = np.max(np.abs(step[2:]) / sigma) < _SETTLED
        if settled and np.max(np.abs(step[:2])) < _CONVERGED_RAD:
            break
    tolerance = one * scale
    share2 = np.minimum((residual / (_TUKEY * tolerance)) ** 2, 1.0)
    loss = (_TUKEY**2 / 3.0) * (1.0 - (1.0 - share2) ** 3) * one**2 / spread2
    # A fit worse than its model says is less certain than its model says.
    covariance = np.linalg.inv(normal) * _misfit2(residual, weight, one, spread2)
    return replace(
        _without_fit(points, c, prior),
        height_m=float(free[1]),
        covariance=covariance,
        residual_rad=_per_camera(points, residual),
        tolerance_rad=_per_camera(points, one),
        cost=float(np.sum(loss) + np.sum(known * (free - expected) ** 2)),
    )


def possible_fits(result: Fit, limb: Limb) -> list[Fit]:
    """A fit cut into slices of its own uncertainty about nadir, so that each may be judged.

    Every slice has its share of that uncertainty left; its cost holds how far out it lies.
    """
    sigma_rad = float(np.sqrt(result.covariance[2, 2]))
    gain = result.covariance[:, 2] / sigma_rad**2
    across = result.covariance - np.outer(gain, gain) * sigma_rad**2
    across += np.outer(gain, gain) * (_SLICE * sigma_rad) ** 2 / 12.0
    axes = np.stack([*limb.axes_itrf, limb.nadir_itrf])
    slices = []
    for out in _SLICE * np.arange(-_SLICES, _SLICES + 1):
        step = gain * out * sigma_rad
        slices.append(
            replace(
                result,
                c_body_from_itrf=result.c_body_from_itrf @ _rotation(axes.T @ step[:3]).T,
                height_m=result.height_m + float(step[3]),
                covariance=across,
                cost=result.cost + float(out**2),
            )
        )
    return slices


def _expected_unknowns(prior: Prior, overexposed: int, bends: int) -> tuple[Array, Array]:
    """All unknowns but the tilts beforehand, and their 1-sigma; lenses' in units of theirs."""
    expected = [0.0, prior.height_m, 1.0, 0.0, 0.0, *[_CLIPPED_M, 0.0, 0.0] * overexposed]
    expected += [0.0] * bends
    sigma = [
        prior.heading_sigma_rad,
        max(prior.height_sigma_m, 1.0),
        _RISE_SIGMA,
        prior.lean_sigma_m,
        prior.bend_sigma_m,
        *[_CLIPPED_M, _CLIPPED_LEAN_M, _CLIPPED_BEND_M] * overexposed,
        *[1.0] * bends,
    ]
    return np.array(expected), np.array(sigma)


def _lifts(
    d: Array, clipped: Array, limb: Limb, prior: Prior, height_m: float
) -> tuple[Array, Array]:
    """What lifts the limb along rays (n, 3) per unit of each unknown, (n, 3 + 3 k); roughness."""
    shape = np.zeros((len(d), 3))
    shape[:, 0] = 1.0
    rise_m = np.zeros(len(d))
    if prior.sun_itrf is not None:
        rise_m = sun_rise_m(limb.sun_elevation_rad(d, height_m, prior.sun_itrf))
        sunward = _horizontal(prior.sun_itrf, limb.nadir_itrf)
        shape[:, 1] = d @ sunward
        shape[:, 2] = shape[:, 1] ** 2 - (d @ np.cross(limb.nadir_itrf, sunward)) ** 2
    own = (clipped[:, :, None] * shape[:, None, :]).reshape(len(d), -1)
    rough_m = np.hypot(prior.roughness_m, _RISE_SCATTER * rise_m)
    rough_m *= 1.0 + clipped.sum(axis=1)
    return np.column_stack([rise_m, shape[:, 1:], own]), rough_m


def _clipped_columns(used: list[LimbPoints]) -> Array:
    """1 where a found column (n,) is of an overexposed camera (k,)."""
    counts = [int(np.sum(p.found)) for p in used]
    over = [float(np.mean(p.clipped[p.found])) > _CLIPPED_SHARE for p in used]
    return np.repeat(np.eye(len(used)), counts, axis=0)[:, over]


def _bent(used: list[LimbPoints]) -> Array:
    """How found rays change with each unmeasured lens's unknowns, (n, 3, 2 k)."""
    spread = []
    for k, p in enumerate(used):
        own = np.zeros((int(np.sum(p.found)), 3, 2 * len(used)))
        own[:, :, 2 * k : 2 * k + 2] = p.bent_body[p.found]
        spread.append(own)
    bent = np.concatenate(spread)
    return bent[:, :, np.any(bent, axis=(0, 1))]


def _inside(limb: Limb, by_m: Array, d: Array, height: float) -> tuple[Array, Array, Array]:
    """Angle of rays (n, 3) inside the limb, its derivatives by the ray (n, 3) and height (n,).

    by_m: the cone's derivative by height, which changes by a thousandth over the limb's heights.
    """
    md = d @ limb.cone(height)
    value = np.sum(md * d, axis=1)
    slope = 2.0 * np.linalg.norm(md - value[:, None] * d, axis=1)
    by_height = np.sum((d @ by_m) * d, axis=1) / slope
    return value / slope, md * (2.0 / slope)[:, None], by_height


def columns_per_patch(points: LimbPoints) -> Array:
    """How many found columns share each column's 5 deg of azimuth, itself included."""
    reach = max(int(CORRELATED_RAD / points.step_rad), 1)
    window = np.ones(reach)
    count = np.convolve(points.found.astype(float), window, mode="same")
    return np.maximum(count[: len(points)] if len(count) >= len(points) else count, 1.0)


def _tukey(residual: Array, one: Array, scale: float) -> Array:
    if not np.isfinite(scale):
        # The first step has no scale yet: take the residuals' own.
        scale = 1.4826 * float(np.median(np.abs(residual) / one)) + 1.0
    share2 = (residual / (_TUKEY * scale * one)) ** 2
    return np.where(share2 < 1.0, (1.0 - share2) ** 2, 0.0)


def _misfit2(residual: Array, weight: Array, one: Array, spread2: Array) -> float:
    """Mean square of the residuals against their model, at least 1."""
    expected = float(np.sum(weight * one**2 / spread2))
    return max(1.0, float(np.sum(weight * residual**2 / spread2)) / max(expected, 1e-12))


def _per_camera(points: list[LimbPoints], values: Array) -> tuple[Array, ...]:
    spread, start = [], 0
    for p in points:
        own = np.full(len(p), np.nan)
        count = int(np.sum(p.found))
        own[p.found] = values[start : start + count]
        spread.append(own)
        start += count
    return tuple(spread)


def _without_fit(points: list[LimbPoints], c: Array, prior: Prior) -> Fit:
    nothing = tuple(np.full(len(p), np.nan) for p in points)
    return Fit(
        c_body_from_itrf=c,
        height_m=prior.height_m,
        covariance=np.diag([np.pi**2] * 3 + [prior.height_sigma_m**2]),
        residual_rad=nothing,
        tolerance_rad=nothing,
        cost=np.inf,
    )


def _horizontal(sun_itrf: Array, nadir_itrf: Array) -> Array:
    """The Sun's direction across nadir, a unit vector; zeros where it stands overhead."""
    across = sun_itrf - (sun_itrf @ nadir_itrf) * nadir_itrf
    length = float(np.linalg.norm(across))
    return across / length if length > 0.02 else np.zeros(3)


def _cross(v: Array) -> Array:
    return np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])


def _rotation(turn: Array) -> Array:
    angle = float(np.linalg.norm(turn))
    if angle < 1e-12:
        return np.asarray(np.eye(3) + _cross(turn))
    k = _cross(turn / angle)
    return np.asarray(np.eye(3) + np.sin(angle) * k + (1.0 - np.cos(angle)) * (k @ k))
