"""The craft's heading about the vertical, from how the limb's light runs along it.

Clear air scatters sunlight forwards and backwards more than sideways (Rayleigh), and the limb
lies above most dust and cloud; so along each camera's arc the limb's brightness follows the
angle to the Sun.  Each camera's exposure is free, and so, within bounds, are how much the
light scattered more than once evens out, what dust adds and how much the lens darkens off its
axis.  It decides between headings that fit the limb's shape alike, for when no attitude was
predicted.

Dust scatters sunlight of all colours forwards, so the limb reddens towards the Sun: where the
file kept its colours sharp, that tells the Sun's side from its opposite.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from estimator.camera import HorizonCamera
from estimator.images import Frame
from estimator.limb import LimbPoints
from estimator.limb_geometry import Limb
from estimator.nadir import columns_per_patch
from planner.arrays import Array

_SCATTER = 0.035  # of brightness from one 5 deg of limb to the next: dust, thin cloud
_EVENED, _EVENED_SIGMA = 0.75, 0.25  # contrast left of single scattering
_DARKENED, _DARKENED_SIGMA = 0.25, 0.3  # of cos^4: lenses are flat-fielded, or nearly, or not
_FORWARD = 0.65  # mean cosine of dust's scattering
_DUST, _DUST_SIGMA = 0.15, 0.15  # its light against the air's, if it scattered evenly
_DECODED_SHARE = 0.05  # the curve that is undone is rarely the whole of what a camera did
_FREE_EXPOSURE = 3.0
_OUTLIER = 3.0
_FEWEST = 16
# Of the logarithm of red over blue: its rise from across the Sun's direction to along it, and
# its scatter from one 5 deg of limb to the next.
_REDDENED, _REDDENED_SIGMA = 0.2, 0.12
_COLOUR_SCATTER = 0.02
_WITHIN_M, _BEYOND_M = (6e3, 10e3, 14e3), (-30e3, -36e3)


@dataclass(frozen=True)
class LimbBrightness:
    """The limb's brightness in all cameras, an entry per column that can be used.

    log_brightness (n,); ray_body (n, 3); share (n,): of the information of 5 deg of limb;
    lens (n, 2 k): per camera its exposure's part and its lens's.
    """

    log_brightness: Array
    ray_body: Array
    share: Array
    lens: Array

    def cost(self, limb: Limb, c_body_from_itrf: Array, height_m: float, sun: Array) -> float:
        """Minus twice the log likelihood of an attitude; sun: direction (3,) in ITRF axes."""
        direction = self.ray_body @ c_body_from_itrf
        elevation = limb.sun_elevation_rad(direction, height_m, sun)
        scattered = np.log(1.0 + (direction @ sun) ** 2)
        dimmed = 0.04 / np.maximum(np.sin(elevation), 0.02)
        cameras = self.lens.shape[1] // 2
        dusty = _forwards(direction @ sun)
        expected = np.array([_EVENED, _DUST, *[0.0, _DARKENED] * cameras])
        sigma = np.array([_EVENED_SIGMA, _DUST_SIGMA, *[_FREE_EXPOSURE, _DARKENED_SIGMA] * cameras])
        design = np.column_stack([scattered, dusty, self.lens])
        observed = self.log_brightness + dimmed
        return _misfit(observed, design, expected, sigma, self.share, _SCATTER)


@dataclass(frozen=True)
class LimbColour:
    """How red the limb is in all cameras, an entry per column that can be used.

    log_red_over_blue (n,), less each camera's mean; ray_body (n, 3); share (n,): of the
    information of 5 deg of limb; camera (n, k): 1 for the camera it is of.
    """

    log_red_over_blue: Array
    ray_body: Array
    share: Array
    camera: Array

    def cost(self, c_body_from_itrf: Array, sun: Array) -> float:
        """Minus twice the log likelihood of an attitude; sun: direction (3,) in ITRF axes."""
        design = np.column_stack([self.ray_body @ c_body_from_itrf @ sun, self.camera])
        cameras = self.camera.shape[1]
        expected = np.array([_REDDENED, *[0.0] * cameras])
        sigma = np.array([_REDDENED_SIGMA, *[_FREE_EXPOSURE] * cameras])
        return _misfit(self.log_red_over_blue, design, expected, sigma, self.share, _COLOUR_SCATTER)


@dataclass(frozen=True)
class Sunlight:
    """All that the sunlight along the limb says of attitudes; sun: direction (3,) in ITRF axes."""

    limb: Limb
    sun_itrf: Array
    brightness: LimbBrightness | None
    colour: LimbColour | None

    def cost(self, c_body_from_itrf: Array, height_m: float) -> float:
        """Minus twice the log likelihood; 0 where nothing was seen."""
        total = 0.0
        if self.brightness is not None:
            total += self.brightness.cost(self.limb, c_body_from_itrf, height_m, self.sun_itrf)
        if self.colour is not None:
            total += self.colour.cost(c_body_from_itrf, self.sun_itrf)
        return total


def _misfit(
    observed: Array, design: Array, expected: Array, sigma: Array, share: Array, scatter: float
) -> float:
    """Chi-square of the best robust linear fit, its unknowns' own departures included."""
    off = observed - design @ expected
    known = sigma**-2
    weight = share / scatter**2
    least = weight
    for _ in range(2):
        normal = (design.T * least) @ design + np.diag(known)
        free = np.linalg.solve(normal, design.T @ (least * off))
        rest = (off - design @ free) / scatter
        least = weight / np.maximum(np.abs(rest) / _OUTLIER, 1.0)
    return float(np.sum(share * np.minimum(rest**2, _OUTLIER**2)) + np.sum(known * free**2))


def _forwards(cosine: Array) -> Array:
    """What dust scatters at an angle to the Sun, against air (Henyey and Greenstein 1941)."""
    dust = (1.0 - _FORWARD**2) / (1.0 + _FORWARD**2 - 2.0 * _FORWARD * cosine) ** 1.5
    return np.asarray(dust / (0.75 * (1.0 + cosine**2)))


def limb_colour(
    points: list[LimbPoints],
    frames: Sequence[Frame],
    cameras: Sequence[HorizonCamera],
    nadir_body: Array,
    reach_m: float,
) -> LimbColour | None:
    """None where no camera shows enough of an unsaturated limb in sharp colour.

    reach_m: from the craft to its limb.
    """
    log_ratio, ray_body, share = [], [], []
    for p, frame, camera in zip(points, frames, cameras, strict=True):
        if not frame.blue or np.sum(p.found & ~p.clipped) < _FEWEST:
            continue
        good = np.flatnonzero(p.found & ~p.clipped)
        ray = p.ray_body[good]
        light = _light(ray, frame, camera, nadir_body, reach_m)
        seen = np.all(light > 0.0, axis=1)
        if np.sum(seen) < _FEWEST:
            continue
        ratio = np.log(light[seen, 2] / light[seen, 0])
        log_ratio.append(ratio - np.mean(ratio))
        ray_body.append(ray[seen])
        share.append(1.0 / columns_per_patch(p)[good[seen]])
    if not log_ratio:
        return None
    return LimbColour(
        log_red_over_blue=np.concatenate(log_ratio),
        ray_body=np.concatenate(ray_body),
        share=np.concatenate(share),
        camera=np.repeat(np.eye(len(log_ratio)), [len(one) for one in log_ratio], axis=0),
    )


def _light(
    ray_body: Array, frame: Frame, camera: HorizonCamera, nadir_body: Array, reach_m: float
) -> Array:
    """How much brighter than the sky it is within the limb along rays (n, 3): (n, 3) colours."""
    across = nadir_body - (ray_body @ nadir_body)[:, None] * ray_body
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    lower = np.array([*_WITHIN_M, *_BEYOND_M])[:, None, None] / reach_m
    rays = np.cos(lower) * ray_body + np.sin(lower) * across
    x, y = camera.pixels(rays.reshape(-1, 3)).astype(np.float32).T.copy()
    picked = cv2.remap(frame.pixels, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    level = frame.table[picked].reshape(len(lower), len(ray_body), -1)[..., :3].astype(float)
    within = len(_WITHIN_M)
    return np.asarray(level[:within].mean(axis=0) - level[within:].mean(axis=0))


def limb_brightness(
    points: list[LimbPoints], frames: Sequence[Frame], cameras: Sequence[HorizonCamera]
) -> LimbBrightness | None:
    """None where no camera shows enough of an unsaturated limb."""
    log_brightness, ray_body, share, lens = [], [], [], []
    for p, frame, camera in zip(points, frames, cameras, strict=True):
        good = p.found & ~p.clipped & (p.slope > 0.0)
        if np.sum(good) < _FEWEST:
            continue
        log_brightness.append(np.log(p.slope[good]))
        ray_body.append(p.ray_body[good])
        share.append((_DECODED_SHARE if frame.decoded else 1.0) / columns_per_patch(p)[good])
        axial = np.maximum(ray_body[-1] @ camera.boresight_body, 0.05)
        own = np.column_stack([np.ones(len(axial)), 4.0 * np.log(axial)])
        lens.append(own)
    if not lens:
        return None
    # A start at the mean brightness keeps the exposure's bound loose.
    level = [np.mean(one) for one in log_brightness]
    columns = np.zeros((sum(map(len, lens)), 2 * len(lens)))
    at = 0
    for k, own in enumerate(lens):
        columns[at : at + len(own), 2 * k : 2 * k + 2] = own
        at += len(own)
    return LimbBrightness(
        log_brightness=np.concatenate(
            [one - mean for one, mean in zip(log_brightness, level, strict=True)]
        ),
        ray_body=np.concatenate(ray_body),
        share=np.concatenate(share),
        lens=columns,
    )
