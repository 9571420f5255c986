"""Which way does the craft face about the vertical, by how the limb's brightness runs?

Clear air scatters sunlight forwards and backwards more than sideways (Rayleigh), and the limb
lies above most dust and cloud; so along each camera's arc the limb's brightness follows the
angle to the Sun.  Each camera's exposure is free, and so, within bounds, are how much the
light scattered more than once evens out and how much the lens darkens off its axis.  It
decides between headings that fit the limb's shape alike, for when no attitude was predicted.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from estimator.camera import HorizonCamera
from estimator.limb import LimbPoints
from estimator.limb_geometry import Limb
from estimator.nadir import columns_per_patch

Floats = NDArray[np.float64]

_SCATTER = 0.05  # of brightness from one 5 deg of limb to the next: dust, thin cloud
_EVENED, _EVENED_SIGMA = 0.75, 0.25  # contrast left of single scattering
_DARKENED, _DARKENED_SIGMA = 0.25, 0.3  # of cos^4: lenses are flat-fielded, or nearly, or not
_FREE_EXPOSURE = 3.0
_OUTLIER = 3.0
_FEWEST = 16


@dataclass(frozen=True)
class LimbBrightness:
    """The limb's brightness in all cameras, an entry per column that can be used.

    log_brightness (n,); ray_body (n, 3); share (n,): of the information of 5 deg of limb;
    lens (n, 2 k): per camera its exposure's part and its lens's.
    """

    log_brightness: Floats
    ray_body: Floats
    share: Floats
    lens: Floats

    def cost(self, limb: Limb, c_body_from_itrf: Floats, height_m: float, sun: Floats) -> float:
        """Minus twice the log likelihood of an attitude; sun: direction (3,) in ITRF axes."""
        direction = self.ray_body @ c_body_from_itrf
        elevation = limb.sun_elevation_rad(direction, height_m, sun)
        scattered = np.log(1.0 + (direction @ sun) ** 2)
        dimmed = 0.04 / np.maximum(np.sin(elevation), 0.02)
        design = np.column_stack([scattered, self.lens])
        cameras = self.lens.shape[1] // 2
        expected = np.array([_EVENED, *[0.0, _DARKENED] * cameras])
        known = np.array([_EVENED_SIGMA, *[_FREE_EXPOSURE, _DARKENED_SIGMA] * cameras]) ** -2
        off = self.log_brightness + dimmed - design @ expected
        weight = self.share / _SCATTER**2
        least = weight
        for _ in range(2):
            normal = (design.T * least) @ design + np.diag(known)
            free = np.linalg.solve(normal, design.T @ (least * off))
            rest = (off - design @ free) / _SCATTER
            least = weight / np.maximum(np.abs(rest) / _OUTLIER, 1.0)
        misfit = np.sum(self.share * np.minimum(rest**2, _OUTLIER**2))
        return float(misfit + np.sum(known * free**2))


def limb_brightness(
    points: list[LimbPoints], cameras: Sequence[HorizonCamera]
) -> LimbBrightness | None:
    """None where no camera shows enough of an unsaturated limb."""
    log_brightness, ray_body, share, lens = [], [], [], []
    for p, camera in zip(points, cameras, strict=True):
        good = p.found & ~p.clipped & (p.slope > 0.0)
        if np.sum(good) < _FEWEST:
            continue
        log_brightness.append(np.log(p.slope[good]))
        ray_body.append(p.ray_body[good])
        share.append(1.0 / columns_per_patch(p)[good])
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
