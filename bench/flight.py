"""How long does a flight take, beside SciPy's integrators on the same equations?

Ours: compiled, CPU time of 92 s flights, the best of several.  Theirs: `solve_ivp` with LSODA and
Radau from one control step to the next (tests/oracles/flight_reference.py), rtol 1e-6, CPU time of
a shorter flight scaled to as long; what is compared is that shorter flight.

    python bench/flight.py [--seconds 4]
"""

import argparse
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

sys.path.extend(
    str(Path(__file__).parents[1] / "tests" / folder) for folder in ("oracles", "properties")
)
from flight_cases import ARCSEC, ROCKING, rough, steady, swinging
from flight_reference import Reference

from planner.commands import CommandTable
from planner.platforms import ISS_HRC, AxisDrive, CarrierMode, TwoAxisPlatform
from planner.simulation.flight import fly

FLIGHT_S = 92.0
_MODES = tuple(
    CarrierMode(axis_platform=axis, frequency_hz=frequency_hz, inertia_kg_m2=1e5)
    for axis, frequency_hz in (((1.0, 0.0, 0.0), 0.15), ((0.0, 1.0, 0.0), 0.7))
)
CASES: dict[str, tuple[TwoAxisPlatform, Callable[[float], CommandTable]]] = {
    "swinging": (ISS_HRC, lambda seconds: swinging(seconds)),
    "sticking": (ISS_HRC, lambda seconds: steady(30.0, -12.0, duration_s=seconds)),
    "two modes": (
        replace(ISS_HRC, structural_modes=_MODES),
        lambda seconds: swinging(seconds),
    ),
    "four light modes": (ROCKING, lambda seconds: swinging(seconds)),
}


def cpu_s(work: Callable[[], object], times: int) -> float:
    best = np.inf
    for _ in range(times):
        start = time.process_time()
        work()
        best = min(best, time.process_time() - start)
    return best


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=4.0)
    seconds = parser.parse_args().seconds
    print(f"CPU seconds for a flight of {FLIGHT_S:g} s; apart: largest difference in arcsec")
    for name, (platform, table) in CASES.items():
        drives: tuple[AxisDrive, AxisDrive] = (rough(), rough())
        noisy = replace(platform, drives=(AxisDrive(), AxisDrive()))
        fly(table(1.0), platform, drives=drives)
        long = table(FLIGHT_S)
        ours_s = cpu_s(lambda long=long, noisy=noisy: fly(long, noisy), 5)
        ours = fly(table(seconds), platform, drives=drives)
        line = f"{name:17s} ours {ours_s:.4f}"
        for method in ("LSODA", "Radau"):
            start = time.process_time()
            theirs, _ = Reference(platform, drives).fly(
                table(seconds), len(ours.t_s), method=method, rtol=1e-6, atol=1e-8
            )
            theirs_s = (time.process_time() - start) * FLIGHT_S / seconds
            apart = np.abs(theirs - ours.angle_rad).max() / ARCSEC
            line += f"  {method} {theirs_s:.0f} ({theirs_s / ours_s:.0f}x, apart {apart:.3f})"
        print(line, flush=True)


if __name__ == "__main__":
    main()
