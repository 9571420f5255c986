"""The smoothest motion of one axis within its limits, and a proof of how near it is to the best.

`ocp` states and solves the slew on given knots.  What its limits are worth there
gives a lower bound for every motion, and says what each span adds to the gap: the spans that
add most are cut, up to the next size of `SIZES`, and it is solved again until the gap is closed.
For the command table knots lie on its rows.  While knots are sought PIQP may solve; the motion
that is handed back is Ipopt's.  Within, all is in normalised time: the motion lasts 1.
"""

import heapq
import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from planner.base import effort
from planner.base.arrays import Array, Indices, Mask
from planner.base.effort import WorkLimitReached
from planner.base.solvers import SolverRun, has_piqp
from planner.motion.slew.closed_forms import least_jerk_profile
from planner.motion.slew.feasibility import verdict
from planner.motion.slew.lower_bound import lower_bound
from planner.motion.slew.normalised import normalise_slew
from planner.motion.slew.ocp import Begin, Rows, Solved, SpanProgramme, Start, Vibration, solve
from planner.motion.slew.problem import AxisSlew
from planner.motion.slew.solution import AxisProfile, cells_that_break, cells_that_leave, obeys
from planner.motion.slew.spans import (
    BETWEEN,
    hull_between,
    jerk_cost,
    least_cost,
    meet_end,
    turning_shares,
    values_at,
    where_to_cut,
)
from planner.motion.slew.stops import braked_ends
from planner.motion.slew.vibration import (
    JERK_COST,
    WEIGHTS,
    residual_vibration_rows,
    wanted_residuals,
)

SIZES = (16, 40, 56, 80, 112, 160, 224, 320, 448)  # of spans: each has solvers, made once
GAP_WANTED = 3e-4  # of the cost: what is called optimal may be off three times as much
NOTHING = 1e-6  # of a cost in normalised time, 720 for an ordinary move: of what needn't move
FIRST_SPANS = 24
UNEVEN = 0.7  # of the first spans' widths follows a cosine, which is dense at the ends
HOLDING_ROUNDS, ROUNDS = 6, 12
NARROWEST = 3e-8
HELD = 5e-8  # of a range: what a known motion may pass a limit by
INSIDE = 3e-9  # of a limit's range, so that rounding doesn't break it
MULTIPLIER_SHARE = 1e-8  # of the cost for half a limit's range: less is the solver's rounding
DEAREST = 30.0  # times the quintic's cost: what scales the cost of a rough motion
HALVED = 1.0 / 16.0  # of a span's loss is left in each of its halves
MODE_SPANS, MODE_ROWS_MAX = 48, 250  # of so few rows all are needed to suppress modes
WEIGHINGS = 12  # of modes, one against another; all but a few slews need one
RESIDUAL_SHARE = 0.95  # of the residual that is wanted, so that rows don't exceed it
WEIGHT_CHANGES = (0.3, 3.0)  # least and most by which a mode's weight changes at once
HOPELESS = 20.0  # times the residual wanted: no weights have been seen to gain a tenfold
JUDGED, JUDGED_SPAN = 130, 1.0  # of `effort`: extremes and the proof, beside solving
SURE: tuple[Start, ...] = ("warm", "cold", "roomy")
NO_MODES = np.zeros(0)
MayFly = Callable[[AxisProfile], bool]


class Smoothest(NamedTuple):
    """lower_bound_rad2_s5: no motion between these states within these limits costs less.

    negligible_rad2_s5: a cost that is rounding.  run: of the solver, how this motion was solved.
    iterations: of Ipopt, in all.
    suppresses_modes: whether the slew's modes were suppressed, as far as its limits allow.
    """

    profile: AxisProfile
    lower_bound_rad2_s5: float
    negligible_rad2_s5: float
    run: SolverRun
    iterations: int
    suppresses_modes: bool = False


class _Grid(NamedTuple):
    """knots (n + 1,) of spans; flat_rows: those of constant jerk."""

    knots: Array
    flat_rows: Indices


class _Motion(NamedTuple):
    """A solved motion on n spans, accepted on its own extremes.

    given: the programme.  states (n + 1, 3), jerks (n, 2).  iterations: of Ipopt, in all tries.
    """

    grid: _Grid
    given: SpanProgramme
    states: Array
    jerks: Array
    profile: AxisProfile
    solved: Solved
    iterations: int

    @property
    def cost(self) -> float:
        """The integral of squared jerk."""
        return jerk_cost(self.given.widths, self.jerks)

    @property
    def left_of_modes(self) -> Array:
        """Residual vibration of each detuned mode, real parts and then imaginary ones."""
        return np.asarray(np.einsum("mnu,nu->m", self.given.vibration.maps, self.jerks))

    @property
    def is_ipopts(self) -> bool:
        """Whether it may be handed back."""
        return self.solved.run.name == "ipopt"


class _Losses(NamedTuple):
    """bound: on the cost of any motion.  by_span (n,): what each adds to the gap.  cuts (n,): where
    in it to cut, shares."""

    bound: float
    by_span: Array
    cuts: Array


def find_smoothest(
    slew: AxisSlew,
    known: AxisProfile | None,
    rows: int | None,
    *,
    may_fly: MayFly | None = lambda _: True,
    lower_bound_rad2_s5: float = 0.0,
) -> Smoothest | None:
    """The smoothest motion in exactly the slew's time; None where none is found.

    known: a motion with these ends within the limits, to begin at.  rows: in how many equal
    steps a cubic Hermite must fly the motion; None: the jerk may change anywhere.  may_fly: which
    motions would be flown, and so must be Ipopt's; None: none.  lower_bound_rad2_s5: one that is
    known already.
    avoid_modes of the slew are left as calm as the limits allow, see `slew.vibration`.
    """
    axis = _Axis(slew, rows, known)
    unit = axis.normal.cost_unit_rad2_s5
    is_first_flown = axis.is_unbound and not slew.avoid_modes and may_fly is not None
    starts = ("near", *SURE[1:]) if is_first_flown else _quick_options()
    best, bound, iterations = _place_knots(axis, lower_bound_rad2_s5 / unit, starts)
    calm = axis.calm_modes(best) if best is not None and slew.avoid_modes else None
    found = calm or best
    if found and not found.is_ipopts and may_fly is not None and may_fly(found.profile):
        with effort.finish():
            found = axis.solve_to_fly(found)
        iterations += found.iterations if found is not None else 0
    if found is None:
        return _with_braked_ends(slew, rows, may_fly)
    return Smoothest(
        found.profile,
        bound * unit,
        NOTHING * unit,
        found.solved.run,
        iterations,
        suppresses_modes=calm is not None,
    )


def _quick_options() -> tuple[Start, ...]:
    """How motions are solved that nobody flies."""
    return ("quick", "cold") if has_piqp() else SURE[1:]


def _place_knots(
    axis: "_Axis", bound: float, starts: tuple[Start, ...]
) -> tuple[_Motion | None, float, int]:
    """The best motion on knots that are added to until the gap is closed, its bound, iterations.

    Once one is found, the end of the work that may be done is no more than the end of bettering it.
    Where the quintic keeps the limits it is where to begin, and its cost the bound: a few spans
    come as near to it as is wanted.
    """
    best, iterations, bound = None, 0, max(bound, least_cost(axis.ends))
    begun = axis.known
    flat_rows = axis.rows_astray(begun)
    knots = axis.first_knots(begun, flat_rows)
    for _ in range(ROUNDS):
        try:
            motion = axis.solve_on(knots, flat_rows, begun, starts)
        except WorkLimitReached:
            if best is None:
                raise
            break
        if motion is None:
            break
        begun, iterations = motion.profile, iterations + motion.iterations
        allowed = GAP_WANTED * max(motion.cost, NOTHING)
        astray = np.setdiff1d(axis.rows_astray(begun), flat_rows)
        if not astray.size and motion.cost - bound <= allowed:
            best = motion
            break
        losses = axis.span_losses(motion)
        bound = max(bound, losses.bound)
        is_closed = min(motion.cost - bound, float(losses.by_span.sum())) <= allowed
        if not astray.size:
            is_stuck = (
                best is not None
                and len(best.grid.knots) == len(knots)
                and best.cost - motion.cost <= allowed
            )
            best = motion if best is None or motion.cost < best.cost else best
            if is_closed or is_stuck or len(knots) > SIZES[-1]:
                break
        flat_rows = np.union1d(flat_rows, astray)
        is_fine = is_closed or float(losses.by_span[axis.can_cut(knots)].sum()) <= allowed
        spans = len(motion.jerks) + (not is_fine)
        knots = axis.refined(motion, losses, astray, at_least=spans)
    return best, bound, iterations


def _with_braked_ends(slew: AxisSlew, rows: int | None, may_fly: MayFly | None) -> Smoothest | None:
    """Braked at the ends, and the smoothest between.

    Where an end all but determines how the axis leaves or reaches it, no motion near it is left
    to search among.
    """
    ends = braked_ends(slew)
    if ends is None or ends.rows >= (rows or math.inf) or ends.free.duration_s <= 0.0:
        return None
    possible = verdict(ends.free.start, ends.free.end, slew.limits, ends.free.duration_s)
    if possible.limit is not None:
        return None
    flown = may_fly if rows is None else None
    flies = flown and (lambda profile: flown(ends.around(profile)))
    between = find_smoothest(ends.free, possible.profile, None, may_fly=flies)
    if between is not None and rows is not None:
        between = find_smoothest(ends.free, between.profile, rows - ends.rows)
    if between is None:
        return None
    profile = ends.around(between.profile)
    if not obeys(profile, slew.start, slew.end, slew.limits):
        return None
    return between._replace(profile=profile, lower_bound_rad2_s5=bound_without_contacts(slew))


def bound_without_contacts(slew: AxisSlew) -> float:
    """A lower bound of the cost, rad^2/s^5, that knows of the jerk's limit alone."""
    axis = _Axis(slew, None, None)
    knots = np.linspace(0.0, 1.0, FIRST_SPANS + 1)
    _, jerks = axis.sample_at_knots(axis.known, knots)
    bound, _ = lower_bound(axis.ends, axis.limits, np.zeros((0, 3)), knots, jerks)
    return bound * axis.normal.cost_unit_rad2_s5


class _Axis:
    """One axis's slew on spans, in normalised time; on rows where these are given.

    known: to begin at, else the quintic, the motion of least squared jerk without limits.
    is_unbound: the quintic itself is known to keep the limits.
    """

    def __init__(self, slew: AxisSlew, rows: int | None, known: AxisProfile | None) -> None:
        self.slew, self.rows = slew, rows
        self.normal = normalise_slew(slew)
        self.ends, self.limits = self.normal.ends, self.normal.limits
        quintic = least_jerk_profile(slew.start, slew.end, slew.duration_s)
        self.known = known or quintic
        self.is_unbound = known is not None and np.array_equal(
            known.coefficients, quintic.coefficients
        )

    def solve_on(
        self,
        knots: Array,
        flat_rows: Indices,
        begun: AxisProfile,
        starts: tuple[Start, ...],
        calm: Array = NO_MODES,
    ) -> _Motion | None:
        """The motion on these knots, by the first solver whose answer obeys its limits.

        calm: weights of what is left of the detuned modes.
        """
        widths = np.diff(knots)
        states, jerks = self.sample_at_knots(begun, knots)
        rows = None
        if self.rows is not None:
            middle = ((knots[1:] + knots[:-1]) / 2.0 * self.rows).astype(int)
            flat = ~self.can_cut(knots) & np.isin(middle, flat_rows)
            rows = Rows(flat, turning_shares(states))
            jerks = np.where(flat[:, None], jerks.mean(axis=1, keepdims=True), jerks)
        inset = INSIDE * np.ptp(self.limits, axis=1)[:, None] * np.array([1.0, -1.0])
        maps = np.zeros((0, len(widths), 2))
        if calm.size:
            left = residual_vibration_rows(knots, self.slew.duration_s, self.slew.avoid_modes)
            maps = np.concatenate([left.real, left.imag])
        vibration = Vibration(maps, np.tile(calm, 2))
        rough = min(jerk_cost(widths, jerks), DEAREST * least_cost(self.ends))
        weight = 1.0 / max(rough, NOTHING)
        given = SpanProgramme(widths, self.ends, self.limits + inset, rows, vibration, weight)
        grid, begin = _Grid(knots, flat_rows), Begin(states, jerks)
        found = self._by_first(grid, given, begin, starts)
        if found is None and rows is not None:
            halfway = given._replace(rows=rows._replace(turns=np.full_like(rows.turns, 0.5)))
            found = self._by_first(grid, halfway, begin, starts)
        return found

    def solve_to_fly(self, motion: _Motion) -> _Motion | None:
        """Solve by Ipopt, begun there.

        Solvers differ in the last digits: a row that only now goes astray gets a constant jerk.
        """
        given, begin = motion.given, Begin(motion.states, motion.jerks, motion.solved.answer)
        found = self._by_first(motion.grid, given, begin, SURE)
        while found is not None:
            knots, flat_rows = found.grid
            astray = np.setdiff1d(self.rows_astray(found.profile), flat_rows)
            if not astray.size:
                break
            knots = self._fill_knots(np.union1d(knots, self._row_edges(astray)))
            calm = np.split(given.vibration.weights, 2)[0]
            flat_rows = np.union1d(flat_rows, astray)
            found = self.solve_on(knots, flat_rows, found.profile, SURE[1:], calm)
        return found

    def _by_first(
        self, grid: _Grid, given: SpanProgramme, begin: Begin, starts: tuple[Start, ...]
    ) -> _Motion | None:
        jerk_max, iterations = self.limits[3, 1], 0
        flat = np.zeros(len(given.widths), bool) if given.rows is None else given.rows.flat
        for start in starts:
            solved = solve(given, begin, start)
            effort.count(JUDGED + JUDGED_SPAN * len(flat))
            iterations += solved.run.iterations
            if not solved.run.is_promising:
                continue
            jerks = np.clip(solved.jerks, -jerk_max, jerk_max)
            states, jerks = meet_end(given.widths, flat, self.ends, jerk_max, jerks)
            profile = self.normal.profile(grid.knots, flat, states, jerks)
            if obeys(profile, self.slew.start, self.slew.end, self.slew.limits):
                return _Motion(grid, given, states, jerks, profile, solved, iterations)
        return None

    def span_losses(self, motion: _Motion) -> _Losses:
        """What each span adds to the gap.

        The squared distance of its jerk from the costate's, unless it can't be cut, and what a
        bound on a coefficient holds back where the motion itself is still away from the limit.
        """
        _, multipliers, orders, places, _ = motion.solved
        widths, limits = motion.given.widths, self.limits[orders]
        worth = np.abs(multipliers) * np.ptp(limits, axis=1) / 2.0
        counted = worth > MULTIPLIER_SHARE * motion.cost
        at = motion.grid.knots[:-1, None] + places * widths[:, None]
        of_order = np.broadcast_to(orders, at.shape)
        contacts = np.column_stack([at[counted], of_order[counted], multipliers[counted]])
        bound, missed = lower_bound(
            self.ends, self.limits, contacts, motion.grid.knots, motion.jerks
        )
        values = values_at(widths, motion.states, motion.jerks, places, orders)
        reached = np.where(multipliers > 0.0, limits[:, 1], limits[:, 0])
        held_back = 2.0 * np.where(counted, multipliers * (reached - values), 0.0).sum(axis=1)
        by_span = np.where(self.can_cut(motion.grid.knots), missed, 0.0) + held_back
        active = np.abs(multipliers) * (places > 0.0)
        by_order = np.column_stack([active[:, orders == order].sum(axis=1) for order in (0, 1)])
        return _Losses(bound, by_span, where_to_cut(motion.states, by_order > 0.0))

    def calm_modes(self, motion: _Motion) -> _Motion | None:
        """What leaves the modes calmest, with weights shifted towards those that ring too much.

        None where no motion is found; the best so far where the work that may be done ends.
        Source: Lawson 1961, the least greatest residual by least squares weighed anew.
        """
        slew, rows = self.slew, self.rows
        spans = rows if rows is not None and rows <= MODE_ROWS_MAX else MODE_SPANS
        knots = self._fill_knots(np.union1d(motion.grid.knots, np.linspace(0.0, 1.0, spans + 1)))
        wanted = RESIDUAL_SHARE * wanted_residuals(self.ends, slew.duration_s, slew.avoid_modes)
        weights = np.resize(WEIGHTS, len(wanted)) * JERK_COST
        best, least_share, begun = None, math.inf, motion.profile
        # Modes feel what is flown: exactly the motion, where the jerk is constant on a row.
        single = knots[:-1][~self.can_cut(knots)]
        flat_rows = np.union1d(motion.grid.flat_rows, np.rint(single * (rows or 1)).astype(np.intp))
        for _ in range(WEIGHINGS):
            try:
                found = self.solve_on(knots, flat_rows, begun, _quick_options(), weights)
            except WorkLimitReached:
                if best is None:
                    raise
                break
            if found is None:
                break
            begun = found.profile
            astray = np.setdiff1d(self.rows_astray(begun), flat_rows)
            if astray.size:
                flat_rows = np.union1d(flat_rows, astray)
                knots = self._fill_knots(np.union1d(knots, self._row_edges(astray)))
                continue
            shares = np.hypot(*np.split(found.left_of_modes, 2)) / wanted
            if shares.max() < least_share:
                best, least_share = found, float(shares.max())
            if not 1.0 < shares.max() < HOPELESS:
                break
            weights = weights * np.clip(shares, *WEIGHT_CHANGES)
        return best

    def sample_at_knots(self, known: AxisProfile, knots: Array) -> tuple[Array, Array]:
        """States (n + 1, 3) of a known motion at the knots, jerks (n, 2) just within each span.

        What it does on stretches too short for a knot is in the mean of the jerks.
        """
        T, widths = self.slew.duration_s, np.diff(knots)
        inside = np.column_stack([knots[:-1] + 1e-6 * widths, knots[1:] - 1e-6 * widths])
        units = T ** np.arange(4)[:, None] / self.normal.scale_rad
        states = (np.array(known.evaluate(knots * T)) * units)[:3].T
        states[:, 0] -= self.normal.start_angle_rad / self.normal.scale_rad
        jerks = (np.array(known.evaluate(inside.ravel() * T)) * units)[3].reshape(inside.shape)
        missed = np.diff(states[:, 2]) / widths - jerks.mean(axis=1)
        jerk_max = self.limits[3, 1]
        return states, np.clip(jerks + missed[:, None], -jerk_max, jerk_max)

    def rows_astray(self, profile: AxisProfile) -> Indices:
        """Rows after which the Hermite breaks a limit or leaves the motion."""
        if self.rows is None:
            return np.zeros(0, dtype=np.intp)
        breaking = cells_that_break(profile, self.rows, self.slew.limits)
        return np.union1d(breaking, cells_that_leave(profile, self.rows))

    def first_knots(self, known: AxisProfile, flat_rows: Indices) -> Array:
        """Where a known motion changes its jerk, and such that its hulls keep its limits."""
        knots = known.breakpoints_s / known.duration_s
        if self.rows is not None:
            return self._fill_knots(np.union1d(knots, self._row_edges(flat_rows)))
        if not self.is_unbound:
            x = np.linspace(0.0, 1.0, FIRST_SPANS + 1)
            uneven = (1.0 - UNEVEN) * x + UNEVEN * (1.0 - np.cos(np.pi * x)) / 2.0
            knots = self._space_knots(np.union1d(knots, uneven))
        knots = self._fill_knots(knots)
        for _ in range(HOLDING_ROUNDS):
            states, jerks = self.sample_at_knots(known, knots)
            low, high = self.limits[BETWEEN[0]].T
            hull = hull_between(np.diff(knots), states, jerks)
            over = np.maximum(hull - high, low - hull) > HELD * (high - low)
            is_cut = over.any(axis=1) & (np.diff(knots) > 4.0 * NARROWEST)
            if not is_cut.any() or len(knots) > SIZES[-1]:
                break
            by_order = np.column_stack(
                [over[:, BETWEEN[0] == order].any(axis=1) for order in (0, 1)]
            )
            cuts = knots[:-1] + where_to_cut(states, by_order) * np.diff(knots)
            knots = np.union1d(knots, cuts[is_cut])
        return self._fill_knots(knots)

    def refined(self, motion: _Motion, losses: _Losses, astray: Indices, *, at_least: int) -> Array:
        """The motion's knots and those of rows astray, and more where most is lost."""
        knots = np.union1d(motion.grid.knots, self._row_edges(astray))
        owner = np.searchsorted(motion.grid.knots, (knots[1:] + knots[:-1]) / 2.0) - 1
        share = np.diff(knots) / motion.given.widths[owner]
        cuts = np.where(share > 0.99, losses.cuts[owner], 0.5)
        least = max(at_least, len(knots) - 1)
        return self._halve_spans(knots, least, losses.by_span[owner] * share**4, cuts)

    def can_cut(self, knots: Array) -> Mask:
        """Which spans are longer than a row."""
        return np.asarray(np.diff(knots) * (self.rows or math.inf) > 1.5)

    def _fill_knots(self, knots: Array) -> Array:
        """Add knots up to the next size: the widest spans are cut."""
        knots = self._space_knots(knots)
        n = len(knots) - 1
        return self._halve_spans(knots, n, np.diff(knots), np.full(n, 0.5))

    def _halve_spans(self, knots: Array, at_least: int, scores: Array, cuts: Array) -> Array:
        """Knots of the next size: spans of the greatest score are cut, again and again."""
        size = next((size for size in SIZES if size >= at_least), at_least)
        heap = list(zip(-scores, knots[:-1], knots[1:], cuts, strict=True))
        heapq.heapify(heap)
        more: list[float] = []
        while len(knots) - 1 + len(more) < size and heap:
            score, begin, end, share = heapq.heappop(heap)
            cut = begin + share * (end - begin)
            if self.rows is not None:
                first, last = round(begin * self.rows), round(end * self.rows)
                cut = min(max(round(cut * self.rows), first + 1), last - 1) / self.rows
            if cut - begin < NARROWEST or end - cut < NARROWEST:
                continue
            for part in ((begin, cut), (cut, end)):
                heapq.heappush(heap, (score * HALVED, *part, 0.5))
            more.append(cut)
        return np.union1d(knots, more)

    def _space_knots(self, knots: Array) -> Array:
        """Sorted knots, on rows or at least NARROWEST apart."""
        if self.rows is not None:
            return np.asarray(np.unique(np.round(knots * self.rows)) / self.rows)
        return np.append(0.0, knots[1:][np.diff(knots) > NARROWEST])

    def _row_edges(self, rows: Indices) -> Array:
        """Where rows begin and end."""
        return np.asarray(np.union1d(rows, rows + 1) / (self.rows or 1))
