"""The slew of one axis as an optimal control problem, stated once in CasADi.

    least      integral of squared jerk, and what is left of structural modes
    such that  angle' = rate, rate' = acceleration, acceleration' = jerk,
               the first and the last state are the given ones, and
               angle, rate, acceleration and jerk keep their limits at every instant

The jerk is linear on spans of time, so a span's motion is known exactly: no integrator, no
error.  The angle is then a polynomial on each span, and a polynomial stays within the hull of
its Bernstein coefficients: limits on these hold at every instant, not at samples.

For the command table spans begin and end on its rows.  A span of a single row can't be cut, so
that its hull may stand off from the motion: there the polynomial is split where it turned in
the motion before (de Casteljau).  Both halves are hulls whatever the place, so a poor one costs
a little and breaks nothing.  Where the cubic Hermite that is flown from rows would go astray,
the jerk is constant on a row, which the Hermite flies exactly.

All in normalised time: the motion lasts 1.  Knots, limits, states and modes enter as numbers:
every slew of as many spans is the same programme, and its solver is made once.
"""

from collections.abc import Iterable
from functools import lru_cache
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np

from planner.base import effort
from planner.base.arrays import Array, Indices, Mask
from planner.base.solvers import Answer, Options, Plugin, Solver, SolverRun, Work, has_piqp
from planner.motion.slew.spans import BETWEEN, bernstein_hulls

if TYPE_CHECKING:
    import casadi

UNITS = np.array([1.0, 2.0, 6.0, 60.0])  # of angle to jerk: what a unit move needs
FAR = 1e3  # in UNITS: as good as no bound
SOLVERS_KEPT = 64  # some MB and 10 to 400 ms to make each; a size of spans has two or three
# Of `effort`: a span in an iteration; to make a solver, each of its spans,
# and each residual of a mode on it.
SPAN, SPAN_ON_ROWS = 1.15, 2.4
STRAINED_SHARE = 4.0  # of an iteration that is strained, and by so much dearer
MADE, MADE_SPAN, MADE_RESIDUAL = 300.0, 20.0, 0.5
MULTIPLIER_MOST = 1e12  # beside a cost of 1: no motion keeps the limits, and to go on is dear
Start = Literal["quick", "near", "warm", "cold", "roomy"]

# How the programme is solved.  Cold: from a rough motion.  Near: from one that all but solves it.
# Warm: from such a one with its multipliers.  Roomy: the same, where an end leaves no room between
# bounds.  Quick: by PIQP, to learn where knots belong.
COLD: Options = {
    "tol": 1e-5,  # of the dual; the cost is right to 1e-8
    "max_iter": 50,  # those that succeed need a dozen; what fails goes on at five times the cost
    "nlp_scaling_method": "none",  # UNITS and the cost's weight are the scaling
    "jac_c_constant": "yes",
    "jac_d_constant": "yes",
    "hessian_constant": "yes",
    "mehrotra_algorithm": "yes",  # predictor and corrector: made for convex quadratic programmes
    "least_square_init_primal": "no",  # which Mehrotra's would say, and forget where to begin
    "bound_mult_init_method": "mu-based",
    "mu_init": 1e-2,
    "bound_push": 1e-2,
    "bound_frac": 1e-2,
    "min_refinement_steps": 0,
    "mumps_scaling": 0,
    "mumps_permuting_scaling": 0,
    "mumps_pivot_order": 0,  # AMD: with modes what MUMPS chooses takes up to ten times as long
}
NEAR: Options = {**COLD, "mu_init": 1e-6, "bound_push": 1e-6, "bound_frac": 1e-6}
WARM: Options = {
    **COLD,
    "mu_init": 1e-6,
    "warm_start_init_point": "yes",
    "warm_start_bound_push": 1e-6,
    "warm_start_bound_frac": 1e-6,
    "warm_start_slack_bound_push": 1e-6,
    "warm_start_slack_bound_frac": 1e-6,
    "warm_start_mult_bound_push": 1e-6,
}
# With modes, whose rows are full: what MUMPS puts off for a pivot that is small beside the rest of
# its column fills the factors, at three times the time and no gain.
WITH_MODES: Options = {"mumps_pivtol": 1e-10, "mumps_pivtolmax": 1e-6}
ROOMY: Options = {**WARM, "bound_relax_factor": 1e-9}
QUICK: Options = {"eps_abs": 1e-9, "eps_rel": 1e-9, "max_iter": 60}
STARTS: dict[Start, tuple[Plugin, Options]] = {
    "quick": ("piqp", QUICK),
    "near": ("ipopt", NEAR),
    "warm": ("ipopt", WARM),
    "cold": ("ipopt", COLD),
    "roomy": ("ipopt", ROOMY),
}


class _Ocp(NamedTuple):
    """x, p, f and g of the programme, and how g changes by x."""

    x: "casadi.SX"
    p: "casadi.SX"
    f: "casadi.SX"
    g: "casadi.SX"
    g_by_x: "casadi.SX"

    def hessian(self) -> "casadi.Function":
        """Hessian of the Lagrangian: the cost's alone, as all constraints are linear in x."""
        import casadi as ca

        of_cost, of_constraints = ca.SX.sym("lam_f"), ca.SX.sym("lam_g", self.g.numel())
        return ca.Function(
            "nlp_hess_l",
            [self.x, self.p, of_cost, of_constraints],
            [ca.triu(of_cost * ca.hessian(self.f, self.x)[0])],
            ["x", "p", "lam_f", "lam_g"],
            ["triu_hess_gamma_x_x"],
        )

    def jacobian(self) -> "casadi.Function":
        """Jacobian of the constraints."""
        import casadi as ca

        made = [self.g, self.g_by_x]
        return ca.Function("nlp_jac_g", [self.x, self.p], made, ["x", "p"], ["g", "jac_g_x"])


@lru_cache(maxsize=1)  # a size's solvers are mostly made one after the other
def slew_ocp(spans: int, *, on_rows: bool, residuals: int) -> _Ocp:
    """The programme in CasADi's symbols.

    on_rows: with splits and with spans of constant jerk.  residuals: how many numbers tell what
    is left of modes.
    """
    import casadi as ca

    states = ca.SX.sym("states", 3, spans + 1)  # at the knots, in UNITS
    jerks = ca.SX.sym("jerks", 2, spans)  # at begin and end of each span, in UNITS
    left = ca.SX.sym("left", residuals)  # of modes
    h, weight = ca.SX.sym("h", 1, spans), ca.SX.sym("weight")  # widths; scale of the cost
    flat, turns = ca.SX.sym("flat", 1, spans * on_rows), ca.SX.sym("turns", 2, spans * on_rows)
    maps, calm = ca.SX.sym("maps", residuals, 2 * spans), ca.SX.sym("calm", residuals)

    q, v, a = (UNITS[order] * states[order, :] for order in range(3))
    begin, end = ([x[:-1] for x in (q, v, a)], [x[1:] for x in (q, v, a)])
    j0, j1 = UNITS[3] * jerks[0, :], UNITS[3] * jerks[1, :]
    if on_rows:
        j1 = flat * j0 + (1 - flat) * j1
    (q0, v0, a0), (q1, v1, a1) = begin, end
    dynamics = ca.vertcat(
        q1 - (q0 + h * (v0 + h * (a0 / 2 + h * (3 * j0 + j1) / 24))),
        v1 - (v0 + h * (a0 + h * (2 * j0 + j1) / 6)),
        a1 - (a0 + h * (j0 + j1) / 2),
    )
    angle, rate, acceleration = bernstein_hulls(h, begin, end, j0)
    if on_rows:
        angle, rate = _split_bernstein(angle, turns[0, :]), _split_bernstein(rate, turns[1, :])
    limited = [
        coefficient / UNITS[order]
        for order, hull in enumerate((angle, rate, acceleration))
        for coefficient in hull[1:-1]  # the first and the last are states
    ]
    both = ca.vec(ca.vertcat(j0, j1))
    cost = ca.dot(h, j0**2 + j0 * j1 + j1**2) / 3 + ca.dot(calm, left**2)
    x, others = ca.veccat(states, jerks, left), ca.veccat(dynamics, ca.vertcat(*limited))
    # Modes have full rows, in which CasADi would look for zeros for seconds.
    of_modes = maps @ ca.jacobian(both, x) - ca.jacobian(left, x)
    return _Ocp(
        x=x,
        p=ca.veccat(h, weight, flat, turns, maps, calm),
        f=weight * cost,
        g=ca.veccat(others, maps @ both - left),
        g_by_x=ca.vertcat(ca.jacobian(others, x), of_modes),
    )


def _split_bernstein(hull: "list[Any]", at: "casadi.SX") -> "list[Any]":
    """Bernstein coefficients of both parts of a polynomial (de Casteljau), the shared one once."""
    before: list[Any] = []
    after: list[Any] = []
    while hull:
        before.append(hull[0])
        after.insert(0, hull[-1])
        hull = [(1 - at) * x + at * y for x, y in pairwise(hull)]
    return before + after[1:]


@lru_cache(maxsize=SOLVERS_KEPT)
def slew_solver(start: Start, spans: int, *, on_rows: bool, residuals: int) -> Solver:
    """Made once per process and size."""
    plugin, options = STARTS[start]
    if residuals and plugin == "ipopt":
        options = {**options, **WITH_MODES}
    # Of `effort`; PIQP counts no iterations.
    span = SPAN_ON_ROWS if on_rows else SPAN
    iteration = 17.0 + span * spans * (1.0 + residuals / 35.0)
    work = Work(60.0 + 2.5 * span * spans, iteration, STRAINED_SHARE * iteration)
    if plugin == "piqp":
        quick = 50.0 + spans * (0.5 + 2.0 * span + 0.3 * residuals)
        work = Work(quick, 0.0, failed_cost=quick)
    ocp = slew_ocp(spans, on_rows=on_rows, residuals=residuals)
    programme = {"x": ocp.x, "p": ocp.p, "f": ocp.f, "g": ocp.g}
    derivatives = {"hessian": ocp.hessian(), "jacobian": ocp.jacobian()}
    most = MULTIPLIER_MOST
    return Solver(programme, options, work, plugin=plugin, multiplier_bound=most, **derivatives)


def make_solvers(sizes: Iterable[int]) -> None:
    """Build what slews of so many spans ask for, before there is a slew: 10 ms each."""
    for spans in sizes:
        for on_rows in (False, True):
            if has_piqp():
                slew_solver("quick", spans, on_rows=on_rows, residuals=0)
            slew_solver("warm", spans, on_rows=on_rows, residuals=0)


class Rows(NamedTuple):
    """Spans on rows of the table: flat (n,), of constant jerk; turns (n, 2), where angle and rate
    are split, shares of the span."""

    flat: Mask
    turns: Array


class Vibration(NamedTuple):
    """What the jerks (n, 2) leave of modes, maps (m, n, 2); the squares, times weights (m,), add
    to the cost."""

    maps: Array
    weights: Array


class SpanProgramme(NamedTuple):
    """What the programme is given: widths (n,) of the spans, ends (2, 3), limits (4, 2).

    weight: scales the cost, so that it is about 1.
    """

    widths: Array
    ends: Array
    limits: Array
    rows: Rows | None
    vibration: Vibration
    weight: float


class Begin(NamedTuple):
    """A motion to begin at: states (n + 1, 3), jerks (n, 2).

    answer: of another solver, for a warm start.
    """

    states: Array
    jerks: Array
    answer: Answer | None = None


class Solved(NamedTuple):
    """jerks (n, 2) at both ends of each span.

    multipliers (n, m): what a unit of each limited quantity is worth, positive at its upper limit;
    of orders (m,), 0 angle to 2 acceleration, at places (n, m), shares of the span.
    """

    jerks: Array
    multipliers: Array
    orders: Indices
    places: Array
    answer: Answer

    @property
    def run(self) -> SolverRun:
        """How it was solved."""
        return self.answer.run


def solve(given: SpanProgramme, begin: Begin, start: Start) -> Solved:
    """The solver's answer, to be judged by what it is."""
    n, (low, high) = len(given.widths), (given.limits / UNITS[:, None]).T
    orders, places = BETWEEN if given.rows is None else _between_splits(given.rows.turns)
    places = np.broadcast_to(places, (n, len(orders)))
    least, most = np.tile(low[orders], (n, 1)), np.tile(high[orders], (n, 1))
    for side, fixed in zip((0, -1), _fixed_by_ends(given.rows is not None), strict=True):
        least[side, fixed], most[side, fixed] = -FAR, FAR
    state_least, state_most = np.tile(low[:3], (n + 1, 1)), np.tile(high[:3], (n + 1, 1))
    for side in (0, -1):
        state_least[side] = state_most[side] = given.ends[side] / UNITS[:3]
    rows = [] if given.rows is None else [given.rows.flat, given.rows.turns.ravel()]
    maps, calm = given.vibration
    m, dynamics = len(calm), np.zeros(3 * n)
    no_bound = np.full(m, np.inf)
    left = np.einsum("mnu,nu->m", maps, begin.jerks)
    states, jerks = begin.states / UNITS[:3], begin.jerks / UNITS[3]
    numbers = {
        "x0": np.concatenate([states.ravel(), jerks.ravel(), left]),
        "p": np.concatenate(
            [given.widths, [given.weight], *rows, maps.reshape(m, 2 * n).ravel(order="F"), calm]
        ),
        "lbx": np.concatenate([state_least.ravel(), np.full(2 * n, low[3]), -no_bound]),
        "ubx": np.concatenate([state_most.ravel(), np.full(2 * n, high[3]), no_bound]),
        "lbg": np.concatenate([dynamics, least.ravel(), np.zeros(m)]),
        "ubg": np.concatenate([dynamics, most.ravel(), np.zeros(m)]),
    }
    if start in ("warm", "roomy") and begin.answer is not None:
        x0, lam_x0, lam_g0, _ = begin.answer
        numbers |= {"x0": x0, "lam_x0": lam_x0, "lam_g0": lam_g0}
    span = SPAN if given.rows is None else SPAN_ON_ROWS
    size = (start, n, given.rows is None, m)
    effort.count_once(size, MADE + (MADE_SPAN * span + MADE_RESIDUAL * m) * n)
    solver = slew_solver(start, n, on_rows=given.rows is not None, residuals=m)
    answer = solver.solve(**numbers)
    jerks = answer.x_numbers[3 * n + 3 : 5 * n + 3].reshape(n, 2) * UNITS[3]
    if given.rows is not None:
        jerks[given.rows.flat, 1] = jerks[given.rows.flat, 0]
    at_knots = answer.lam_x_numbers[: 3 * n].reshape(n, 3) / UNITS[:3]
    at_knots[0] = 0.0  # the first state is given
    held = answer.lam_g_numbers[3 * n : 3 * n + places.size]
    between = held.reshape(places.shape) / UNITS[orders]
    return Solved(
        jerks=jerks,
        multipliers=np.hstack([at_knots, between]) / (2.0 * given.weight),
        orders=np.append(np.arange(3), orders),
        places=np.hstack([np.zeros((n, 3)), places]),
        answer=answer,
    )


def _between_splits(turns: Array) -> tuple[Indices, Array]:
    """Orders (13,) and places (n, 13) of what is limited within spans that are split."""
    places = []
    for turn, degree in zip(turns.T, (4, 3), strict=True):
        places += [turn * i / degree for i in range(1, degree + 1)]
        places += [turn + (1.0 - turn) * i / degree for i in range(1, degree)]
    places.append(np.full(len(turns), 0.5))
    return np.repeat([0, 1, 2], [7, 5, 1]), np.column_stack(places)


def _fixed_by_ends(split: bool) -> tuple[list[int], list[int]]:
    """Which of these follow from the first, and from the last, state alone."""
    return ([0, 1, 7], [5, 6, 11]) if split else ([0, 1, 3], [1, 2, 4])
