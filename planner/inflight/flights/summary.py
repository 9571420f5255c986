"""Summaries of many disturbed flights, of each session and of the whole plan."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from planner.base.answer_members import Count, Member, answer
from planner.base.arrays import Array, Indices, Mask
from planner.inflight.flights.contributors import Contributor, contributors
from planner.inflight.flights.outcomes import RunOutcomes
from planner.inflight.flights.proportion import Proportion
from planner.inflight.simulation.gyros.report import GyroSteadiness, worst_of

BINS = 24
QUANTILES = (0.05, 0.5, 0.95)
_SHOWN_SHARE = 0.99  # of the runs; the rest is told by number, as one far miss would hide all


@answer
class Histogram:
    """Histogram of the runs' largest misses.

    edges_rad: of the bins, one more than there are.
    counts: of the runs in each bin.
    beyond: number of runs that missed by more than the last edge.
    """

    edges_rad: Annotated[Array, Member("arcsec", 0.0, decimals=6)]
    counts: Annotated[Indices, Member(least=0)]
    beyond: Count


@dataclass(frozen=True, kw_only=True, eq=False)
class SessionFlights:
    """One session under errors.

    in_frame: all frames hold the target.  sharp: all frames are sharp, too.
    held_share, sharp_share: of the frames, mean over the runs.  smear_px: median of a run's
    frames, at `QUANTILES` of the runs.  miss_rad: the largest angle between boresight and target
    in a run.  miss_m: the same on the ground at `QUANTILES`, across the line of sight; None for a
    target in the sky.  gyros: their steadiness in the worst of all runs; None without.
    """

    in_frame: Proportion
    sharp: Proportion
    held_share: float
    sharp_share: float
    smear_px: Array
    miss_rad: Histogram
    miss_m: Array | None
    gyros: GyroSteadiness | None
    contributors: list[Contributor]


@dataclass(frozen=True, kw_only=True, eq=False)
class PlanFlights:
    """All sessions of a plan in the same runs: in_frame and sharp hold of every session."""

    in_frame: Proportion
    sharp: Proportion
    contributors: list[Contributor]
    sessions: list[SessionFlights]


def joined(parts: Sequence[RunOutcomes]) -> RunOutcomes:
    """Runs of one session, flown in parts, in the order of their numbers."""
    return RunOutcomes(
        causes=parts[0].causes,
        **{
            name: np.concatenate([part.columns[name] for part in parts])
            for name in parts[0].columns
        },
    )


def summarise(sessions: Sequence[RunOutcomes]) -> PlanFlights:
    """The same runs of each session."""
    return PlanFlights(
        in_frame=_proportion(np.all([runs.holds for runs in sessions], axis=0)),
        sharp=_proportion(np.all([runs.sharp for runs in sessions], axis=0)),
        contributors=contributors(sessions),
        sessions=[
            SessionFlights(
                in_frame=_proportion(runs.holds),
                sharp=_proportion(runs.sharp),
                held_share=float(runs.holds_share.mean()),
                sharp_share=float(runs.sharp_share.mean()),
                smear_px=np.quantile(runs.smear_px, QUANTILES),
                miss_rad=_histogram(runs.miss_rad),
                miss_m=np.quantile(runs.miss_m, QUANTILES)
                if np.isfinite(runs.miss_m).all()
                else None,
                gyros=worst_of(runs.gyro_numbers),
                contributors=contributors([runs]),
            )
            for runs in sessions
        ],
    )


def _proportion(found: Mask) -> Proportion:
    return Proportion(count=int(found.sum()), runs=len(found))


def _histogram(angles_rad: Array) -> Histogram:
    last = float(np.quantile(angles_rad, _SHOWN_SHARE))
    counts, edges_rad = np.histogram(angles_rad, bins=BINS, range=(0.0, last or 1.0))
    return Histogram(edges_rad=edges_rad, counts=counts, beyond=len(angles_rad) - int(counts.sum()))
