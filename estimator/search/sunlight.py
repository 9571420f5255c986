"""The craft's heading about the vertical, from how the limb's light runs along it.

Clear air scatters sunlight forwards and backwards more than sideways (Rayleigh), and the limb
lies above most dust and cloud; so along each camera's arc the limb's brightness follows the
angle to the Sun.  Each camera's exposure is free, and so, within bounds, are how much the
light scattered more than once evens out, what dust adds, how much the air takes from sunlight on
its way to the limb and how much the lens darkens off its axis.  It decides between headings that
fit the limb's shape alike, for when no attitude was predicted.

Dust scatters sunlight of all colours forwards, so the limb reddens towards the Sun: where the
file kept its colours sharp, that tells the Sun's side from its opposite.

The bounds are what twelve airs give of SASKTRAN2's light and the renderer's, from none with dust
to that after an eruption (bench/limb_tables.py).
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
from planner.arrays import Array

_SCATTER = 0.025  # of brightness from one 5 deg of limb to the next: dust, thin cloud
_DARKENED, _DARKENED_SIGMA = 0.25, 0.3  # of cos^4: lenses are flat-fielded, or nearly, or not
_FORWARD = 0.65  # mean cosine of dust's scattering
_DECODED_SHARE = 0.05  # the curve that is undone is rarely the whole of what a camera did
_FREE_EXPOSURE = 3.0
_OUTLIER = 3.0
_FEWEST = 16
# Of the logarithm of red over blue: its rise from across the Sun's direction to along it, its rise
# to both sides, and its scatter from one 5 deg of limb to the next.
_REDDENED, _REDDENED_SIGMA = 0.15, 0.13
_REDDER_ALONG, _REDDER_ALONG_SIGMA = 0.02, 0.03
_COLOUR_SCATTER = 0.015
_WITHIN_M, _BEYOND_M = (6e3, 10e3, 14e3), (-30e3, -36e3)


@dataclass(frozen=True)
class _Air:
    """What is expected of a kind of air, and its 1-sigma.

    share: how often it is met.  evened_ratio: contrast left of single scattering.
    dust_ratio: its light against the air's, if it scattered evenly.  dimmed_ratio: sunlight's
    loss, by its path's length against that straight down.
    """

    share: float
    evened_ratio: tuple[float, float]
    dust_ratio: tuple[float, float]
    dimmed_ratio: tuple[float, float]


_AIRS = (
    _Air(share=0.88, evened_ratio=(0.75, 0.25), dust_ratio=(0.15, 0.15), dimmed_ratio=(0.04, 0.03)),
    # Laden with dust, or with the haze of an eruption.
    _Air(share=0.12, evened_ratio=(0.3, 0.25), dust_ratio=(0.7, 0.35), dimmed_ratio=(0.08, 0.05)),
)


@dataclass(frozen=True)
class _LimbLight:
    """One measure of the limb's light in all cameras, an entry per column that can be used.

    log_level (n,): its logarithm, less each camera's mean.  ray_body (n, 3): towards the limb.
    share (n,): of the information of 5 deg of limb.  camera_basis (n, k): the columns of each
    camera's own unknowns, its exposure first, zero in the other cameras' rows.
    """

    log_level: Array
    ray_body: Array
    share: Array
    camera_basis: Array

    def misfit(
        self,
        basis: list[Array],
        expected_coefficients: list[float],
        sigma: list[float],
        scatter_sigma: float,
    ) -> float:
        """Chi-square of the best robust linear fit, its unknowns' own departures included."""
        design = np.column_stack([*basis, self.camera_basis])
        off = self.log_level - design @ np.array(expected_coefficients)
        information = np.array(sigma) ** -2
        weight = self.share / scatter_sigma**2
        robust = weight
        for _ in range(2):
            normal = (design.T * robust) @ design + np.diag(information)
            free = np.linalg.solve(normal, design.T @ (robust * off))
            rest = (off - design @ free) / scatter_sigma
            robust = weight / np.maximum(np.abs(rest) / _OUTLIER, 1.0)
        loss = np.sum(self.share * np.minimum(rest**2, _OUTLIER**2))
        return float(loss + np.sum(information * free**2))


@dataclass(frozen=True)
class Sunlight:
    """All that the sunlight along the limb says of attitudes.

    brightness: the limb's; each camera's unknowns are its exposure and its lens's darkening.
    colour: red over blue; each camera's unknown is its balance.  None where too little is seen.
    """

    around: Surroundings
    brightness: _LimbLight | None
    colour: _LimbLight | None

    def cost(self, c_body_from_itrf: Array, height_m: float) -> float:
        """Minus twice the log likelihood of an attitude; 0 where nothing was seen."""
        cost, sun_itrf = 0.0, self.around.sun_itrf
        if self.brightness is not None:
            cost += self._brightness_cost(self.brightness, c_body_from_itrf, height_m)
        if self.colour is not None:
            cameras = self.colour.camera_basis.shape[1]
            cosine = self.colour.ray_body @ c_body_from_itrf @ sun_itrf
            cost += self.colour.misfit(
                basis=[cosine, cosine**2],
                expected_coefficients=[_REDDENED, _REDDER_ALONG, *[0.0] * cameras],
                sigma=[_REDDENED_SIGMA, _REDDER_ALONG_SIGMA, *[_FREE_EXPOSURE] * cameras],
                scatter_sigma=_COLOUR_SCATTER,
            )
        return cost

    def _brightness_cost(
        self, light: _LimbLight, c_body_from_itrf: Array, height_m: float
    ) -> float:
        sun_itrf = self.around.sun_itrf
        ray_itrf = light.ray_body @ c_body_from_itrf
        elevation_rad = self.around.limb.sun_elevation_rad(ray_itrf, height_m, sun_itrf)
        cosine = ray_itrf @ sun_itrf
        path = 1.0 / np.maximum(np.sin(elevation_rad), 0.02)
        cameras = light.camera_basis.shape[1] // 2
        own = [(0.0, _FREE_EXPOSURE), (_DARKENED, _DARKENED_SIGMA)] * cameras
        costs = []
        for air in _AIRS:
            expected, sigma = zip(
                air.evened_ratio, air.dust_ratio, air.dimmed_ratio, *own, strict=True
            )
            misfit = light.misfit(
                basis=[np.log(1.0 + cosine**2), _dust_over_air(cosine), -path],
                expected_coefficients=list(expected),
                sigma=list(sigma),
                scatter_sigma=_SCATTER,
            )
            costs.append(misfit - 2.0 * float(np.log(air.share)))
        return float(-2.0 * np.logaddexp.reduce(-0.5 * np.array(costs)))


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
        return Sunlight(around, None, None)
    seen = list(zip(points, frames, cameras, strict=True))
    reach_m = around.limb.touch_range_m(height_m)
    return Sunlight(
        around,
        brightness=_together([_brightness(*one) for one in seen]),
        colour=_together([_colour(*one, nadir_body, reach_m) for one in seen]),
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
    )


def _brightness(p: LimbPoints, frame: Frame, camera: HorizonCamera) -> _LimbLight | None:
    good = p.found & ~p.clipped & (p.slope_per_px > 0.0)
    if np.sum(good) < _FEWEST:
        return None
    ray_body = p.ray_body[good]
    axial = np.maximum(ray_body @ camera.boresight_body, 0.05)
    return _LimbLight(
        log_level=np.log(p.slope_per_px[good]),
        ray_body=ray_body,
        share=(_DECODED_SHARE if frame.decoded else 1.0) / p.columns_per_patch()[good],
        camera_basis=np.column_stack([np.ones(len(axial)), 4.0 * np.log(axial)]),
    )


def _colour(
    p: LimbPoints, frame: Frame, camera: HorizonCamera, nadir_body: Array, reach_m: float
) -> _LimbLight | None:
    """reach_m: from the craft to its limb."""
    good = np.flatnonzero(p.found & ~p.clipped)
    if not frame.blue or len(good) < _FEWEST:
        return None
    light = _light(p.ray_body[good], frame, camera, nadir_body, reach_m)
    positive = np.all(light > 0.0, axis=1)
    good, light = good[positive], light[positive]
    if len(good) < _FEWEST:
        return None
    return _LimbLight(
        log_level=np.log(light[:, 2] / light[:, 0]),
        ray_body=p.ray_body[good],
        share=1.0 / p.columns_per_patch()[good],
        camera_basis=np.ones((len(good), 1)),
    )


def _light(
    ray_body: Array, frame: Frame, camera: HorizonCamera, nadir_body: Array, reach_m: float
) -> Array:
    """How much brighter than the sky it is within the limb along rays (n, 3): (n, 3) colours."""
    across_body = nadir_body - (ray_body @ nadir_body)[:, None] * ray_body
    across_body /= np.linalg.norm(across_body, axis=1, keepdims=True)
    lower_rad = np.array([*_WITHIN_M, *_BEYOND_M])[:, None, None] / reach_m
    look_body = np.cos(lower_rad) * ray_body + np.sin(lower_rad) * across_body
    x, y = camera.pixels(look_body.reshape(-1, 3)).astype(np.float32).T.copy()
    picked = cv2.remap(frame.pixels, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    level = frame.table[picked].reshape(len(lower_rad), len(ray_body), -1)[..., :3].astype(float)
    within = len(_WITHIN_M)
    return np.asarray(level[:within].mean(axis=0) - level[within:].mean(axis=0))


def _dust_over_air(cosine: Array) -> Array:
    """What dust scatters at an angle to the Sun, against air (Henyey and Greenstein 1941)."""
    dust = (1.0 - _FORWARD**2) / (1.0 + _FORWARD**2 - 2.0 * _FORWARD * cosine) ** 1.5
    return np.asarray(dust / (0.75 * (1.0 + cosine**2)))
