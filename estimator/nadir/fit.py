"""The attitude about the vertical that fits all cameras' limb points best, and how well.

Gauss-Newton on the angles between limb rays and the cone of an ellipsoid's limb, with
Tukey's weights; unknowns are two tilts, the heading (held by its prior, since a round limb
hardly shows it), the limb's height, how strongly it rises under a low Sun, how it leans along
the Sun's azimuth and bends across it, how much clouds draw it inwards, the lift, lean and bend of
each overexposed camera by itself, each camera's focal length and distortion where nobody
measured them, and the body's turn while a rolling shutter reads the frames.
The limb's roughness is common to neighbouring columns: n columns within 5 deg of azimuth
carry the information of one.
Source: Christian 2017 for the cone; Beaton and Tukey 1974 for the weights.
"""

from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np

from estimator.limb.geometry import Limb
from estimator.limb.low_sun import sun_rise_m
from estimator.limb.points import LimbPoints
from planner.base.arrays import Array

ROUGHNESS_M = 0.8e3


@dataclass(frozen=True, kw_only=True)
class NadirFitOptions:
    """How nadir is fitted to a limb, and what of the limb's model is uncertain."""

    # scales beyond which a point counts for nothing: 95 % efficient with normal errors (Beaton
    # and Tukey 1974)
    tukey: float = 4.685
    steps: int = 8  # of reweighting; it converges in fewer as a rule
    converged_rad: float = 2e-6  # 0.4 arcsec
    settled: float = 1e-3  # of what was known beforehand
    slice: float = 0.75  # width of a slice of what stays uncertain, in sigmas,
    slices: int = 2  # and how many to each side
    still_rad: float = 1e-3  # a step that moves no lift by more than a few metres
    # how far the limb's rise under a low Sun may differ from its model: as a whole, which the
    # images themselves can tell,
    rise_sigma: float = 0.7
    rise_scatter: float = 0.2  # and from place to place
    # of how far clouds had drawn the limb's edge, what is left once it is moved back: as a whole,
    drawn_sigma: float = 0.3
    drawn_scatter: float = 0.1  # and from place to place
    # Overexposed, the limb is where its light saturates the camera: twice the light moves it up
    # by ln 2 scale heights, 5 km, in every camera by its own exposure;
    clipped_m: float = 5e3
    clipped_lean_m: float = 3e3  # and along the limb's arc, as the dust does
    clipped_bend_m: float = 2e3  # and the Rayleigh scattering 1 + cos^2


OPTIONS = NadirFitOptions()


class Doubt(StrEnum):
    """What may be otherwise than a request's cameras have it."""

    LENS = "a lens that is stated to be known better than the frames bear out"
    SHUTTER = "a rolling shutter, where no `readout_s` is stated"


@dataclass(frozen=True)
class Prior:
    """What is known beforehand: the limb's height, and the heading to 1-sigma.

    lean_sigma_m: of the height's slope along the Sun's azimuth.  bend_sigma_m: of its part that
    repeats twice around the limb, along the Sun against across it.
    sun_itrf: None where the limb doesn't follow the Sun.
    rate_body_rad_s: of the body against the stars, on its axes, each to rate_sigma_rad_s.
    """

    height_m: float
    height_sigma_m: float
    heading_sigma_rad: float
    lean_sigma_m: float
    bend_sigma_m: float
    roughness_m: float
    sun_itrf: Array | None
    rate_body_rad_s: tuple[float, ...] = (0.0, 0.0, 0.0)
    rate_sigma_rad_s: float = np.deg2rad(3.0)  # as good as unknown


@dataclass(frozen=True)
class Fit:
    """c_body_from_itrf (3, 3) and height_m of the limb, with the covariance of all unknowns.

    Those are: tilt about the limb's east and north axes, turn about nadir (rad); height (m), the
    rise under a low Sun over its model, the limb's lean and bend by the Sun's azimuth (m); the
    share left of what clouds drew it by; by how much overexposed cameras' limbs are higher, lean
    and bend (m); unmeasured lenses' focal lengths and distortions, and the turn during a rolling
    shutter's reading, in units of their 1-sigma.
    residual_rad: per camera, over its columns, NaN where nothing was found.
    tolerance_rad: their expected 1-sigma.  cost: minus twice the log likelihood, for residuals
    on their own scale where that is beyond the expected one.
    bent_sigma: of lenses and turn, how far the one farthest from what is stated is.
    doubt: of the cameras' statements, the one not believed.
    weight: probability against the fits at other headings and by other doubts.
    careful_weight: the same, with less trust in what tells of the heading.
    """

    c_body_from_itrf: Array
    height_m: float
    covariance_matrix: Array
    residual_rad: tuple[Array, ...]
    tolerance_rad: tuple[Array, ...]
    cost: float
    bent_sigma: float = 0.0
    doubt: Doubt | None = None
    weight: float = 1.0
    careful_weight: float = 1.0

    @property
    def tilt_sigma_rad(self) -> float:
        """Rms of the angle that the vertical is off."""
        return float(np.sqrt(self.covariance_matrix[0, 0] + self.covariance_matrix[1, 1]))


def attitude_facing(nadir_body: Array, limb: Limb, heading_rad: float = 0.0) -> Array:
    """A c_body_from_itrf (3, 3) that puts geodetic nadir along a body direction (3,)."""
    nadir_itrf = limb.nadir_geodetic_itrf
    level_itrf = limb.axes_itrf[0] - (limb.axes_itrf[0] @ nadir_itrf) * nadir_itrf
    level_itrf /= np.linalg.norm(level_itrf)
    axes_itrf = np.stack([level_itrf, np.cross(nadir_itrf, level_itrf), nadir_itrf])
    helper_body = np.eye(3)[np.argmin(np.abs(nadir_body))]
    first_body = np.cross(nadir_body, helper_body)
    first_body /= np.linalg.norm(first_body)
    second_body = np.cross(nadir_body, first_body)
    cosine, sine = np.cos(heading_rad), np.sin(heading_rad)
    x_body = cosine * first_body + sine * second_body
    y_body = cosine * second_body - sine * first_body
    axes_body = np.stack([x_body, y_body, nadir_body])
    return np.asarray(axes_body.T @ axes_itrf)


def attitude_with_nadir(c_body_from_itrf: Array, nadir_body: Array, limb: Limb) -> Array:
    """The attitude turned by the least angle so that geodetic nadir lies along (3,)."""
    now_body = c_body_from_itrf @ limb.nadir_geodetic_itrf
    axis_body = np.cross(now_body, nadir_body)
    cosine = float(now_body @ nadir_body)
    if cosine < -0.999999:
        return attitude_facing(nadir_body, limb)
    k = _cross_matrix(axis_body)
    return np.asarray((np.eye(3) + k + k @ k / (1.0 + cosine)) @ c_body_from_itrf)


def fit(points: list[LimbPoints], limb: Limb, c_body_from_itrf: Array, prior: Prior) -> Fit:
    """The best attitude and limb height from a trial attitude near it."""
    used = [p for p in points if np.any(p.found)]
    if not used:
        nothing = tuple(np.full(len(p), np.nan) for p in points)
        covariance = np.diag([np.pi**2] * 3 + [prior.height_sigma_m**2])
        return Fit(c_body_from_itrf, prior.height_m, covariance, nothing, nothing, cost=np.inf)
    ray_body = np.concatenate([p.ray_body[p.found] for p in used])
    edge_rad = np.concatenate([p.sigma_rad[p.found] for p in used])
    drawn_m = np.concatenate([p.drawn_m[p.found] for p in used])
    per_patch = np.concatenate([p.columns_per_patch()[p.found] for p in used])
    clipped_mask = _clipped_mask(used, by_daylight=prior.sun_itrf is not None)
    shift_body, shift_parameters = _shift_body(used, prior)
    axes_itrf = np.stack([*limb.axes_itrf, limb.nadir_itrf])
    reach_m = limb.touch_range_m(prior.height_m)
    cone_per_m = (limb.cone(prior.height_m + 50.0) - limb.cone(prior.height_m - 50.0)) / 100.0
    c = c_body_from_itrf.copy()
    # Besides the tilts: turn, height, and what lifts the limb from place to place.
    expected, sigma = _expected_unknowns(prior, clipped_mask.shape[1], shift_parameters)
    unknowns = expected.copy()
    information = sigma**-2
    # Out of this range it will be refused; within it, there is a limb to compare with.
    reach_sigma_m = 10.0 * max(prior.height_sigma_m, 1.0)
    scale, turned_rad = np.inf, np.inf
    for _ in range(OPTIONS.steps):
        ray_itrf = ray_body @ c
        height_m = float(unknowns[1])
        if turned_rad > OPTIONS.still_rad:
            lifts, rough_m = _lifts(ray_itrf, clipped_mask, drawn_m, limb, prior, height_m)
        inside_rad, by_ray, by_height = _inside(limb, cone_per_m, ray_itrf, height_m)
        by_shift = np.einsum("ni,nik->nk", by_ray @ c.T, shift_body)
        by_lift = np.column_stack([by_height[:, None] * lifts, by_shift])
        jacobian = np.column_stack([np.cross(ray_itrf, by_ray) @ axes_itrf.T, by_height, by_lift])
        residual_rad = inside_rad + by_lift @ unknowns[2:]
        sigma_rad = np.hypot(edge_rad, rough_m / reach_m)
        weight = _tukey(residual_rad, sigma_rad, scale)
        scale = max(1.0, 1.4826 * float(np.median(np.abs(residual_rad) / sigma_rad)))
        variance_rad2 = edge_rad**2 + per_patch * (rough_m / reach_m) ** 2
        weighted = jacobian * (weight / variance_rad2)[:, None]
        normal = weighted.T @ jacobian + np.diag([1.0, 1.0, *information])
        gradient = weighted.T @ residual_rad
        gradient[2:] += information * (unknowns - expected)
        step = -np.linalg.solve(normal + 1e-9 * np.diag(np.diag(normal)), gradient)
        step[:3] = np.clip(step[:3], -0.05, 0.05)
        c = c @ _rotation(axes_itrf.T @ step[:3]).T
        unknowns = unknowns + step[2:]
        unknowns[1] = np.clip(unknowns[1], expected[1] - reach_sigma_m, expected[1] + reach_sigma_m)
        turned_rad = float(np.max(np.abs(step[:3])))
        settled = np.max(np.abs(step[2:]) / sigma) < OPTIONS.settled
        if settled and np.max(np.abs(step[:2])) < OPTIONS.converged_rad:
            break
    share2 = np.minimum((residual_rad / (OPTIONS.tukey * (sigma_rad * scale))) ** 2, 1.0)
    own_share = sigma_rad**2 / variance_rad2
    # The logarithm keeps a fit from being likelier the larger its residuals' own scale.
    loss = own_share * (
        (OPTIONS.tukey**2 / 3.0) * (1.0 - (1.0 - share2) ** 3) + 2.0 * np.log(scale)
    )
    # What is known of the unknowns now, against beforehand: else more of them were always likelier.
    left = np.linalg.slogdet(normal)[1] + 2.0 * np.sum(np.log(sigma))
    bent = np.abs(unknowns - expected)[len(expected) - len(shift_parameters) :]
    # A fit worse than its model says is less certain than its model says.
    misfit2 = _misfit2(residual_rad, weight, sigma_rad, variance_rad2)
    return Fit(
        c_body_from_itrf=c,
        height_m=float(unknowns[1]),
        covariance_matrix=np.linalg.inv(normal) * misfit2,
        residual_rad=_per_camera(points, residual_rad),
        tolerance_rad=_per_camera(points, sigma_rad),
        cost=float(np.sum(loss) + np.sum(information * (unknowns - expected) ** 2) + left),
        bent_sigma=float(np.max(bent, initial=0.0)),
    )


def possible_fits(result: Fit, limb: Limb) -> list[Fit]:
    """A fit cut into slices of its own uncertainty about nadir, so that each may be judged.

    Every slice has its share of that uncertainty left; its cost holds how far out it lies.
    """
    sigma_rad = float(np.sqrt(result.covariance_matrix[2, 2]))
    gain = result.covariance_matrix[:, 2] / sigma_rad**2
    across = result.covariance_matrix - np.outer(gain, gain) * sigma_rad**2
    across += np.outer(gain, gain) * (OPTIONS.slice * sigma_rad) ** 2 / 12.0
    axes_itrf = np.stack([*limb.axes_itrf, limb.nadir_itrf])
    slices = []
    for out in OPTIONS.slice * np.arange(-OPTIONS.slices, OPTIONS.slices + 1):
        step = gain * out * sigma_rad
        slices.append(
            replace(
                result,
                c_body_from_itrf=result.c_body_from_itrf @ _rotation(axes_itrf.T @ step[:3]).T,
                height_m=result.height_m + float(step[3]),
                covariance_matrix=across,
                cost=result.cost + float(out**2),
            )
        )
    return slices


def _expected_unknowns(
    prior: Prior, overexposed: int, shift_parameters: Array
) -> tuple[Array, Array]:
    """All unknowns but the tilts beforehand, those of `_shift_body` last, and their 1-sigma."""
    expected = [
        0.0,
        prior.height_m,
        1.0,
        0.0,
        0.0,
        0.0,
        *[OPTIONS.clipped_m, 0.0, 0.0] * overexposed,
        *shift_parameters,
    ]
    sigma = [
        prior.heading_sigma_rad,
        max(prior.height_sigma_m, 1.0),
        OPTIONS.rise_sigma,
        prior.lean_sigma_m,
        prior.bend_sigma_m,
        OPTIONS.drawn_sigma,
        *[OPTIONS.clipped_m, OPTIONS.clipped_lean_m, OPTIONS.clipped_bend_m] * overexposed,
        *[1.0] * len(shift_parameters),
    ]
    return np.array(expected), np.array(sigma)


def _lifts(
    ray_itrf: Array,
    clipped_mask: Array,
    drawn_m: Array,
    limb: Limb,
    prior: Prior,
    height_m: float,
) -> tuple[Array, Array]:
    """What lifts the limb along rays (n, 3) per unit of each unknown, (n, 4 + 3 k), and its
    roughness in m, (n,)."""
    shape = np.zeros((len(ray_itrf), 3))
    shape[:, 0] = 1.0
    rise_m = np.zeros(len(ray_itrf))
    if prior.sun_itrf is not None:
        rise_m = sun_rise_m(limb.sun_elevation_rad(ray_itrf, height_m, prior.sun_itrf))
        sunward = _sunward_itrf(prior.sun_itrf, limb.nadir_itrf)
        shape[:, 1] = ray_itrf @ sunward
        shape[:, 2] = shape[:, 1] ** 2 - (ray_itrf @ np.cross(limb.nadir_itrf, sunward)) ** 2
    own = (clipped_mask[:, :, None] * shape[:, None, :]).reshape(len(ray_itrf), -1)
    rough_m = np.hypot(prior.roughness_m, OPTIONS.rise_scatter * rise_m)
    rough_m *= 1.0 + clipped_mask.sum(axis=1)
    rough_m = np.hypot(rough_m, OPTIONS.drawn_scatter * drawn_m)
    return np.column_stack([rise_m, shape[:, 1:], drawn_m, own]), rough_m


def _clipped_mask(used: list[LimbPoints], *, by_daylight: bool) -> Array:
    """1 where a found column (n,) is of an overexposed camera (k,).

    by_daylight: the limb is the daylight's, whose light fades upwards, not of a height stated.
    """
    counts = [int(np.sum(p.found)) for p in used]
    over = [by_daylight and p.is_overexposed for p in used]
    return np.repeat(np.eye(len(used)), counts, axis=0)[:, over]


def _shift_body(used: list[LimbPoints], prior: Prior) -> tuple[Array, Array]:
    """How found rays change with each unmeasured lens's unknowns and, under a rolling shutter, with
    the body's rate, (n, 3, k), and what is expected of these (k,); all in their 1-sigma."""
    sigma_rad_s = max(prior.rate_sigma_rad_s, 1e-9)
    per_camera = []
    for k, p in enumerate(used):
        own = np.zeros((int(np.sum(p.found)), 3, 2 * len(used) + 3))
        own[:, :, 2 * k : 2 * k + 2] = p.lens_shift_body[p.found]
        turn_rad = sigma_rad_s * p.exposed_s[p.found][:, None]
        own[:, :, -3:] = np.moveaxis(
            np.cross(np.eye(3)[:, None], p.ray_body[p.found]) * turn_rad, 0, 2
        )
        per_camera.append(own)
    shift_body = np.concatenate(per_camera)
    expected = np.concatenate(
        [np.zeros(2 * len(used)), np.array(prior.rate_body_rad_s) / sigma_rad_s]
    )
    moves = np.any(shift_body, axis=(0, 1))
    return shift_body[:, :, moves], expected[moves]


def _inside(
    limb: Limb, cone_per_m: Array, ray_itrf: Array, height_m: float
) -> tuple[Array, Array, Array]:
    """Angle of rays (n, 3) inside the limb, its derivatives by the ray (n, 3) and height (n,).

    cone_per_m: the cone's derivative, which changes by a thousandth over the limb's heights.
    """
    md = ray_itrf @ limb.cone(height_m)
    value = np.sum(md * ray_itrf, axis=1)
    slope = 2.0 * np.linalg.norm(md - value[:, None] * ray_itrf, axis=1)
    by_height = np.sum((ray_itrf @ cone_per_m) * ray_itrf, axis=1) / slope
    return value / slope, md * (2.0 / slope)[:, None], by_height


def _tukey(residual_rad: Array, sigma_rad: Array, scale: float) -> Array:
    if not np.isfinite(scale):
        # The first step has no scale yet: take the residuals' own.
        scale = 1.4826 * float(np.median(np.abs(residual_rad) / sigma_rad)) + 1.0
    share2 = (residual_rad / (OPTIONS.tukey * scale * sigma_rad)) ** 2
    return np.where(share2 < 1.0, (1.0 - share2) ** 2, 0.0)


def _misfit2(residual_rad: Array, weight: Array, sigma_rad: Array, variance_rad2: Array) -> float:
    """Mean square of the residuals against their model, at least 1."""
    expected = float(np.sum(weight * sigma_rad**2 / variance_rad2))
    found = float(np.sum(weight * residual_rad**2 / variance_rad2))
    return max(1.0, found / max(expected, 1e-12))


def _per_camera(points: list[LimbPoints], found_rad: Array) -> tuple[Array, ...]:
    """Values of the found columns, back in their cameras' columns; NaN elsewhere."""
    per_camera, start = [], 0
    for p in points:
        own = np.full(len(p), np.nan)
        count = int(np.sum(p.found))
        own[p.found] = found_rad[start : start + count]
        per_camera.append(own)
        start += count
    return tuple(per_camera)


def _sunward_itrf(sun_itrf: Array, nadir_itrf: Array) -> Array:
    """The Sun's direction across nadir, a unit vector; zeros where it stands overhead."""
    across_itrf = sun_itrf - (sun_itrf @ nadir_itrf) * nadir_itrf
    length = float(np.linalg.norm(across_itrf))
    return across_itrf / length if length > 0.02 else np.zeros(3)


def _cross_matrix(v: Array) -> Array:
    return np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])


def _rotation(turn_itrf_rad: Array) -> Array:
    angle_rad = float(np.linalg.norm(turn_itrf_rad))
    if angle_rad < 1e-12:
        return np.asarray(np.eye(3) + _cross_matrix(turn_itrf_rad))
    k = _cross_matrix(turn_itrf_rad / angle_rad)
    return np.asarray(np.eye(3) + np.sin(angle_rad) * k + (1.0 - np.cos(angle_rad)) * (k @ k))
