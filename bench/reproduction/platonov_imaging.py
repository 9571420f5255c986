"""Imaging from a CMG spacecraft: Platonov, Sumarokov 2019, Figs. 3 to 9."""

import dataclasses
import math
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np
from imaging_cases import area, line, session_request, sun_synchronous
from matplotlib.figure import Figure
from spacecraft_flight import PAPER_TURNS_S

from planner.spacecraft.flight.closed_loop import Log
from planner.spacecraft.flight.stabilisation import rate_errors
from planner.spacecraft.imaging.candidates import candidates
from planner.spacecraft.imaging.session import make_session
from planner.spacecraft.plan import ImagingPlan, plan_imaging
from planner.spacecraft.requests import GeoLineString, ImagingPlanRequest, StripRequest
from planner.spacecraft.table import TICK_S
from planner.spacecraft.vehicle.definition import AGILE_CMG
from reproduction.platonov_own_turns import STRIP_S
from reproduction.platonov_sessions import AREAS_KM, LONG_START_S, flown, planned
from reproduction.statements import Numbers

LIMIT_DEG_S = 1e-3
ASIDE_KM = 670.0
STRIPS = "strip_and_stereo"
AREAS = "eight_areas"
Span = tuple[str, float, float]  # name and the paper's interval on its clock, s
SHOWN: dict[str, tuple[Span, ...]] = {
    STRIPS: (
        ("Fig. 4: strip", 128.0, 144.0),
        ("Fig. 6: stereo pair, first look", 338.0, 354.0),
        ("Fig. 6: stereo pair, second look", 448.0, 464.0),
    ),
    AREAS: (
        ("Fig. 8: second area, first strip", 866.0, 881.0),
        ("Fig. 9: fifth area, third strip", 1405.0, 1419.0),
    ),
}
CLOCK_S = {STRIPS: 0.0, AREAS: LONG_START_S}  # the paper's at row 0


def angles_between_strips_deg(height_km: float, scan_s: float) -> list[float]:
    """Of the three turns of the paper's second area, its strips scanned so fast."""
    commands_s = [t - PAPER_TURNS_S[4] for t in PAPER_TURNS_S[4:9]]
    starts_s = [round(5.0 * (t - scan_s)) / 5.0 for t in commands_s[1:]]
    orbit = sun_synchronous(height_km)
    middle_s = 0.5 * (starts_s[0] + starts_s[-1] + scan_s)
    request = area(orbit, middle_s, "area", across_km=60.0)
    session = make_session(session_request(orbit, commands_s[-1] + 60.0, (request,)))
    ends = []
    for strip, start_s in zip(candidates(request, 0, session)[0].arcs, starts_s, strict=True):
        arc = dataclasses.replace(strip, start_s=start_s)
        t_s = np.array([start_s, start_s + arc.duration_s])
        turned, _ = session.profile(arc, start_s - 1.0, t_s[1] + 1.0).attitude_at(t_s)
        ends.append(turned)
    # Both ends lie in inertial axes: what the Earth and the orbit turn meanwhile is in it.
    return [
        float(np.rad2deg((after[0] * before[1].inv()).magnitude()))
        for before, after in pairwise(ends)
    ]


def _pitch_share(plan: ImagingPlan, first_row: int, last_row: int) -> float:
    turned = np.abs(plan.table.omega_body_rad_s[first_row:last_row].sum(axis=0))
    return float(turned[2] / np.linalg.norm(turned))


def _along_deg(height_km: float) -> float:
    """How far ahead or behind an area's ends are seen at the paper's moments, flat ground."""
    orbit = sun_synchronous(height_km)
    speed_m_s = 1e3 * math.hypot(*orbit.velocity_km_s)
    ground_m_s = speed_m_s * 6378.137 / (6378.137 + height_km)
    # From the middle of the area's time to the last strip's end, which lies 30 km beyond.
    half_s = 0.5 * (PAPER_TURNS_S[4] - PAPER_TURNS_S[1] + 14.0)
    return math.degrees(math.atan2(ground_m_s * half_s - 30e3, 1e3 * height_km))


def numbers() -> Numbers:
    return {**_simulation(), **_turns(), **_session()}


def _simulation() -> Numbers:
    array, modes = AGILE_CMG.array, [mode.frequency_hz for mode in AGILE_CMG.modes]
    return {
        "control cycle": TICK_S,
        "rate_max_deg_s": math.degrees(array.rate_max_rad_s),
        "rate_step_deg_s": math.degrees(array.rate_step_rad_s),
        "error_percent": 100 * array.rate_error_share,
        "error_deg_s": math.degrees(array.rate_error_rad_s),
        "slowest_hz": min(modes),
        "fastest_hz": max(modes),
    }


def worst_deg_s(log: Log, first_row: int, last_row: int) -> float:
    """Largest rate error of any axis between two rows."""
    return float(np.rad2deg(np.abs(rate_errors(log, first_row, last_row)).max()))


def fed_forward_deg_s(name: str, span: Span) -> float:
    """Worst rate error in an interval of the paper, of all runs of the planner's table."""
    rows = [round((t - CLOCK_S[name]) * 5.0) for t in span[1:]]
    return max(worst_deg_s(log, *rows) for log in flown(name))


def _turns() -> Numbers:
    long = planned(AREAS)
    between = [slew for slew in long.slews if slew.window is not None and slew.window % 4 != 0]
    angles = [math.degrees(turn.comparison.angle_rad) for turn in between]
    as_told = angles_between_strips_deg(600.0, STRIP_S)
    pitch = [_pitch_share(long, turn.first_row, turn.last_row) for turn in between]
    return {
        "angle between strips": float(np.mean(angles)),
        "mostly in pitch": 100.0 * float(np.median(pitch)),
        "least_deg": min(angles),
        "most_deg": max(angles),
        "eigenaxis_s": float(np.median([turn.comparison.eigenaxis_s for turn in between])),
        "at_600_km_deg": float(np.mean(as_told)),
    }


def _session() -> Numbers:
    plan, logs = planned(AREAS), flown(AREAS)
    windows = plan.table.windows
    worst = [worst_deg_s(log, w.first_row, w.last_row) for log in logs for w in windows]
    aside = plan_imaging(far_aside())
    scans_s = np.diff(PAPER_TURNS_S[1:])[::4]
    return {
        "eight areas": (windows[-1].last_row - windows[0].first_row) / 300.0,
        "time of a strip": (windows[1].last_row - windows[1].first_row) / 5.0,
        "angle along the track": max(w.along_deg for w in plan.verification.windows),
        "angle across the track": max(abs(w.across_deg) for w in aside.verification.windows),
        "strips": len(windows),
        "steady_percent": 100.0 * float(np.mean(np.array(worst) <= LIMIT_DEG_S)),
        "intervals": len(worst),
        "worst_deg_s": max(worst),
        "scan_least_s": float(scans_s.min()),
        "scan_most_s": float(scans_s.max()),
        "along_640_deg": _along_deg(AREAS_KM),
        "along_600_deg": _along_deg(600.0),
        "aside_deg_s": math.degrees(aside.stabilisation.worst_rad_s),
        "aside_runs": aside.request.simulation_runs,
    }


def far_aside() -> ImagingPlanRequest:
    """Two strips of 60 km as far to either side of the track as the camera may look."""
    orbit = sun_synchronous(AREAS_KM)
    strips = tuple(
        StripRequest(
            name=f"strip {k + 1}",
            geometry=GeoLineString(coordinates=line(orbit, at_s, 30.0, side * ASIDE_KM)),
        )
        for k, (at_s, side) in enumerate(((120.0, 1.0), (260.0, -1.0)))
    )
    return session_request(orbit, 400.0, strips, simulation_runs=8)


def pictures(folder: Path) -> None:
    for name in (STRIPS, AREAS):
        figure = draw(planned(name), flown(name)[0], SHOWN[name], CLOCK_S[name])
        figure.savefig(folder / f"reproduction_spacecraft_{name}.png", dpi=90)


def draw(plan: ImagingPlan, log: Log, spans: Sequence[Span], clock_s: float) -> Figure:
    """Rates of the table, whole, and rate errors of a run in each span of the paper's clock."""
    t_s = np.arange(len(log.rate_error_rad_s) * log.rate_error_rad_s.shape[1]) * 0.005 + clock_s
    error_deg_s = np.rad2deg(log.rate_error_rad_s.reshape(-1, 3))
    rate_deg_s = np.rad2deg(plan.table.omega_body_rad_s)
    figure = Figure(figsize=(9.0, 2.2 * (1 + len(spans))), layout="constrained")
    top, *details = figure.subplots(1 + len(spans), 1)
    for k, axis in enumerate("XYZ"):
        top.plot(plan.table.t_s + clock_s, rate_deg_s[:, k], label=axis, lw=1.0)
    top.set_ylabel("body rate, deg/s")
    for window in plan.table.windows:
        top.axvspan(window.first_row / 5 + clock_s, window.last_row / 5 + clock_s, alpha=0.15)
    top.legend(loc="upper right", ncols=3)
    for panel, (name, start_s, stop_s) in zip(details, spans, strict=True):
        inside = (t_s >= start_s - 6.0) & (t_s <= stop_s)
        for k in range(3):
            panel.plot(t_s[inside], error_deg_s[inside, k], color=f"C{k}", lw=0.8)
        panel.axvspan(start_s, stop_s, alpha=0.15)
        for limit in (-LIMIT_DEG_S, LIMIT_DEG_S):
            panel.axhline(limit, color="0.4", lw=0.8, ls="--")
        panel.set_ylim(-2.5e-3, 2.5e-3)
        panel.set_ylabel("rate error, deg/s")
        panel.set_title(name, fontsize="medium")
    details[-1].set_xlabel("time on the paper's clock, s")
    return figure
