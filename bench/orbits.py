"""How well and how fast are orbits propagated and messages read?  python bench/orbits.py OEM...

Each OEM (XML or KVN, .gz allowed) is read, interpolated and used as the truth for state
vectors propagated ahead from its nodes, away from burns.  CPU times are the process's, warm.
"""

import argparse
import gzip
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Literal, TypeVar

import numpy as np

from planner.frames.earth_orientation import c_itrf_from_eci
from planner.frames.time_scales import Instants, elapsed_s, shifted_utc
from planner.messages.oem import OemSegment
from planner.orbits import OemOrbit, StateVectorOrbit

T = TypeVar("T")

AHEAD_S = (60.0, 900.0, 5400.0)
STARTS = 100
ROWS = 4500  # a 900 s plan's command rows
BURN_STEP_S = 60.0  # NASA's nodes crowd where an engine burns


def main() -> None:
    """Print one line a file and horizon, then the times."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("oem", nargs="+", type=Path)
    paths = parser.parse_args().oem
    models: tuple[Literal["full", "j2j4"], ...] = ("full", "j2j4")
    misses: dict[tuple[str, float], list[float]] = {}
    cpu_s: dict[str, list[float]] = {}
    for path in paths:
        text = gzip.decompress(path.read_bytes()) if path.suffix == ".gz" else path.read_bytes()
        orbit = timed(cpu_s, "read", partial(OemOrbit, content=text.decode()))
        segment = orbit.message.segments[0]
        for model in models:
            for ahead_s in AHEAD_S:
                found = [
                    miss_m(orbit, segment, float(t_s), model, ahead_s, cpu_s)
                    for t_s in starts_s(segment, ahead_s)
                ]
                misses.setdefault((model, ahead_s), []).extend(found)
                print(f"{path.name:40} {model} {ahead_s:6.0f} s: {rms(found):9.3f} m rms")
        table(orbit, segment, cpu_s)
    print()
    for (name, ahead_s), found in misses.items():
        spread = f"{rms(found):9.3f} m rms, {max(found):9.3f} m worst of {len(found)}"
        print(f"{name} {ahead_s:6.0f} s: {spread}")
    print()
    for what, values in cpu_s.items():
        print(f"{what:32} {1e3 * np.median(values):8.2f} ms CPU, median of {len(values)}")


def starts_s(segment: OemSegment, ahead_s: float) -> list[float]:
    """Nodes spread over the file from which no burn lies ahead."""
    t_s = segment.t_s
    crowded_s = t_s[:-1][np.diff(t_s) < BURN_STEP_S]
    free = [
        float(t)
        for t in t_s[5:-5]
        if t + ahead_s <= t_s[-5] and not np.any((crowded_s >= t) & (crowded_s <= t + ahead_s))
    ]
    return free[:: max(1, len(free) // STARTS)]


def miss_m(
    orbit: OemOrbit,
    segment: OemSegment,
    t_s: float,
    model: Literal["full", "j2j4"],
    ahead_s: float,
    cpu_s: dict[str, list[float]],
) -> float:
    """Distance between the propagated and the published position."""
    start_utc = shifted_utc(segment.epoch_utc, t_s)
    stop_utc = shifted_utc(start_utc, ahead_s)
    ends = Instants(start_utc, np.array([0.0, ahead_s]))
    truth = orbit.ephemeris(start_utc, stop_utc).states(ends)
    state = StateVectorOrbit(
        frame="GCRF",
        epoch=start_utc,
        position_km=tuple((truth.r_sat_eci_m[0] / 1e3).tolist()),
        velocity_km_s=tuple((truth.v_sat_eci_m_s[0] / 1e3).tolist()),
        force_model=model,
    )
    label = f"propagate {model} {ahead_s:.0f} s"
    ephemeris = timed(cpu_s, label, partial(state.ephemeris, start_utc, stop_utc))
    return float(np.linalg.norm(ephemeris.states(ends).r_sat_eci_m[1] - truth.r_sat_eci_m[1]))


def table(orbit: OemOrbit, segment: OemSegment, cpu_s: dict[str, list[float]]) -> None:
    """Time what a plan of 900 s asks for."""
    start_utc = shifted_utc(segment.epoch_utc, float(segment.t_s[20]))
    stop_utc = shifted_utc(start_utc, 900.0)
    rows = Instants(start_utc, np.linspace(0.0, elapsed_s(stop_utc, start_utc), ROWS))
    for _ in range(5):
        ephemeris = timed(
            cpu_s, "prepare OEM for 900 s", partial(orbit.ephemeris, start_utc, stop_utc)
        )
        timed(cpu_s, f"{ROWS} OEM states", partial(ephemeris.states, rows))
        timed(cpu_s, f"{ROWS} ITRF matrices", partial(c_itrf_from_eci, rows))


def timed(cpu_s: dict[str, list[float]], label: str, job: Callable[[], T]) -> T:
    """Run the job and note its CPU time."""
    before_s = time.process_time()
    result = job()
    cpu_s.setdefault(label, []).append(time.process_time() - before_s)
    return result


def rms(values: list[float]) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(np.square(values))))


if __name__ == "__main__":
    main()
