"""One axis's part of the programme of a detour: a B-spline between two states within limits.

In normalised time tau = t/T the angle is a clamped B-spline.  Its derivatives are B-splines
whose coefficients D_k c are linear in its own c, and a B-spline never leaves the hull of its
coefficients: limits put on D_k c hold at every instant.  Every matrix depends on the knots
alone; duration, states and limits enter through bounds and a gradient, so that one solver
serves every slew.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from planner.base.arrays import Array
from planner.motion.slew.problem import AxisSlew
from planner.motion.slew.solution import AxisProfile
from planner.motion.slew.vibration import JERK_COST, WEIGHTS, span_residuals
from planner.world.platforms import StructuralMode

# Clamped B-splines: what their coefficients give at every instant of normalised time tau.

ENDS = 3  # angle, rate and acceleration at an end fix so many coefficients there
GAUSS_POINTS = 3  # exact to degree 5; squared third derivatives of a quintic have degree 4


@dataclass(frozen=True)
class SplineBasis:
    """Everything the knots determine; n coefficients, the first and last three fixed.

    breakpoints_tau: the knots without repetition, from 0 to 1.
    fixed_from_ends: (6, 6) from the normalised angle, rate, acceleration at both ends.
    power_matrix: (spans, degree + 1, degree + 1), power coefficients from the coefficients
    whose splines don't vanish on a span; all n of hundreds of spans would take 100 MB.
    """

    knots: Array
    breakpoints_tau: Array
    fixed: NDArray[np.intp]
    free: NDArray[np.intp]
    fixed_from_ends: Array
    power_matrix: Array

    @property
    def support(self) -> NDArray[np.intp]:
        """Coefficients whose splines don't vanish on each span, shape (spans, degree + 1)."""
        spans, powers, _ = self.power_matrix.shape
        return np.asarray(np.arange(spans)[:, None] + np.arange(powers))


def spline_basis(breakpoints_tau: Array, degree: int) -> SplineBasis:
    knots = np.concatenate([np.zeros(degree), breakpoints_tau, np.ones(degree)])
    n = len(knots) - degree - 1
    derivatives = derivative_matrices(knots, degree)
    fixed = np.r_[0:ENDS, n - ENDS : n]
    ends = np.stack(
        [
            *(derivatives[order][0] for order in range(ENDS)),
            *(derivatives[order][-1] for order in reversed(range(ENDS))),
        ]
    )
    return SplineBasis(
        knots=knots,
        breakpoints_tau=breakpoints_tau,
        fixed=fixed,
        free=np.arange(ENDS, n - ENDS),
        fixed_from_ends=np.linalg.inv(ends[:, fixed]),
        power_matrix=_power_matrix(breakpoints_tau, knots, degree),
    )


def derivative_matrices(knots: Array, degree: int) -> list[Array]:
    """D_0 = 1 to D_3: coefficients of each derivative from the spline's own, (n - order, n)."""
    n = len(knots) - degree - 1
    chain = [np.eye(n)]
    for order in range(1, ENDS + 1):
        weight = _difference_weights(knots, n, degree, order)
        chain.append(weight[:, None] * np.diff(chain[-1], axis=0))
    return chain


def _difference_weights(knots: Array, n: int, degree: int, order: int) -> Array:
    """What the differences of the coefficients of derivative order - 1 count, (n - order,)."""
    count, p = n - order, degree - order + 1
    inner = knots[order:-order]
    return np.asarray(p / (inner[p : p + count] - inner[:count]))


def _power_matrix(breakpoints_tau: Array, knots: Array, degree: int) -> Array:
    """Taylor coefficients at each span's start, from the coefficients of its support."""
    n, spans = len(knots) - degree - 1, len(breakpoints_tau) - 1
    local = np.tile(np.eye(degree + 1), (spans, 1, 1))
    power_matrix, factorial = np.empty((spans, degree + 1, degree + 1)), 1.0
    for power in range(degree + 1):
        if power:
            weight = _difference_weights(knots, n, degree, power)
            here = weight[np.arange(spans)[:, None] + np.arange(degree + 1 - power)]
            local = here[:, :, None] * np.diff(local, axis=1)
            factorial *= power
        reduced = knots[power : len(knots) - power]
        values = _values_at_starts(reduced, degree - power, breakpoints_tau[:-1])
        power_matrix[:, power] = np.einsum("kl,kln->kn", values, local) / factorial
    return power_matrix


def _values_at_starts(knots: Array, degree: int, starts_tau: Array) -> Array:
    """B-splines that don't vanish on each span, at its start (Cox-de Boor), (k, degree + 1)."""
    left = np.arange(len(starts_tau))[:, None] + degree
    at = starts_tau[:, None]
    values = np.ones((len(starts_tau), 1))
    for p in range(1, degree + 1):
        low, high = knots[left + np.arange(1 - p, 1)], knots[left + np.arange(1, p + 1)]
        share = values / (high - low)
        values = np.pad((high - at) * share, ((0, 0), (0, 1)))
        values[:, 1:] += (at - low) * share
    return values


def jerk_cost(basis: SplineBasis, n: int) -> Array:
    """Integral over [0, 1] of the outer product of third derivatives, shape (n, n)."""
    nodes, weights = np.polynomial.legendre.leggauss(GAUSS_POINTS)
    width, support = np.diff(basis.breakpoints_tau), basis.support
    total = np.zeros((n, n))
    powers = np.arange(3, basis.power_matrix.shape[1])
    factor = powers * (powers - 1) * (powers - 2)
    for node, weight in zip(nodes, weights, strict=True):
        x = width * (node + 1.0) / 2.0
        third = np.einsum(
            "kj,kjn->kn", factor * x[:, None] ** (powers - 3), basis.power_matrix[:, 3:]
        )
        squares = (weight * width / 2.0)[:, None, None] * third[:, :, None] * third[:, None, :]
        np.add.at(total, (support[:, :, None], support[:, None, :]), squares)
    return total


@dataclass(frozen=True, kw_only=True)
class SplineProgrammeOptions:
    """How a spline's programme is solved, and what that takes."""

    rounding: float = 1e-9  # of the limits' ranges
    on_rows_kept: int = 2  # both axes ask for the same one; at 200 rows it takes 3 MB
    inside: float = 1.0 - 1e-8  # of the limits, so that the solver's last digits stay within them
    solve: int = 100  # of `effort`: a solve, and
    iteration_entry: float = 0.03  # an entry of a full hessian in each iteration


OPTIONS = SplineProgrammeOptions()


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
        derivatives = derivative_matrices(basis.knots, degree)[1:]
        self._limited = [
            np.flatnonzero(np.any(matrix[:, basis.free] != 0.0, axis=1)) for matrix in derivatives
        ]
        rows = np.vstack([d[rows] for d, rows in zip(derivatives, self._limited, strict=True)])
        self._row_scale = 1.0 / np.abs(rows[:, basis.free] * self._unit).max(axis=1)
        self.jacobian = rows[:, basis.free] * self._unit * self._row_scale[:, None]
        self._jacobian_fixed = rows[:, basis.fixed] * self._row_scale[:, None]

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
        slack = OPTIONS.rounding * (greatest - least)
        within = (least - slack <= rows) & (rows <= greatest + slack)
        return bool(within.all())

    def value_matrices(self, tau: Array) -> ValueMatrices:
        """Matrices for the angle at tau (k,) in [0, 1): start + scale times (free y + fixed c)."""
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

    def pose_programme(
        self,
        slew: AxisSlew,
        *,
        scale_rad: float,
    ) -> AxisProgramme:
        """The numbers that make this family of problems one problem."""
        basis, T = self._basis, slew.duration_s
        scale = scale_rad
        fixed = basis.fixed_from_ends @ _ends_over_scale(slew, scale)
        limit = slew.limits.bounds
        reach = (
            OPTIONS.inside
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
            cost = _modal_cost(basis, T, slew.avoid_modes)
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
        basis, c = self._basis, self._all_coefficients(programme, y_coefficients)
        powers = np.arange(basis.power_matrix.shape[1])
        coefficients = np.einsum("kjn,kn->kj", basis.power_matrix, c[basis.support])
        coefficients = coefficients * programme.scale_rad / programme.duration_s**powers
        coefficients[:, 0] += programme.start_angle_rad
        return AxisProfile(
            breakpoints_s=basis.breakpoints_tau * programme.duration_s, coefficients=coefficients
        )

    def _all_coefficients(self, programme: AxisProgramme, y: Array) -> Array:
        basis = self._basis
        c = np.empty(len(basis.fixed) + len(basis.free))
        c[basis.fixed] = programme.fixed_coefficients
        c[basis.free] = y * self._unit
        return c


@lru_cache(maxsize=8)
def graded_ocp(spans: int) -> SplineOcp:
    """Quintics on knots five times denser at the ends, where the jerk must turn quickly.

    Made once per process.
    """
    x = np.linspace(0.0, 1.0, spans + 1)
    breakpoints_tau = 0.2 * x + 0.4 * (1.0 - np.cos(np.pi * x))
    breakpoints_tau[0], breakpoints_tau[-1] = 0.0, 1.0
    return SplineOcp(breakpoints_tau, degree=5)


@lru_cache(maxsize=OPTIONS.on_rows_kept)
def ocp_on_all_rows(rows: int) -> SplineOcp:
    """Cubics whose jerk may change on every row and nowhere else; a Hermite reproduces them."""
    return SplineOcp(np.linspace(0.0, 1.0, rows + 1), degree=3)


def _modal_cost(basis: SplineBasis, duration_s: float, modes: tuple[StructuralMode, ...]) -> Array:
    """Matrix (n, n) of the cost c^T P c / 2 of what coefficients c leave of the detuned modes.

    Source: Singer, Seering 1990, residual vibration as a constraint on the command; here soft.
    """
    powers = np.arange(3, basis.power_matrix.shape[1])
    third = basis.power_matrix[:, 3:] * (powers * (powers - 1) * (powers - 2))[:, None]
    residuals = span_residuals(basis.breakpoints_tau, duration_s, modes, len(powers))
    rows = np.zeros((int(basis.support.max()) + 1, len(residuals)), dtype=complex)
    np.add.at(rows, basis.support, np.einsum("ekj,kjn->kne", residuals, third))
    weights = np.resize(WEIGHTS, len(residuals))
    return np.asarray(sum((part * weights) @ part.T for part in (rows.real, rows.imag)))


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
