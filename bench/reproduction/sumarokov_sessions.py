"""Three consecutive sessions: Sumarokov 2016, Fig. 2."""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from planner.world.frames.time_scales import elapsed_s
from reproduction.example_plans import THREE_SESSIONS, closest, plan_of, view_of
from reproduction.statements import Numbers

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


def numbers() -> Numbers:
    plan = plan_of(THREE_SESSIONS)
    found: Numbers = {"greatest rate": float(np.rad2deg(np.abs(plan.table.rate_rad_s).max()))}
    transfers, imaging = spans_s("slew"), spans_s("track")
    for name, transfer, image, at_s, slew in zip(
        NAMES, transfers, imaging, closest_s(), plan.slews, strict=True
    ):
        assert slew.comparison is not None
        broken = {violation.limit for violation in slew.comparison.spline.violations}
        found |= {
            f"{name} transfer": transfer[1] - transfer[0],
            f"{name} imaging": image[1] - image[0],
            f"{name} closest approach": at_s,
            f"{name} transfer's time": slew.comparison.paper_duration_s,
            f"{name}_least_s": slew.minimum_s,
            f"{name}_breaks": ", ".join(sorted(broken)) or "no limit",
        }
    return found


def pictures(folder: Path) -> None:
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


def _axes_over_time(panel, t_s: NDArray, values_rad: NDArray, label: str) -> None:  # noqa: ANN001
    for k, name in enumerate(("alpha", "beta")):
        panel.plot(t_s, np.rad2deg(values_rad[:, k]), label=name, lw=1.3)
    panel.set_ylabel(label)
