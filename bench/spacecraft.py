"""Figures of the CMG spacecraft against what is promised; run it with python.

python bench/spacecraft.py            everything
python bench/spacecraft.py timeline   some parts: timeline, settle, areas, slews, choice, random,
                                      ground

Times are CPU times: others at work on the machine don't count.
"""

import math
import sys
import time

import numpy as np
from imaging_cases import line, session_request, sun_synchronous
from spacecraft_choice import bench_choice, bench_slews
from spacecraft_flight import bench_areas, bench_settle, bench_timeline
from spacecraft_random import bench_random

from planner.spacecraft.plan import plan_imaging
from planner.spacecraft.requests import (
    CorridorRequest,
    GeoLineString,
    StereoRequest,
    StripRequest,
)


def bench_ground() -> None:
    print("Strip, stereo, corridors (the judge's own ground points; Skyfield's: in the tests):")
    orbit = sun_synchronous(640.0)

    def along(t_s: float, across_km: float, azimuth_deg: float = 0.0) -> GeoLineString:
        return GeoLineString(coordinates=line(orbit, t_s, 30.0, across_km, azimuth_deg))

    requests = (
        StripRequest(name="strip", geometry=along(90.0, 100.0)),
        StereoRequest(name="stereo", geometry=along(230.0, -40.0)),
        CorridorRequest(name="corridor 45 deg", geometry=along(360.0, 0.0, 45.0)),
        CorridorRequest(name="corridor 90 deg", geometry=along(470.0, 50.0, 90.0)),
    )
    begun = time.process_time()
    plan = plan_imaging(session_request(orbit, 600.0, requests))
    print(f"  planned, judged and flown 4 times in {time.process_time() - begun:.1f} s")
    rates = np.rad2deg(np.linalg.norm(plan.table.omega_body_rad_s, axis=1))
    for seen, flown in zip(plan.verification.windows, plan.stabilisation.windows, strict=True):
        print(
            f"  {seen.request} look {seen.look}: miss {seen.miss_m:.2e} m, speed off "
            f"{100 * seen.speed_spread:.4f} %, drift {math.degrees(seen.drift_rad):.1e} deg, along "
            f"{seen.along_deg:.1f} deg, body rate {rates[seen.first_row]:.2f} deg/s; flown: "
            f"{np.rad2deg(flown.rate_error_rad_s).max():.5f} deg/s, pointing "
            f"{math.degrees(flown.pointing_error_rad) * 3600:.1f} arcsec, smear "
            f"{flown.smear_px:.3f} px, settled {flown.spare_s:.1f} s before, gimbal margin "
            f"{flown.gimbal_margin:.2f}"
        )


PARTS = {
    "ground": bench_ground,
    "timeline": bench_timeline,
    "settle": bench_settle,
    "areas": bench_areas,
    "slews": bench_slews,
    "choice": bench_choice,
    "random": bench_random,
}

if __name__ == "__main__":
    for part in sys.argv[1:] or PARTS:
        PARTS[part]()
