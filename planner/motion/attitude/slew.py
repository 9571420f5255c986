"""The slew of a whole body: the OCP's within all limits, or a refusal that names the limit."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from typing import Literal, NamedTuple

import numpy as np

from planner.base import effort
from planner.base.arrays import Array
from planner.base.commands import ROWS_PER_S, Motion
from planner.base.effort import at_most
from planner.base.errors import InfeasibleSlew, figures
from planner.base.mrp import BodyMotion
from planner.base.solvers import SolverRun
from planner.motion.attitude.around import around_cones, centres_eci
from planner.motion.attitude.bounds import least_cost_rad2_s5, least_row
from planner.motion.attitude.eigenaxis import (
    EigenaxisSlew,
    eigenaxis_slew,
    over_limits,
    quickest_eigenaxis,
)
from planner.motion.attitude.ocp import SolvedBodySlew, SpanMotion, arrival_within, solve
from planner.motion.attitude.problem import (
    ORDERS,
    BodySlewProblem,
    between_rows,
    depths_rad,
    require_ends,
)


@dataclass(frozen=True, kw_only=True)
class BodySlewOptions:
    """How the OCP is begun, and its answer judged."""

    phases: int = 7  # a jerk-limited slew about one axis: up, hold, down, coast and the same again
    spans: int = 28  # of which each phase has 4
    least_spans: int = 3  # of a phase on rows: the others go to the longest
    shortest_phase: float = 0.01  # of the time, to begin at
    second_start: float = 1.15  # times as long as the first: a smooth slew there begins the second
    eased: tuple[float, ...] = (1.15, 1.5, 2.2, 3.0)  # times the eigenaxis's, until one is found
    cap: float = 1.5  # times the guess: the time is free up to there
    limit_share: float = 1.0 - 2e-6  # used on spans, so that the quintics between rows keep all
    limit_tolerance: float = 1e-6  # of a limit, of what is flown
    looks: int = 8  # at every row, of what is flown
    later: float = 1.1  # times as long, where what a slew takes isn't known, another one is tried
    later_rows: int = 8  # tried after the least time: a row's span can't switch inside
    patience_rows: int = 18_000  # an hour: to tell what a slew without enough time takes
    proven: float = 1e-3  # of the cost, beyond its bound: the best there is
    again_share: float = 0.6  # of the work that is left, for the least time from another start
    best_share: float = 0.98  # of a least time from one start, the least that there may be
    # times what a turn between rests takes: with more time, its motions at the ends decide
    hasty: float = 2.0
    # of the rate limit, at an end: with more, no least time was found, at a second's cost
    fast_end: float = 0.98


OPTIONS = BodySlewOptions()


@dataclass(frozen=True, eq=False, kw_only=True)
class BodySlew:
    """A slew on the table's rows, with what no slew can beat beside it.

    motion: rows 0 .. n, the start and the goal's row among them; between them the body flies
    quintics in Rodrigues parameters, within all limits.
    cost_rad2_s5, bound_rad2_s5: integral of squared jerk, and what no slew of as many rows can
    do with less.  least_s: no slew takes less; quickest_s: the least time found for a jerk that
    changes anywhere, None where the time was given; eigenaxis_s: of the quickest slew about the
    Euler axis found, None where none was.
    is_best: what of this slew no other can beat: "time" (to a row), "jerk" or nothing, which is
    then the best found.
    shares: the most used of rate, acceleration and jerk, as flown.  run: of the solver.
    """

    motion: Motion
    cost_rad2_s5: float
    bound_rad2_s5: float
    least_s: float
    quickest_s: float | None
    eigenaxis_s: float | None
    is_best: Literal["time", "jerk"] | None
    shares: tuple[float, float, float]
    run: SolverRun

    @property
    def duration_s(self) -> float:
        return (len(self.motion.position) - 1) / ROWS_PER_S


class _Found(NamedTuple):
    """A motion on spans of whole rows, the rows, and what is flown between them."""

    spans: SpanMotion
    motion: Motion
    shares: Array
    run: SolverRun


class _Tried(NamedTuple):
    """What was found in the time given, and the least time without cones, if it was sought."""

    found: _Found | None
    least_s: float | None = None

    def is_beyond(self, available_s: float) -> bool:
        """Whether it clearly takes longer than that."""
        return self.found is None and available_s < OPTIONS.best_share * (self.least_s or 0.0)


def solve_attitude_slew(problem: BodySlewProblem) -> BodySlew:
    """The slew asked for.

    Raises InfeasibleSlew, whose limit is "rate", "acceleration" or "jerk" where an end breaks it
    or can't be left or reached within it; "exclusion" where a cone is in the way; "duration"
    where the time is too short, with the time it takes.  Raises WorkLimitReached.
    """
    require_ends(problem)
    least = least_row(problem)
    if least is None:
        raise _too_short(problem, is_proof=True)
    eigenaxis, _, keeps = quickest_eigenaxis(problem)
    if problem.objective != "minimum_time" or len(problem.goal.position) == 1:
        quickest_s, tried = None, _smoothest(problem.arriving_at(problem.last_arrival_row))
    else:
        quickest_s, tried = _quickest(problem, least, eigenaxis)
    found = tried.found
    if found is None:
        raise _refusal(problem, tried.least_s)
    row = len(found.motion.position) - 1
    bound = least_cost_rad2_s5(problem, row)
    cost = found.spans.cost_rad2_s5
    is_best: Literal["time", "jerk"] | None = None
    if row == least and problem.objective == "minimum_time":
        is_best = "time"
    elif cost - bound <= OPTIONS.proven * cost:
        is_best = "jerk"
    rate, acceleration, jerk = found.shares.tolist()
    return BodySlew(
        motion=found.motion,
        cost_rad2_s5=cost,
        bound_rad2_s5=bound,
        least_s=least / ROWS_PER_S,
        quickest_s=quickest_s,
        eigenaxis_s=eigenaxis.duration_s if keeps else None,
        is_best=is_best,
        shares=(rate, acceleration, jerk),
        run=found.run,
    )


def _quickest(
    problem: BodySlewProblem, least: int, eigenaxis: EigenaxisSlew
) -> tuple[float | None, _Tried]:
    """The least time found from two starts, and the slew on rows that comes next to one of them."""
    smoothest_at = cache(lambda row: _smoothest(problem.arriving_at(row)))
    if eigenaxis.duration_s > problem.available_s:
        tried = smoothest_at(problem.last_arrival_row)
        if tried.is_beyond(problem.available_s):
            return None, tried
    quickest = _least_times(problem, least, eigenaxis, smoothest_at)
    if not quickest:
        return None, smoothest_at(problem.last_arrival_row)
    quickest_s = min(motion.duration_s for motion in quickest)
    row = max(_row_from(quickest_s), least)
    for later in range(OPTIONS.later_rows):
        if row > problem.last_arrival_row:
            break
        with effort.finish():
            found = _next_to(quickest, eigenaxis, problem.arriving_at(row))
        if found is not None:
            return quickest_s, _Tried(found)
        row += 1 + later
    return quickest_s, smoothest_at(problem.last_arrival_row)


def _next_to(
    quickest: list[SpanMotion], eigenaxis: EigenaxisSlew, problem: BodySlewProblem
) -> _Found | None:
    """On rows, in the time given: the smoothest that switches next to where one of them does.

    Least times that last digits lead apart switch elsewhere, at more or less jerk.
    """
    found: _Found | None = None
    begun = [m for m in quickest if _row_from(m.duration_s) <= problem.first_arrival_row]
    for motion in [*begun, _in_phases(eigenaxis)]:
        found = _smoother(found, _on_rows(problem, motion))
    if found is None:
        return None
    shares = np.linspace(0.0, 1.0, _span_count(problem) + 1)
    return _smoother(found, _blended_on_rows(problem, shares))


def _least_times(
    problem: BodySlewProblem,
    least: int,
    eigenaxis: EigenaxisSlew,
    smoothest_at: Callable[[int], _Tried],
) -> list[SpanMotion]:
    """Motions of least time found from the eigenaxis slew and from a smooth one, if need be."""
    quickest: list[SpanMotion] = []
    if not problem.cones:
        found = _least_time(problem, least, _in_phases(eigenaxis))
        quickest += [found] if found else []
    if quickest and problem.is_rest_to_rest and problem.limits.kind == "magnitude":
        return quickest  # which is proven
    guess_s = quickest[0].duration_s if quickest else eigenaxis.duration_s
    for factor in OPTIONS.eased:
        row = min(math.ceil(factor * guess_s * ROWS_PER_S), problem.last_arrival_row)
        eased = smoothest_at(max(row, problem.first_arrival_row)).found
        if eased is not None:
            begin = eased.spans.on_spans(_even_widths_s(eased))
            with at_most(OPTIONS.again_share * effort.remaining()):
                found = _least_time(problem, least, begin)
                quickest += [found] if found else []
            return quickest
    return quickest


def _row_from(duration_s: float) -> int:
    """The first row after that time."""
    return math.ceil(duration_s * ROWS_PER_S - 1e-6)


def _smoother(one: _Found | None, other: _Found | None) -> _Found | None:
    """The first, unless the other has clearly less squared jerk: last digits don't decide."""
    if one is None or other is None:
        return one or other
    most = (1.0 - OPTIONS.proven) * one.spans.cost_rad2_s5
    return other if other.spans.cost_rad2_s5 < most else one


def _in_phases(eigenaxis: EigenaxisSlew) -> SpanMotion:
    """The same in the phases of its scalar slew."""
    least_s = OPTIONS.shortest_phase * eigenaxis.duration_s
    phase = np.maximum(np.diff(eigenaxis.angle_at.x), least_s)
    widths_s = np.repeat(phase, OPTIONS.spans // OPTIONS.phases)
    return eigenaxis.on_spans(widths_s * (eigenaxis.duration_s / widths_s.sum()))


def _even_widths_s(found: _Found) -> Array:
    duration_s = found.spans.duration_s
    return np.full(OPTIONS.spans, duration_s / OPTIONS.spans)


def _least_time(problem: BodySlewProblem, least: int, begin: SpanMotion) -> SpanMotion | None:
    """The least time that is found from here, with a jerk that may change at any time."""
    cap = math.ceil(OPTIONS.cap * begin.duration_s * ROWS_PER_S)
    last = min(max(cap, least + 1), problem.last_arrival_row)
    first = min(max(least - 1, problem.first_arrival_row), last - 1)
    if first < problem.first_arrival_row:
        return None
    found = solve(problem, begin, arrival_within(problem, first, last), phases=OPTIONS.phases)
    return found.motion if found.run.is_promising else None


def _smoothest(problem: BodySlewProblem) -> _Tried:
    """The least squared jerk found, in the time given, of all starts.

    Where the first of them fails in little time, the least time is sought, which may tell that
    there is none.
    """
    shares = np.linspace(0.0, 1.0, _span_count(problem) + 1)
    best: _Found | None = None
    tried: _Tried | None = None
    is_open = max(_end_rates(problem)) < OPTIONS.fast_end and _is_hasty(problem)
    if is_open and problem.objective == "any" and _is_quicker_than_eigenaxis(problem):
        tried = _next_to_least_time(problem)
        if tried.found or tried.is_beyond(problem.available_s):
            return tried
    is_clear = False  # a slew was found that no cone is in the way of
    for begin, is_bow in _starts(problem, _row_widths_s(shares, problem)):
        if is_bow and is_clear:
            break
        best = _smoother(best, _solve_on_rows(problem, begin))
        is_clear = best is not None and not is_bow
        if best is not None and (problem.objective == "any" or _is_smoothest(problem, best)):
            break
        if is_open and best is None and tried is None:
            tried = _next_to_least_time(problem)
            if tried.found or tried.is_beyond(problem.available_s):
                return tried
    if best is None and tried is None:
        # An end that moves nearly as fast as it may is left or met by a jerk that changes soon.
        best = _blended_on_rows(problem, (1.0 - np.cos(np.pi * shares)) / 2.0)
    return _Tried(best, tried.least_s if tried else None)


def _blended_on_rows(problem: BodySlewProblem, end_shares: Array) -> _Found | None:
    """From the first start of `_starts`, its spans ending at these shares of the time."""
    begin, _ = next(_starts(problem, _row_widths_s(end_shares, problem)))
    return _solve_on_rows(problem, begin)


def _is_smoothest(problem: BodySlewProblem, found: _Found) -> bool:
    """Whether no slew of as many rows has less squared jerk to speak of."""
    bound = least_cost_rad2_s5(problem, problem.first_arrival_row)
    return found.spans.cost_rad2_s5 - bound <= OPTIONS.proven * found.spans.cost_rad2_s5


def _is_quicker_than_eigenaxis(problem: BodySlewProblem) -> bool:
    """Whether no slew about the Euler axis that was found is as quick as is asked."""
    return problem.available_s < quickest_eigenaxis(problem)[0].duration_s


def _is_hasty(problem: BodySlewProblem) -> bool:
    """Whether the time given may be too short, rather than its ends too near to the limits."""
    resting_s = eigenaxis_slew(problem.at_rest(), problem.first_arrival_row).duration_s
    return problem.available_s < OPTIONS.hasty * resting_s


def _end_rates(problem: BodySlewProblem) -> list[float]:
    """Shares of the rate limit with which a slew to one row begins and ends."""
    none = np.zeros((1, 3))
    return [
        float(problem.limits.shares(BodyMotion(end.rate_rad_s, none, none))[0, 0])
        for end in (problem.start, problem.goal)
    ]


def _next_to_least_time(problem: BodySlewProblem) -> _Tried:
    """The least time in which its goal is reached as it is at its row, cones aside.

    And, without cones, a slew whose jerk switches where it does there, as it must next to it.
    """
    patient = problem.without_cones().with_patience(OPTIONS.patience_rows)
    least = _least_time(patient, 1, _in_phases(quickest_eigenaxis(patient)[0]))
    if least is None:
        return _Tried(None)
    is_near = OPTIONS.best_share * least.duration_s <= problem.available_s
    found = _on_rows(problem, least) if is_near and not problem.cones else None
    return _Tried(found, least.duration_s)


def _starts(problem: BodySlewProblem, widths_s: Array) -> Iterator[tuple[SpanMotion, bool]]:
    """Blends about the Euler axis with and without the ends' motions, past cones on each side.

    And whether it is a bow past a cone: from these many fail, at 200 iterations each, so that they
    come last.
    """
    row = problem.first_arrival_row
    duration_s = row / ROWS_PER_S
    problems = [problem] if problem.is_rest_to_rest else [problem, problem.at_rest()]
    blends = [
        eigenaxis_slew(one, row, duration_s=duration_s, smooth=True).on_spans(widths_s)
        for one in problems
    ]
    for ways in sorted((list(around_cones(problem, blend)) for blend in blends), key=len):
        yield from ((begin, len(ways) > 1) for begin in ways)


def _on_rows(problem: BodySlewProblem, quickest: SpanMotion) -> _Found | None:
    """The least jerk in the time given, switching on rows next to those of the least time."""
    phases = quickest.widths_s.reshape(OPTIONS.phases, -1).sum(axis=1) / quickest.duration_s
    size = _span_count(problem)
    counts = np.full(OPTIONS.phases, min(OPTIONS.least_spans, size // OPTIONS.phases))
    while counts.sum() < size:  # the longest are cut first: a step of attitude errs by its length
        counts[np.argmax(phases / counts)] += 1
    end_shares = np.append(0.0, np.cumsum(np.repeat(phases / np.maximum(counts, 1), counts)))
    if size < OPTIONS.phases:
        end_shares = np.linspace(0.0, 1.0, size + 1)
    begin = quickest.on_spans(_row_widths_s(end_shares, problem))
    return _solve_on_rows(problem, begin)


def _solve_on_rows(problem: BodySlewProblem, begin: SpanMotion) -> _Found | None:
    """The OCP's answer where it is flown within all limits."""
    row, n = problem.first_arrival_row, len(begin.widths_s)
    phases = OPTIONS.phases if n % OPTIONS.phases == 0 else n
    found = solve(
        problem,
        begin,
        arrival_within(problem, row, row),
        phases=phases,
        limit_share=OPTIONS.limit_share,
    )
    return _flown(problem, found) if found.run.is_promising else None


def _flown(problem: BodySlewProblem, found: SolvedBodySlew) -> _Found | None:
    motion = found.motion.on_rows(problem)
    looks = np.arange(OPTIONS.looks + 1) / OPTIONS.looks
    q_xyzw, body = between_rows(motion, looks)
    rows = BodyMotion(*(part.reshape(-1, 3) for part in body))
    shares = np.max(problem.limits.shares(rows), axis=0)
    if np.any(shares > 1.0 + OPTIONS.limit_tolerance):
        return None
    t_s = (np.arange(len(q_xyzw))[:, None] + looks).ravel() / ROWS_PER_S
    for cone in problem.cones:
        if np.any(depths_rad(cone, q_xyzw.reshape(-1, 4), centres_eci(cone, t_s)) > 0.0):
            return None
    return _Found(found.motion, motion, shares, found.run)


def _span_count(problem: BodySlewProblem) -> int:
    """As many as there are, or whole numbers of phases; a row each where there are few."""
    rows = min(problem.first_arrival_row, OPTIONS.spans)
    return rows - rows % OPTIONS.phases if rows >= OPTIONS.phases else rows


def _row_widths_s(end_shares: Array, problem: BodySlewProblem) -> Array:
    """Spans of whole rows, one at least, that end next to these shares of the time."""
    rows, n = problem.first_arrival_row, len(end_shares) - 1
    ends = np.round(end_shares * rows)
    order = np.arange(n + 1)
    ends = np.maximum.accumulate(ends - order) + order
    ends = np.minimum(ends, rows - n + order)
    return np.diff(ends) / ROWS_PER_S


def _refusal(problem: BodySlewProblem, least_s: float | None) -> InfeasibleSlew:
    """Of a slew that wasn't found; least_s: the least time found without cones, if any was."""
    if problem.cones:
        free = problem.without_cones()
        if _smoothest(free.arriving_at(free.last_arrival_row)).found is not None:
            names = ", ".join(cone.name for cone in problem.cones)
            return InfeasibleSlew(
                f"no slew of {problem.available_s:.1f} s was found that stays out of what is to be "
                f"avoided ({names}), though there is one without; give it more time, or choose "
                "another time or attitude",
                limit="exclusion",
            )
    last = problem.arriving_at(problem.last_arrival_row)
    if least_s is None and not _is_hasty(last):
        used = _end_rates(last)
        return InfeasibleSlew(
            f"no slew of {last.available_s:.1f} s was found: at its start the body turns at "
            f"{figures(used[0], 1.0)} of its rate limit, at its end at {figures(used[1], 1.0)}; "
            "begin and end it at other times, or slower",
            limit="rate",
        )
    return _too_short(problem, least_s, is_proof=False)


def _too_short(
    problem: BodySlewProblem, least_s: float | None = None, *, is_proof: bool
) -> InfeasibleSlew:
    """Of a slew with too little time: with the time it takes about, the goal as it is at last."""
    last = problem.arriving_at(problem.last_arrival_row)
    angle_deg = math.degrees(float(last.angles_rad[0]))
    patient, _, keeps = quickest_eigenaxis(last.with_patience(OPTIONS.patience_rows))
    there = eigenaxis_slew(last, last.first_arrival_row, duration_s=last.available_s)
    used = over_limits(last, there)
    order = int(np.argmax(used ** (1.0 / np.arange(1, 4))))
    found_s = least_s or (patient.duration_s if keeps else None)
    needs_rows = math.ceil((found_s or 0.0) * ROWS_PER_S - 1e-6)
    needs_s = max(needs_rows, last.first_arrival_row + 1) / ROWS_PER_S
    needed = f"about {needs_s:.1f} s" if found_s else f"more than {last.available_s:.1f} s"
    shown = "no slew fits" if is_proof else "no slew was found"
    refusal = InfeasibleSlew(
        f"the body needs {needed} to turn by {angle_deg:.4g} deg, but {last.available_s:.1f} s are "
        f"available, in which {shown} (about the Euler axis it would take {used[order]:.3g} of the "
        f"{ORDERS[order]} limit); begin the session later or start the slew nearer to it",
        limit="duration",
    )
    refusal.needs_s = needs_s if found_s else OPTIONS.later * last.available_s
    return refusal
