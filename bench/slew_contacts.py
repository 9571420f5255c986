"""One slew against a stop and the rate limit: its contacts, its knots, its jerk and the costate.

    python bench/slew_contacts.py [PATH]    # docs/images/slew_contacts.png is made so

The costate is put together from the solver's multipliers alone, the three of the end chosen so
that it comes nearest to the jerk where this is within its limit; elsewhere it shows where the
jerk would go.
"""

import sys
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

sys.path.append(str(Path(__file__).parents[1] / "tests" / "properties"))
from slew_cases import LIMITS, deg_state

from planner.motion.slew import next_duration_s, verdict
from planner.motion.slew.normalised import normalise_slew
from planner.motion.slew.ocp import Begin, SpanProgramme, Vibration, solve
from planner.motion.slew.problem import AxisSlew
from planner.motion.slew.smoothest import find_smoothest
from planner.motion.slew.solution import AxisProfile

Array = NDArray[np.float64]

START, END = deg_state(170.9, 2.2, 0.2), deg_state(90.0, 0.6, 0.0)
LEAST_SHARE = 1.03  # of the least time
COUNTED = 1e-5  # of the cost, for a multiplier over a limit's range: less isn't seen in the picture
GREY, BLUE, RED = "0.45", "#1f5fa8", "#c0392b"


def contacts(slew: AxisSlew, profile: AxisProfile) -> Array:
    """Time, order (0 angle, 1 rate, 2 acceleration) and multiplier of each, (m, 3), normalised."""
    problem, knots = normalise_slew(slew), profile.breakpoints_s / profile.duration_s
    units = profile.duration_s ** np.arange(4)[:, None] / problem.scale_rad
    states = (np.array(profile.evaluate(profile.breakpoints_s)) * units)[:3].T
    states[:, 0] -= problem.start_angle_rad / problem.scale_rad
    early = 6.0 * profile.coefficients[:, 3]
    late = early + 24.0 * profile.coefficients[:, 4] * np.diff(profile.breakpoints_s)
    jerks = np.column_stack([early, late]) * units[3]
    no_modes = Vibration(np.zeros((0, len(jerks), 2)), np.zeros(0))
    cost = profile.jerk_squared_integral / problem.cost_unit_rad2_s5
    given = SpanProgramme(
        np.diff(knots), problem.ends, problem.limits, None, no_modes, weight=1.0 / cost
    )
    solved = solve(given, Begin(states, 0.9 * jerks), "cold")
    worth = np.abs(solved.multipliers) * np.ptp(problem.limits, axis=1)[solved.orders]
    span, row = np.nonzero(worth > COUNTED * cost)
    places = knots[span] + solved.places[span, row] * given.widths[span]
    return np.column_stack([places, solved.orders[row], solved.multipliers[span, row]])


def costate(active: Array, t: Array, jerk: Array, free: NDArray[np.bool_]) -> Array:
    """At t (n,): a quadratic less what each contact bends before it, fitted where free."""
    before = np.clip(active[:, 0] - t[:, None], 0.0, None)
    response = np.choose(
        active[:, 1].astype(int), (before**2 / 2.0, before, (before > 0.0).astype(float))
    )
    of_contacts = -response @ active[:, 2]
    quadratic = np.vander(t, 3)
    of_end, *_ = np.linalg.lstsq(quadratic[free], (jerk - of_contacts)[free])
    return of_contacts + quadratic @ of_end


def draw(path: str = "") -> None:
    duration_s = LEAST_SHARE * next_duration_s(START, END, LIMITS, 0.0)
    slew = AxisSlew(start=START, end=END, limits=LIMITS, duration_s=duration_s)
    found = find_smoothest(slew, verdict(START, END, LIMITS, duration_s).profile, None)
    profile = found.profile
    cost = profile.jerk_squared_integral
    t_s = np.linspace(0.0, duration_s, 4000)[1:-1]
    motion = [np.degrees(values) for values in profile.evaluate(t_s)]
    jerk_max = np.degrees(LIMITS.jerk_max_rad_s3)
    active = contacts(slew, profile)
    unit = np.degrees(normalise_slew(slew).scale_rad) / duration_s**3
    free = np.abs(motion[3]) < 0.98 * jerk_max
    wanted = costate(active, t_s / duration_s, motion[3] / unit, free) * unit
    print(
        f"{len(profile.coefficients)} spans, {len(active)} contacts, gap "
        f"{1.0 - found.lower_bound_rad2_s5 / cost:.1e}, costate off by "
        f"{np.abs(wanted - motion[3])[free].max():.1e} deg/s3 where free"
    )

    figure = Figure(figsize=(8.0, 8.4), layout="constrained")
    panels = figure.subplots(4, 1, sharex=True, height_ratios=(1.0, 1.0, 1.0, 1.5))
    names = ("angle, deg", "rate, deg/s", "acceleration, deg/s²", "jerk, deg/s³")
    for order, (panel, name) in enumerate(zip(panels, names, strict=True)):
        low, high = np.degrees(LIMITS.bounds[order])
        for bound, label in ((low, None), (high, "limit")):
            panel.axhline(bound, color=RED, linewidth=0.9, linestyle=(0, (6, 3)), label=label)
        panel.plot(t_s, motion[order], color=BLUE, linewidth=1.8, label="motion")
        at_s = duration_s * np.unique(active[active[:, 1] == order, 0])
        values = np.degrees(profile.evaluate(at_s)[order])
        panel.plot(at_s, values, "o", color=RED, markersize=4.0, label="contact")
        panel.set_ylabel(name)
        panel.spines[["top", "right"]].set_visible(False)
        panel.set_ylim(1.15 * low, 1.15 * high)
    panels[0].set_ylim(motion[0].min() - 8.0, motion[0].max() + 8.0)
    panels[0].legend(frameon=False, loc="lower left")
    jerk = panels[3]
    jerk.plot(t_s, wanted, color="black", linewidth=1.1, linestyle="--", label="costate")
    floor = 1.05 * min(wanted.min(), -jerk_max)
    knots_s = profile.breakpoints_s
    jerk.plot(knots_s, np.full(len(knots_s), floor - 0.2), "|", color=GREY, label="knot")
    jerk.set_ylim(floor - 0.4, 1.6 * jerk_max)
    jerk.legend(*(part[-2:] for part in jerk.get_legend_handles_labels()), ncols=2, frameon=False)
    jerk.set_xlabel("time, s")
    if path:
        figure.savefig(path, dpi=110)


if __name__ == "__main__":
    draw(*sys.argv[1:])
