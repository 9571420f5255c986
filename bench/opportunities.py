"""Windows of 20, 300 and 1,000 targets over 7 days: processor time, and agreement with the peers.

Ours against Skyfield's find_events and brahe's location_accesses, all on one thread, in one
run: 559 real OCO-3 targets and 441 seeded ones, the ISS, elevation of 10 deg.  Ours are windows
and sessions; these with all that is told of their view, what the peers don't: angles and rates of
the axes, sunlight, Sun and Moon at five samples; the whole request of a first page of 100 with its
JSON; of all windows; windows and sessions of axes so slow that every session must be searched; and
those of a body, smallsat-120kg, by its exclusions, its rate and its roll rule, which no peer asks
for: fewer windows, looked at second by second.

    python bench/opportunities.py [--targets 20 300 1000] [--days 7]

Times are of the processor (all threads, so that those of linear algebra must not wait beside each
other: tables of the carrier would count twice), which other work on the machine changes least; the
best of three for ours.  Earth orientation is the same finals2000A in all three.

Why edges differ: find_events bisects to half a second; ours lie within 0.1 ms of where
Skyfield's own elevation crosses the limit (tests/oracles/test_opportunities_skyfield.py).
brahe's carrier runs 75 m, 10 ms, ahead of the other two's.  All mean the same elevation:
geometric, over the plane of the WGS84 ellipsoid, without refraction or light time.
"""

import os

os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"

import argparse
import json
import math
import time
from collections.abc import Callable
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from functools import partial
from importlib.resources import files
from pathlib import Path
from typing import TypeVar

import brahe
import numpy as np
from numpy.typing import NDArray
from skyfield.api import EarthSatellite, Loader, wgs84
from skyfield.data import iers

from app.answers.members import provenance
from app.work.searches import (
    VIEW,
    WindowsAsked,
    find_windows,
    read_opportunity_request,
    search_json,
)
from planner.planning.opportunities import OpportunityRequest, WindowEdges, WindowSearch
from planner.world.platforms import TwoAxisPlatform
from planner.world.platforms.choice import BODIES

ROOT = Path(__file__).parent.parent
FINALS = files("skyfield_data") / "data" / "finals2000A.all"
MIN_ELEVATION_DEG = 10.0
SLOW_RAD_S = math.radians(0.2)  # a pass at 10 deg turns by as much
START = datetime(2015, 2, 27, tzinfo=UTC)
T = TypeVar("T")
Windows = list[NDArray[np.float64]]  # per target: rows of rise and set, s since the start


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--targets", type=int, nargs="+", default=[20, 300, 1000])
    parser.add_argument("--days", type=float, default=7.0)
    asked = parser.parse_args()
    stop = START + timedelta(days=asked.days)
    orbit = json.loads((ROOT / "examples" / "las_vegas_2015.json").read_text())["orbit"]
    lines = orbit["line1"], orbit["line2"]
    for targets in asked.targets:
        _beside_peers(_places_deg(targets), stop, lines)


def _beside_peers(
    places_deg: list[tuple[float, float]], stop: datetime, lines: tuple[str, str]
) -> None:
    body = _body(places_deg, stop, lines)
    request = read_opportunity_request(body)
    ours, took_s = _best(lambda: _by_target(WindowSearch(request).find(), len(places_deg)))
    _, told_s = _best(lambda: _told(request))
    _, page_s = _best(lambda: _answer(body, WindowsAsked(limit=100, include=frozenset({VIEW}))))
    every = WindowsAsked(limit=1_000_000, include=frozenset({VIEW}))
    text, all_s = _best(lambda: _answer(body, every))
    of_slow, slow_s = _best(lambda: WindowSearch(_of_slow_axes(request)).find())
    held_s = (of_slow.held_to_s - of_slow.held_from_s) / (of_slow.set_s - of_slow.rise_s)
    of_body, body_s = _best(lambda: WindowSearch(_of_body(request)).find())
    print(
        f"{len(places_deg)} targets: {_count(ours)} windows, {len(text) / 1e6:.1f} MB of JSON; "
        f"{len(of_body)} windows of a body; slow axes hold {np.nanmedian(held_s):.2f} of a window"
    )
    own = {
        "windows and sessions": took_s,
        "with all that is told": told_s,
        "request, JSON of 100": page_s,
        "request, JSON of all": all_s,
        "every session searched": slow_s,
        "a body's": body_s,
    }
    for name, one_s in own.items():
        print(f"  {name:26s} {one_s:8.3f} s")
    for name, finder in (
        ("Skyfield find_events", _skyfield),
        ("brahe, 60 s steps", partial(_brahe, 60.0)),
        ("brahe, 10 s steps", partial(_brahe, 10.0)),
    ):
        theirs, theirs_s = _timed(partial(finder, places_deg, stop, lines))
        ratios = ", ".join(f"{theirs_s / own_s:.1f}" for own_s in own.values())
        print(f"  {name:26s} {theirs_s:8.3f} s = {ratios} x; {_compared(ours, theirs)}")


def _of_body(request: OpportunityRequest) -> OpportunityRequest:
    return replace(request, platform=BODIES["smallsat-120kg"], attitude=None)


def _of_slow_axes(request: OpportunityRequest) -> OpportunityRequest:
    """With rates below all that passes ask for, so that no window is known to be held as it is."""
    platform = request.platform
    assert isinstance(platform, TwoAxisPlatform)
    slow = tuple(
        replace(axis, rate_max_rad_s=SLOW_RAD_S, rate_min_rad_s=0.0)
        for axis in platform.axis_limits
    )
    return replace(request, platform=platform.with_limits(slow))


def _told(request: OpportunityRequest) -> WindowEdges:
    search = WindowSearch(request)
    return search.tell(search.find())


def _answer(body: bytes, asked: WindowsAsked) -> bytes:
    """As the service makes it, from the request's bytes to the answer's."""
    request = read_opportunity_request(body)
    found, page = find_windows(request, provenance(START, body), asked)
    return search_json("id", found.head, page)


def _places_deg(count: int) -> list[tuple[float, float]]:
    """Latitude and longitude: the OCO-3 targets, then even over the belt the ISS can see."""
    listed = json.loads((ROOT / "tests" / "data" / "oco3_targets.json").read_text())["targets"]
    real = [(latitude, longitude) for _, _, latitude, longitude in listed]
    rng = np.random.default_rng(20150227)
    spread = max(count - len(real), 0)
    latitudes = np.rad2deg(np.arcsin(rng.uniform(-0.85, 0.85, spread)))
    seeded = zip(latitudes.tolist(), rng.uniform(-180.0, 180.0, spread).tolist(), strict=True)
    return [*real, *seeded][:count]


def _body(places_deg: list[tuple[float, float]], stop: datetime, lines: tuple[str, str]) -> bytes:
    targets = [
        {
            "id": str(number),
            "target": {"mode": "ground", "latitude_deg": latitude, "longitude_deg": longitude},
        }
        for number, (latitude, longitude) in enumerate(places_deg)
    ]
    asked = {
        "platform": "iss-hrc",
        "orbit": {"source": "tle", "line1": lines[0], "line2": lines[1]},
        "targets": targets,
        "start": START.isoformat(),
        "stop": stop.isoformat(),
        "conditions": {"min_elevation_deg": MIN_ELEVATION_DEG},
    }
    return json.dumps(asked).encode()


def _by_target(found: WindowEdges, count: int) -> Windows:
    edges_s = np.stack([found.rise_s, found.set_s], axis=1)
    return [edges_s[found.target == number] for number in range(count)]


def _skyfield(
    places_deg: list[tuple[float, float]], stop: datetime, lines: tuple[str, str]
) -> Windows:
    load = Loader(str(files("skyfield_data") / "data"))
    timescale = load.timescale(builtin=False)
    with load.open("finals2000A.all") as finals:
        iers.install_polar_motion_table(timescale, iers.parse_x_y_dut1_from_finals_all(finals))
    satellite = EarthSatellite(*lines, ts=timescale)
    start, end = timescale.from_datetime(START), timescale.from_datetime(stop)
    windows = []
    for latitude, longitude in places_deg:
        times, events = satellite.find_events(
            wgs84.latlon(latitude, longitude), start, end, altitude_degrees=MIN_ELEVATION_DEG
        )
        # two-part dates: one float resolves 40 us only
        t_s = ((times.whole - start.whole) + (times.tt_fraction - start.tt_fraction)) * 86400.0
        rises, sets = t_s[events == 0], t_s[events == 2]
        if len(sets) and (not len(rises) or sets[0] < rises[0]):
            rises = np.append(0.0, rises)
        if len(rises) > len(sets):
            sets = np.append(sets, (end - start) * 86400.0)
        windows.append(np.stack([rises, sets], axis=1))
    return windows


def _brahe(
    step_s: float, places_deg: list[tuple[float, float]], stop: datetime, lines: tuple[str, str]
) -> Windows:
    brahe.set_num_threads(1)
    brahe.set_global_eop_provider(
        brahe.FileEOPProvider.from_standard_file(str(FINALS), True, "Hold")
    )
    start = brahe.Epoch.from_datetime(START.year, START.month, START.day, 0, 0, 0.0, 0.0, brahe.UTC)
    accesses = brahe.location_accesses(
        [
            brahe.PointLocation(longitude, latitude, 0.0).with_id(number)
            for number, (latitude, longitude) in enumerate(places_deg)
        ],
        brahe.SGPPropagator.from_tle(*lines, 60.0),
        start,
        start + (stop - START).total_seconds(),
        brahe.ElevationConstraint(MIN_ELEVATION_DEG),
        config=brahe.AccessSearchConfig(initial_time_step=step_s, time_tolerance=0.001),
    )
    windows: list[list[tuple[float, float]]] = [[] for _ in places_deg]
    for access in accesses:
        windows[access.location_id].append((access.start - start, access.end - start))
    return [np.array(sorted(edges)).reshape(-1, 2) for edges in windows]


def _compared(ours: Windows, theirs: Windows) -> str:
    """Windows of one without an overlapping one of the other, and how far the edges differ."""
    missed_s, extra, off_s = [], 0, []
    for one, other in zip(ours, theirs, strict=True):
        overlap = (one[:, None, 0] < other[None, :, 1]) & (other[None, :, 0] < one[:, None, 1])
        alone = ~overlap.any(axis=1)
        missed_s += (one[alone, 1] - one[alone, 0]).tolist()
        extra += int(np.count_nonzero(~overlap.any(axis=0)))
        mine, its = np.nonzero(overlap)
        off_s.append(np.abs(one[mine] - other[its]).ravel())
    all_off_ms = 1e3 * np.concatenate(off_s)
    longest = f" (up to {max(missed_s):.0f} s long)" if missed_s else ""
    return (
        f"{_count(theirs)} windows, lacks {len(missed_s)}{longest}, has {extra} more; edges "
        f"differ by {np.median(all_off_ms):.3f} ms (median), {all_off_ms.max():.1f} ms (most)"
    )


def _timed(work: Callable[[], T]) -> tuple[T, float]:
    began = time.process_time()
    made = work()
    return made, time.process_time() - began


def _best(work: Callable[[], T]) -> tuple[T, float]:
    """Of four: in the first of a process kernels are loaded."""
    return min((_timed(work) for _ in range(4)), key=lambda timed: timed[1])


def _count(windows: Windows) -> int:
    return sum(len(edges) for edges in windows)


if __name__ == "__main__":
    main()
