"""The slew of a whole body as an optimal control problem, stated once in CasADi.

    least      time, or the integral of squared jerk
    such that  q' = q o omega / 2, omega' = alpha, alpha' = jerk,
               the start is the given one and the end is the goal's at the time of arrival, and
               rate, acceleration, jerk and cones keep their limits at every instant

The jerk is linear on spans of time, so that omega is a cubic on each.  It stays within the hull
of its Bernstein coefficients, and so do its derivatives: limits put on these, as norms or by
axis, hold at every instant.  Attitudes follow by two Magnus steps of order 6 a span.  Cones are
kept at samples, deeper by what a path can bulge between two of them.

Spans are runs of equal share of phases, whose lengths are free in least time, so that switches
lie where they belong; at a given time both are given, and spans begin and end on rows.  The
goal's motion is a polynomial in the time of arrival.  Time is counted in the first guess's.
One programme serves all objectives: its solver is made once for each size and kind of limit,
from the derivatives of one span, which are mapped over all: derivatives of the whole took 15 times
as long to find, and 45 to 170 MB to keep.

Source: S. Blanes, F. Casas, J. Ros, BIT 40 (2000), 434-450, of the Magnus expansion.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from planner.base import effort
from planner.base.arrays import Array, Indices
from planner.base.commands import ROWS_PER_S, Motion
from planner.base.rotation import Rotation, continuous
from planner.base.solvers import Solver, SolverRun, Work
from planner.motion.attitude.problem import BodySlewProblem, LimitKind

if TYPE_CHECKING:
    import casadi


@dataclass(frozen=True, kw_only=True)
class ProgrammeOptions:
    """The size of the programme, and the time it is solved in."""

    goal_degree: int = 8  # of the goal's motion in the time of arrival: 1e-6 rad of a low orbit
    centre_degree: int = 3  # of a cone's middle in time
    samples: int = 4  # a span, at which cones are kept
    phase_least: float = 5e-3  # of the whole time: switches stay in order
    # beside the time, of the mean squared jerk in limits: what time leaves free is smooth
    jerk_weight: float = 1e-4
    solvers_kept: int = 64
    # Of Ipopt: in the time given all of 560 that were found took 31 or fewer, around cones 96, and
    # of 146 least times 198; what fails goes on to the end.
    iterations: int = 200
    iterations_on_rows: int = 60
    # Of `effort`: to ask, an iteration of a span, and of a span and cone; to make a solver.
    asked: float = 60.0
    span_iteration: float = 14.0
    cone_iteration: float = 18.0
    made_span: float = 200.0


OPTIONS = ProgrammeOptions()


class _Span(NamedTuple):
    """Of one span: its width, rate and acceleration where it begins, jerk at both ends."""

    width: "casadi.SX"
    omega: "casadi.SX"
    alpha: "casadi.SX"
    j0: "casadi.SX"
    j1: "casadi.SX"

    def rate(self, share: "casadi.SX | float") -> "casadi.SX":
        t = share * self.width
        return self.omega + t * (self.alpha + t * (self.j0 + share * (self.j1 - self.j0) / 3) / 2)

    def acceleration(self, share: "casadi.SX | float") -> "casadi.SX":
        return self.alpha + share * self.width * (self.j0 + share * (self.j1 - self.j0) / 2)

    def turn(self, begin: "casadi.SX | float", end: "casadi.SX | float") -> "casadi.SX":
        """Rotation from one share to another: a Magnus step; for body rates [a, b] = -a x b."""
        import casadi as ca

        gauss = (0.5 - math.sqrt(0.15), 0.5, 0.5 + math.sqrt(0.15))
        w1, w2, w3 = (self.rate(begin + x * (end - begin)) for x in gauss)
        h = (end - begin) * self.width
        a1, a2 = h * w2, math.sqrt(15.0) / 3.0 * h * (w3 - w1)
        a3 = 10.0 / 3.0 * h * (w3 - 2 * w2 + w1)
        c1 = -ca.cross(a1, a2)
        c2 = ca.cross(a1, 2.0 * a3 + c1) / 60.0
        return _exponential(a1 + a3 / 12.0 - ca.cross(-20.0 * a1 - a3 + c1, a2 + c2) / 240.0)


def _exponential(phi: "casadi.SX") -> "casadi.SX":
    """Quaternion of a rotation vector below a turn, by series: smooth at zero."""
    import casadi as ca

    x = ca.dot(phi, phi) / 4.0
    sinc = 1 - x / 6 * (1 - x / 20 * (1 - x / 42 * (1 - x / 72 * (1 - x / 110))))
    cosine = 1 - x / 2 * (1 - x / 12 * (1 - x / 30 * (1 - x / 56 * (1 - x / 90 * (1 - x / 132)))))
    return ca.vertcat(sinc / 2 * phi, cosine)


def _product(p: "casadi.SX", q: "casadi.SX") -> "casadi.SX":
    import casadi as ca

    (u, d), (v, w) = ca.vertsplit(p, [0, 3, 4]), ca.vertsplit(q, [0, 3, 4])
    return ca.vertcat(d * v + w * u + ca.cross(u, v), d * w - ca.dot(u, v))


def _rotated(q: "casadi.SX", v: "casadi.SX") -> "casadi.SX":
    """Body vector v in GCRF."""
    import casadi as ca

    u = q[:3]
    return v + 2.0 * ca.cross(u, ca.cross(u, v) + q[3] * v)


class BoundedSolver(NamedTuple):
    """A solver, and the bounds of its constraints."""

    solver: Solver
    lbg_numbers: Array
    ubg_numbers: Array


@lru_cache(maxsize=OPTIONS.solvers_kept)
def body_solver(
    spans: int, phases: int, kind: LimitKind, cones: int, iterations: int
) -> BoundedSolver:
    """Made once per process and size, 30 to 50 ms: a span's derivatives are found once.

    iterations: after which Ipopt gives up.
    """
    import casadi as ca

    span = _span_functions(kind, cones)
    whole = _whole_functions(spans, phases, span.rows.size1_in(1))
    x, p = (ca.MX.sym(name, whole.spread.size1_in(i)) for i, name in enumerate(("x", "p")))
    each, numbers, met = whole.spread(x, p)
    each_by_x, met_by_x = whole.spread_by_x(x, p)
    given = each, ca.repmat(numbers, 1, spans)
    rows = span.rows.map(spans)(*given)
    size, count = rows.size1(), rows.numel()
    lam_f, lam_g = ca.MX.sym("lam_f"), ca.MX.sym("lam_g", count + met.numel())
    lam = ca.reshape(lam_g[:count], size, spans)
    rows_by_each = ca.horzsplit(span.jacobian.map(spans)(*given), each.size1())
    bent_by_each = ca.horzsplit(span.hessian.map(spans)(*given, lam), each.size1())
    hessian = each_by_x.T @ ca.diagcat(*bent_by_each) @ each_by_x
    hessian += whole.hessian(x, p, lam_f, lam_g[count:])
    g = ca.vertcat(ca.vec(rows), met)
    g_by_x = ca.vertcat(ca.diagcat(*rows_by_each) @ each_by_x, met_by_x)
    iteration = spans * (OPTIONS.span_iteration + cones * OPTIONS.cone_iteration)
    solver = Solver(
        {"x": x, "p": p, "f": whole.cost(x, p), "g": g},
        {"tol": 1e-7, "max_iter": iterations, "mu_strategy": "adaptive"},
        Work(OPTIONS.asked, iteration),
        jacobian=ca.Function("nlp_jac_g", [x, p], [g, g_by_x], ["x", "p"], ["g", "jac_g_x"]),
        hessian=ca.Function(
            "nlp_hess_l",
            [x, p, lam_f, lam_g],
            [ca.triu(hessian)],
            ["x", "p", "lam_f", "lam_g"],
            ["triu_hess_gamma_x_x"],
        ),
    )
    least, most = (
        np.tile(bounds, (spans, 1)) for bounds in (span.least_numbers, span.most_numbers)
    )
    given_start = slice(10, 10 + {"magnitude": 2, "gyros": 4, "axis": 6}[kind])
    for side, follows in ((0, given_start), (-1, slice(size - cones, size))):  # from the ends
        least[side, follows], most[side, follows] = -np.inf, np.inf
    zero = np.zeros(met.numel())
    return BoundedSolver(solver, np.append(least, zero), np.append(most, zero))


class _WholeFunctions(NamedTuple):
    """Of all variables x and numbers p of the programme.

    spread: the variables of each span in a column, the numbers that all share, and what is 0
    where the goal is met.  cost.  hessian: of cost and meeting, times a multiplier each.
    """

    spread: "casadi.Function"
    spread_by_x: "casadi.Function"
    cost: "casadi.Function"
    hessian: "casadi.Function"


def _whole_functions(spans: int, phases: int, shared: int) -> _WholeFunctions:
    import casadi as ca

    q, j = ca.SX.sym("q", 4, spans + 1), ca.SX.sym("jerk", 6, spans)
    w, a = ca.SX.sym("omega", 3, spans + 1), ca.SX.sym("alpha", 3, spans + 1)
    T, shares = ca.SX.sym("T"), ca.SX.sym("shares", phases)
    fractions = ca.SX.sym("fractions", spans)  # of its phase
    goal, about = ca.SX.sym("goal", 10, OPTIONS.goal_degree + 1), ca.SX.sym("about", 2)
    weights = ca.SX.sym("weights", 2)  # of time and of jerk
    numbers = ca.SX.sym("numbers", shared)
    widths = (ca.repmat(shares.T, spans // phases, 1).reshape((1, spans))) * fractions.T
    begins = ca.cumsum(widths, 1) - widths
    knots = ca.vertcat(q, w, a)
    each = ca.vertcat(ca.repmat(T, 1, spans), widths, begins, knots[:, :-1], j, knots[:, 1:])
    j0, j1 = j[:3, :], j[3:, :]
    squares = ca.sum1(j0**2 + j0 * j1 + j1**2) / 3
    cost = weights[0] * T + weights[1] * T * ca.dot(widths, squares)
    z = (T - about[0]) / about[1]
    arrival = goal @ ca.vertcat(*(z**p for p in range(OPTIONS.goal_degree + 1)))
    off = _product(ca.vertcat(-arrival[:3], arrival[3]), q[:, spans])
    met = ca.vertcat(
        off[:3], w[:, spans] - arrival[4:7], a[:, spans] - arrival[7:], ca.sum1(shares) - 1.0
    )
    x, p = ca.veccat(q, w, a, j, T, shares), ca.veccat(fractions, goal, about, weights, numbers)
    lam_f, lam_met = ca.SX.sym("lam_f"), ca.SX.sym("lam_met", met.numel())
    bent, _ = ca.hessian(lam_f * cost + ca.dot(lam_met, met), x)
    by_x = [ca.jacobian(ca.vec(each), x), ca.jacobian(met, x)]
    return _WholeFunctions(
        spread=ca.Function("spread", [x, p], [each, numbers, met]),
        spread_by_x=ca.Function("spread_by_x", [x, p], by_x),
        cost=ca.Function("cost", [x, p], [cost]),
        hessian=ca.Function("hessian", [x, p, lam_f, lam_met], [bent]),
    )


class _SpanFunctions(NamedTuple):
    """Of one span's variables and the numbers that all spans share.

    rows: what is kept between least_numbers and most_numbers: 10 of the motion, limits, cones.
    hessian: of the rows, times a multiplier each.
    """

    rows: "casadi.Function"
    jacobian: "casadi.Function"
    hessian: "casadi.Function"
    least_numbers: Array
    most_numbers: Array


@lru_cache(maxsize=OPTIONS.solvers_kept)
def _span_functions(kind: LimitKind, cones: int) -> _SpanFunctions:
    import casadi as ca

    T, share, begun = (ca.SX.sym(name) for name in ("T", "share", "begun"))
    begin, omega, alpha, jerk, end, next_omega, next_alpha = (
        ca.SX.sym(f"v{i}", n) for i, n in enumerate((4, 3, 3, 6, 4, 3, 3))
    )
    most = ca.SX.sym("most", 3, 3)  # by body axis, of rate, acceleration, jerk
    b, cosine = ca.SX.sym("b", 3, cones), ca.SX.sym("cosine", cones)
    centre = ca.SX.sym("centre", 3 * (OPTIONS.centre_degree + 1), cones)
    bend = ca.SX.sym("bend", cones)  # at least |d2/dt2 (b . s)|
    inside = []

    def keep(order: int, *points: ca.SX) -> None:
        for point in points:
            x = point / most[:, order]
            is_round = kind == "magnitude" or (kind == "gyros" and order > 0)
            inside.append(ca.dot(x, x) if is_round else x)

    h = T * share
    span = _Span(h, omega, alpha, jerk[:3], jerk[3:])
    half = _product(begin, span.turn(0.0, 0.5))
    zero = [_product(half, span.turn(0.5, 1.0)) - end]
    zero += [span.rate(1.0) - next_omega, span.acceleration(1.0) - next_alpha]
    keep(0, omega)
    keep(1, alpha)
    keep(0, omega + h / 3 * alpha, next_omega - h / 3 * next_alpha)
    keep(1, alpha + h / 2 * span.j0)
    keep(2, span.j0, span.j1)
    limited = ca.vertcat(*inside).numel()
    path = {0.5: half, 1.0: end}
    for i in range(1, OPTIONS.samples + 1) if cones else ():
        at = i / OPTIONS.samples
        here = path.get(at)
        if here is None:
            first = 0.0 if at < 0.5 else 0.5
            here = _product(half if first else begin, span.turn(first, at))
        z = 2.0 * T * (begun + at * share) - 1.0
        bulge = bend * (h / OPTIONS.samples) ** 2 / 8.0
        powers = ca.vertcat(*(z**p for p in range(OPTIONS.centre_degree + 1)))
        for c in range(cones):
            middle = ca.reshape(centre[:, c], 3, OPTIONS.centre_degree + 1) @ powers
            off = ca.dot(_rotated(here, b[:, c]), middle) - cosine[c]
            inside.append(off + bulge[c] + 1.0)
    x = ca.vertcat(T, share, begun, begin, omega, alpha, jerk, end, next_omega, next_alpha)
    p = ca.veccat(most, b, cosine, centre, bend)
    rows = ca.vertcat(*zero, *inside)
    lam = ca.SX.sym("lam", rows.numel())
    least = np.full(rows.numel(), -np.inf)
    least[:10] = 0.0
    if kind != "magnitude":  # squares aren't below either
        least[10 : 10 + limited] = -1.0
    return _SpanFunctions(
        rows=ca.Function("rows", [x, p], [rows]),
        jacobian=ca.Function("jacobian", [x, p], [ca.jacobian(rows, x)]),
        hessian=ca.Function("hessian", [x, p, lam], [ca.hessian(ca.dot(lam, rows), x)[0]]),
        least_numbers=least,
        most_numbers=np.append(np.zeros(10), np.ones(rows.numel() - 10)),
    )


class SpanMotion(NamedTuple):
    """A motion whose jerk is linear on n spans.

    widths_s: (n,).  q_eci_from_body_xyzw (n + 1, 4), omega_body_rad_s and alpha_body_rad_s2
    (n + 1, 3) where they begin and end.  jerk_body_rad_s3: at both ends of each, (n, 2, 3).
    """

    widths_s: Array
    q_eci_from_body_xyzw: Array
    omega_body_rad_s: Array
    alpha_body_rad_s2: Array
    jerk_body_rad_s3: Array

    @property
    def duration_s(self) -> float:
        return float(self.widths_s.sum())

    @property
    def cost_rad2_s5(self) -> float:
        """Integral of squared jerk."""
        j0, j1 = self.jerk_body_rad_s3.swapaxes(0, 1)
        return float(self.widths_s @ (j0 * j0 + j0 * j1 + j1 * j1).sum(axis=1) / 3.0)

    def at(self, t_s: Array) -> Motion:
        """The motion at instants (m,), good to begin at."""
        k, shares = self._place(t_s)
        turns, omega, alpha = self._turned(k, np.zeros_like(shares), shares)
        q = Rotation.from_quat(self.q_eci_from_body_xyzw[k]) * Rotation.from_quat(turns)
        return Motion(continuous(q), omega, alpha)

    def on_rows(self, problem: BodySlewProblem) -> Motion:
        """The motion on the rows of a table, for spans of whole rows; it ends at the goal's row.

        Attitudes are the product of a step each row, so that the quintics between rows turn by
        the integral of omega to 1e-13 rad; what the end is missed by, 1e-9 rad, is spread.
        """
        (goal,) = problem.goal.position
        rows = problem.first_arrival_row
        k, shares = self._place((np.arange(rows) + 0.5) / ROWS_PER_S)
        half = 0.5 / ROWS_PER_S / self.widths_s[k]
        turns, omega, alpha = self._turned(k, shares - half, shares + half)
        q_xyzw = [tuple(problem.start.position[0].tolist())]
        for turn in turns.tolist():
            q_xyzw.append(_quaternion_product(q_xyzw[-1], turn))
        missed = (Rotation.from_quat(q_xyzw[-1]).inv() * Rotation.from_quat(goal)).as_rotvec()
        u = np.arange(rows + 1) / rows
        spread = u**3 * (10.0 - 15.0 * u + 6.0 * u**2)
        q = Rotation.from_quat(q_xyzw) * Rotation.from_rotvec(spread[:, None] * missed)
        omega[-1], alpha[-1] = problem.goal.rate_rad_s[0], problem.goal.acceleration_rad_s2[0]
        return Motion(
            continuous(q),
            np.vstack([problem.start.rate_rad_s, omega]),
            np.vstack([problem.start.acceleration_rad_s2, alpha]),
        )

    def _place(self, t_s: Array) -> tuple[Indices, Array]:
        """Which span, and the share of it."""
        begins_s = np.append(0.0, np.cumsum(self.widths_s))
        k = np.searchsorted(begins_s, t_s, side="right") - 1
        k = np.clip(k, 0, len(self.widths_s) - 1)
        return k, (t_s - begins_s[k]) / self.widths_s[k]

    def _turned(
        self, k: Indices, first_share: Array, last_share: Array
    ) -> tuple[Array, Array, Array]:
        """Rotations from one share of a span to another, (m, 4), rates and accelerations then."""
        jerk = self.jerk_body_rad_s3[k]
        vectors = (self.omega_body_rad_s[k], self.alpha_body_rad_s2[k], jerk[:, 0], jerk[:, 1])
        scalars = (first_share[None], last_share[None], self.widths_s[k][None])
        turns, omega, alpha = _turn_within_span()(*scalars, *(vector.T for vector in vectors))
        return np.array(turns).T, np.array(omega).T, np.array(alpha).T

    def on_spans(self, widths_s: Array) -> "SpanMotion":
        """The same, stretched in time, on other spans: to begin at."""
        stretch = float(widths_s.sum()) / self.duration_s
        t_s = np.append(0.0, np.cumsum(widths_s)) / stretch
        there = self.at(np.minimum(t_s, self.duration_s))
        omega, alpha = there.rate_rad_s / stretch, there.acceleration_rad_s2 / stretch**2
        jerk = np.diff(alpha, axis=0) / widths_s[:, None]
        return SpanMotion(widths_s, there.position, omega, alpha, np.stack([jerk, jerk], axis=1))


def _quaternion_product(p: Sequence[float], q: Sequence[float]) -> tuple[float, ...]:
    a, b, c, d = p
    x, y, z, w = q
    return (
        d * x + a * w + b * z - c * y,
        d * y - a * z + b * w + c * x,
        d * z + a * y - b * x + c * w,
        d * w - a * x - b * y - c * z,
    )


@lru_cache(maxsize=1)
def _turn_within_span() -> "casadi.Function":
    """The rotation from one share of a span to another; rate and acceleration at the last."""
    import casadi as ca

    first, last, width = (ca.SX.sym(name) for name in ("first", "last", "width"))
    vectors = [ca.SX.sym(name, 3) for name in ("omega", "alpha", "j0", "j1")]
    span = _Span(width, *vectors)
    motion = [span.turn(first, last), span.rate(last), span.acceleration(last)]
    return ca.Function("turn_within_span", [first, last, width, *vectors], motion)


class Arrival(NamedTuple):
    """When the slew may end, and the goal's motion then.

    goal_coefficients: (10, d + 1), of attitude, rate and acceleration in powers of
    (t - middle_s) / half_s.
    """

    first_s: float
    last_s: float
    goal_coefficients: Array

    @property
    def middle_s(self) -> float:
        return (self.first_s + self.last_s) / 2.0

    @property
    def half_s(self) -> float:
        return (self.last_s - self.first_s) / 2.0 or 1.0


def arrival_within(problem: BodySlewProblem, first_row: int, last_row: int) -> Arrival:
    """At any time between two rows of the goal."""
    begin = first_row - problem.first_arrival_row
    rows = slice(begin, begin + last_row - first_row + 1)
    goal = problem.goal
    motion = np.hstack([goal.position, goal.rate_rad_s, goal.acceleration_rad_s2])[rows]
    coefficients = np.zeros((10, OPTIONS.goal_degree + 1))
    degree = min(OPTIONS.goal_degree, len(motion) - 1)
    z = np.linspace(-1.0, 1.0, len(motion)) if degree else np.zeros(1)
    fitted = np.polynomial.chebyshev.chebfit(z, motion, degree)
    for row, numbers in zip(coefficients, fitted.T, strict=True):
        powers = np.polynomial.chebyshev.cheb2poly(numbers)
        row[: len(powers)] = powers
    return Arrival(first_row / ROWS_PER_S, last_row / ROWS_PER_S, coefficients)


class SolvedBodySlew(NamedTuple):
    """A motion, to be judged by what it is."""

    motion: SpanMotion
    run: SolverRun


def solve(
    problem: BodySlewProblem,
    begin: SpanMotion,
    arrival: Arrival,
    *,
    phases: int,
    limit_share: float = 1.0,
) -> SolvedBodySlew:
    """The solver's answer, begun at a motion of as many spans.

    Where the arrival is at one instant, its spans' widths are kept and the jerk is least; else the
    time.  phases: whose lengths are free then; so many times begin's equal spans.
    limit_share: of the limits that is used.
    """
    n, is_fixed = len(begin.widths_s), arrival.first_s == arrival.last_s
    unit_s, cones = begin.duration_s, problem.cones
    kind = problem.limits.kind
    is_soon = is_fixed and not cones
    most_iterations = OPTIONS.iterations_on_rows if is_soon else OPTIONS.iterations
    size = n, phases, kind, len(cones), most_iterations
    effort.count_once(size, OPTIONS.made_span * n)
    kept = body_solver(*size)
    most = limit_share * problem.limits.by_order * unit_s ** np.arange(1, 4)
    by_phase = begin.widths_s.reshape(phases, -1)
    shares = by_phase.sum(axis=1)
    fractions = by_phase / shares[:, None]
    shares = shares / unit_s
    rates = np.repeat([1.0, unit_s, unit_s**2], [4, 3, 3])
    jerk = begin.jerk_body_rad_s3.reshape(n, 6) * unit_s**3
    cost = begin.cost_rad2_s5 * unit_s**5
    weights = [0.0, 1.0 / max(cost, 1e-6)]
    if not is_fixed:
        weights = [1.0, OPTIONS.jerk_weight / float(most[:, 2] @ most[:, 2])]
    numbers = [
        fractions.ravel(),
        (arrival.goal_coefficients * rates[:, None]).ravel(order="F"),
        [arrival.middle_s / unit_s, arrival.half_s / unit_s],
        weights,
        most.ravel(order="F"),
        *_cone_numbers(problem, arrival, unit_s),
    ]
    x0 = [
        begin.q_eci_from_body_xyzw.ravel(),
        begin.omega_body_rad_s.ravel() * unit_s,
        begin.alpha_body_rad_s2.ravel() * unit_s**2,
        jerk.ravel(),
        [1.0],
        shares,
    ]
    low = [np.full(np.size(part), -np.inf) for part in x0]
    high = [np.full(np.size(part), np.inf) for part in x0]
    start = problem.start
    ends = (start.position, start.rate_rad_s * unit_s, start.acceleration_rad_s2 * unit_s**2)
    for bounds in (low, high):
        for part, given in zip(bounds, ends, strict=False):
            part[: given.size] = given.ravel()
    low[4][:], high[4][:] = arrival.first_s / unit_s, arrival.last_s / unit_s
    low[5][:], high[5][:] = (shares, shares) if is_fixed else (OPTIONS.phase_least, 1.0)
    answer = kept.solver.solve(
        x0=np.concatenate(x0),
        p=np.concatenate([np.asarray(part, dtype=float).ravel() for part in numbers]),
        lbx=np.concatenate(low),
        ubx=np.concatenate(high),
        lbg=kept.lbg_numbers,
        ubg=kept.ubg_numbers,
    )
    ends_at = np.cumsum([np.size(part) for part in x0])
    q, w, a, j, time, phase = np.split(answer.x_numbers, ends_at[:-1])
    widths_s = begin.widths_s
    if not is_fixed:
        widths_s = (time * phase[:, None] * fractions).ravel() * unit_s
    motion = SpanMotion(
        widths_s,
        q.reshape(-1, 4),
        w.reshape(-1, 3) / unit_s,
        a.reshape(-1, 3) / unit_s**2,
        j.reshape(-1, 2, 3) / unit_s**3,
    )
    return SolvedBodySlew(motion, answer.run)


def _cone_numbers(problem: BodySlewProblem, arrival: Arrival, unit_s: float) -> list[Array]:
    """Body directions, cosines, middles and bends of the cones, time counted in unit_s."""
    directions, cosines, middles, bends = [], [], [], []
    rate, acceleration, _ = problem.limits.lengths
    for cone in problem.cones:
        rows = cone.centre_eci[: math.ceil(arrival.last_s * ROWS_PER_S - 1e-6) + 1]
        z = 2.0 * np.arange(len(rows)) / ROWS_PER_S / unit_s - 1.0
        fitted = np.polynomial.polynomial.polyfit(
            z, rows, min(OPTIONS.centre_degree, len(rows) - 1)
        )
        fit = np.zeros((OPTIONS.centre_degree + 1, 3))
        fit[: len(fitted)] = fitted
        off = np.max(np.linalg.norm(np.polynomial.polynomial.polyval(z, fit).T - rows, axis=1))
        moved = np.diff(rows, axis=0) * ROWS_PER_S
        centre_rad_s = float(np.max(np.linalg.norm(moved, axis=1), initial=0.0))
        directions.append(cone.direction_body)
        cosines.append(math.cos(min(cone.half_rad + off, math.pi)))
        middles.append(fit.ravel())
        bends.append((acceleration + (rate + centre_rad_s) ** 2) * unit_s**2)
    return [np.array(part).ravel() for part in (directions, cosines, middles, bends)]
