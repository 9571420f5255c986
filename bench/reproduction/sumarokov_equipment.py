"""Camera and platform: Sumarokov 2016, pp. 85 and 86."""

import math

import numpy as np

from planner.base.commands import COMMAND_STEP_S
from planner.planning.opportunities.ground_sample import sample_along_m
from planner.world.platforms import ISS_HRC
from planner.world.platforms.camera import HRC_CAMERA, HRC_PIXEL_ARCSEC
from planner.world.platforms.two_axis import HRC_FRAME_HALF_RAD
from reproduction.example_plans import LAS_VEGAS, view_of
from reproduction.statements import Numbers

HEIGHT_KM = 350.0


def numbers() -> Numbers:
    limits, view = ISS_HRC.outer_limits, view_of(LAS_VEGAS)
    track = view.targets[0]
    [below_m] = sample_along_m(np.ones(1), np.array([HEIGHT_KM * 1e3]), HRC_CAMERA.pixel_rad)
    long_km, short_km = (2.0 * HEIGHT_KM * math.tan(half) for half in HRC_FRAME_HALF_RAD)
    return {
        "frame, long": long_km,
        "frame, short": short_km,
        "pixel": float(below_m),
        "pixel, Las Vegas": float(np.min(track.ground_sample_across_m[track.in_session])),
        "exposure": HRC_CAMERA.exposure_s,
        "stops": math.degrees(limits.angle_max_rad),
        "fastest": math.degrees(limits.rate_max_rad_s),
        "slowest": math.degrees(limits.rate_min_rad_s) * 60.0,
        "acceleration": math.degrees(limits.acceleration_max_rad_s2),
        "table": COMMAND_STEP_S,
        "pixel_arcsec": HRC_PIXEL_ARCSEC,
        "height_km": float(view.carrier.height_m.mean()) / 1e3,
        "along_m": float(np.max(track.ground_sample_along_m[track.in_session])),
    }
