"""What is the smoothest motion a B-spline can make between two states within the limits?

In normalised time tau = t/T the angle is a clamped B-spline.  Its derivatives are B-splines
whose coefficients D_k c are linear in its own c, and a B-spline never leaves the hull of its
coefficients: limits put on D_k c hold at every instant.  Every matrix depends on the knots
alone; duration, states and limits enter through bounds and a gradient, so that one solver
serves every slew.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from planner import effort
from planner.arrays import Array
from planner.platforms import AxisLimits, StructuralMode
from planner.slew.backends.spline_basis import derivative_matrices, jerk_cost, spline_basis
from planner.slew.problem import AxisState
from planner.slew.solution import AxisProfile, bounds, obeys
from planner.slew.vibration import modal_cost, modal_rows, wanted_residuals

if TYPE_CHECKING:
    import casadi

JERK_COST = 720.0  # least integral of squared jerk of a unit rest-to-rest move in unit time
ROUNDING = 1e-9  # of the limits' ranges
INSIDE = 1.0 - 1e-8  # of the limits, so that the solver's last digits stay within them
IPOPT: dict[str, str | float | int] = {
    "print_level": 0,
    "sb": "yes",
    "linear_solver": "mumps",  # others crash or are not packaged everywhere
    "tol": 1e-8,
    "bound_relax_factor": 0.0,
    "acceptable_iter": 0,
    "max_iter": 50,  # what can be solved took 28 at most in 300 requests; the rest never ends
    "mehrotra_algorithm": "yes",  # predictor-corrector: made for convex quadratic programs
    "jac_d_constant": "yes",
    "hessian_constant": "yes",
}


UNCONSTRAINED = "unconstrained"
SOLVED = (UNCONSTRAINED, "Solve_Succeeded")
WEIGHINGS = 12  # of modes, one against another; all but a few slews need one
CALM = 0.95  # of the residual that is wanted, so that rows don't exceed it
FAINT, LOUD = 0.3, 3.0  # of it: so much less or more a mode weighs next
HOPELESS = 20.0  # of it: no weights have been seen to gain a tenfold


# Of `planner.effort`: a solve, a row or variable in an iteration, an entry of a full hessian.
SOLVE, ITERATION_ROW, ITERATION_ENTRY = 100, 0.3, 0.03


class OcpResult(NamedTuple):
    """A candidate to be judged by its polynomials; ipopt_status is hearsay."""

    profile: AxisProfile
    iterations: int
    ipopt_status: str


@dataclass(frozen=True, eq=False)
class PosedAxis:
    """One axis of a slew in the solver's variables y: free coefficients over their units.

    The angle is start + scale_rad * sum of c_i B_i(t/T).  fixed: the coefficients that the
    ends determine.  low, high bound y; rows_low, rows_high the hull rows.  gradient (k,)
    and, where structural modes are spared, hessian (k, k): of the cost.
    """

    start_angle_rad: float
    scale_rad: float
    duration_s: float
    fixed: Array
    low: Array
    high: Array
    rows_low: Array
    rows_high: Array
    gradient: Array
    hessian: Array | None


class Values(NamedTuple):
    """What free (k, m) and fixed (k, 6) coefficients add to the normalised angle."""

    free: Array
    fixed: Array


class SplineOcp:
    """Least integral of squared jerk over clamped B-splines on fixed knots.

    breakpoints: from 0 to 1, the knots in normalised time.
    hessian: of the cost in y.  jacobian: of the hull rows in y.
    Source: hull property, de Boor, A Practical Guide to Splines (2001), ch. XI.
    """

    def __init__(self, breakpoints: Array, degree: int) -> None:
        self._basis = basis = spline_basis(breakpoints, degree)
        n = len(basis.free) + len(basis.fixed)
        cost = jerk_cost(basis, n) / JERK_COST
        cost_free = cost[np.ix_(basis.free, basis.free)]
        # Short spans make costs of 1e11 beside 1: in c the gradient drowns in rounding.
        self._unit = 1.0 / np.sqrt(JERK_COST * np.diag(cost_free))
        self.hessian = cost_free * np.outer(self._unit, self._unit)
        self._gradient = cost[np.ix_(basis.free, basis.fixed)] * self._unit[:, None]
        self._unconstrained = -np.linalg.solve(self.hessian, self._gradient)
        derivatives = derivative_matrices(basis.knots, degree)[1:]
        self._limited = [
            np.flatnonzero(np.any(matrix[:, basis.free] != 0.0, axis=1)) for matrix in derivatives
        ]
        rows = np.vstack([d[rows] for d, rows in zip(derivatives, self._limited, strict=True)])
        self._row_scale = 1.0 / np.abs(rows[:, basis.free] * self._unit).max(axis=1)
        self.jacobian = rows[:, basis.free] * self._unit * self._row_scale[:, None]
        self._jacobian_fixed = rows[:, basis.fixed] * self._row_scale[:, None]

    @cached_property
    def _solver(self) -> "casadi.Function":
        """Its parameter is the gradient."""
        import casadi

        parameter = casadi.MX.sym("gradient", self.free_count)
        return self._programme(casadi.sparsify(casadi.DM(self.hessian)), parameter)

    @cached_property
    def _calm_solver(self) -> "casadi.Function":
        """Its parameters are the gradient and the full hessian, which modes change."""
        import casadi

        n = self.free_count
        parameters = casadi.MX.sym("gradient and hessian", n + n * n)
        return self._programme(casadi.reshape(parameters[n:], n, n), parameters)

    def _programme(
        self, hessian: "casadi.DM | casadi.MX", parameters: "casadi.MX"
    ) -> "casadi.Function":
        # CasADi takes 0.1 s to import, which only a process that solves should pay.
        import casadi

        y = casadi.MX.sym("y", self.free_count)
        problem: dict[str, Any] = {
            "x": y,
            "p": parameters,
            "f": casadi.bilin(hessian, y, y) / 2.0 + casadi.dot(parameters[: self.free_count], y),
            "g": casadi.mtimes(casadi.sparsify(casadi.DM(self.jacobian)), y),
        }
        weight, row_weights = casadi.MX.sym("weight"), casadi.MX.sym("rows", len(self.jacobian))
        # Given, as CasADi would take seconds to find a full one by differentiation.
        lagrangian_hessian = casadi.Function(
            "nlp_hess_l",
            [y, parameters, weight, row_weights],
            [casadi.triu(weight * hessian)],
            ["x", "p", "lam_f", "lam_g"],
            ["triu_hess_gamma_x_x"],
        )
        options: dict[str, Any] = {
            "print_time": False,
            "ipopt": IPOPT,
            "hess_lag": lagrangian_hessian,
        }
        return casadi.nlpsol("slew", "ipopt", problem, options)

    def solve(
        self,
        start: AxisState,
        end: AxisState,
        limits: AxisLimits,
        duration_s: float,
        avoid_modes: tuple[StructuralMode, ...] = (),
    ) -> OcpResult:
        """The smoothest spline from start to end in duration_s, if the solver is to be believed.

        avoid_modes: left as calm as the limits allow; see `planner.slew.vibration`.
        """
        if avoid_modes:
            return self._calmest(start, end, limits, duration_s, avoid_modes)
        posed = self.pose(start, end, limits, duration_s)
        y, iterations, status = self._solved(posed)
        return OcpResult(self.profile(posed, y), iterations, status)

    def _calmest(
        self,
        start: AxisState,
        end: AxisState,
        limits: AxisLimits,
        duration_s: float,
        modes: tuple[StructuralMode, ...],
    ) -> OcpResult:
        """With weights shifted towards what rings too much, until none does or tries run out.

        Source: Lawson 1961, the least greatest residual by least squares weighed anew.
        """
        basis = self._basis
        rows = modal_rows(basis.spans, basis.pieces, basis.living, duration_s, modes)
        emphasis = np.ones(len(rows))
        iterations, least_share = 0, np.inf
        best: OcpResult | None = None
        for _ in range(WEIGHINGS):
            posed = self.pose(start, end, limits, duration_s, avoid_modes=modes, emphasis=emphasis)
            y, used, status = self._solved(posed)
            iterations += used
            ends = _normalised_ends(start, end, duration_s, posed.scale_rad)
            left = np.abs(rows @ self._coefficients(posed, y))
            shares = left / (CALM * wanted_residuals(ends, duration_s, modes))
            profile = self.profile(posed, y)
            good = status in SOLVED and obeys(profile, start, end, limits)
            if best is None or (good and shares.max() < least_share):
                least_share = float(shares.max())
                best = OcpResult(profile, iterations, status)
            if not good or not 1.0 < least_share < HOPELESS:
                break
            emphasis = emphasis * np.clip(shares, FAINT, LOUD)
        assert best is not None
        return best._replace(iterations=iterations)

    def _solved(self, posed: PosedAxis) -> tuple[Array, int, str]:
        """y, iterations and what the solver says."""
        if posed.hessian is None:
            solver, parameters = self._solver, posed.gradient
            optimum = self._unconstrained @ posed.fixed
        else:
            solver = self._calm_solver
            parameters = np.concatenate([posed.gradient, posed.hessian.ravel()])
            optimum = np.asarray(-np.linalg.solve(posed.hessian, posed.gradient))
            bounded = np.concatenate([optimum, self.jacobian @ optimum])
            least = np.concatenate([posed.low, posed.rows_low])
            greatest = np.concatenate([posed.high, posed.rows_high])
            if ((least <= bounded) & (bounded <= greatest)).all():
                return optimum, 0, UNCONSTRAINED
        effort.spend(SOLVE)
        found = solver(
            x0=np.clip(optimum, posed.low, posed.high),
            p=parameters,
            lbx=posed.low,
            ubx=posed.high,
            lbg=posed.rows_low,
            ubg=posed.rows_high,
        )
        stats = solver.stats()
        y, iterations = np.asarray(found["x"]).ravel(), int(stats["iter_count"])
        dense = 0.0 if posed.hessian is None else ITERATION_ENTRY * posed.hessian.size
        effort.count(iterations * (ITERATION_ROW * (len(y) + len(posed.rows_low)) + dense))
        return y, iterations, str(stats["return_status"])

    @property
    def free_count(self) -> int:
        """How many coefficients the ends leave free."""
        return len(self._basis.free)

    @property
    def rate_rows(self) -> int:
        """How many of the hull rows, the first ones, bound the rate."""
        return len(self._limited[0])

    def keeps_rows(self, posed: PosedAxis, y: Array) -> bool:
        """Whether the hull of the spline with free coefficients y keeps its limits."""
        rows = self.jacobian @ y
        slack = ROUNDING * (posed.rows_high - posed.rows_low)
        within = (posed.rows_low - slack <= rows) & (rows <= posed.rows_high + slack)
        return bool(within.all())

    def values(self, tau: Array) -> Values:
        """The angle at tau (k,) in [0, 1) is start + scale times (free y + fixed c_fixed)."""
        basis = self._basis
        span = np.searchsorted(basis.spans, tau, side="right") - 1
        powers = (tau - basis.spans[span])[:, None] ** np.arange(basis.pieces.shape[1])
        all_c = np.zeros((len(tau), len(basis.free) + len(basis.fixed)))
        weights = np.einsum("kj,kjn->kn", powers, basis.pieces[span])
        np.put_along_axis(all_c, basis.living[span], weights, axis=1)
        return Values(all_c[:, basis.free] * self._unit, all_c[:, basis.fixed])

    def guess(self, posed: PosedAxis, profile: AxisProfile, aside_rad: Array) -> Array:
        """y of a motion near profile, moved aside by aside_rad at the `greville` instants."""
        at_s = self.greville * posed.duration_s
        angle = profile.evaluate(at_s)[0] + aside_rad
        free = (angle - posed.start_angle_rad) / posed.scale_rad / self._unit
        return np.asarray(np.clip(free, posed.low, posed.high))

    @property
    def greville(self) -> Array:
        """Where in normalised time a free coefficient is nearly the spline's value, (k,)."""
        degree = self._basis.pieces.shape[1] - 1
        knots = self._basis.knots[1:-1]
        means = np.convolve(knots, np.ones(degree) / degree, "valid")
        return np.asarray(means[self._basis.free])

    def pose(
        self,
        start: AxisState,
        end: AxisState,
        limits: AxisLimits,
        duration_s: float,
        *,
        scale_rad: float | None = None,
        avoid_modes: tuple[StructuralMode, ...] = (),
        emphasis: Array | None = None,
    ) -> PosedAxis:
        """The numbers that make this family of problems one problem.

        emphasis: of the modes' rows, see `modal_cost`.
        """
        basis, T = self._basis, duration_s
        scale = _distance_scale_rad(start, end, T) if scale_rad is None else scale_rad
        fixed = basis.fixed_from_ends @ _normalised_ends(start, end, T, scale)
        limit = bounds(limits)
        low = (limit[0][0] - start.angle_rad) / scale / self._unit
        high = (limit[0][1] - start.angle_rad) / scale / self._unit
        reach = (
            INSIDE
            * self._row_scale
            * np.concatenate(
                [
                    np.full(len(rows), limit[order][1] * T**order / scale)
                    for order, rows in enumerate(self._limited, start=1)
                ]
            )
        )
        known = self._jacobian_fixed @ fixed
        gradient, hessian = self._gradient @ fixed, None
        if avoid_modes:
            calm = modal_cost(
                modal_rows(basis.spans, basis.pieces, basis.living, duration_s, avoid_modes),
                emphasis,
            )
            free = calm[np.ix_(basis.free, basis.free)]
            hessian = self.hessian + free * np.outer(self._unit, self._unit)
            gradient = gradient + self._unit * (calm[np.ix_(basis.free, basis.fixed)] @ fixed)
        return PosedAxis(
            start_angle_rad=start.angle_rad,
            scale_rad=scale,
            duration_s=T,
            fixed=fixed,
            low=low,
            high=high,
            rows_low=-reach - known,
            rows_high=reach - known,
            gradient=gradient,
            hessian=hessian,
        )

    def profile(self, posed: PosedAxis, y: Array) -> AxisProfile:
        """The motion whose free coefficients are y."""
        basis, c = self._basis, self._coefficients(posed, y)
        powers = np.arange(basis.pieces.shape[1])
        coefficients = np.einsum("kjn,kn->kj", basis.pieces, c[basis.living])
        coefficients = coefficients * posed.scale_rad / posed.duration_s**powers
        coefficients[:, 0] += posed.start_angle_rad
        return AxisProfile(breakpoints_s=basis.spans * posed.duration_s, coefficients=coefficients)

    def _coefficients(self, posed: PosedAxis, y: Array) -> Array:
        basis = self._basis
        c = np.empty(len(basis.fixed) + len(basis.free))
        c[basis.fixed] = posed.fixed
        c[basis.free] = y * self._unit
        return c


def _distance_scale_rad(start: AxisState, end: AxisState, T: float) -> float:
    """What the motion is measured in, so that coefficients are of order one."""
    rates = (abs(start.rate_rad_s) + abs(end.rate_rad_s)) * T / 4.0
    accelerations = (abs(start.acceleration_rad_s2) + abs(end.acceleration_rad_s2)) * T**2 / 40.0
    return max(abs(end.angle_rad - start.angle_rad), rates, accelerations, 1e-9)


def _normalised_ends(start: AxisState, end: AxisState, T: float, scale: float) -> Array:
    return (
        np.array(
            [
                0.0,
                start.rate_rad_s * T,
                start.acceleration_rad_s2 * T**2,
                end.acceleration_rad_s2 * T**2,
                end.rate_rad_s * T,
                end.angle_rad - start.angle_rad,
            ]
        )
        / scale
    )
