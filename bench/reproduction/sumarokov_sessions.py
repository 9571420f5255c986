"""Three consecutive sessions: Sumarokov 2016, Fig. 2."""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from planner.frames.time_scales import elapsed_s
from reproduction.example_plans import THREE_SESSIONS, closest, plan_of, view_of
from reproduction.statements import Picture, Statement, holds, judge

PAPER = "Sumarokov 2016"
CLOCK_S = 1200.0  # the paper's at row 0
TRANSFERS_S = ((1200.0, 1320.0), (1450.0, 1660.0), (1750.0, 1800.0))
IMAGING_S = ((1320.0, 1450.0), (1660.0, 1750.0), (1800.0, 1900.0))
NAMES = ("first", "second", "third")


def spans_s(kind: str) -> list[tuple[float, float]]:
    """Of the plan's segments of a kind, on the paper's clock."""
    plan = plan_of(THREE_SESSIONS)
    return [
        (
            CLOCK_S + elapsed_s(segment.start_utc, plan.table.epoch_utc),
            CLOCK_S + elapsed_s(segment.stop_utc, plan.table.epoch_utc),
        )
        for segment in plan.segments
        if segment.kind == kind
    ]


def closest_s() -> list[float]:
    view = view_of(THREE_SESSIONS)
    return [CLOCK_S + closest(track, view.t_s)[1] for track in view.targets]


def statements() -> list[Statement]:
    return [*_timetable(), *_transfers(), *_rates()]


def _timetable() -> list[Statement]:
    found = []
    for what, stated, ours in (
        ("transfer", TRANSFERS_S, spans_s("slew")),
        ("imaging", IMAGING_S, spans_s("track")),
    ):
        for name, (start_s, stop_s), (our_start_s, our_stop_s) in zip(
            NAMES, stated, ours, strict=True
        ):
            off_s = max(abs(our_start_s - start_s), abs(our_stop_s - stop_s))
            found.append(
                Statement(
                    paper=PAPER,
                    place="Fig. 2",
                    name=f"{name} {what}",
                    says=f"{name} {what}, {start_s:.0f} to {stop_s:.0f} s",
                    stated=stop_s - start_s,
                    ours=our_stop_s - our_start_s,
                    unit="s",
                    tolerance=0.1,
                    verdict=judge(0.0, off_s, 0.2),
                    why="asked for, on passes of ours: that it is flown within all limits is what "
                    "is shown"
                    if what == "imaging"
                    else "the time there is between two sessions, all of it used",
                )
            )
    for name, (start_s, stop_s), at_s in zip(NAMES, IMAGING_S, closest_s(), strict=True):
        found.append(
            Statement(
                paper=PAPER,
                place="Fig. 2",
                name=f"{name} closest approach",
                says=f"the target is nearest within the {name} imaging (a dashed line)",
                ours=at_s,
                unit="s",
                tolerance=0.5,
                verdict=holds(start_s < at_s < stop_s),
                why="the least range; the paper's line, of the least distance from the ground "
                "track, is told in the picture only",
            )
        )
    return found


def _transfers() -> list[Statement]:
    found = []
    for name, (start_s, stop_s), slew in zip(
        NAMES, TRANSFERS_S, plan_of(THREE_SESSIONS).slews, strict=True
    ):
        comparison = slew.comparison
        assert comparison is not None
        broken = {violation.limit for violation in comparison.spline.violations}
        found.append(
            Statement(
                paper=PAPER,
                place="Fig. 2, eq. 12",
                name=f"{name} transfer's time",
                says=f"the {name} transfer fits into the time there is, by (12)",
                stated=stop_s - start_s,
                ours=comparison.paper_duration_s,
                unit="s",
                tolerance=0.2,
                verdict=holds(comparison.paper_duration_s <= stop_s - start_s),
                why=f"(12) over our passes; at least {slew.minimum_s:.1f} s are needed. Filtered, "
                f"the paper's cubic over the whole time breaks {', '.join(broken) or 'no limit'}",
            )
        )
    return found


def _rates() -> list[Statement]:
    plan = plan_of(THREE_SESSIONS)
    rate_deg_s = float(np.rad2deg(np.abs(plan.table.rate_rad_s).max()))
    return [
        Statement(
            paper=PAPER,
            place="Fig. 2",
            name="greatest rate",
            says="the rates stay within what the drives can",
            stated=3.0,
            ours=rate_deg_s,
            unit="deg/s",
            tolerance=0.01,
            verdict=holds(plan.verification.passed and rate_deg_s <= 3.0),
            why="the independent judge finds no limit broken in the whole table",
        ),
        Statement(
            paper=PAPER,
            place="Fig. 2",
            name="curves",
            says="the curves of angles and rates themselves",
            ours=None,
            verdict="can't be reproduced",
            why="neither orbit, attitude nor targets are told, and the text that we have of the "
            "paper holds no curves: ours, on other passes, are drawn above for their shape",
        ),
    ]


def pictures(folder: Path) -> list[Picture]:
    plan = plan_of(THREE_SESSIONS)
    t_s = plan.table.t_s + CLOCK_S
    figure = Figure(figsize=(8.4, 5.4), layout="constrained")
    panels = figure.subplots(2, 1, sharex=True)
    _axes_over_time(panels[0], t_s, plan.table.angle_rad, "angle, deg")
    _axes_over_time(panels[1], t_s, plan.table.rate_rad_s, "rate, deg/s")
    for panel in panels:
        for start_s, stop_s in IMAGING_S:
            panel.axvspan(start_s, stop_s, color="#f3e9c6", zorder=0)
        for at_s in closest_s():
            panel.axvline(at_s, color="#7b5aa6", ls="--", lw=1.0)
        panel.grid(alpha=0.3)
    panels[0].legend(loc="upper right", ncols=2)
    panels[1].set_xlabel("time on the paper's clock, s")
    panels[1].set_xticks(sorted({s for span in (*TRANSFERS_S, *IMAGING_S) for s in span}))
    figure.savefig(folder / "reproduction_sessions.png", dpi=100)
    return [
        Picture(
            file="reproduction_sessions.png",
            shows="Angles and rates of both axes over three sessions, on the paper's clock",
            text="Shaded: imaging; dashed: closest approach.",
        )
    ]


def _axes_over_time(panel, t_s: NDArray, values_rad: NDArray, label: str) -> None:  # noqa: ANN001
    for k, name in enumerate(("alpha", "beta")):
        panel.plot(t_s, np.rad2deg(values_rad[:, k]), label=name, lw=1.3)
    panel.set_ylabel(label)
