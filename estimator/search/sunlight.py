"""The craft's heading about the vertical, from how the limb's light runs along it.

Clear air scatters sunlight forwards and backwards more than sideways (Rayleigh), and the limb
lies above most dust and cloud; so along each camera's arc the limb's brightness follows the
angle to the Sun.  Each camera's exposure is free, and so, within bounds, are how much the
light scattered more than once evens out, what dust adds, how much the air takes from sunlight on
its way to the limb and how much the lens darkens off its axis.  It decides between headings that
fit the limb's shape alike, for when no attitude was predicted.

Dust scatters sunlight of all colours forwards, so the limb reddens towards the Sun: where the
file kept its colours sharp, that tells the Sun's side from its opposite.

What one unknown is tells of the others: air without dust neither reddens nor brightens towards the
Sun, and its light is clearest from behind.  Together their bounds are what airs of two models give,
from none with dust to that after an eruption (air_light.py).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from scipy.linalg import block_diag

from estimator.camera import HorizonCamera
from estimator.images import Frame
from estimator.limb.points import LimbPoints
from estimator.surroundings import Surroundings
from planner.base.arrays import Array

# Profiles of the limb's light along the horizon by kind of air, for estimator/search/sunlight.py.
#
# Linear fits to the limbs of SASKTRAN2 (the twelve chosen airs of bench/limb_tables.py and sixty
# drawn as its `drawn` draws, seeds 101 to 160; drawn_1 to drawn_6 are not among them) and of 40
# airs of our own renderer, with the Sun 25 to 85 deg high. Each limb is fitted to 0.02.
# bench/air_light.py made the numbers; both scripts as of commit 54f03d3.

_FORWARD = 0.65  # mean cosine of dust's scattering


@dataclass(frozen=True)
class AirLight:
    """How often a kind of air is met, and the mean (8,) and covariance (8, 8) of its light.

    Of blue brightness, by the columns of `brightness_basis`: contrast left of single scattering,
    dust's light against the air's if it scattered evenly, and sunlight's loss by its path's length
    against that straight down.  Of the logarithm of red over blue, by those of `colour_basis`: its
    slope and bend by the cosine of the angle to the Sun.  Of grey brightness: the first three.
    """

    share: float
    mean_parameters: Array
    covariance_parameters: Array


def brightness_basis(cosine: Array, sun_elevation_sine: Array) -> Array:
    """What the logarithm of the limb's brightness is made of, (n, 3).

    cosine (n,): of the ray and the Sun's direction.  sun_elevation_sine (n,): at the limb.
    """
    path = 1.0 / np.maximum(sun_elevation_sine, 0.02)
    return np.column_stack([np.log(1.0 + cosine**2), _dust_over_air(cosine), -path])


def colour_basis(cosine: Array) -> Array:
    """What the logarithm of red over blue is made of, (n, 2)."""
    return np.column_stack([cosine, cosine**2])


def _dust_over_air(cosine: Array) -> Array:
    """What dust scatters at an angle to the Sun, against air (Henyey and Greenstein 1941)."""
    dust = (1.0 - _FORWARD**2) / (1.0 + _FORWARD**2 - 2.0 * _FORWARD * cosine) ** 1.5
    return np.asarray(dust / (0.75 * (1.0 + cosine**2)))


def _kind(share: float, mean: str, covariance: str, scale: float = 1.0) -> AirLight:
    """covariance: its lower triangle by rows, in 1e-5."""
    lower = np.zeros((8, 8))
    lower[np.tril_indices(8)] = 1e-5 * np.array(covariance.split(), dtype=float)
    full = lower + np.tril(lower, -1).T
    return AirLight(share, np.array(mean.split(), dtype=float), scale**2 * full)


_SCATTERED_OFTEN = (
    "0.491 0.299 0.014 0.106 0.059 0.494 0.362 0.017",
    """
    1451
    -1703 3256
    -35 104 14
    -146 519 11 725
    239 -177 -4 109 98
    1546 -1875 -36 -275 271 1910
    -1730 3271 94 1037 -84 -2021 3994
    -46 121 13 27 -4 -53 115 20
    """,
)
_SCATTERED_ONCE = (
    "0.867 0.1 0.018 0.082 0.009 0.843 0.143 0.026",
    """
    676
    -521 629
    8 -5 3
    -400 404 -3 522
    24 -17 0 57 47
    724 -647 9 -504 32 994
    -684 657 -9 676 47 -864 1152
    -50 58 0 44 -5 -66 63 12
    """,
)
AIRS = (
    _kind(0.5, *_SCATTERED_OFTEN),
    # As our renderer has it, where little is scattered more than once.
    _kind(0.35, *_SCATTERED_ONCE),
    # Laden with dust, or with the haze of an eruption.
    _kind(0.15, *_SCATTERED_OFTEN, scale=2.5),
)


@dataclass(frozen=True, kw_only=True)
class SunlightOptions:
    """How the brightness along the limb tells where the Sun stands."""

    scatter: float = 0.025  # of brightness from one 5 deg of limb to the next: dust, thin cloud
    darkened: float = 0.25  # of cos^4 is what lenses lose: they are flat-fielded, or nearly, or not
    darkened_sigma: float = 0.3  # and so widely
    decoded_share: float = 0.05  # the curve that is undone is rarely the whole of what a camera did
    free_exposure: float = 3.0  # sigma of its logarithm: any
    outlier: float = 3.0  # sigmas, beyond which a column counts no more
    fewest: int = 16  # columns, for an image to tell anything
    colour_scatter: float = 0.015  # of the logarithm of red over blue, likewise
    # depths below the edge at which the limb's brightness is taken
    within_m: tuple[float, float, float] = (6e3, 10e3, 14e3)
    above_m: tuple[float, float, float] = (-8e3, -10e3, -12e3)  # heights above it, of thin air,
    beyond_m: tuple[float, float] = (-30e3, -36e3)  # and for the sky's
    # Blue over red above the edge against within it, as a logarithm: 0.13 to 1.4 by airs of
    # SASKTRAN2 (bench/limb_frames.py), the Sun 4 deg high and up; 0 of an edge of one colour
    least_bluer: float = 0.08
    coarsest_m: float = 8e3  # a pixel that still tells above from within


OPTIONS = SunlightOptions()

_OF_BLUE, _OF_COLOUR, _OF_GREY = [0, 1, 2], [3, 4], [5, 6, 7]  # of the air's unknowns


@dataclass(frozen=True)
class _LimbLight:
    """One measure of the limb's light in all cameras, an entry per column that can be used.

    log_level (n,): its logarithm, less each camera's mean.  ray_body (n, 3): towards the limb.
    share (n,): of the information of 5 deg of limb.  camera_basis (n, k): the columns of each
    camera's own unknowns, zero in the other cameras' rows; own_mean and own_sigma (k,): what is
    expected of them.
    """

    log_level: Array
    ray_body: Array
    share: Array
    camera_basis: Array
    own_mean: Array
    own_sigma: Array


@dataclass(frozen=True)
class Sunlight:
    """All that the sunlight along the limb says of attitudes.

    brightness: the limb's; each camera's unknowns are its exposure and its lens's darkening.
    colour: red over blue; each camera's unknown is its balance.  None where too little is seen.
    blue: brightness is that of blue.
    """

    around: Surroundings
    brightness: _LimbLight | None
    colour: _LimbLight | None
    blue: bool

    def cost(self, c_body_from_itrf: Array, height_m: float) -> float:
        """Minus twice the log likelihood of an attitude; 0 where nothing was seen."""
        lights: list[_LimbLight] = []
        bases: list[Array] = []
        sigmas: list[float] = []
        known: list[int] = []
        if self.brightness is not None:
            lights.append(self.brightness)
            bases.append(self._brightness_basis(self.brightness, c_body_from_itrf, height_m))
            sigmas.append(OPTIONS.scatter)
            known += _OF_BLUE
        if self.colour is not None:
            cosine = self.colour.ray_body @ c_body_from_itrf @ self.around.sun_itrf
            lights.append(self.colour)
            bases.append(colour_basis(cosine))
            sigmas.append(OPTIONS.colour_scatter)
            known += _OF_COLOUR
        if not lights:
            return 0.0
        own = [light.camera_basis for light in lights]
        design = np.hstack([block_diag(*bases), block_diag(*own)])
        own_mean = [light.own_mean for light in lights]
        own_sigma = np.concatenate([light.own_sigma for light in lights])
        level = np.concatenate([light.log_level for light in lights])
        share = np.concatenate([light.share for light in lights])
        sigma = np.repeat(sigmas, [len(light.share) for light in lights])
        if not self.blue:
            known = _OF_GREY
        costs = []
        for air in AIRS:
            off = level - design @ np.concatenate([air.mean_parameters[known], *own_mean])
            covariance = block_diag(
                air.covariance_parameters[np.ix_(known, known)], np.diag(own_sigma**2)
            )
            misfit = _misfit(design, off, share, sigma, covariance)
            costs.append(misfit - 2.0 * float(np.log(air.share)))
        return float(-2.0 * np.logaddexp.reduce(-0.5 * np.array(costs)))

    def _brightness_basis(
        self, light: _LimbLight, c_body_from_itrf: Array, height_m: float
    ) -> Array:
        sun_itrf = self.around.sun_itrf
        ray_itrf = light.ray_body @ c_body_from_itrf
        elevation_rad = self.around.limb.sun_elevation_rad(ray_itrf, height_m, sun_itrf)
        return brightness_basis(ray_itrf @ sun_itrf, np.sin(elevation_rad))


def _misfit(
    basis: Array, off_level: Array, share: Array, sigma: Array, covariance_parameters: Array
) -> float:
    """Minus twice the log likelihood of rows (n,) under a robust linear fit of unknowns (k,).

    share, sigma (n,): each row's part of a patch of limb, and a patch's scatter.
    covariance_parameters (k, k): of the unknowns beforehand, about 0.
    """
    information = np.linalg.inv(covariance_parameters)
    weight = share / sigma**2
    robust = weight
    for _ in range(2):
        normal = (basis.T * robust) @ basis + information
        free = np.linalg.solve(normal, basis.T @ (robust * off_level))
        rest = (off_level - basis @ free) / sigma
        robust = weight / np.maximum(np.abs(rest) / OPTIONS.outlier, 1.0)
    loss = np.sum(share * np.minimum(rest**2, OPTIONS.outlier**2)) + free @ information @ free
    # What the unknowns could have been, against what is left of that.
    left = np.linalg.slogdet(normal)[1] + np.linalg.slogdet(covariance_parameters)[1]
    return float(loss + left)


def sunlight_along(
    points: list[LimbPoints],
    frames: Sequence[Frame],
    cameras: Sequence[HorizonCamera],
    around: Surroundings,
    nadir_body: Array,
    height_m: float,
) -> Sunlight:
    """What cameras tell that show enough of an unsaturated daylight limb.

    nadir_body, height_m: roughly, to look within the limb and beyond it.
    """
    if not around.daylight:
        return Sunlight(around, None, None, blue=False)
    seen = list(zip(points, frames, cameras, strict=True))
    reach_m = around.limb.touch_range_m(height_m)
    return Sunlight(
        around,
        brightness=_together([_brightness(*one) for one in seen]),
        colour=_together([_colour(*one, nadir_body, reach_m) for one in seen]),
        blue=all(frame.blue for frame in frames),
    )


def _together(per_camera: list[_LimbLight | None]) -> _LimbLight | None:
    lights = [light for light in per_camera if light is not None]
    if not lights:
        return None
    return _LimbLight(
        # A start at the mean keeps the exposure's bound loose.
        log_level=np.concatenate([one.log_level - np.mean(one.log_level) for one in lights]),
        ray_body=np.concatenate([one.ray_body for one in lights]),
        share=np.concatenate([one.share for one in lights]),
        camera_basis=block_diag(*[one.camera_basis for one in lights]),
        own_mean=np.concatenate([one.own_mean for one in lights]),
        own_sigma=np.concatenate([one.own_sigma for one in lights]),
    )


def _brightness(p: LimbPoints, frame: Frame, camera: HorizonCamera) -> _LimbLight | None:
    good = p.found & ~p.clipped & (p.slope_per_px > 0.0)
    if np.sum(good) < OPTIONS.fewest:
        return None
    ray_body = p.ray_body[good]
    axial = np.maximum(ray_body @ camera.boresight_body, 0.05)
    return _LimbLight(
        log_level=np.log(p.slope_per_px[good]),
        ray_body=ray_body,
        share=(OPTIONS.decoded_share if frame.decoded else 1.0) / p.columns_per_patch()[good],
        camera_basis=np.column_stack([np.ones(len(axial)), 4.0 * np.log(axial)]),
        own_mean=np.array([0.0, OPTIONS.darkened]),
        own_sigma=np.array([OPTIONS.free_exposure, OPTIONS.darkened_sigma]),
    )


def _colour(
    p: LimbPoints, frame: Frame, camera: HorizonCamera, nadir_body: Array, reach_m: float
) -> _LimbLight | None:
    """reach_m: from the craft to its limb."""
    good = np.flatnonzero(p.found & ~p.clipped)
    if not frame.blue or len(good) < OPTIONS.fewest:
        return None
    light = _light(p.ray_body[good], frame, camera, nadir_body, reach_m, OPTIONS.within_m)
    # Full ones are not a number.
    positive = np.all(light > 0.0, axis=1)
    good, light = good[positive], light[positive]
    if len(good) < OPTIONS.fewest:
        return None
    return _LimbLight(
        log_level=np.log(light[:, 2] / light[:, 0]),
        ray_body=p.ray_body[good],
        share=1.0 / p.columns_per_patch()[good],
        camera_basis=np.ones((len(good), 1)),
        own_mean=np.zeros(1),
        own_sigma=np.array([OPTIONS.free_exposure]),
    )


def is_no_bluer_above(
    p: LimbPoints, frame: Frame, camera: HorizonCamera, nadir_body: Array, reach_m: float
) -> bool:
    """Whether the edge is no bluer above, where thin air would scatter blue most, than within."""
    good = p.found & ~p.clipped
    coarse = camera.rad_per_px * reach_m > OPTIONS.coarsest_m
    if not frame.blue or coarse or np.sum(good) < OPTIONS.fewest:
        return False
    along = (p.ray_body[good], frame, camera, nadir_body, reach_m)
    light = np.hstack([_light(*along, at_m) for at_m in (OPTIONS.above_m, OPTIONS.within_m)])
    unsaturated = np.all(np.isfinite(light), axis=1)
    if np.sum(unsaturated) < OPTIONS.fewest:
        return False
    blue_above, _, red_above, blue, _, red = np.median(light[unsaturated], axis=0)
    if min(blue_above, red_above, blue, red) <= 0.0:
        return False
    bluer = np.log(blue_above / red_above) - np.log(blue / red)
    return bool(bluer < OPTIONS.least_bluer)


def _light(
    ray_body: Array,
    frame: Frame,
    camera: HorizonCamera,
    nadir_body: Array,
    reach_m: float,
    at_m: tuple[float, ...],
) -> Array:
    """Light over the sky's, at depths below the limb along rays (n, 3): (n, 3) colours."""
    across_body = nadir_body - (ray_body @ nadir_body)[:, None] * ray_body
    across_body /= np.linalg.norm(across_body, axis=1, keepdims=True)
    lower_rad = np.array([*at_m, *OPTIONS.beyond_m])[:, None, None] / reach_m
    look_body = np.cos(lower_rad) * ray_body + np.sin(lower_rad) * across_body
    x, y = camera.pixels(look_body.reshape(-1, 3)).astype(np.float32).T.copy()
    picked = cv2.remap(frame.pixels, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    level = frame.table[picked].reshape(len(lower_rad), len(ray_body), -1)[..., :3].astype(float)
    level[frame.is_full(picked).reshape(*level.shape[:2], -1)[..., :3]] = np.nan
    here = len(at_m)
    return np.asarray(level[:here].mean(axis=0) - level[here:].mean(axis=0))
