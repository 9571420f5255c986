"""The best choice found of requests to image, their times and order, its slews, and its bound.

Chosen as the looks of one pass of a campaign, at slew times that suffice, and bounded by it with
times that none can beat.  Of a request all looks are imaged or none, in any order.  A choice holds
once every slew in it is found.
"""

import math
from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from operator import itemgetter
from typing import NamedTuple

import numpy as np

from planner.base import effort
from planner.base.arrays import Array, Indices
from planner.base.commands import COMMAND_STEP_S
from planner.base.effort import at_most
from planner.base.errors import InfeasibleSlew, Refusal, SearchEnded, Unreachable
from planner.base.reporting import tell_nobody
from planner.planning.campaigns import choice as campaigns
from planner.planning.campaigns.looking import Looking
from planner.planning.campaigns.network import Network, Rests, Slewing, network_of, relax
from planner.planning.campaigns.path import best_path
from planner.planning.campaigns.pricing import PricedPasses
from planner.planning.campaigns.ways import Ways
from planner.spacecraft.imaging.candidates import (
    ScanStarts,
    candidates,
    grid_s,
    require_together,
)
from planner.spacecraft.imaging.session import GroundArc, ImagingSession
from planner.spacecraft.imaging.timeline import DoesNotFit, Timeline, build_timeline
from planner.spacecraft.requests import LeftOut


@dataclass(frozen=True, kw_only=True)
class ChoiceOptions:
    """What a choice and its bound may take, and how it is revised where a slew isn't found."""

    fit: float = 0.01  # of `effort`: to look whether a slew fits, of those that there may be
    off: float = 1e-4  # of a look's worth, for each radian off its best angle: of equals the best
    bound_share: float = 0.3  # of what work is left: the rest is for flights
    more_s: tuple[float, float, float] = (4.0, 2.0, 0.8)  # for every slew, tried in this order
    tries: int = 3  # of a request, before others are imaged in its place
    request: float = 1_000.0  # of `effort`, for each request
    gentler_share: float = 0.4  # of what work is left, for gentler slews
    rest_before_s: float = 20.0  # a slew from and to the idle attitude takes about so long


OPTIONS = ChoiceOptions()
# Of a campaign whose one pass is all there is: with so many labels 100 strips in 1,200 s are worth
# 3 % more, in half a second; 30,000 orders took 100 s and found no more than 300.
ONE_PASS = replace(
    campaigns.OPTIONS, exact_labels_max=4_000_000, pass_labels_max=2_000_000, pass_orders=300
)


class LooksTooClose(InfeasibleSlew):
    """The looks of a stereo pair leave no time for the slew between; gap_s: how far apart they had
    to begin if the slew were no longer for it."""

    def __init__(self, number: int, gap_s: float, scan_s: float, slew_s: float) -> None:
        self.gap_s = scan_s + slew_s
        super().__init__(
            f"the looks of requests.{number} begin {gap_s:.1f} s apart; a scan takes "
            f"{scan_s:.1f} s and the slew between about {slew_s:.1f} s: ask for a larger gap_s "
            "or look_angle_deg, a faster scan or a shorter line",
            field=f"requests.{number}",
            limit="time",
        )


def options_of(session: ImagingSession) -> tuple[list[ScanStarts], tuple[LeftOut, ...]]:
    """Scans that can be turned to from the session's start and back before its end.

    Raises the first request's refusal when there is none of any.
    """
    options: list[ScanStarts] = []
    left_out: list[LeftOut] = []
    refusal: Refusal | None = None
    for number, request in enumerate(session.request.requests):
        try:
            effort.charge(OPTIONS.request)
            own = _within_session(candidates(request, number, session), number, session)
            require_together(own, session, lambda scans: bool(choose(scans, session).chosen))
            options += own
        except (Unreachable, InfeasibleSlew) as why:
            refusal = refusal or why
            left_out.append(LeftOut(name=request.name, reason=why.detail))
    if not options and refusal is not None:
        raise refusal
    return options, tuple(left_out)


def _within_session(
    options: list[ScanStarts], number: int, session: ImagingSession
) -> list[ScanStarts]:
    slews, counts = session.slews, [len(one.starts_s) for one in options]
    starts_s, stops_s, entries, exits = (
        np.concatenate(parts)
        for parts in zip(
            *((one.starts_s, one.stops_s, one.entry_states, one.exit_states) for one in options),
            strict=True,
        )
    )
    looks = np.repeat([one.arc.look for one in options], counts)
    leaving_s = np.maximum(starts_s - OPTIONS.rest_before_s, 0.0)
    back_by_s = np.minimum(stops_s + OPTIONS.rest_before_s, session.duration_s)
    before, after = np.split(session.ends(None, np.append(leaving_s, back_by_s), 0.0), 2)
    there_s = slews.ticks(before, entries) * COMMAND_STEP_S
    if (initial := session.initial_state) is not None:
        there_s += slews.ticks(np.tile(initial, (len(before), 1)), before) * COMMAND_STEP_S
    back_s = slews.ticks(exits, after) * COMMAND_STEP_S - slews.settle_s
    fits = (there_s <= starts_s) & (stops_s + back_s <= session.duration_s)
    lacking = np.flatnonzero(~np.isin(looks, looks[fits]))  # half a pair is no image
    if lacking.size:
        k = int(lacking[0])
        raise InfeasibleSlew(
            f"turning onto requests.{number} and back to orbital orientation needs about "
            f"{there_s[k]:.1f} s before its start and {back_s[k]:.1f} s after its end, more than "
            f"the session leaves (it could be imaged {starts_s[k]:.1f} to {stops_s[k]:.1f} s "
            "after the start); start earlier or stop later by as much",
            field=f"requests.{number}",
            limit="time",
        )
    if session.request.requests[number].mode == "stereo":
        # Some second look has to be in reach of a first one.
        second, first = map(
            np.ravel, np.meshgrid(*(np.flatnonzero(fits & (looks == look)) for look in (1, 0)))
        )
        needed_s = COMMAND_STEP_S * slews.ticks(exits[first], entries[second])
        between_s = starts_s[second] - stops_s[first]
        k = int(np.argmax(between_s - needed_s))
        if needed_s[k] > between_s[k] + 0.5 * COMMAND_STEP_S:
            gap_s = float(starts_s[second[k]] - starts_s[first[k]])
            raise LooksTooClose(number, gap_s, gap_s - between_s[k], needed_s[k])
    kept = zip(options, np.split(fits, np.cumsum(counts)[:-1]), strict=True)
    return [one.only(fit) for one, fit in kept if fit.any()]


class Imaging(NamedTuple):
    """Scans as the looks of one pass.

    runs: of each way its first step, its scan's starts, and which of these follow step after step.
    requests: of each look, (looks,).
    """

    runs: list[tuple[int, ScanStarts, Indices]]
    requests: Indices
    least_steps: Indices
    ways: Ways
    slewing: Slewing
    network: Network
    looking: Looking

    def priced(self, network: Network) -> PricedPasses:
        """The pass by either of its networks; all scans can be held."""
        return PricedPasses([network], [network], self.looking, lambda _: None)

    def relaxed(self) -> Network:
        """At slew times that nothing can beat, and the best views."""
        relaxed = relax(self.network, self.ways, self.least_steps, self.slewing)
        return relaxed._replace(quality_sum=np.arange(relaxed.size, dtype=np.float64))

    def greedy_requests(self, priorities: Sequence[float]) -> set[int]:
        """By priority, each where those before it leave room."""
        taken: list[int] = []
        for request in np.argsort(-np.array(priorities), kind="stable").tolist():
            trial = np.isin(self.requests, [*taken, request])
            price = np.where(trial, -1.0 - sum(priorities), np.inf)
            path = best_path(self.network, self.looking.less_prices(price))
            if request in self.requests and len(path.looks) == np.count_nonzero(trial):
                taken.append(request)
        return set(taken)


@dataclass(frozen=True, kw_only=True)
class Choice:
    """Scans in order of time, and how good the choice of them is.

    value: sum of priorities fulfilled.  greedy_value: of taking requests by priority, each where
    those before it leave room.  price, imaging: for the bound.
    """

    chosen: tuple[GroundArc, ...] = ()
    value: float = 0.0
    greedy_value: float = 0.0
    price: Array | None = None
    imaging: Imaging | None = None

    @property
    def requests(self) -> frozenset[int]:
        """Theirs."""
        return frozenset(one.request for one in self.chosen)

    def bound(self, priorities: Sequence[float]) -> float:
        """No choice of the same scans is worth more, whatever its slews."""
        assert self.imaging is not None
        assert self.price is not None
        least = _worth(set(self.imaging.requests.tolist()), priorities)
        if least > self.value and effort.remaining() > 0.0:
            with at_most(OPTIONS.bound_share * effort.remaining()):
                passes = self.imaging.priced(self.imaging.relaxed())
                least = min(least, campaigns.bound_at(passes, self.price, ONE_PASS))
        return max(least, self.value)


@dataclass(frozen=True, kw_only=True)
class Chosen:
    """What is imaged, with its slews, and why the rest of what could be seen is not.

    first: what was chosen before slews were found, for the bound.
    """

    first: Choice
    choice: Choice
    timeline: Timeline
    left_out: tuple[LeftOut, ...] = ()


def choose_and_slew(
    session: ImagingSession, options: Sequence[ScanStarts], *, refine: bool
) -> Chosen:
    """The choice and its timeline.  Where all that can be seen fits and it is to be refined, smooth
    slews share the time left over, as a slower slew shakes the structure less.

    Raises InfeasibleSlew where nothing fits.
    """
    first, found = choose(options, session), None
    is_all = first.requests == {one.arc.request for one in options}
    if refine and is_all and session.request.objective == "smooth":
        with at_most(OPTIONS.gentler_share * effort.remaining()):
            found = _gentler(session, first)
    return found or _fitting(session, options, first)


def _gentler(session: ImagingSession, first: Choice) -> Chosen | None:
    """Everything imaged with the gentlest slews tried, or None.

    What the choice is measured by stays.
    """
    for more_s in OPTIONS.more_s:
        longer = replace(session, slews=replace(session.slews, more_s=more_s))
        with suppress(Unreachable, InfeasibleSlew, SearchEnded, DoesNotFit):
            choice = choose(options_of(longer)[0], longer)
            if choice.value >= first.value:
                timeline = build_timeline(longer, choice.chosen)
                choice = replace(choice, greedy_value=first.greedy_value)
                return Chosen(first=first, choice=choice, timeline=timeline)
    return None


def _fitting(session: ImagingSession, options: Sequence[ScanStarts], first: Choice) -> Chosen:
    """The choice with its slews; where one isn't found, another choice without the scan at fault,
    after some tries without its request."""
    choice, seen = first, {one.arc.request for one in options}
    refused: dict[int, list[str]] = {}  # requests, and why
    why: Refusal = InfeasibleSlew("the slews between its scans don't fit", limit="time")
    while choice.chosen:
        try:
            timeline = build_timeline(session, choice.chosen)
            break
        except DoesNotFit as misfit:
            at_fault, why = misfit.arc, misfit.why
        refused.setdefault(at_fault.request, []).append(why.detail)
        is_over = len(refused[at_fault.request]) >= OPTIONS.tries
        look = at_fault.request, at_fault.look
        options = [
            one.only((one.starts_s != at_fault.start_s) | (one.look != look))
            for one in options
            if not (is_over and one.arc.request == at_fault.request)
        ]
        choice = choose(options, session)
    else:
        raise InfeasibleSlew(why.detail, field="requests", limit=why.limit)
    requests = session.request.requests
    beside = ["no time beside requests worth more, in the best choice found"]
    left_out = tuple(
        LeftOut(name=requests[number].name, reason=refused.get(number, beside)[-1])
        for number in sorted(seen - choice.requests)
    )
    choice = replace(choice, greedy_value=min(first.greedy_value, choice.value))
    return Chosen(first=first, choice=choice, timeline=timeline, left_out=left_out)


def choose(options: Sequence[ScanStarts], session: ImagingSession) -> Choice:
    """The best choice found of scans for slew times that suffice."""
    seen = {one.look for one in options if len(one.starts_s)}
    halves = {one.arc.request for one in options if one.look not in seen}
    options = [one for one in options if len(one.starts_s) and one.arc.request not in halves]
    if not options:
        return Choice()
    imaging, priorities = _made_ready(options, session), session.priorities
    found = campaigns.choose(imaging.priced(imaging.network), tell_nobody, ONE_PASS)
    looks = [(*imaging.runs[look.way], look.first_step) for look in found.passes[0]]
    chosen = tuple(one.begun(run[step - first]) for first, one, run, step in looks)
    value = _worth({one.request for one in chosen}, priorities)
    return Choice(
        chosen=chosen,
        value=value,
        greedy_value=min(_worth(imaging.greedy_requests(priorities), priorities), value),
        price=found.price,
        imaging=imaging,
    )


def _worth(requests: Iterable[int], priorities: Sequence[float]) -> float:
    return float(sum(priorities[request] for request in requests))


def _made_ready(options: Sequence[ScanStarts], session: ImagingSession) -> Imaging:
    slews, step_s = session.slews, grid_s(session)
    reach_steps = math.ceil(slews.widest_ticks * COMMAND_STEP_S / step_s) + 1
    held_s = {one.look: slews.settle_s + one.arc.scan_s for one in options}
    numbers = {look: number for number, look in enumerate(held_s)}
    least_steps = np.array([math.ceil(lasts_s / step_s - 1e-9) for lasts_s in held_s.values()])
    runs: list[tuple[int, ScanStarts, Indices]] = []
    for one in options:
        entered_s = one.starts_s - slews.settle_s
        steps = np.floor(entered_s / step_s + 1e-6).astype(np.intp)
        ticks = np.round((entered_s - steps * step_s) / COMMAND_STEP_S)
        order = np.lexsort((steps, ticks))
        cuts = np.flatnonzero((np.diff(steps[order]) != 1) | (np.diff(ticks[order]) != 0)) + 1
        # By so much all steps are later that who rests before them can reach any way.
        runs += [(int(steps[run[0]]) + reach_steps, one, run) for run in np.split(order, cuts)]
    runs.sort(key=itemgetter(0))
    columns = []
    for first, one, run in runs:
        least = int(least_steps[numbers[one.look]])
        late_s = one.starts_s[run[0]] - slews.settle_s - (first - reach_steps) * step_s
        spare_s = least * step_s - late_s - held_s[one.look], late_s - slews.more_s
        none = np.full((least, one.entry_states.shape[1]), np.nan)
        middle = np.clip(np.arange(len(run) + least) - least // 2, 0, len(run) - 1)
        columns.append(
            (
                numbers[one.look],
                first,
                len(run) + least,
                spare_s,
                np.concatenate([none, one.exit_states[run]]),
                np.concatenate([one.entry_states[run], none]),
                1.0 - OPTIONS.off * one.off_rad[run][middle],
            )
        )
    target, first_step, steps, spares_s = (
        np.array([column[k] for column in columns]) for k in range(4)
    )
    states, begin_states, quality = (
        np.concatenate([column[k] for column in columns]) for k in range(4, 7)
    )
    ways = Ways(
        step_s=step_s,
        target=target,
        pass_number=np.zeros_like(target),
        first_step=first_step,
        steps=steps,
        offset=np.cumsum(steps) - steps,
        states=states,
        quality=quality,
        scanned=np.ones(len(target), np.bool_),
        begin_states=begin_states,
        look=np.arange(len(target)),
        spare_s=spares_s,
    )
    # The options are those that leave time for slews from rest before all, and to it after all.
    rests = Rests(start_state=states[-1], stop_state=states[-1], stop_s=math.inf)
    slewing = Slewing(slews.limits[0], rests, reach_steps * step_s)
    near = np.abs(first_step[:, None] - first_step) < steps + reach_steps
    effort.charge(OPTIONS.fit * float(steps @ near @ np.minimum(steps, reach_steps)))
    requests = np.array([request for request, _ in numbers])
    share = np.array(session.priorities)[requests] / np.bincount(requests)[requests]
    several = np.bincount(requests)[requests] > 1
    names, group = np.unique(requests[several], return_inverse=True)
    looking = Looking(
        length_steps=least_steps[:, None],
        look_value=share[:, None],
        look_limit=np.ones(len(requests)),
        group=np.full(len(requests), -1),
        way_to=np.arange(len(names)),
        way_limit=np.ones(len(names)),
        settle_steps=np.zeros(1, np.intp),
    )
    looking.group[several] = group
    network = network_of(ways, ways.look, least_steps, slewing)
    return Imaging(runs, requests, least_steps, ways, slewing, network, looking)
