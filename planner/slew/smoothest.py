"""The smoothest motion of one axis within its limits, and a proof of how near it is to the best.

The optimum's jerk is a quadratic of time less pushes of the contacts with limits, cut off at
its limit.  A jerk that is linear on spans, angle, rate and acceleration held within their
limits by their Bernstein coefficients, comes as near to it as the spans allow.  The pushes that
the solver finds give a lower bound for every motion; the gap to it is the sum of what each span
loses, so the spans that lose most are cut, until the gap is closed.  Within, all is in
normalised time: the motion lasts 1.
"""

import math
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np

from planner import effort
from planner.arrays import Array, Mask
from planner.slew.braking import braked_ends
from planner.slew.closed_forms import least_jerk_profile
from planner.slew.feasibility import verdict
from planner.slew.flown import cells_that_break, cells_that_leave
from planner.slew.interior_point import ORDERS, bounded_values, least_jerk
from planner.slew.jerk_spans import jerk_cost, meet_end, trajectory
from planner.slew.lower_bound import lower_bound
from planner.slew.normalised import NormalisedSlew, normalised
from planner.slew.problem import AxisSlew
from planner.slew.solution import AxisProfile, obeys
from planner.slew.vibration import JERK_COST, WEIGHTS, modal_echoes, wanted_residuals

GAP_WANTED = 3e-4  # of the cost: what is called optimal may be off three times as much
FIRST_SPANS = 32
UNEVEN = 0.7  # of the first spans' widths follows a cosine, which is dense at the ends
ROUNDS = 20
HOLDING_ROUNDS = 6
ROWS_AROUND = 6
NARROWEST = 3e-8
HELD = 1e-7  # of half a range: what a known motion may pass a limit by
INSIDE = 3e-9  # of a limit's range, so that rounding doesn't break it
PUSH_SHARE = 1e-8  # of the cost for passing half a limit's range: less is the solver's rounding
DEEP = 100.0  # times what a span may lose: it is cut in four
LOSS_SHARE = 0.02  # of the greatest loss: spans that lose less are left as they are
MODE_SPANS, MODE_ROWS_MAX = 48, 250  # of so few rows all are needed to spare modes
WEIGHINGS = 12  # of modes, one against another; all but a few slews need one
RESIDUAL_SHARE = 0.95  # of the residual that is wanted, so that rows don't exceed it
WEIGHT_CHANGES = (0.3, 3.0)  # least and most by which a mode's weight changes at once
HOPELESS = 20.0  # times the residual wanted: no weights have been seen to gain a tenfold
SPANS_MAX = 2000  # which no more are cut, whatever the gap: a round takes half a second then
# Of `planner.effort`: a solve, an iteration on a span, and more of it for each echo of a mode, and
# for each pair of them; a span in the proof, and each contact's part of it.
SOLVE, ITERATION_SPAN, ECHO, ECHO_PAIR = 40, 0.08, 0.006, 0.0007
PROOF_SPAN, PROOF_CONTACT = 2.0, 0.0015
# Where each of `least_jerk`'s bounds holds, as a share of the span: a Bernstein coefficient's own
# place (Greville abscissa).
_AT = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 1 / 4, 1 / 2, 3 / 4, 1 / 3, 2 / 3, 1 / 2])
_NO_ECHOES = np.zeros(0)


class Smoothest(NamedTuple):
    """lower_bound_rad2_s5: no motion between these states within these limits costs less.

    spares_modes: whether the slew's modes were spared, as far as its limits allow.
    """

    profile: AxisProfile
    lower_bound_rad2_s5: float
    iterations: int
    spares_modes: bool = False


class _Motion(NamedTuple):
    """A solved motion on its knots, in normalised time; pushes (n, 11) at places (n, 11)."""

    knots: Array
    flat: Mask
    places: Array
    states: Array
    jerks: Array
    pushes: Array
    iterations: int


def smoothest(slew: AxisSlew, known: AxisProfile | None, rows: int | None) -> Smoothest | None:
    """The smoothest motion in exactly the slew's time; None where none is found.

    known: a motion with these ends within the limits, to begin at.  rows: in how many equal
    steps the jerk may change only between them, on spans of one step not at all within; a cubic
    Hermite through the rows then flies the motion.  avoid_modes of the slew are left as calm as
    the limits allow, see `planner.slew.vibration`.
    """
    problem, begun = normalised(slew), known or _without_limits(slew)
    found = _from_knots(problem, slew, begun, _first_knots(problem, begun, rows), rows)
    if found is None and rows is not None:
        found = _from_knots(problem, slew, begun, _knots_around(problem, begun, rows), rows)
    return found or _with_braked_ends(slew, rows)


def _with_braked_ends(slew: AxisSlew, rows: int | None) -> Smoothest | None:
    """Braked at the ends, and the smoothest between.

    Where an end all but determines how the axis leaves or reaches it, no motion near it is left
    to search among.
    """
    ends = braked_ends(slew)
    if ends is None or ends.rows >= (rows or math.inf) or ends.free.duration_s <= 0.0:
        return None
    possible = verdict(ends.free.start, ends.free.end, slew.limits, ends.free.duration_s)
    between = None if possible.limit else smoothest(ends.free, possible.profile, None)
    if between is not None and rows is not None:
        between = smoothest(ends.free, between.profile, rows - ends.rows)
    if between is None:
        return None
    profile = ends.around(between.profile)
    if not obeys(profile, slew.start, slew.end, slew.limits):
        return None
    return Smoothest(profile, bound_without_contacts(slew), between.iterations)


def _from_knots(
    problem: NormalisedSlew,
    slew: AxisSlew,
    known: AxisProfile,
    knots: Array,
    rows: int | None,
) -> Smoothest | None:
    found = _solve(problem, known, knots, rows)
    if found is None:
        return None
    motion, bound = found
    solve, calm = _on_knots, None
    if slew.avoid_modes:
        spans = rows if rows is not None and rows <= MODE_ROWS_MAX else MODE_SPANS
        knots = _spaced(np.union1d(motion.knots, np.linspace(0.0, 1.0, spans + 1)), rows)
        calm = _calmest(problem, knots, rows, _guess(problem, motion, knots), slew)
        if calm is not None:
            motion, solve = calm, partial(_calmest, slew=slew)
    if rows is not None:
        carried = _carried(problem, slew, motion, rows, solve)
        if carried is None:
            return None
        motion = carried
    profile = _profile(problem, motion)
    if not obeys(profile, slew.start, slew.end, slew.limits):
        return None
    bound_rad2_s5 = bound * problem.cost_unit_rad2_s5
    return Smoothest(profile, bound_rad2_s5, motion.iterations, spares_modes=calm is not None)


def bound_without_contacts(slew: AxisSlew) -> float:
    """A lower bound of the cost, rad^2/s^5, that knows of the jerk's limit alone."""
    problem = normalised(slew)
    knots = np.linspace(0.0, 1.0, FIRST_SPANS + 1)
    jerks, _ = _known(problem, _without_limits(slew), knots)
    bound, _ = lower_bound(problem.ends, problem.limits, np.zeros((0, 3)), knots, jerks)
    return bound * problem.cost_unit_rad2_s5


def _without_limits(slew: AxisSlew) -> AxisProfile:
    return least_jerk_profile(slew.start, slew.end, slew.duration_s)


def _profile(problem: NormalisedSlew, motion: _Motion) -> AxisProfile:
    return problem.profile(motion.knots, motion.flat, motion.states, motion.jerks)


def _solve(
    problem: NormalisedSlew, known: AxisProfile, knots: Array, rows: int | None
) -> tuple[_Motion, float] | None:
    """The motion and its lower bound, on knots that are added to until the gap is closed."""
    best: _Motion | None = None
    bound, iterations = 0.0, 0
    guess, _ = _known(problem, known, knots)
    for _ in range(ROUNDS):
        motion = _on_knots(problem, knots, rows, guess)
        if motion is None:
            break
        iterations += motion.iterations
        best, cost = motion, _cost(motion)
        proven, losses = _losses(problem, motion)
        bound = max(bound, proven)
        if min(cost - bound, losses[~motion.flat].sum()) <= GAP_WANTED * cost:
            break
        cut = losses > np.maximum(GAP_WANTED * cost / len(losses), LOSS_SHARE * losses.max()) / 3.0
        cuts = _cuts(knots, motion.states, np.abs(motion.pushes), rows)
        deep = losses > DEEP * GAP_WANTED * cost / len(losses)
        quarters = np.column_stack([(knots[:-1] + cuts) / 2.0, (knots[1:] + cuts) / 2.0])[deep]
        finer = _spaced(np.union1d(knots, np.append(cuts[cut], quarters)), rows)
        if len(finer) == len(knots) or len(finer) > max(SPANS_MAX, rows or 0):
            break
        guess = _guess(problem, motion, finer)
        knots = finer
    return None if best is None else (best._replace(iterations=iterations), bound)


def _first_knots(problem: NormalisedSlew, known: AxisProfile, rows: int | None) -> Array:
    """Knots on which a known motion keeps what bounds it on each span."""
    x = np.linspace(0.0, 1.0, FIRST_SPANS + 1)
    even = (1.0 - UNEVEN) * x + UNEVEN * (1.0 - np.cos(np.pi * x)) / 2.0
    knots = _spaced(np.union1d(even, known.breakpoints_s / known.duration_s), rows)
    for _ in range(HOLDING_ROUNDS):
        jerks, states = _known(problem, known, knots)
        values = bounded_values(np.diff(knots), states, problem.limits, jerks)
        excess = np.maximum(np.abs(values) - 1.0 - HELD, 0.0)
        cuts = _cuts(knots, states, excess, rows)[excess.any(axis=1)]
        finer = _spaced(np.union1d(knots, cuts), rows)
        if len(finer) == len(knots):
            break
        knots = finer
    return knots


def _knots_around(problem: NormalisedSlew, known: AxisProfile, rows: int) -> Array:
    """Knots on the rows near those where the jerk would change at any time.

    Within a row or so of the least time it must change on the right ones.
    """
    around = np.arange(-ROWS_AROUND, ROWS_AROUND + 1) / rows
    changes = known.breakpoints_s[:, None] / known.duration_s + around
    knots = _first_knots(problem, known, rows)
    return _spaced(np.union1d(knots, np.clip(changes, 0.0, 1.0)), rows)


def _spaced(knots: Array, rows: int | None) -> Array:
    """Sorted knots, on rows or at least NARROWEST apart."""
    if rows is not None:
        return np.asarray(np.unique(np.round(knots * rows)) / rows)
    knots = knots[np.append(np.diff(knots) > NARROWEST, True)]
    knots[0] = 0.0
    return np.asarray(knots)


def _known(problem: NormalisedSlew, known: AxisProfile, knots: Array) -> tuple[Array, Array]:
    """Jerks (n, 2) of a known motion just within each span, states (n + 1, 3) at the knots.

    What it does on stretches too short for a knot is in the mean of the jerks.
    """
    widths = np.diff(knots)
    inside = np.column_stack([knots[:-1] + 1e-6 * widths, knots[1:] - 1e-6 * widths])
    units = problem.duration_s ** np.arange(4)[:, None] / problem.scale_rad
    T = problem.duration_s
    states = (np.array(known.evaluate(knots * T)) * units)[:3].T
    states[:, 0] -= problem.start_angle_rad / problem.scale_rad
    jerks = (np.array(known.evaluate(inside.ravel() * T)) * units)[3].reshape(inside.shape)
    missed = np.diff(states[:, 2]) / widths - jerks.mean(axis=1)
    jerk_max = problem.limits[3, 1]
    return np.clip(jerks + missed[:, None], -jerk_max, jerk_max), states


def _guess(problem: NormalisedSlew, motion: _Motion, knots: Array) -> Array:
    """The motion's jerks on finer knots, a little within their limit."""
    owner = np.searchsorted(motion.knots, (knots[:-1] + knots[1:]) / 2.0) - 1
    begin, width = motion.knots[owner], np.diff(motion.knots)[owner]
    early, late = motion.jerks[owner].T
    jerks = [early + (at - begin) / width * (late - early) for at in (knots[:-1], knots[1:])]
    return np.column_stack(jerks)


def _on_knots(
    problem: NormalisedSlew,
    knots: Array,
    rows: int | None,
    guess: Array,
    echoes: Array | None = None,
    weights: Array = _NO_ECHOES,
) -> _Motion | None:
    widths = np.diff(knots)
    flat = _flat(knots, rows)
    inner = problem.limits + INSIDE * np.ptp(problem.limits, axis=1)[:, None] * np.array(
        [1.0, -1.0]
    )
    if echoes is None:
        echoes = np.zeros((0, len(widths), 2))
    jerks, pushes, turns, iterations, converged = least_jerk(
        widths, flat, problem.ends, inner, echoes, weights, guess
    )
    effort.spend(SOLVE)
    a_span = ITERATION_SPAN + len(echoes) * (ECHO + ECHO_PAIR * len(echoes))
    effort.count(iterations * len(widths) * a_span)
    if not converged:
        return None
    jerk_max = problem.limits[3, 1]
    jerks = meet_end(widths, flat, problem.ends, jerk_max, np.clip(jerks, -jerk_max, jerk_max))
    if rows is not None:
        jerks = np.where(flat[:, None], jerks.mean(axis=1, keepdims=True), jerks)
    states = trajectory(widths, flat, problem.ends[0], jerks)
    places = np.tile(_AT, (len(widths), 1))
    places[flat, 6], places[flat, 8] = turns[flat].T
    return _Motion(knots, flat, places, states, jerks, pushes, iterations)


def _flat(knots: Array, rows: int | None) -> Mask:
    """Which spans are single rows, on which the jerk is constant."""
    return np.asarray(np.diff(knots) * (rows or 0) < 1.5) & (rows is not None)


def _cost(motion: _Motion) -> float:
    return jerk_cost(np.diff(motion.knots), motion.jerks)


def _losses(problem: NormalisedSlew, motion: _Motion) -> tuple[float, Array]:
    """The lower bound, and what each span adds to the gap, (n,).

    A span loses the squared distance of its jerk from the costate's, and what a bound on a
    Bernstein coefficient holds back where the motion itself is still away from the limit.
    """
    widths, pushes, limits = np.diff(motion.knots), motion.pushes, problem.limits
    after = motion.places * widths[:, None]
    early, slope = motion.jerks[:, :1], np.diff(motion.jerks, axis=1) / widths[:, None]
    angle, rate, acceleration = (motion.states[:-1, order, None] for order in range(3))
    values = np.where(
        ORDERS == 0,
        angle
        + after * (rate + after * (acceleration / 2 + after * (early / 6 + after * slope / 24))),
        np.where(
            ORDERS == 1,
            rate + after * (acceleration + after * (early / 2 + after * slope / 6)),
            acceleration + after * (early + after * slope / 2),
        ),
    )
    reached = np.where(pushes > 0.0, limits[ORDERS, 1], limits[ORDERS, 0])
    counted = np.abs(pushes) * np.ptp(limits, axis=1)[ORDERS] / 2.0 > PUSH_SHARE * _cost(motion)
    counted[:, 3:5] = False
    span, row = np.nonzero(counted)
    contacts = np.column_stack(
        [motion.knots[span] + after[span, row], ORDERS[row], pushes[span, row]]
    )
    effort.count(len(widths) * (PROOF_SPAN + PROOF_CONTACT * len(contacts)))
    bound, missed = lower_bound(problem.ends, limits, contacts, motion.knots, motion.jerks)
    held_back = 2.0 * np.where(counted, pushes * (reached - values), 0.0).sum(axis=1)
    return bound, missed + held_back


def _cuts(knots: Array, states: Array, pushed: Array, rows: int | None) -> Array:
    """Where to cut each span, (n,): where what is pushed (n, 11) turns, or in the middle.

    On rows at least one row from either end, where the span has more than one.
    """
    at = np.full(len(pushed), 0.5)
    for order, bounds in ((0, slice(5, 8)), (1, slice(8, 10))):
        before, after = states[:-1, order + 1], states[1:, order + 1]
        turns = (before * after < 0.0) & (pushed[:, bounds].sum(axis=1) > 0.0)
        share = before / np.where(turns, before - after, 1.0)
        at = np.where(turns & (share > 0.1) & (share < 0.9), share, at)
    begin, end = knots[:-1], knots[1:]
    cuts = begin + at * (end - begin)
    return cuts if rows is None else np.clip(cuts, begin + 1.0 / rows, end - 1.0 / rows)


def _carried(
    problem: NormalisedSlew,
    slew: AxisSlew,
    motion: _Motion,
    rows: int,
    solve: Callable[[NormalisedSlew, Array, int | None, Array], _Motion | None],
) -> _Motion | None:
    """With spans of single rows where the Hermite through the rows of longer ones goes astray."""
    for _ in range(ROUNDS):
        profile = _profile(problem, motion)
        astray = np.union1d(
            cells_that_break(profile, rows, slew.limits), cells_that_leave(profile, rows)
        )
        if not astray.size:
            return motion
        span = np.searchsorted(motion.knots, (astray + 0.5) / rows) - 1
        begin, end = (np.rint(motion.knots[span + late] * rows).astype(int) for late in (0, 1))
        every = [np.arange(first, last) / rows for first, last in zip(begin, end, strict=True)]
        knots = _spaced(np.concatenate([motion.knots, *every]), rows)
        if len(knots) == len(motion.knots):
            return None
        finer = solve(problem, knots, rows, _guess(problem, motion, knots))
        if finer is None:
            return None
        motion = finer._replace(iterations=motion.iterations + finer.iterations)
    return None


def _calmest(
    problem: NormalisedSlew, knots: Array, rows: int | None, guess: Array, slew: AxisSlew
) -> _Motion | None:
    """What leaves the modes calmest, with weights shifted towards those that ring too much.

    None where no motion is found.
    Source: Lawson 1961, the least greatest residual by least squares weighed anew.
    """
    echoes = modal_echoes(knots, slew.duration_s, slew.avoid_modes)
    flat = _flat(knots, rows)
    echoes[:, flat] = echoes[:, flat].mean(axis=2, keepdims=True)
    real = np.concatenate([echoes.real, echoes.imag])
    wanted = wanted_residuals(problem.ends, slew.duration_s, slew.avoid_modes)
    weights = np.resize(WEIGHTS, len(echoes)) * JERK_COST
    best, least_share = None, np.inf
    for _ in range(WEIGHINGS):
        motion = _on_knots(problem, knots, rows, guess, real, np.tile(weights, 2))
        if motion is None or not obeys(
            _profile(problem, motion), slew.start, slew.end, slew.limits
        ):
            break
        left = np.abs(np.einsum("enu,nu->e", echoes, motion.jerks))
        shares = left / (RESIDUAL_SHARE * wanted)
        if shares.max() < least_share:
            best, least_share = motion, float(shares.max())
        if not 1.0 < shares.max() < HOPELESS:
            break
        weights = weights * np.clip(shares, *WEIGHT_CHANGES)
    return best
