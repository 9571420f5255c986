"""The sessions of Platonov, Sumarokov 2019, Figs. 3 to 9: requests, plans and dispersed flights.

    PYTHONPATH=.:bench python -m reproduction.platonov_sessions

writes the requests into examples/.  The paper gives times and sizes, neither orbit nor places;
here strips lie along the track where the orbit passes at those times.
"""

import json
from collections.abc import Sequence
from datetime import timedelta
from functools import lru_cache
from pathlib import Path

from imaging_cases import EPOCH, local_axes, positions, sun_synchronous
from scipy.spatial.transform import Rotation
from spacecraft_flight import PAPER_TURNS_S, itself, orbit_states

from app.requests.spacecraft import read_spacecraft_request
from planner.spacecraft.flight.closed_loop import Log
from planner.spacecraft.flight.simulation import fly_many
from planner.spacecraft.plan import ImagingPlan, plan_imaging
from planner.spacecraft.requests import SCAN_SPEED_M_S
from planner.world.frames.time_scales import utc_text
from planner.world.orbits import StateVectorOrbit

EXAMPLES = Path(__file__).parents[2] / "examples"
STRIP_S, STEREO_S, SCAN_S, GAP_S = 128.0, 338.0, 16.0, 110.0  # Figs. 4 and 6
STEREO_KM, AREAS_KM = 700.0, 640.0  # of the paper's 600 to 700; lower, the ends lie beyond 30 deg
LONG_START_S = 400.0  # the paper's clock at row 0 of the long session
FIRST_SCAN_S, SCAN_AFTER_S = 15.0, 14.0  # Figs. 8 and 9: 866-881 and 1405-1419 s
SEEDS = range(8)  # dispersed runs: 40 move the worst by a fifth


def at(t_s: float) -> str:
    return utc_text(EPOCH + timedelta(seconds=t_s), 1)


def lines(
    orbit: StateVectorOrbit, t_s: float, half_m: float, across_m: tuple[float, ...]
) -> list[Sequence]:
    """Lines along the track beside each other, where the orbit passes at t_s."""
    origin, along, across = local_axes(orbit, t_s)
    return [
        positions([origin + a * across - half_m * along, origin + a * across + half_m * along])
        for a in across_m
    ]


def one(name: str, mode: str, line: Sequence, start_s: float, **more: object) -> dict:
    coordinates = [[round(x, 6) for x in position] for position in line]
    return {
        "mode": mode,
        "name": name,
        "geometry": {"type": "LineString", "coordinates": coordinates},
        "start": at(start_s),
        **more,
    }


def session(
    name: str, orbit: StateVectorOrbit, stop_s: float, requests: list[dict], **more: object
) -> dict:
    return {
        "name": name,
        "orbit": {
            "source": "state",
            "frame": "GCRF",
            "epoch": at(0.0),
            "position_km": [round(x, 6) for x in orbit.position_km],
            "velocity_km_s": [round(x, 9) for x in orbit.velocity_km_s],
        },
        "start": at(0.0),
        "stop": at(stop_s),
        **more,
        "requests": requests,
    }


def strip_and_stereo() -> dict:
    orbit = sun_synchronous(STEREO_KM)
    half_m = 0.5 * SCAN_S * SCAN_SPEED_M_S
    [strip] = lines(orbit, STRIP_S + 0.5 * SCAN_S, half_m, (0.0,))
    [stereo] = lines(orbit, STEREO_S + 0.5 * (GAP_S + SCAN_S), half_m, (0.0,))
    return session(
        "Strip and stereo pair of Platonov, Sumarokov 2019",
        orbit,
        560.0,
        [
            one("strip", "strip", strip, STRIP_S),
            one("stereo", "stereo", stereo, STEREO_S, gap_s=GAP_S),
        ],
    )


def eight_areas() -> dict:
    """Each area of 48 x 60 km as its four strips, so that each has the paper's moment."""
    orbit = sun_synchronous(AREAS_KM)
    requests = []
    for block in range(8):
        turns_s = [t - LONG_START_S for t in PAPER_TURNS_S[4 * block : 4 * block + 5]]
        scans_s = [FIRST_SCAN_S, *[SCAN_AFTER_S] * 3]
        stops_s = [turns_s[1] - 1.0, *[t - 0.2 for t in turns_s[2:]]]
        starts_s = [stop - scan for stop, scan in zip(stops_s, scans_s, strict=True)]
        aside_m = 60e3 * (-1) ** block
        across_m = tuple(aside_m + 12e3 * (k - 1.5) for k in range(4))
        middle_s = 0.5 * (starts_s[0] + stops_s[-1])
        strips = lines(orbit, middle_s, 30e3, across_m)
        requests += [
            one(
                f"area {block + 1} strip {k + 1}",
                "strip",
                strip,
                start_s,
                scan_speed_m_s=round(60e3 / (scan_s - 0.05), 3),
            )
            for k, (strip, scan_s, start_s) in enumerate(
                zip(strips, scans_s, starts_s, strict=True)
            )
        ]
    inertial = Rotation.from_euler("XYZ", [0.3, 1.0, -0.4]).as_quat()
    return session(
        "The long session of Platonov, Sumarokov 2019: eight areas",
        orbit,
        1590.0,
        requests,
        initial_q_body_from_eci_xyzw=[round(x, 9) for x in inertial.tolist()],
    )


@lru_cache(maxsize=2)
def planned(name: str) -> ImagingPlan:
    """The plan of "strip_and_stereo" or "eight_areas"."""
    return plan_imaging(read_spacecraft_request(text(name).encode()))


@lru_cache(maxsize=2)
def flown(name: str) -> tuple[Log, ...]:
    """Its table in closed loop, one run for each of SEEDS."""
    plan = planned(name)
    return tuple(fly_many(plan.spacecraft, plan.table, orbit_states(plan), SEEDS, itself))


def text(name: str) -> str:
    """The request as a file."""
    document = {"strip_and_stereo": strip_and_stereo, "eight_areas": eight_areas}[name]()
    return json.dumps(document, indent=2) + "\n"


if __name__ == "__main__":
    for name in ("strip_and_stereo", "eight_areas"):
        (EXAMPLES / f"spacecraft_{name}.json").write_text(text(name), encoding="utf-8")
