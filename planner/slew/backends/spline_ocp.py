"""What is the smoothest motion a B-spline can make between two states within the limits?

In normalised time tau = t/T the angle is a clamped B-spline.  Its derivatives are B-splines
whose coefficients D_k c are linear in its own c, and a B-spline never leaves the hull of its
coefficients: limits put on D_k c hold at every instant.  Every matrix depends on the knots
alone; duration, states and limits enter through bounds and a gradient, so that one solver
serves every slew.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from planner.platforms import AxisLimits
from planner.slew.problem import AxisState
from planner.slew.solution import AxisProfile, bounds

Array = NDArray[np.float64]
JERK_COST = 720.0  # least integral of squared jerk of a unit rest-to-rest move in unit time
INSIDE = 1.0 - 1e-8  # of the limits, so that the solver's last digits stay within them
ENDS = 3  # angle, rate and acceleration at an end fix so many coefficients there
GAUSS_POINTS = 3  # exact to degree 5; squared third derivatives of a quintic have degree 4
IPOPT: dict[str, str | float | int] = {
    "print_level": 0,
    "sb": "yes",
    "linear_solver": "mumps",  # others crash or are not packaged everywhere
    "tol": 1e-8,
    "bound_relax_factor": 0.0,
    "acceptable_iter": 0,
    "max_iter": 120,
    "mehrotra_algorithm": "yes",  # predictor-corrector: made for convex quadratic programs
    "jac_d_constant": "yes",
    "hessian_constant": "yes",
}


class OcpResult(NamedTuple):
    """A candidate to be judged by its polynomials; ipopt_status is hearsay."""

    profile: AxisProfile
    iterations: int
    ipopt_status: str


@dataclass(frozen=True)
class _Basis:
    """Everything the knots determine; n coefficients, the first and last three fixed.

    derivatives: D_0 = 1, D_1, D_2, D_3.  fixed_from_ends: (6, 6) from the normalised angle,
    rate, acceleration at both ends.  pieces: (spans, degree + 1, n) power coefficients.
    """

    knots: Array
    spans: Array
    derivatives: tuple[Array, ...]
    fixed: NDArray[np.intp]
    free: NDArray[np.intp]
    fixed_from_ends: Array
    cost: Array
    pieces: Array


class SplineOcp:
    """Least integral of squared jerk over clamped B-splines on fixed knots.

    breakpoints: from 0 to 1, the knots in normalised time.
    Source: hull property, de Boor, A Practical Guide to Splines (2001), ch. XI.
    """

    def __init__(self, breakpoints: Array, degree: int) -> None:
        # CasADi takes 0.1 s to import, which only a process that solves should pay.
        import casadi

        self._basis = basis = _basis(breakpoints, degree)
        cost_free = basis.cost[np.ix_(basis.free, basis.free)]
        # Short spans make costs of 1e11 beside 1: in c the gradient drowns in rounding.
        self._unit = 1.0 / np.sqrt(JERK_COST * np.diag(cost_free))
        self._hessian = cost_free * np.outer(self._unit, self._unit)
        self._gradient = basis.cost[np.ix_(basis.free, basis.fixed)] * self._unit[:, None]
        self._unconstrained = -np.linalg.solve(self._hessian, self._gradient)
        self._limited = [
            np.flatnonzero(np.any(matrix[:, basis.free] != 0.0, axis=1))
            for matrix in basis.derivatives[1:]
        ]
        rows = np.vstack(
            [d[rows] for d, rows in zip(basis.derivatives[1:], self._limited, strict=True)]
        )
        self._row_scale = 1.0 / np.abs(rows[:, basis.free] * self._unit).max(axis=1)
        self._jacobian = rows[:, basis.free] * self._unit * self._row_scale[:, None]
        self._jacobian_fixed = rows[:, basis.fixed] * self._row_scale[:, None]

        y = casadi.MX.sym("y", len(basis.free))
        gradient = casadi.MX.sym("gradient", len(basis.free))
        hessian = casadi.sparsify(casadi.DM(self._hessian))
        quadratic = casadi.bilin(hessian, y, y) / 2.0
        self._solver = casadi.nlpsol(
            "slew",
            "ipopt",
            {
                "x": y,
                "p": gradient,
                "f": quadratic + casadi.dot(gradient, y),
                "g": casadi.mtimes(casadi.sparsify(casadi.DM(self._jacobian)), y),
            },
            {"print_time": False, "ipopt": IPOPT},
        )

    def solve(
        self, start: AxisState, end: AxisState, limits: AxisLimits, duration_s: float
    ) -> OcpResult:
        """The smoothest spline from start to end in duration_s, if the solver is to be believed."""
        basis, T = self._basis, duration_s
        scale = _distance_scale_rad(start, end, T)
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
        free_optimum = self._unconstrained @ fixed
        found = self._solver(
            x0=np.clip(free_optimum, low, high),
            p=self._gradient @ fixed,
            lbx=low,
            ubx=high,
            lbg=-reach - known,
            ubg=reach - known,
        )
        stats = self._solver.stats()
        c = np.empty(len(basis.fixed) + len(basis.free))
        c[basis.fixed] = fixed
        c[basis.free] = np.asarray(found["x"]).ravel() * self._unit
        powers = np.arange(basis.pieces.shape[1])
        coefficients = np.einsum("kjn,n->kj", basis.pieces, c) * scale / T**powers
        coefficients[:, 0] += start.angle_rad
        profile = AxisProfile(breakpoints_s=basis.spans * T, coefficients=coefficients)
        return OcpResult(profile, int(stats["iter_count"]), str(stats["return_status"]))


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


def _basis(breakpoints: Array, degree: int) -> _Basis:
    knots = np.concatenate([np.zeros(degree), breakpoints, np.ones(degree)])
    n = len(knots) - degree - 1
    derivatives = [np.eye(n)]
    for order in range(1, 4):
        derivatives.append(_difference(knots, n, degree, order) @ derivatives[-1])
    fixed = np.r_[0:ENDS, n - ENDS : n]
    ends = np.stack(
        [
            *(derivatives[order][0] for order in range(ENDS)),
            *(derivatives[order][-1] for order in reversed(range(ENDS))),
        ]
    )
    pieces = _power_pieces(breakpoints, knots, n, degree)
    return _Basis(
        knots=knots,
        spans=breakpoints,
        derivatives=tuple(derivatives),
        fixed=fixed,
        free=np.arange(ENDS, n - ENDS),
        fixed_from_ends=np.linalg.inv(ends[:, fixed]),
        cost=_jerk_cost(breakpoints, pieces) / JERK_COST,
        pieces=pieces,
    )


def _difference(knots: Array, n: int, degree: int, order: int) -> Array:
    """Coefficients of derivative `order` from those of order - 1, shape (n-order, n-order+1)."""
    count, p = n - order, degree - order + 1
    inner = knots[order:-order]
    weight = p / (inner[p : p + count] - inner[:count])
    matrix = np.zeros((count, count + 1))
    index = np.arange(count)
    matrix[index, index], matrix[index, index + 1] = -weight, weight
    return matrix


def _power_pieces(breakpoints: Array, knots: Array, n: int, degree: int) -> Array:
    """(spans, degree+1, n): Taylor coefficients at each span's start, from the coefficients."""
    matrix, factorial = np.eye(n), 1.0
    pieces = np.empty((len(breakpoints) - 1, degree + 1, n))
    for power in range(degree + 1):
        if power:
            matrix = _difference(knots, n, degree, power) @ matrix
            factorial *= power
        reduced = knots[power : len(knots) - power]
        for span, at in enumerate(breakpoints[:-1]):
            weights = _values_at(reduced, degree - power, span, at)
            pieces[span, power] = weights @ matrix[span : span + len(weights)] / factorial
    return pieces


def _values_at(knots: Array, degree: int, span: int, at: float) -> Array:
    """The degree + 1 B-splines that live on a span, at one point of it (Cox-de Boor)."""
    left = span + degree
    values = np.array([1.0])
    for p in range(1, degree + 1):
        low, high = knots[left - p + 1 : left + 1], knots[left + 1 : left + p + 1]
        share = values / (high - low)
        values = np.append((high - at) * share, 0.0) + np.append(0.0, (at - low) * share)
    return values


def _jerk_cost(breakpoints: Array, pieces: Array) -> Array:
    """Integral over [0, 1] of the outer product of third derivatives, shape (n, n)."""
    nodes, weights = np.polynomial.legendre.leggauss(GAUSS_POINTS)
    width = np.diff(breakpoints)
    total = np.zeros((pieces.shape[2], pieces.shape[2]))
    powers = np.arange(3, pieces.shape[1])
    factor = powers * (powers - 1) * (powers - 2)
    for node, weight in zip(nodes, weights, strict=True):
        x = width * (node + 1.0) / 2.0
        third = np.einsum("kj,kjn->kn", factor * x[:, None] ** (powers - 3), pieces[:, 3:])
        total += np.einsum("k,kn,km->nm", weight * width / 2.0, third, third)
    return total
