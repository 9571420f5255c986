"""A fit of the limb is as likely as its residuals say."""

import numpy as np
import pytest
from horizon_cases import camera

from estimator.limb.geometry import Limb
from estimator.limb.points import ideal_points
from estimator.nadir.fit import Prior, attitude_facing, fit

LIMB = Limb(np.array([4.9e6, 0.0, 4.9e6]), 6378137.0, 6356752.3142)
HEIGHT_M, ROUGHNESS_M = 17.5e3, 800.0
PRIOR = Prior(
    height_m=HEIGHT_M,
    height_sigma_m=4e3,
    heading_sigma_rad=np.deg2rad(1.0),
    lean_sigma_m=1.0,
    bend_sigma_m=1.0,
    roughness_m=ROUGHNESS_M,
    sun_itrf=None,
)
PATCHES, PER_PATCH = 72, 20


def cost_of_limb(rough_m):
    """Of a limb all round, on patches of 5 deg (72,) so much higher."""
    c_body_from_itrf = attitude_facing(np.array([0.0, 0.0, 1.0]), LIMB)
    step_rad = 2.0 * np.pi / (PATCHES * PER_PATCH)
    azimuth_rad = step_rad * np.arange(PATCHES * PER_PATCH)
    height_m = HEIGHT_M + np.repeat(rough_m, PER_PATCH)
    ray_itrf = np.concatenate(
        [LIMB.directions_itrf(np.array([a]), h) for a, h in zip(azimuth_rad, height_m, strict=True)]
    )
    ray_body = ray_itrf @ c_body_from_itrf.T
    every = np.ones(len(azimuth_rad), dtype=bool)
    # So fine that an edge's own noise, 50 m, is nothing beside the roughness.
    fine = camera("c", 0.0, width=6400, height=4800)
    points = ideal_points(fine, ray_body, azimuth_rad, every, step_rad)
    return fit([points], LIMB, c_body_from_itrf, PRIOR).cost


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_rougher_limb_is_less_likely(seed):
    """By Gauss's law with the scale of the residuals themselves: each of n patches k times as far
    off costs 2 ln k.  Else a heading whose limb fits nowhere were as good as the true one."""
    rough_m = np.random.default_rng(seed).normal(0.0, ROUGHNESS_M, PATCHES)
    dearer = cost_of_limb(4.0 * rough_m) - cost_of_limb(1.2 * rough_m)
    # Tukey's weights and the median, in place of the rms, are good to a tenth of it.
    assert dearer == pytest.approx(2.0 * PATCHES * np.log(4.0 / 1.2), rel=0.1)
