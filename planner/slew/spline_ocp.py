"""The smoothest motion that a B-spline can make between two states within the limits.

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
from planner.slew.problem import AxisSlew
from planner.slew.solution import AxisProfile, obeys
from planner.slew.spline_basis import derivative_matrices, jerk_cost, spline_basis
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

WEIGHINGS = 12  # of modes, one against another; all but a few slews need one
RESIDUAL_SHARE = 0.95  # of the residual that is wanted, so that rows don't exceed it
WEIGHT_CHANGES = (0.3, 3.0)  # least and most by which a mode's weight changes at once
HOPELESS = 20.0  # times the residual wanted: no weights have been seen to gain a tenfold
# Of `planner.effort`: a solve, a row or variable in an iteration, an entry of a full hessian.
SOLVE, ITERATION_ROW, ITERATION_ENTRY = 100, 0.3, 0.03


class OcpResult(NamedTuple):
    """A candidate to be judged by its polynomials, whatever the solver says of it."""

    profile: AxisProfile
    iterations: int


@dataclass(frozen=True, eq=False)
class AxisProgramme:
    """One axis of a slew as a programme in y: the k free coefficients over their units.

    The angle is start + scale_rad * sum of c_i B_i(t/T).  fixed_coefficients: those that the
    ends determine.  least_y, greatest_y bound y; least_rows, greatest_rows the hull rows.
    cost_gradient (k,) and, where structural modes are avoided, cost_hessian (k, k).
    """

    start_angle_rad: float
    scale_rad: float
    duration_s: float
    fixed_coefficients: Array
    least_y: Array
    greatest_y: Array
    least_rows: Array
    greatest_rows: Array
    cost_gradient: Array
    cost_hessian: Array | None


class ValueMatrices(NamedTuple):
    """What y (k, m) and the fixed coefficients (k, 6) add to the normalised angle."""

    free_matrix: Array
    fixed_matrix: Array


class SplineOcp:
    """Least integral of squared jerk over clamped B-splines on fixed knots.

    breakpoints_tau: from 0 to 1, the knots in normalised time.
    hessian: of the cost in y.  jacobian: of the hull rows in y.
    Source: hull property, de Boor, A Practical Guide to Splines (2001), ch. XI.
    """

    def __init__(self, breakpoints_tau: Array, degree: int) -> None:
        self._basis = basis = spline_basis(breakpoints_tau, degree)
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
        return self._build_solver(casadi.sparsify(casadi.DM(self.hessian)), parameter)

    @cached_property
    def _modes_solver(self) -> "casadi.Function":
        """Its parameters are the gradient and the full hessian, which modes change."""
        import casadi

        n = self.free_count
        parameters = casadi.MX.sym("gradient and hessian", n + n * n)
        return self._build_solver(casadi.reshape(parameters[n:], n, n), parameters)

    def _build_solver(
        self, hessian: "casadi.DM | casadi.MX", parameters: "casadi.MX"
    ) -> "casadi.Function":
        # CasADi takes 0.1 s to import, which only a process that solves should pay.
        import casadi

        y = casadi.MX.sym("y", self.free_count)
        programme: dict[str, Any] = {
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
        return casadi.nlpsol("slew", "ipopt", programme, options)

    def solve(self, slew: AxisSlew) -> OcpResult:
        """The smoothest spline from start to end, if the solver is to be believed.

        avoid_modes are left as calm as the limits allow; see `planner.slew.vibration`.
        """
        if slew.avoid_modes:
            return self._solve_avoiding_modes(slew)
        programme = self.pose(slew)
        y, iterations, _ = self._run(programme)
        return OcpResult(self.profile(programme, y), iterations)

    def _solve_avoiding_modes(self, slew: AxisSlew) -> OcpResult:
        """With weights shifted towards what rings too much, until none does or tries run out.

        Source: Lawson 1961, the least greatest residual by least squares weighed anew.
        """
        rows = modal_rows(self._basis, slew.duration_s, slew.avoid_modes)
        weight_factors = np.ones(len(rows))
        iterations, least_share = 0, np.inf
        best: AxisProfile | None = None
        for _ in range(WEIGHINGS):
            programme = self.pose(slew, weight_factors=weight_factors)
            y, used, success = self._run(programme)
            iterations += used
            ends_over_scale = _ends_over_scale(slew, programme.scale_rad)
            left = np.abs(rows @ self._coefficients(programme, y))
            wanted = wanted_residuals(ends_over_scale, slew.duration_s, slew.avoid_modes)
            shares = left / (RESIDUAL_SHARE * wanted)
            profile = self.profile(programme, y)
            good = success and obeys(profile, slew.start, slew.end, slew.limits)
            if best is None or (good and shares.max() < least_share):
                least_share = float(shares.max())
                best = profile
            if not good or not 1.0 < least_share < HOPELESS:
                break
            weight_factors = weight_factors * np.clip(shares, *WEIGHT_CHANGES)
        assert best is not None
        return OcpResult(best, iterations)

    def _run(self, programme: AxisProgramme) -> tuple[Array, int, bool]:
        """y, iterations and whether the solver says that it is the optimum."""
        if programme.cost_hessian is None:
            solver, parameters = self._solver, programme.cost_gradient
            optimum = self._unconstrained @ programme.fixed_coefficients
        else:
            solver = self._modes_solver
            parameters = np.concatenate([programme.cost_gradient, programme.cost_hessian.ravel()])
            optimum = np.asarray(-np.linalg.solve(programme.cost_hessian, programme.cost_gradient))
            bounded = np.concatenate([optimum, self.jacobian @ optimum])
            least = np.concatenate([programme.least_y, programme.least_rows])
            greatest = np.concatenate([programme.greatest_y, programme.greatest_rows])
            if ((least <= bounded) & (bounded <= greatest)).all():
                return optimum, 0, True
        effort.spend(SOLVE)
        found = solver(
            x0=np.clip(optimum, programme.least_y, programme.greatest_y),
            p=parameters,
            lbx=programme.least_y,
            ubx=programme.greatest_y,
            lbg=programme.least_rows,
            ubg=programme.greatest_rows,
        )
        stats = solver.stats()
        y, iterations = np.asarray(found["x"]).ravel(), int(stats["iter_count"])
        full = 0.0 if programme.cost_hessian is None else programme.cost_hessian.size
        rows = len(y) + len(programme.least_rows)
        effort.count(iterations * (ITERATION_ROW * rows + ITERATION_ENTRY * full))
        return y, iterations, stats["return_status"] == "Solve_Succeeded"

    @property
    def free_count(self) -> int:
        """How many coefficients the ends leave free."""
        return len(self._basis.free)

    @property
    def rate_rows(self) -> int:
        """How many of the hull rows, the first ones, bound the rate."""
        return len(self._limited[0])

    def keeps_rows(self, programme: AxisProgramme, y_coefficients: Array) -> bool:
        """Whether the hull of the spline with free coefficients y keeps its limits."""
        rows = self.jacobian @ y_coefficients
        least, greatest = programme.least_rows, programme.greatest_rows
        slack = ROUNDING * (greatest - least)
        within = (least - slack <= rows) & (rows <= greatest + slack)
        return bool(within.all())

    def value_matrices(self, tau: Array) -> ValueMatrices:
        """For the angle at tau (k,) in [0, 1): start + scale times (free y + fixed c)."""
        basis = self._basis
        span = np.searchsorted(basis.breakpoints_tau, tau, side="right") - 1
        powers = (tau - basis.breakpoints_tau[span])[:, None] ** np.arange(
            basis.power_matrix.shape[1]
        )
        all_c = np.zeros((len(tau), len(basis.free) + len(basis.fixed)))
        weights = np.einsum("kj,kjn->kn", powers, basis.power_matrix[span])
        np.put_along_axis(all_c, basis.support[span], weights, axis=1)
        return ValueMatrices(all_c[:, basis.free] * self._unit, all_c[:, basis.fixed])

    def guess_y(self, programme: AxisProgramme, profile: AxisProfile, aside_rad: Array) -> Array:
        """y of a motion near profile, moved aside by aside_rad at the `greville_tau` instants."""
        at_s = self.greville_tau * programme.duration_s
        angle = profile.evaluate(at_s)[0] + aside_rad
        free = (angle - programme.start_angle_rad) / programme.scale_rad / self._unit
        return np.asarray(np.clip(free, programme.least_y, programme.greatest_y))

    @property
    def greville_tau(self) -> Array:
        """Where in normalised time a free coefficient is nearly the spline's value, (k,)."""
        degree = self._basis.power_matrix.shape[1] - 1
        knots = self._basis.knots[1:-1]
        means = np.convolve(knots, np.ones(degree) / degree, "valid")
        return np.asarray(means[self._basis.free])

    def pose(
        self,
        slew: AxisSlew,
        *,
        scale_rad: float | None = None,
        weight_factors: Array | None = None,
    ) -> AxisProgramme:
        """The numbers that make this family of problems one problem.

        weight_factors: of the modes' rows, see `modal_cost`.
        """
        basis, T = self._basis, slew.duration_s
        scale = _distance_scale_rad(slew) if scale_rad is None else scale_rad
        fixed = basis.fixed_from_ends @ _ends_over_scale(slew, scale)
        limit = slew.limits.bounds
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
        if slew.avoid_modes:
            cost = modal_cost(modal_rows(basis, T, slew.avoid_modes), weight_factors)
            free = cost[np.ix_(basis.free, basis.free)]
            hessian = self.hessian + free * np.outer(self._unit, self._unit)
            gradient = gradient + self._unit * (cost[np.ix_(basis.free, basis.fixed)] @ fixed)
        return AxisProgramme(
            start_angle_rad=slew.start.angle_rad,
            scale_rad=scale,
            duration_s=T,
            fixed_coefficients=fixed,
            least_y=(limit[0][0] - slew.start.angle_rad) / scale / self._unit,
            greatest_y=(limit[0][1] - slew.start.angle_rad) / scale / self._unit,
            least_rows=-reach - known,
            greatest_rows=reach - known,
            cost_gradient=gradient,
            cost_hessian=hessian,
        )

    def profile(self, programme: AxisProgramme, y_coefficients: Array) -> AxisProfile:
        """The motion whose free coefficients are y."""
        basis, c = self._basis, self._coefficients(programme, y_coefficients)
        powers = np.arange(basis.power_matrix.shape[1])
        coefficients = np.einsum("kjn,kn->kj", basis.power_matrix, c[basis.support])
        coefficients = coefficients * programme.scale_rad / programme.duration_s**powers
        coefficients[:, 0] += programme.start_angle_rad
        return AxisProfile(
            breakpoints_s=basis.breakpoints_tau * programme.duration_s, coefficients=coefficients
        )

    def _coefficients(self, programme: AxisProgramme, y: Array) -> Array:
        basis = self._basis
        c = np.empty(len(basis.fixed) + len(basis.free))
        c[basis.fixed] = programme.fixed_coefficients
        c[basis.free] = y * self._unit
        return c


def _distance_scale_rad(slew: AxisSlew) -> float:
    """What the motion is measured in, so that coefficients are of order one."""
    start, end, T = slew.start, slew.end, slew.duration_s
    rates = (abs(start.rate_rad_s) + abs(end.rate_rad_s)) * T / 4.0
    accelerations = (abs(start.acceleration_rad_s2) + abs(end.acceleration_rad_s2)) * T**2 / 40.0
    return max(abs(end.angle_rad - start.angle_rad), rates, accelerations, 1e-9)


def _ends_over_scale(slew: AxisSlew, scale_rad: float) -> Array:
    """Angle, rate, acceleration at the start, and backwards at the end, in normalised time."""
    start, end, T = slew.start, slew.end, slew.duration_s
    ends = [
        0.0,
        start.rate_rad_s * T,
        start.acceleration_rad_s2 * T**2,
        end.acceleration_rad_s2 * T**2,
        end.rate_rad_s * T,
        end.angle_rad - start.angle_rad,
    ]
    return np.array(ends) / scale_rad
