"""Summaries of many disturbed flights, of each session and of the whole plan."""

from collections.abc import Iterator, Sequence
from typing import Annotated

import numpy as np

from planner.base.answer_members import Count, Internal, Member, Share, answer
from planner.base.arrays import Array, Indices, Mask
from planner.inflight.flights.contributors import Contributor, contributors
from planner.inflight.flights.outcomes import NominalSession, RunOutcomes
from planner.inflight.flights.proportion import Proportion
from planner.inflight.simulation.gyros.report import GyroSteadiness, worst_of

BINS = 24
QUANTILES = (0.05, 0.5, 0.95)
_SHOWN_SHARE = 0.99  # of the runs; the rest is told by number, as one far miss would hide all
_End = Annotated[float, Member(least=0.0, greatest=1.0, decimals=6)]  # of an interval
_Quantiles = Annotated[Array, Member("", 0.0, decimals=6)]  # at `QUANTILES` of the runs


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


@answer
class FlownRuns:
    """Runs of one session or of all of a plan's, by what they show; null where none is flown yet.

    in_frame: all frames hold the target.  sharp: all frames are sharp, too.
    """

    in_frame: Internal[Proportion | None] = None
    sharp: Internal[Proportion | None] = None

    @property
    def probability_in_frame(self) -> Share | None:
        return self.in_frame.value if self.in_frame else None

    @property
    def in_frame_interval(self) -> tuple[_End, ...] | None:
        return self.in_frame.interval() if self.in_frame else None

    @property
    def probability_sharp(self) -> Share | None:
        return self.sharp.value if self.sharp else None

    @property
    def sharp_interval(self) -> tuple[_End, ...] | None:
        return self.sharp.interval() if self.sharp else None


@answer
class FlownSession(FlownRuns):
    """One session in all runs."""

    frames_held: Share | None = None
    frames_sharp: Share | None = None
    smear_px: _Quantiles | None = None
    miss_m: _Quantiles | None = None
    misses: Histogram | None = None
    contributors: tuple[Contributor, ...] = ()
    gyros: GyroSteadiness | None = None

    def doubts(self, session: int, budget_probability: float) -> Iterator[str]:
        """Of what the plan's budget tells of the session."""
        if self.in_frame is not None and self.in_frame.differs_from(budget_probability):
            low, high = self.in_frame.interval()
            yield (
                f"session {session + 1}: the plan's budget tells a probability of "
                f"{budget_probability:.3f} that the target stays in the frame, the flights "
                f"{self.in_frame.value:.3f} ({low:.3f} to {high:.3f}): more than chance; the "
                "budget is linear and knows no drives but their resolution: trust the flights"
            )


@answer
class SessionHead:
    """Its place in the plan, and what the plan says of it."""

    session: Count
    label: str
    budget_probability_in_frame: Share


@answer
class SessionFlightsOut(FlownSession, SessionHead):
    """A session under errors; null where no run is flown yet.

    session: its number in the plan.
    label: its name in lists.
    budget_probability_in_frame: the same probability by the plan's linear budget.
    probability_in_frame: share of the runs in which all frames hold the target.
    in_frame_interval: within which that probability lies with 95 % confidence (Wilson).
    probability_sharp: share of the runs in which all frames hold it smeared over less than a pixel.
    sharp_interval: within which that probability lies with 95 % confidence (Wilson).
    frames_held: share of all runs' frames that hold the target.
    frames_sharp: share of all runs' frames that hold it smeared over less than a pixel.
    smear_px: median of a run's frames; in 5, 50 and 95 % of the runs it is less. [pixels]
    miss_m: largest distance of the target from the boresight in a run, across the line of sight; in
    5, 50 and 95 % of the runs it is less; null for a target in the sky. [m]
    misses: the same as an angle, as a histogram.
    contributors: causes of the errors, the largest first.
    gyros: of a body with gyros, their steadiness in the worst of the runs; null without.
    nominal: the session flown as planned.
    """

    nominal: NominalSession


@answer
class FlightsHead:
    """What is flown, and how often."""

    plan: str
    runs: Annotated[int, Member(least=2)]
    seed: Count
    flown: Count = 0
    epoch: str | None = None


@answer
class FlownPlan(FlownRuns):
    """All sessions in the same runs: in_frame and sharp hold of every session."""

    contributors: tuple[Contributor, ...] = ()
    sessions: tuple[FlownSession, ...] = ()


@answer
class PlanFlights(FlownPlan, FlightsHead):
    """What the runs flown so far say of the plan.

    plan: id of the plan that is flown.
    runs: number of flights that were asked for.
    seed: of their errors.
    flown: number of runs flown so far; all numbers are of these.
    epoch: of `t_s`, the plan's row 0; UTC.
    probability_in_frame: share of the runs in which every frame of every session holds its target;
    null before any is flown.
    in_frame_interval: within which that probability lies with 95 % confidence (Wilson).
    probability_sharp: share of the runs in which each of these frames is smeared over less than a
    pixel, too; null before any run is flown.
    sharp_interval: within which that probability lies with 95 % confidence (Wilson).
    contributors: causes of the errors, the largest first; all sessions together.
    sessions: those that look at a target.
    warnings: cautions, such as a linear budget that doesn't agree with the flights. E.g.
    `["session 0: the budget tells a probability of 0.950, ..."]`.
    """

    sessions: tuple[SessionFlightsOut, ...] = ()
    warnings: tuple[str, ...] = ()


def joined(parts: Sequence[RunOutcomes]) -> RunOutcomes:
    """Runs of one session, flown in parts, in the order of their numbers."""
    return RunOutcomes(
        causes=parts[0].causes,
        **{
            name: np.concatenate([part.columns[name] for part in parts])
            for name in parts[0].columns
        },
    )


def summarise(sessions: Sequence[RunOutcomes]) -> FlownPlan:
    """The same runs of each session."""
    return FlownPlan(
        in_frame=_proportion(np.all([runs.holds for runs in sessions], axis=0)),
        sharp=_proportion(np.all([runs.sharp for runs in sessions], axis=0)),
        contributors=tuple(contributors(sessions)),
        sessions=tuple(
            FlownSession(
                in_frame=_proportion(runs.holds),
                sharp=_proportion(runs.sharp),
                frames_held=float(runs.holds_share.mean()),
                frames_sharp=float(runs.sharp_share.mean()),
                smear_px=np.quantile(runs.smear_px, QUANTILES),
                misses=_histogram(runs.miss_rad),
                miss_m=np.quantile(runs.miss_m, QUANTILES)
                if np.isfinite(runs.miss_m).all()
                else None,
                gyros=worst_of(runs.gyro_numbers),
                contributors=tuple(contributors([runs])),
            )
            for runs in sessions
        ),
    )


def _proportion(found: Mask) -> Proportion:
    return Proportion(count=int(found.sum()), runs=len(found))


def _histogram(angles_rad: Array) -> Histogram:
    last = float(np.quantile(angles_rad, _SHOWN_SHARE))
    counts, edges_rad = np.histogram(angles_rad, bins=BINS, range=(0.0, last or 1.0))
    return Histogram(edges_rad=edges_rad, counts=counts, beyond=len(angles_rad) - int(counts.sum()))
