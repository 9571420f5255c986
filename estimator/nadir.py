"""Which attitude about the vertical fits the limb points of all cameras best, and how well?

Gauss-Newton on the angles between limb rays and the cone of an ellipsoid's limb, with
Tukey's weights; unknowns are two tilts, the heading (held by its prior, since a round limb
hardly shows it), the limb's height, how strongly it rises under a low Sun and how it leans
along the Sun's azimuth.  The limb's roughness is common to neighbouring columns: n columns
within 5 deg of azimuth carry the information of one.
Source: Christian 2017 for the cone; Beaton and Tukey 1974 for the weights.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from estimator.limb import LimbPoints
from estimator.limb_geometry import Limb
from estimator.limb_height import sun_rise_m

Floats = NDArray[np.float64]

ROUGHNESS_M = 0.9e3
CORRELATED_RAD = np.deg2rad(5.0)
_TUKEY = 4.685
_STEPS = 8
_CONVERGED_RAD = 2e-6  # 0.4 arcsec

# How far the limb's rise under a low Sun may differ from its model: as a whole, which the
# images themselves can tell, and from place to place.
_RISE_SIGMA = 0.7
_RISE_SCATTER = 0.2


@dataclass(frozen=True)
class Prior:
    """What is known beforehand: the limb's height, and the heading to 1-sigma.

    lean_sigma_m: of the height's slope along the Sun's azimuth.
    sun_itrf: None where the limb doesn't follow the Sun.
    """

    height_m: float
    height_sigma_m: float
    heading_sigma_rad: float
    lean_sigma_m: float
    roughness_m: float
    sun_itrf: Floats | None


@dataclass(frozen=True)
class Fit:
    """c_body_from_itrf (3, 3), limb height, and the covariance (6, 6) of tilt about the limb's
    east and north axes, turn about nadir (rad), height (m), the rise under a low Sun over its
    model and the limb's lean along the Sun's azimuth (m).

    residual_rad: per camera, over its columns, NaN where nothing was found.
    tolerance_rad: their expected 1-sigma.  cost: minus twice the log likelihood.
    """

    c_body_from_itrf: Floats
    height_m: float
    covariance: Floats
    residual_rad: tuple[Floats, ...]
    tolerance_rad: tuple[Floats, ...]
    cost: float


def attitude_facing(nadir_body: Floats, limb: Limb, heading_rad: float = 0.0) -> Floats:
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


def turned_to(c_body_from_itrf: Floats, nadir_body: Floats, limb: Limb) -> Floats:
    """The attitude turned by the least angle so that geodetic nadir lies along (3,)."""
    have = c_body_from_itrf @ limb.nadir_geodetic_itrf
    axis = np.cross(have, nadir_body)
    cosine = float(have @ nadir_body)
    if cosine < -0.999999:
        return attitude_facing(nadir_body, limb)
    k = _cross(axis)
    return np.asarray((np.eye(3) + k + k @ k / (1.0 + cosine)) @ c_body_from_itrf)


def fit(points: list[LimbPoints], limb: Limb, c_body_from_itrf: Floats, prior: Prior) -> Fit:
    """The best attitude and limb height from a trial attitude near it."""
    used = [p for p in points if np.any(p.found)]
    if not used:
        return _unfitted(points, c_body_from_itrf, prior)
    ray_body = np.concatenate([p.ray_body[p.found] for p in used])
    edge_rad = np.concatenate([p.sigma_rad[p.found] for p in used])
    crowd = np.concatenate([columns_per_patch(p)[p.found] for p in used])
    axes = np.stack([*limb.axes_itrf, limb.nadir_itrf])
    reach_m = limb.touch_range_m(prior.height_m)
    c, turn = c_body_from_itrf.copy(), 0.0
    height, rising, lean = prior.height_m, 1.0, 0.0
    information = np.diag(
        [
            1.0,
            1.0,
            prior.heading_sigma_rad**-2,
            max(prior.height_sigma_m, 1.0) ** -2,
            _RISE_SIGMA**-2,
            prior.lean_sigma_m**-2,
        ]
    )
    scale = np.inf
    for _ in range(_STEPS):
        d = ray_body @ c
        rough_m = np.full(len(d), prior.roughness_m)
        rise, sunward = np.zeros(len(d)), np.zeros(len(d))
        if prior.sun_itrf is not None:
            elevation = limb.sun_elevation_rad(d, height, prior.sun_itrf)
            rise = sun_rise_m(elevation)
            rough_m = np.hypot(rough_m, _RISE_SCATTER * rise)
            sunward = d @ _horizontal(prior.sun_itrf, limb.nadir_itrf)
        above = rising * rise + lean * sunward
        residual, by_turn, by_height = _residuals(limb, d, height, above)
        jacobian = np.column_stack(
            [by_turn @ axes.T, by_height, by_height * rise, by_height * sunward]
        )
        one = np.hypot(edge_rad, rough_m / reach_m)
        weight = _tukey(residual, one, scale)
        scale = max(1.0, 1.4826 * float(np.median(np.abs(residual) / one)))
        spread2 = edge_rad**2 + crowd * (rough_m / reach_m) ** 2
        weighted = jacobian * (weight / spread2)[:, None]
        normal = weighted.T @ jacobian + information
        gradient = weighted.T @ residual
        gradient[2] += information[2, 2] * turn
        gradient[3] += information[3, 3] * (height - prior.height_m)
        gradient[4] += information[4, 4] * (rising - 1.0)
        gradient[5] += information[5, 5] * lean
        step = -np.linalg.solve(normal + 1e-9 * np.diag(np.diag(normal)), gradient)
        step[:3] = np.clip(step[:3], -0.05, 0.05)
        c = c @ _rotation(axes.T @ step[:3]).T
        turn += step[2]
        # Out of this range it will be refused; within it, there is a limb to compare with.
        reach_sigma_m = 10.0 * max(prior.height_sigma_m, 1.0)
        low_m, high_m = prior.height_m - reach_sigma_m, prior.height_m + reach_sigma_m
        height = float(np.clip(height + step[3], low_m, high_m))
        rising += step[4]
        lean += step[5]
        if np.max(np.abs(step[:3])) < _CONVERGED_RAD:
            break
    tolerance = one * scale
    share2 = np.minimum((residual / (_TUKEY * tolerance)) ** 2, 1.0)
    loss = (_TUKEY**2 / 3.0) * (1.0 - (1.0 - share2) ** 3) * one**2 / spread2
    cost = float(np.sum(loss)) + (turn / prior.heading_sigma_rad) ** 2
    cost += (height - prior.height_m) ** 2 * information[3, 3]
    cost += (rising - 1.0) ** 2 * information[4, 4] + lean**2 * information[5, 5]
    # A fit worse than its model says is less certain than its model says.
    covariance = np.linalg.inv(normal) * _misfit2(residual, weight, one, spread2)
    result = _unfitted(points, c, prior)
    return replace(
        result,
        height_m=height,
        covariance=covariance,
        residual_rad=_per_camera(points, residual),
        tolerance_rad=_per_camera(points, one),
        cost=cost,
    )


def _residuals(limb: Limb, d: Floats, height: float, rise: Floats) -> tuple[Floats, Floats, Floats]:
    """Angle of rays (n, 3) inside the limb, its derivatives by a turn (n, 3) and height (n,)."""
    cone = limb.cone(height)
    by_m = (limb.cone(height + 50.0) - limb.cone(height - 50.0)) / 100.0
    md = d @ cone
    value = np.sum(md * d, axis=1)
    slope = 2.0 * np.linalg.norm(md - value[:, None] * d, axis=1)
    by_height = np.sum((d @ by_m) * d, axis=1) / slope
    by_turn = 2.0 * np.cross(d, md) / slope[:, None]
    return value / slope + by_height * rise, by_turn, by_height


def columns_per_patch(points: LimbPoints) -> Floats:
    """How many found columns share each column's 5 deg of azimuth, itself included."""
    reach = max(int(CORRELATED_RAD / points.step_rad), 1)
    window = np.ones(reach)
    count = np.convolve(points.found.astype(float), window, mode="same")
    return np.maximum(count[: len(points)] if len(count) >= len(points) else count, 1.0)


def _tukey(residual: Floats, one: Floats, scale: float) -> Floats:
    if not np.isfinite(scale):
        # The first step has no scale yet: take the residuals' own.
        scale = 1.4826 * float(np.median(np.abs(residual) / one)) + 1.0
    share2 = (residual / (_TUKEY * scale * one)) ** 2
    return np.where(share2 < 1.0, (1.0 - share2) ** 2, 0.0)


def _misfit2(residual: Floats, weight: Floats, one: Floats, spread2: Floats) -> float:
    """Mean square of the residuals against their model, at least 1."""
    expected = float(np.sum(weight * one**2 / spread2))
    return max(1.0, float(np.sum(weight * residual**2 / spread2)) / max(expected, 1e-12))


def _per_camera(points: list[LimbPoints], values: Floats) -> tuple[Floats, ...]:
    spread, start = [], 0
    for p in points:
        own = np.full(len(p), np.nan)
        count = int(np.sum(p.found))
        own[p.found] = values[start : start + count]
        spread.append(own)
        start += count
    return tuple(spread)


def _unfitted(points: list[LimbPoints], c: Floats, prior: Prior) -> Fit:
    nothing = tuple(np.full(len(p), np.nan) for p in points)
    return Fit(
        c_body_from_itrf=c,
        height_m=prior.height_m,
        covariance=np.diag(
            [np.pi**2] * 3 + [prior.height_sigma_m**2, _RISE_SIGMA**2, prior.lean_sigma_m**2]
        ),
        residual_rad=nothing,
        tolerance_rad=nothing,
        cost=np.inf,
    )


def _horizontal(sun_itrf: Floats, nadir_itrf: Floats) -> Floats:
    """The Sun's direction across nadir, a unit vector; zeros where it stands overhead."""
    across = sun_itrf - (sun_itrf @ nadir_itrf) * nadir_itrf
    length = float(np.linalg.norm(across))
    return across / length if length > 0.02 else np.zeros(3)


def _cross(v: Floats) -> Floats:
    return np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])


def _rotation(turn: Floats) -> Floats:
    angle = float(np.linalg.norm(turn))
    if angle < 1e-12:
        return np.asarray(np.eye(3) + _cross(turn))
    k = _cross(turn / angle)
    return np.asarray(np.eye(3) + np.sin(angle) * k + (1.0 - np.cos(angle)) * (k @ k))
