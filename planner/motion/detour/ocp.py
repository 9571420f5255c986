"""The smoothest motion of both axes that keeps the boresight out of caps.

The two axes' splines and limits are those of `spline_ocp`; caps couple them.  The cosine
between boresight and a cap's axis is bilinear in the cosines and sines of the two angles,
so that one solver serves every platform and every cap, another one at every instant.
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import product
from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np

from planner.base.arrays import Array, Mask
from planner.base.solvers import Answer, Options, Solver, SolverRun, Work
from planner.motion.detour.spline_ocp import (
    OPTIONS as SPLINE_PROGRAMME_OPTIONS,
)
from planner.motion.detour.spline_ocp import (
    AxisProgramme,
    SplineOcp,
)
from planner.motion.pointing.angles import cosine_coefficients
from planner.motion.slew.solution import AxisProfile
from planner.world.platforms import TwoAxisPlatform

if TYPE_CHECKING:
    import casadi


@dataclass(frozen=True, kw_only=True)
class DetourProgrammeOptions:
    """How a detour's programme is sampled, and what solving it takes."""

    coarse_points: int = 60  # instants at which caps hold for a far guess, and
    fine_points: int = 160  # near the end, with the caps kept
    not_counting: float = 1e3  # beyond any scaled cosine
    solve: int = 300  # of `effort`: a solve
    solve_instant: int = 10  # and each instant of its caps
    # of `effort`: a row or variable in an iteration, as caps fill what is factorised
    iteration_row: float = 0.4


OPTIONS = DetourProgrammeOptions()

# How a solve begins: from far guesses; from such and led off wide of them, to other optima; or
# near its end, with the caps kept at many instants.
Start = Literal["far", "wide", "near"]
STARTS: dict[Start, Options] = {
    "far": {"tol": 1e-4, "mu_init": 1e-2, "max_iter": 40},
    "wide": {"tol": 1e-4, "mu_init": 1e-1, "max_iter": 40},
    # The margin beside a cap is a thousand times the tolerance.
    "near": {"tol": 1e-6, "mu_init": 1e-4, "max_iter": 60},
}


class Caps(NamedTuple):
    """What to keep out of at every instant: axis_platform (caps, instants, 3), unit vectors;
    half_angle_rad and counts, whether it must be kept out of, (caps, instants) each."""

    axis_platform: Array
    half_angle_rad: Array
    counts: Mask


class _Parts(NamedTuple):
    """The programme's parts: variables, parameters, cost, and cosines with the caps' axes.

    cost_weight and row_weights: of cost and cosines in the Lagrangian, of which hessian is the
    upper triangle.
    """

    y: "casadi.MX"
    parameters: "casadi.MX"
    cost: "casadi.MX"
    cosines: "casadi.MX"
    cost_weight: "casadi.MX"
    row_weights: "casadi.MX"
    hessian: "casadi.MX"


class DetourOcp:
    """Least integral of squared jerk of both axes, out of caps at some instants.

    spline: the basis of each axis.  caps: how many at once.  with_modes: whether the cost has
    modes to avoid.  start: from what; far guesses suit fewer instants.
    """

    def __init__(self, spline: SplineOcp, caps: int, *, with_modes: bool, start: Start) -> None:
        self._spline, self._caps, self.start = spline, caps, start
        self._with_modes = with_modes
        points = OPTIONS.fine_points if start == "near" else OPTIONS.coarse_points
        self.tau = np.linspace(0.0, 1.0, points + 2)[1:-1]
        self._values = spline.value_matrices(self.tau)

    @cached_property
    def _parts(self) -> _Parts:
        # CasADi takes 0.1 s to import, which only a process that solves should pay.
        import casadi

        spline, caps, points = self._spline, self._caps, len(self.tau)
        n = spline.free_count
        y = casadi.MX.sym("y", 2 * n)
        p_gradient = casadi.MX.sym("gradient", 2 * n)
        p_hessian = [casadi.MX.sym(f"hessian{axis}", n, n) for axis in range(2 * self._with_modes)]
        p_base, p_scale = casadi.MX.sym("base", 2 * points), casadi.MX.sym("scale")
        p_cosine = casadi.MX.sym("cosine", points * caps, 9)
        cost_weight, row_weights = casadi.MX.sym("weight"), casadi.MX.sym("rows", points * caps)

        own = casadi.MX(casadi.sparsify(casadi.DM(spline.hessian)))
        cost_hessian = casadi.diagcat(*(p_hessian or [own, own]))
        cost = casadi.bilin(cost_hessian, y, y) / 2.0 + casadi.dot(p_gradient, y)
        free = casadi.sparsify(casadi.DM(self._values.free_matrix))
        angles = casadi.vertsplit(
            p_base + p_scale * casadi.mtimes(casadi.diagcat(free, free), y), points
        )
        derivatives = [_trigonometric_rows(casadi.repmat(angle, caps)) for angle in angles]

        def cosines(outer: int, inner: int) -> "casadi.MX":
            """Differentiated so often by either angle."""
            by_outer, by_inner = derivatives[0][outer], derivatives[1][inner]
            terms = [
                p_cosine[:, 3 * i + j] * by_outer[i] * by_inner[j]
                for i, j in product(range(3), repeat=2)
            ]
            return sum(terms, casadi.MX(0))

        def curvature(outer: int, inner: int) -> "casadi.MX":
            weighted = casadi.reshape(row_weights * cosines(outer, inner), points, caps)
            instants = p_scale**2 * casadi.sum2(weighted)
            return casadi.mtimes(free.T, casadi.mtimes(casadi.diag(instants), free))

        mixed = curvature(1, 1)
        rows = casadi.blockcat([[curvature(2, 0), mixed], [mixed, curvature(0, 2)]])
        parameters = [p_gradient, *map(casadi.vec, p_hessian), p_base, p_scale]
        return _Parts(
            y=y,
            parameters=casadi.vertcat(*parameters, casadi.vec(p_cosine)),
            cost=cost,
            cosines=cosines(0, 0),
            cost_weight=cost_weight,
            row_weights=row_weights,
            hessian=casadi.triu(cost_weight * cost_hessian + rows),
        )

    @cached_property
    def _rates_only(self) -> Solver:
        """Neglects the limits of acceleration and jerk, which few slews meet: a third less work."""
        return self._build_solver(self._spline.rate_rows)

    @cached_property
    def _complete(self) -> Solver:
        return self._build_solver(len(self._spline.jacobian))

    def _build_solver(self, hull_rows: int) -> Solver:
        import casadi

        parts = self._parts
        jacobian = casadi.sparsify(casadi.DM(self._spline.jacobian[:hull_rows]))
        rows = casadi.mtimes(casadi.diagcat(jacobian, jacobian), parts.y)
        linear = casadi.MX.sym("hull", rows.shape[0])
        instants, size = parts.cosines.numel(), parts.y.numel()
        full = size**2 / 2.0 if self._with_modes else 0.0  # entries of the hessians
        iteration = (
            OPTIONS.iteration_row * (rows.numel() + instants + size)
            + SPLINE_PROGRAMME_OPTIONS.iteration_entry * full
        )
        return Solver(
            {
                "x": parts.y,
                "p": parts.parameters,
                "f": parts.cost,
                "g": casadi.vertcat(rows, parts.cosines),
            },
            STARTS[self.start],
            Work(OPTIONS.solve + OPTIONS.solve_instant * instants, iteration),
            # CasADi takes up to 40 s to find it by differentiation where modes fill it.
            hessian=casadi.Function(
                "nlp_hess_l",
                [
                    parts.y,
                    parts.parameters,
                    parts.cost_weight,
                    casadi.vertcat(linear, parts.row_weights),
                ],
                [parts.hessian],
                ["x", "p", "lam_f", "lam_g"],
                ["triu_hess_gamma_x_x"],
            ),
        )

    def solve(
        self,
        platform: TwoAxisPlatform,
        axes: tuple[AxisProgramme, AxisProgramme],
        caps: Caps,
        guess_coefficients: Array,
    ) -> tuple[tuple[AxisProfile, AxisProfile], SolverRun]:
        """Both profiles and how they were solved; to be judged by what they are.

        axes: posed with one scale.  caps: at the instants tau.
        guess_coefficients: (2, k), y to begin from.
        """
        half_rad = caps.half_angle_rad.ravel()
        steepness = np.maximum(np.sin(half_rad), 1e-3)
        cosine = cosine_coefficients(platform, caps.axis_platform.reshape(-1, 3))
        most = np.where(caps.counts.ravel(), np.cos(half_rad) / steepness, OPTIONS.not_counting)
        base = [
            axis.start_angle_rad
            + axis.scale_rad * self._values.fixed_matrix @ axis.fixed_coefficients
            for axis in axes
        ]
        hessians = [one.cost_hessian.ravel() for one in axes if one.cost_hessian is not None]
        parameters = np.concatenate(
            [
                *(axis.cost_gradient for axis in axes),
                *hessians,
                *base,
                np.array([axes[0].scale_rad]),
                (cosine / steepness[:, None]).ravel(order="F"),
            ]
        )
        answer = _chain_axes(
            self._rates_only, self._spline.rate_rows, axes, parameters, most, guess_coefficients
        )
        y, run = answer.x_numbers.reshape(2, -1), answer.run
        keeps = all(self._spline.keeps_rows(*one) for one in zip(axes, y, strict=True))
        if run.is_promising and not keeps:
            hull_rows = len(self._spline.jacobian)
            answer = _chain_axes(self._complete, hull_rows, axes, parameters, most, y)
            y, run = answer.x_numbers.reshape(2, -1), answer.run.after(run)
        outer, inner = map(self._spline.profile, axes, y)
        return (outer, inner), run


def _trigonometric_rows(angle: "casadi.MX") -> "list[list[casadi.MX]]":
    """One, cosine and sine of an angle, and their first and second derivatives."""
    import casadi

    cosine, sine = casadi.cos(angle), casadi.sin(angle)
    one, zero = casadi.MX.ones(angle.shape), casadi.MX(*angle.shape)
    return [[one, cosine, sine], [zero, -sine, cosine], [zero, -cosine, -sine]]


def _chain_axes(
    solver: Solver,
    hull_rows: int,
    axes: tuple[AxisProgramme, AxisProgramme],
    parameters: Array,
    cosine_limits: Array,
    guess_coefficients: Array,
) -> Answer:
    """x is y of both axes, one after the other."""
    return solver.solve(
        x0=guess_coefficients.ravel(),
        p=parameters,
        lbx=np.concatenate([axis.least_y for axis in axes]),
        ubx=np.concatenate([axis.greatest_y for axis in axes]),
        lbg=np.concatenate(
            [*(axis.least_rows[:hull_rows] for axis in axes), np.full(len(cosine_limits), -np.inf)]
        ),
        ubg=np.concatenate([*(axis.greatest_rows[:hull_rows] for axis in axes), cosine_limits]),
    )


@lru_cache(maxsize=8)  # each keeps its basis, and on rows takes 20 MB
def detour_ocp(spline: SplineOcp, caps: int, *, with_modes: bool, start: Start) -> DetourOcp:
    """Made once per process and basis."""
    return DetourOcp(spline, caps, with_modes=with_modes, start=start)
