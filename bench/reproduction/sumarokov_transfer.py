"""The transfer onto the track: Sumarokov 2016, eqs. 12 to 14 and the filter."""

import math
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from planner.motion.baseline import compare_with_spline
from planner.motion.baseline.paper_cubic import (
    OPTIONS as PAPER_SPLINE_OPTIONS,
)
from planner.motion.baseline.paper_cubic import (
    cubic_profile,
    filter_lag_s,
    paper_duration_s,
    paper_slew,
)
from planner.motion.slew.optimal import optimal_slew
from planner.motion.slew.problem import AxisState, SlewProblem
from planner.world.platforms import ISS_HRC
from planner.world.scenario import SlewOptions
from reproduction.statements import Numbers

LIMITS = ISS_HRC.outer_limits
UNFILTERED, SLOW = SlewOptions(filter_cutoff_hz=None), SlewOptions(filter_cutoff_hz=0.2)
PRINTED_LAG_S = 0.8
DRAWS, REACH_DEG, TRACK_DEG_S = 300, 170.0, 1.0


def deg_state(angle: float, rate: float = 0.0) -> AxisState:
    return AxisState(angle_rad=math.radians(angle), rate_rad_s=math.radians(rate))


def in_paper_time(start: tuple[AxisState, ...], end: tuple[AxisState, ...]) -> SlewProblem:
    """The slew of all axes in the time of eq. 12."""
    problem = SlewProblem(
        axis_names=ISS_HRC.axis_names,
        limits=ISS_HRC.axis_limits,
        start=start,
        end=end,
        duration_s=1e3,
    )
    return replace(problem, duration_s=paper_duration_s(problem))


class Drawn(NamedTuple):
    """Of slews drawn at random, (DRAWS,) each."""

    time_share: NDArray  # of the least
    breaks_any: NDArray
    breaks_published: NDArray  # limits but for jerk
    left_arcsec: NDArray  # at the join, the lag compensated
    left_uncompensated_arcsec: NDArray


@cache
def drawn_slews() -> Drawn:
    rng = np.random.default_rng(12)
    rows = []
    for _ in range(DRAWS):
        start = tuple(deg_state(rng.uniform(-REACH_DEG, REACH_DEG)) for _ in "ab")
        end = tuple(
            deg_state(rng.uniform(-REACH_DEG, REACH_DEG), rng.uniform(-TRACK_DEG_S, TRACK_DEG_S))
            for _ in "ab"
        )
        problem = in_paper_time(start, end)
        filtered = paper_slew(problem, SlewOptions())
        behind = paper_slew(problem, SlewOptions(filter_lag_compensation=False))
        broken = {violation.limit for violation in filtered.violations}
        least_s = compare_with_spline(filtered, SlewOptions()).least_duration_s
        rows.append(
            (
                problem.duration_s / least_s,
                bool(broken),
                bool(broken - {"jerk"}),
                *(np.rad2deg(np.abs(s.end_error_rad).max()) * 3600.0 for s in (filtered, behind)),
            )
        )
    return Drawn(*np.array(rows).T)


@cache
def example() -> SlewProblem:
    """From rest over 60 deg onto a track of 0.8 deg/s; beta goes a little way."""
    return in_paper_time((deg_state(10.0), deg_state(0.0)), (deg_state(70.0, 0.8), deg_state(8.0)))


def high_passed_deg(lag_s: float) -> float:
    """The most that a first-order high-pass lets through of the example's alpha.

    What the low-pass leaves: input less output.
    """
    problem = example()
    t_s = np.linspace(0.0, problem.duration_s, 2001)
    behind = SlewOptions(filter_cutoff_hz=0.5 / math.pi / lag_s, filter_lag_compensation=False)
    low = paper_slew(problem, behind).profiles[0].evaluate(t_s)[0]
    whole = paper_slew(problem, UNFILTERED).profiles[0].evaluate(t_s)[0]
    return float(np.rad2deg(np.abs(whole - low).max()))


def numbers() -> Numbers:
    drawn = drawn_slews()
    start, end, duration_s = deg_state(10.0, 0.5), deg_state(70.0, 0.8), 34.0
    cubic = cubic_profile(start, end, duration_s)
    left = cubic.end_values[1, :2] - [end.angle_rad, end.rate_rad_s]
    transfer = cubic_profile(start, end, 120.0)  # Fig. 2's first, until 1320 s
    lag_s = filter_lag_s(SlewOptions(filter_cutoff_hz=2.0))
    unfiltered, filtered = (
        math.degrees(paper_slew(example(), options).profiles[0].end_values[0, 2])
        for options in (UNFILTERED, SlewOptions())
    )
    return {
        "effective rate": PAPER_SPLINE_OPTIONS.rate_share * math.degrees(LIMITS.rate_max_rad_s),
        "effective acceleration": PAPER_SPLINE_OPTIONS.acceleration_share
        * math.degrees(LIMITS.acceleration_max_rad_s2),
        "time": float(np.median(drawn.time_share)),
        "limits broken": 100.0 * float(np.mean(drawn.breaks_any)),
        "coefficients": float(np.rad2deg(np.abs(left).max())) * 3600.0,
        "clock": math.degrees(float(transfer.end_values[1, 0])),
        "lag": lag_s,
        "high-pass": high_passed_deg(lag_s),
        "continuous acceleration": filtered,
        "lag compensated": float(np.median(drawn.left_arcsec)),
        "least": float(drawn.time_share.min()),
        "most": float(drawn.time_share.max()),
        "break_published": 100.0 * float(np.mean(drawn.breaks_published)),
        "misread_deg": math.degrees(start.rate_rad_s * (duration_s - 1.0)),
        "cutoff_hz": 0.5 / math.pi / PRINTED_LAG_S,
        "unfiltered": unfiltered,
        "uncompensated_arcsec": float(np.median(drawn.left_uncompensated_arcsec)),
    }


def pictures(folder: Path) -> None:
    problem = example()
    t_s = np.linspace(0.0, problem.duration_s, 1500)
    figure = Figure(figsize=(7.2, 5.4), layout="constrained")
    top, middle, bottom = figure.subplots(3, 1, height_ratios=(1.0, 1.3, 1.0))
    for label, slew, style in (
        ("cubic", paper_slew(problem, UNFILTERED), "C1:"),
        ("through 2 Hz (0.08 s)", paper_slew(problem, SlewOptions()), "C1-"),
        ("through 0.2 Hz (0.8 s)", paper_slew(problem, SLOW), "C3--"),
        ("ours", optimal_slew(problem), "C0-"),
    ):
        angle, _, acceleration, _ = np.rad2deg(slew.profiles[0].evaluate(t_s))
        top.plot(t_s, angle, style, lw=1.2)
        middle.plot(t_s, acceleration, style, lw=1.2, label=label)
    top.set_ylabel("alpha, deg")
    middle.set(ylabel="acceleration, deg/s²", xlabel="time, s")
    middle.legend(fontsize=8, ncols=2)
    bottom.hist(drawn_slews().time_share, bins=40, color="0.6")
    bottom.axvline(float(np.median(drawn_slews().time_share)), color="C3", lw=1.2)
    bottom.set(xlabel="time of eq. 12 over the least time", ylabel=f"of {DRAWS} slews")
    figure.savefig(folder / "reproduction_transfer.png", dpi=100)
