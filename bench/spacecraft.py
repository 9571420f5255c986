"""Figures of the CMG spacecraft against what is promised; run it with python.

python bench/spacecraft.py            everything
python bench/spacecraft.py timeline   some parts: timeline, settle, areas, many, slews, choice,
                                      random, physics, ground, refusals

Times are CPU times: others at work on the machine don't count.
"""

import dataclasses
import math
import sys
import time
from datetime import timedelta

import numpy as np
from imaging_cases import DATA, EPOCH, line, session_request, sun_synchronous
from spacecraft_choice import bench_choice, bench_slews
from spacecraft_flight import bench_areas, bench_many, bench_settle, bench_timeline
from spacecraft_random import bench_random

from planner.base.errors import Refusal
from planner.spacecraft.plan import plan_imaging
from planner.spacecraft.requests import (
    CorridorRequest,
    GeoLineString,
    SpacecraftSettings,
    StereoRequest,
    StripRequest,
)


def bench_refusals() -> None:
    print("Bad input:")
    orbit = sun_synchronous(640.0)
    strip = StripRequest(name="s", geometry=GeoLineString(coordinates=line(orbit, 100, 30, 0)))
    far = GeoLineString(coordinates=line(orbit, 100, 30, 900))
    cases = (
        lambda: (StripRequest(name="far", geometry=far), {}),
        lambda: (
            dataclasses.replace(
                strip,
                window_start=EPOCH + timedelta(seconds=96),
                window_stop=EPOCH + timedelta(seconds=104),
            ),
            {},
        ),
        lambda: (
            StripRequest(
                name="soon",
                geometry=GeoLineString(coordinates=line(orbit, 10, 30, 300)),
                start=EPOCH + timedelta(seconds=8),
            ),
            {},
        ),
        lambda: (strip, {"settings": SpacecraftSettings(momentum_n_m_s=(50.0, 40.0, 0.0))}),
        lambda: (
            CorridorRequest(
                name="loop",
                geometry=GeoLineString(coordinates=((0, 0), (1, 1), (1, 0), (0, 1))),
            ),
            {},
        ),
    )
    for case in cases:
        try:
            request, more = case()
            plan_imaging(session_request(orbit, 240.0, (request,), **more))
            print("  accepted?!")
        except (Refusal, ValueError) as why:
            print(f"  {type(why).__name__}: {why}")


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
        window = seen.window
        print(
            f"  {window.request} look {window.look}: miss {seen.miss_m:.2e} m, speed off "
            f"{100 * seen.speed_spread:.4f} %, drift {math.degrees(seen.drift_rad):.1e} deg, along "
            f"{seen.along_deg:.1f} deg, body rate {rates[window.first_row]:.2f} deg/s; flown: "
            f"{np.rad2deg(flown.rate_error_rad_s).max():.5f} deg/s, pointing "
            f"{math.degrees(flown.pointing_error_rad) * 3600:.1f} arcsec, smear "
            f"{flown.smear_px:.3f} px, settled {flown.spare_s:.1f} s before, gimbal margin "
            f"{flown.gimbal_margin:.2f}"
        )


def bench_physics() -> None:
    print("Physics (the same checks as tests/properties/test_spacecraft_dynamics.py):")
    tests = DATA.parents[1]
    sys.path[:0] = [str(tests), str(tests / "properties"), str(tests / "oracles")]
    import test_spacecraft_basilisk as basilisk
    import test_spacecraft_dynamics as dynamics

    fine = dynamics.flown(0.0005, 4.0, dynamics.COMMAND)[1].state
    errors = [
        np.abs(dynamics.flown(h, 4.0, dynamics.COMMAND)[1].state - fine).max()
        for h in (0.008, 0.004, 0.002)
    ]
    print(f"  order of the integrator {np.log2(np.array(errors[:-1]) / errors[1:]).round(2)}")
    state = dynamics.flown(0.005, 60.0, dynamics.COMMAND)[1].state
    start = dynamics.flown(0.005, 0.0, dynamics.COMMAND)[1].state
    leak = np.linalg.norm(state[4:7] - start[4:7]) / np.linalg.norm(start[4:7])
    print(f"  angular momentum over 60 s without torque: {leak:.1e} relative (a state, exact)")
    rates, _ = basilisk.flown_by_us()
    worst = np.rad2deg(np.abs(rates - basilisk.ROWS[:, 8:11]).max())
    print(f"  Basilisk's 20 deg turn at {np.rad2deg(basilisk.ROWS[:, 8:11].max()):.2f} deg/s fed")
    print(f"  with its gimbal log: body rates within {worst:.1e} deg/s (gimbal inertia modelled)")


PARTS = {
    "physics": bench_physics,
    "ground": bench_ground,
    "refusals": bench_refusals,
    "timeline": bench_timeline,
    "settle": bench_settle,
    "areas": bench_areas,
    "many": bench_many,
    "slews": bench_slews,
    "choice": bench_choice,
    "random": bench_random,
}

if __name__ == "__main__":
    for part in sys.argv[1:] or PARTS:
        PARTS[part]()
