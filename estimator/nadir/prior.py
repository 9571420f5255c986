"""Prior knowledge of limb and attitude, before an image is read."""

from dataclasses import dataclass

import numpy as np

from estimator.nadir.fit import ROUGHNESS_M, Prior
from estimator.surroundings import Surroundings

# The daylight limb in the middle of the visible band.
DAYLIGHT_LIMB_M = 17.5e3
DAYLIGHT_LIMB_SIGMA_M = 4.0e3


@dataclass(frozen=True, kw_only=True)
class LimbPrior:
    """What is known of the limb's height before it is seen."""

    blue_rise_m: float = 3.5e3  # of the limb in blue over that in grey: air scatters it more
    blue_limb_sigma_m: float = 2.4e3  # less than in grey, since dust counts less
    # Dust and ozone scatter and absorb differently towards the Sun and away from it: the limb's
    # height leans along the Sun's azimuth, which no image can tell from a tilt.  In grey, where
    # dust counts, it leans with the level part of the Sun's direction against the upright one:
    lean_m: float = 900.0
    least_lean_m: float = 300.0  # and so much under any Sun
    steepest: float = 6.5  # that ratio, at most: under a low Sun
    blue_lean_m: float = 250.0  # in blue, where air hides the dust
    bend_of_lean: float = 0.25  # of the lean, across the Sun's azimuth
    # of the Sun's azimuth, where the heading isn't known
    unknown_heading_rad: float = np.deg2rad(15.0)
    least_heading_rad: float = np.deg2rad(1.0)  # and where it is


PRIOR = LimbPrior()


def prior_of(around: Surroundings, predicted_sigma_deg: float | None, blue: bool) -> Prior:
    """The limb's height as the request or the daylight gives it, and the heading's hold.

    predicted_sigma_deg: 1-sigma of the predicted attitude; None without a prediction: then the
    heading is tried all round, in steps this prior bridges.
    blue: the frames are blue channels.  There the limb stands higher, in air that holds
    little dust, and follows its model better than in grey.
    """
    heading_sigma_rad = PRIOR.unknown_heading_rad
    if predicted_sigma_deg is not None:
        heading_sigma_rad = max(np.deg2rad(predicted_sigma_deg), PRIOR.least_heading_rad)
    body = around.body
    if body.limb_height_km is None or body.limb_height_sigma_km is None:
        lean_m = _lean_sigma_m(around, blue)
        return Prior(
            height_m=DAYLIGHT_LIMB_M + (PRIOR.blue_rise_m if blue else 0.0),
            height_sigma_m=PRIOR.blue_limb_sigma_m if blue else DAYLIGHT_LIMB_SIGMA_M,
            lean_sigma_m=lean_m,
            bend_sigma_m=PRIOR.bend_of_lean * lean_m,
            heading_sigma_rad=heading_sigma_rad,
            roughness_m=ROUGHNESS_M,
            sun_itrf=around.sun_itrf,
        )
    sigma_m = body.limb_height_sigma_km * 1e3
    return Prior(
        height_m=body.limb_height_km * 1e3,
        height_sigma_m=sigma_m,
        heading_sigma_rad=heading_sigma_rad,
        lean_sigma_m=1.0,
        bend_sigma_m=1.0,
        # A limb said to be known to the metre is no rougher than that.
        roughness_m=min(ROUGHNESS_M, sigma_m + 1.0),
        sun_itrf=None,
    )


def _lean_sigma_m(around: Surroundings, blue: bool) -> float:
    sine = max(around.sun_sine, 0.0)
    if blue:
        # Twice as much at 14 deg.
        return PRIOR.blue_lean_m * (1.0 + 3.0 * float(np.exp(-sine / 0.23)))
    level = np.sqrt(1.0 - sine**2)
    return float(
        np.hypot(PRIOR.lean_m * min(level / max(sine, 1e-3), PRIOR.steepest), PRIOR.least_lean_m)
    )
