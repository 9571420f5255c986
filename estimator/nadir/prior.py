"""Prior knowledge of limb and attitude, before an image is read."""

import numpy as np

from estimator.nadir.fit import ROUGHNESS_M, Prior
from estimator.surroundings import Surroundings

# The daylight limb in the middle of the visible band.
DAYLIGHT_LIMB_M = 17.5e3
DAYLIGHT_LIMB_SIGMA_M = 4.0e3
_BLUE_RISE_M = 3.5e3
_BLUE_LIMB_SIGMA_M = 2.4e3
# Dust and ozone scatter and absorb differently towards the Sun and away from it: the limb's
# height leans along the Sun's azimuth, which no image can tell from a tilt.  In grey, where dust
# counts, it leans with the level part of the Sun's direction against the upright one; in blue,
# where air hides the dust, by some hundred metres.
_LEAN_M, _LEAST_LEAN_M, _STEEPEST = 900.0, 300.0, 6.5
_BLUE_LEAN_M = 250.0
_BEND_OF_LEAN = 0.25
_UNKNOWN_HEADING_RAD = np.deg2rad(15.0)
_LEAST_HEADING_RAD = np.deg2rad(1.0)


def prior_of(around: Surroundings, predicted_sigma_deg: float | None, blue: bool) -> Prior:
    """The limb's height as the request or the daylight gives it, and the heading's hold.

    predicted_sigma_deg: 1-sigma of the predicted attitude; None without a prediction: then the
    heading is tried all round, in steps this prior bridges.
    blue: the frames are blue channels.  There the limb stands higher, in air that holds
    little dust, and follows its model better than in grey.
    """
    heading_sigma_rad = _UNKNOWN_HEADING_RAD
    if predicted_sigma_deg is not None:
        heading_sigma_rad = max(np.deg2rad(predicted_sigma_deg), _LEAST_HEADING_RAD)
    body = around.body
    if body.limb_height_km is None or body.limb_height_sigma_km is None:
        lean_m = _lean_sigma_m(around, blue)
        return Prior(
            height_m=DAYLIGHT_LIMB_M + (_BLUE_RISE_M if blue else 0.0),
            height_sigma_m=_BLUE_LIMB_SIGMA_M if blue else DAYLIGHT_LIMB_SIGMA_M,
            lean_sigma_m=lean_m,
            bend_sigma_m=_BEND_OF_LEAN * lean_m,
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
        return _BLUE_LEAN_M * (1.0 + 3.0 * float(np.exp(-sine / 0.23)))
    level = np.sqrt(1.0 - sine**2)
    return float(np.hypot(_LEAN_M * min(level / max(sine, 1e-3), _STEEPEST), _LEAST_LEAN_M))
