"""The limb as a camera sees it, projected into the image."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from estimator.camera import HorizonCamera
from estimator.limb.geometry import Limb
from planner.base.arrays import Array

_MAX_COLUMNS = 640
_COARSE_STEPS = 2880
_COARSE_RAD = 2.0 * np.pi / _COARSE_STEPS
_MARGIN_PX = 4.0


@dataclass(frozen=True)
class LimbProjection:
    """The limb at a height as a camera sees it from one attitude."""

    camera: HorizonCamera
    limb: Limb
    c_body_from_itrf: Array
    height_m: float

    def ray_body(self, azimuth_rad: Array, above_m: float = 0.0) -> Array:
        """Unit vectors (n, 3) to the limb at azimuths (n,), or to a limb so much higher."""
        direction_itrf = self.limb.directions_itrf(azimuth_rad, self.height_m + above_m)
        return np.asarray(direction_itrf @ self.c_body_from_itrf.T)

    def span_px(self, azimuth_rad: Array, half_m: float) -> tuple[Array, Array, NDArray[np.bool_]]:
        """Pixels (n, 2) of a limb so much lower and higher, and which can be told apart, (n,)."""
        low_px, high_px = (
            self.camera.pixels(self.ray_body(azimuth_rad, above_m)) for above_m in (-half_m, half_m)
        )
        length_px = np.linalg.norm(high_px - low_px, axis=1)
        return low_px, high_px, np.isfinite(length_px) & (length_px > 0.0)

    def visible(self) -> tuple[Array, float]:
        """Azimuths of the limb in the frame, evenly spaced about a pixel apart; their spacing."""
        coarse_rad = np.linspace(0.0, 2.0 * np.pi, _COARSE_STEPS, endpoint=False)
        seen = self.camera.sees(self.camera.pixels(self.ray_body(coarse_rad)), _MARGIN_PX)
        limb, rad_per_px = self.limb, self.camera.rad_per_px
        turn_px = 2.0 * np.pi * limb.mean_radius_m / limb.range_m / rad_per_px
        columns = min(_MAX_COLUMNS, max(float(np.mean(seen)) * turn_px, 1.0))
        count = max(int(np.sum(seen)), 1)
        per_coarse = max(1, round(columns / count))
        thinning = max(1, int(count / columns))
        # Start where the arc does, so that neighbours in the array are neighbours on the limb.
        gaps = np.flatnonzero(~seen)
        start = gaps[-1] + 1 if len(gaps) else 0
        inside = np.flatnonzero(seen)[::thinning]
        inside = (np.sort((inside - start) % _COARSE_STEPS) + start) % _COARSE_STEPS
        within = np.arange(per_coarse) / per_coarse - 0.5 * (per_coarse - 1) / per_coarse
        azimuth_rad = coarse_rad[inside][:, None] + within * _COARSE_RAD
        return azimuth_rad.ravel(), _COARSE_RAD / per_coarse * thinning
