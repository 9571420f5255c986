"""The prediction of the orbit: Sumarokov 2016, eqs. 3 to 7."""

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Literal
from unittest.mock import patch

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from planner.world.frames.earth_orientation import OMEGA_EARTH_RAD_S
from planner.world.frames.geodesy import MU_EARTH_M3_S2
from planner.world.frames.time_scales import Instants, shifted_utc
from planner.world.messages.oem import OemSegment
from planner.world.orbits import OemOrbit, StateVectorOrbit, paper_model
from planner.world.orbits.gravity import RADIUS_M
from reproduction.statements import Numbers

EPHEMERIDES = Path(__file__).parents[2] / "tests/data"
FULL_HARMONICS = files("planner.world.orbits") / "data" / "eigen6s_n36.csv"
PRINTED_P2_KM4 = 2.5023e9
BURN_STEP_S = 60.0  # NASA's nodes crowd where an engine burns
DIFFERENCE_M = 50.0
STARTS = 8  # of each ephemeris
ISS: paper_model.State = (545284.0, 4217457.4, 5288809.9, -7328.9, 208.6, 656.3)  # m, m/s

Model = Literal["full", "j2j4"]


@cache
def misses_m(model: Model, ahead_s: float) -> NDArray:
    """Distances from NASA's ephemerides of the ISS, (k,)."""
    found = []
    for file in sorted(EPHEMERIDES.glob("iss_oem_*_excerpt.xml")):
        orbit = OemOrbit(content=file.read_text(encoding="utf-8"))
        for segment in orbit.message.segments:
            starts = _starts_s(segment.t_s, ahead_s)
            chosen = starts[:: max(1, len(starts) // STARTS)]
            found += [_miss_m(orbit, segment, float(t), model, ahead_s) for t in chosen]
    return np.array(found)


def _miss_m(
    orbit: OemOrbit, segment: OemSegment, t_s: float, model: Model, ahead_s: float
) -> float:
    """Between a state propagated from a node and the ephemeris."""
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
    predicted = state.ephemeris(start_utc, stop_utc).states(ends)
    return float(np.linalg.norm(predicted.r_sat_eci_m[1] - truth.r_sat_eci_m[1]))


def _starts_s(node_s: NDArray, ahead_s: float) -> NDArray:
    """Nodes, not the segment's first and last, from which no burn lies ahead."""
    burn_s = node_s[:-1][np.diff(node_s) < BURN_STEP_S]
    until_s = node_s + ahead_s
    burning = (burn_s >= node_s[:, None]) & (burn_s <= until_s[:, None])
    return node_s[1:][((until_s <= node_s[-2]) & ~burning.any(axis=1))[1:]]


def rms(values: NDArray) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def zonal(degree: int) -> float:
    """J of the packaged field, from its normalised coefficient."""
    rows = (line.split(",") for line in FULL_HARMONICS.read_text("ascii").splitlines())
    [c] = [float(row[2]) for row in rows if row[:2] == [str(degree), "0"]]
    return -c * float(np.sqrt(2 * degree + 1))


@contextmanager
def printed_p2() -> Iterator[None]:
    """The product's prediction with the paper's p2."""
    with patch.object(paper_model, "_P2", PRINTED_P2_KM4 * 1e12):
        paper_model._cached_steps.cache_clear()
        yield
    paper_model._cached_steps.cache_clear()


def p2_moves_m(span_s: float) -> float:
    """How far apart the predictions with both values of p2 end."""
    ours = paper_model.predict(ISS, span_s)[1][-1, :3]
    with printed_p2():
        printed = paper_model.predict(ISS, span_s)[1][-1, :3]
    return float(np.linalg.norm(printed - ours))


def gradient_misses_m_s2() -> tuple[float, float]:
    """Of eq. 3, p2 ours and as printed, from the slope of the potential with J2 and J4, rms."""
    errors = []
    for latitude in np.radians([0.0, 15.0, 30.0, 51.6]):
        x_m, z_m = 6.785e6 * np.cos(latitude), 6.785e6 * np.sin(latitude)
        slope = [
            (_potential(x_m + dx, z_m + dz) - _potential(x_m - dx, z_m - dz)) / (2.0 * DIFFERENCE_M)
            for dx, dz in ((DIFFERENCE_M, 0.0), (0.0, DIFFERENCE_M))
        ]
        state = (float(x_m), 0.0, float(z_m), 0.0, 0.0, 0.0)
        ours = _acceleration(state)
        with printed_p2():
            printed = _acceleration(state)
        errors.append([np.linalg.norm(one - slope) for one in (ours, printed)])
    first, second = np.sqrt(np.mean(np.square(errors), axis=0)).tolist()
    return first, second


def _potential(x_m: float, z_m: float) -> float:
    r_m = np.hypot(x_m, z_m)
    sine = z_m / r_m
    p2 = 0.5 * (3.0 * sine**2 - 1.0)
    p4 = 0.125 * (35.0 * sine**4 - 30.0 * sine**2 + 3.0)
    flattened = zonal(2) * (RADIUS_M / r_m) ** 2 * p2 + zonal(4) * (RADIUS_M / r_m) ** 4 * p4
    return float(MU_EARTH_M3_S2 / r_m * (1.0 - flattened))


def _acceleration(state: paper_model.State) -> NDArray:
    """Along x and z, of a place in the plane of both."""
    derivative = paper_model._derivative(state)
    return np.array([derivative[3], derivative[5]])


def numbers() -> Numbers:
    p2_km4 = -0.625 * zonal(4) * RADIUS_M**4 / 1e12
    ours_m_s2, printed_m_s2 = gradient_misses_m_s2()
    _, states = paper_model.predict(ISS, paper_model.STEP_S)
    there = paper_model.predict(ISS, 900.0)[1][-1]
    back = paper_model.predict((*there.tolist(),), -900.0)[1][-1]
    found: Numbers = {
        "p0": MU_EARTH_M3_S2 / 1e9,
        "p1": -1.5 * zonal(2) * RADIUS_M**2 / 1e6,
        "p2": p2_km4,
        "field": ours_m_s2 * 1e6,
        "missing X_n": float(np.linalg.norm(states[-1, :3])) / 1e3,
        "step": 1e3 * float(np.linalg.norm(back[:3] - np.array(ISS[:3]))),
        "turn": float(OMEGA_EARTH_RAD_S * paper_model.STEP_S * np.linalg.norm(states[0, :2])),
        "p2's effect": p2_moves_m(900.0),
        "too_large": PRINTED_P2_KM4 / p2_km4 - 1.0,
        "printed_um_s2": printed_m_s2 * 1e6,
    }
    for ahead_s in (60.0, 900.0, 5400.0):
        misses = misses_m("j2j4", ahead_s)
        found |= {
            f"orbit, {ahead_s:.0f} s": rms(misses),
            f"count_{ahead_s:.0f}": len(misses),
            f"farthest_{ahead_s:.0f}_m": float(misses.max()),
            f"full_{ahead_s:.0f}_m": rms(misses_m("full", ahead_s)),
        }
    return found


def pictures(folder: Path) -> None:
    figure = Figure(figsize=(7.2, 3.6), layout="constrained")
    panel = figure.add_subplot()
    ahead_s = np.array([60.0, 180.0, 300.0, 600.0, 900.0, 1800.0, 5400.0])
    panel.plot(ahead_s, [rms(misses_m("j2j4", t)) for t in ahead_s], "o-", label="eqs. 3 to 7")
    panel.plot(ahead_s, [p2_moves_m(t) for t in ahead_s], "s:", label="of it by p2 as printed")
    full = [rms(misses_m("full", t)) for t in ahead_s]
    panel.plot(ahead_s, full, "^-", label="full model (ours)")
    panel.axhline(1.15, color="0.5", ls="--", lw=1.0)
    panel.text(60.0, 1.15, "a pixel", color="0.4", va="bottom", fontsize=9)
    panel.set(xscale="log", yscale="log", xlabel="seconds ahead", ylabel="position error, m rms")
    panel.set_xticks(ahead_s, [f"{t:.0f}" for t in ahead_s])
    panel.minorticks_off()
    panel.grid(alpha=0.3)
    panel.legend()
    figure.savefig(folder / "reproduction_orbit.png", dpi=100)
