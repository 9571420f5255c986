"""Las Vegas flown, with friction and without: Sumarokov 2016, Fig. 3."""

import json
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray
from scipy.signal import find_peaks

from planner.base.commands import COMMAND_STEP_S
from planner.inflight.simulation.flight import fly
from planner.planning.sessions.plan import Plan
from planner.world.frames.time_scales import elapsed_s
from reproduction.example_plans import EXAMPLES, LAS_VEGAS
from reproduction.statements import Numbers
from slewtrack import plan, read_request

TORQUE_EQUILIBRIUM = {"law": "lvlh", "yaw_deg": -4.1, "pitch_deg": -2.0, "roll_deg": 0.7}
LOOP_HZ = 0.25  # with more the axis sticks, but hardly oscillates
FAST_ARCMIN_S = 1.5  # well above the drives' least rate
SWING_ARCSEC = 2.0  # less is the sensors' noise
NO_FRICTION = {"coulomb_deg_s2": 0.0, "breakaway_deg_s2": 0.0, "viscous_per_s": 0.0}
NO_CABLE = {"cable_tension_deg_s2": 0.0, "cable_stiffness_per_s2": 0.0}
ARCSEC = np.degrees(1.0) * 3600.0


class Flown(NamedTuple):
    """At the table's rows in the session, (n,) and (n, 2)."""

    t_s: NDArray  # since the session's start
    angle_rad: NDArray
    commanded_rad: NDArray
    commanded_rate_arcmin_s: NDArray
    error_arcsec: NDArray


class Swings(NamedTuple):
    """Of beta's error while it is commanded below its least rate, after it stuck the longest."""

    largest_arcsec: float
    amplitude_arcsec: float  # median half way from one turning point to the next
    frequency_hz: float
    count: int


@cache
def the_plan() -> Plan:
    request = json.loads((EXAMPLES / LAS_VEGAS).read_text(encoding="utf-8"))
    return plan(read_request({**request, "attitude": TORQUE_EQUILIBRIUM}))


@cache
def flight(friction: bool = True, cable: bool = True, loop_hz: float = LOOP_HZ) -> Flown:
    told = the_plan()
    platform = told.scenario.platform
    off = {**({} if friction else NO_FRICTION), **({} if cable else NO_CABLE)}
    alpha, beta = (replace(one, bandwidth_hz=loop_hz, **off) for one in platform.drives)
    motion = fly(told.table, platform, drives=(alpha, beta), output_step_s=COMMAND_STEP_S)
    session = told.scenario.sessions[0]
    start_s, stop_s = (elapsed_s(at, told.table.epoch_utc) for at in (session.start, session.stop))
    inside = (motion.t_s >= start_s - 1e-6) & (motion.t_s <= stop_s + 1e-6)
    commanded_rad = told.table.angle_rad[inside]
    return Flown(
        t_s=motion.t_s[inside] - start_s,
        angle_rad=motion.angle_rad[inside],
        commanded_rad=commanded_rad,
        commanded_rate_arcmin_s=np.degrees(told.table.rate_rad_s[inside]) * 60.0,
        error_arcsec=(motion.angle_rad[inside] - commanded_rad) * ARCSEC,
    )


def slow(flown: Flown) -> NDArray:
    """The rows at which beta is commanded below the drives' least rate."""
    return np.abs(flown.commanded_rate_arcmin_s[:, 1]) < 1.0


def swings(flown: Flown) -> Swings:
    error_arcsec = flown.error_arcsec[slow(flown), 1]
    t_s = flown.t_s[slow(flown)]
    worst = int(np.abs(error_arcsec).argmax())
    largest = float(np.abs(error_arcsec[worst]))
    tops, bottoms = (
        worst + find_peaks(sign * error_arcsec[worst:], prominence=SWING_ARCSEC)[0]
        for sign in (1.0, -1.0)
    )
    turns = np.sort(np.concatenate([tops, bottoms]))
    if len(tops) < 2:
        return Swings(largest, 0.5 * float(np.ptp(error_arcsec)), 0.0, len(tops))
    half = 0.5 * float(np.median(np.abs(np.diff(error_arcsec[turns]))))
    period_s = float(np.median(np.diff(t_s[tops])))
    return Swings(largest, half, 1.0 / period_s, len(tops))


def numbers() -> Numbers:
    flown = flight()
    found = swings(flown)
    fast = np.abs(flown.commanded_rate_arcmin_s[:, 1]) > FAST_ARCMIN_S
    return {
        "flown alpha": float(np.abs(flown.error_arcsec[:, 0]).max()),
        "flown beta, amplitude": found.amplitude_arcsec,
        "flown beta, frequency": found.frequency_hz,
        "flown beta, faster": float(np.abs(flown.error_arcsec[fast, 1]).max()),
        "flown beta, no friction": swings(flight(friction=False, cable=False)).amplitude_arcsec,
        "flown beta, no cables": swings(flight(cable=False)).amplitude_arcsec,
        "turned_deg": float(np.degrees(np.ptp(flown.commanded_rad[:, 0]))),
        "slow_s": float(slow(flown).sum()) * COMMAND_STEP_S,
        "largest_arcsec": found.largest_arcsec,
        "count": found.count,
        "only_cable_arcsec": swings(flight(friction=False)).amplitude_arcsec,
    }


def pictures(folder: Path) -> None:
    flown, free = flight(), flight(friction=False, cable=False)
    figure = Figure(figsize=(8.4, 7.0), layout="constrained")
    panels = figure.subplots(3, 1, sharex=True)
    for k, name in enumerate(("alpha", "beta")):
        panels[k].plot(flown.t_s, np.degrees(flown.commanded_rad[:, k]), "C3", label="commanded")
        panels[k].plot(flown.t_s, np.degrees(flown.angle_rad[:, k]), "C0", lw=1.0, label="flown")
        panels[k].set_ylabel(f"{name}, deg")
    panels[2].plot(flown.t_s, flown.error_arcsec[:, 1], "C0", label="with friction and cables")
    panels[2].plot(free.t_s, free.error_arcsec[:, 1], "C2", label="without")
    panels[2].set_ylabel("beta off, arcsec")
    for panel in panels:
        panel.fill_between(flown.t_s, 0.0, 1.0, where=slow(flown), color="#f3e9c6", zorder=0,
                           transform=panel.get_xaxis_transform())  # fmt: skip
        panel.grid(alpha=0.3)
        panel.legend(loc="lower right")
    panels[2].set_xlabel("seconds since the session began")
    figure.savefig(folder / "reproduction_las_vegas.png", dpi=100)
