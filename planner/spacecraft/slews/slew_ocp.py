"""The best slew: an optimal control problem over attitude splines (CasADi + Ipopt).

The attitude itself is the flat output: sigma(t) is a B-spline in t/T, from which rate, control
torque and torque rate follow exactly, so the rigid body's equations need no integration and
no defect constraints.  (The total momentum's direction in body axes is taken along the guess:
it enters the torque with 0.03 rad/s times a few N m s.)  Both ends match attitude, rate and
acceleration.  One solver per objective and process, kept; times, ends, momentum and limits
enter as parameters.
"""

import time
from dataclasses import dataclass
from functools import cache
from typing import NamedTuple

import casadi
import numpy as np
from scipy.interpolate import BSpline

from planner.base.arrays import Array
from planner.base.mrp import MrpMotion, body_motion
from planner.base.solvers import Answer, Options, Solver, Work
from planner.spacecraft.slews.slew_problem import (
    LIMIT_TOLERANCE,
    AttitudeSlew,
    AttitudeSlewProblem,
    loads,
)
from planner.spacecraft.vehicle.definition import SlewObjective


class Shape(NamedTuple):
    """Spline degree, spans and collocation points a span."""

    degree: int
    spans: int
    points: int


SHAPES: dict[SlewObjective, Shape] = {
    "smooth": Shape(degree=5, spans=12, points=2),
    "minimum_time": Shape(degree=3, spans=18, points=2),
}


@dataclass(frozen=True, kw_only=True)
class SlewProgrammeOptions:
    """How a slew's programme is solved, and its loads kept between points."""

    passes: int = 3  # each tightened by what the loads bulge between points
    unmendable_share: float = 1.05  # no pass mends a failure that far out
    overcorrected: float = 1.5  # tightened by just the bulge, the next pass bulges again
    solve: float = 500.0  # of `effort`: a solve, and
    iteration: float = 350.0  # each of its iterations
    end_tolerance: float = 1e-8  # of sigma: 0.01 arcsec
    # at the collocation points; between them the loads bulge by up to 0.3 %
    limit_factor: float = 0.997


PROGRAMME = SlewProgrammeOptions()

OPTIONS: Options = {"tol": 1e-6, "max_iter": 150, "mu_strategy": "adaptive"}
# Lower bounds at a collocation point: of |omega|^2, omega (3), |tau|^2, |tau'|^2, |H|^2 by limits.
LOWER_LIMITS = (-np.inf, -1.0, -1.0, -1.0, -np.inf, -np.inf, -np.inf)
END_CONDITIONS = 18  # sigma, d1, d2 at start and at end, three parts each


class Transcription(NamedTuple):
    """A kept solver and what its spline is made of."""

    shape: Shape
    solver: Solver


def _spline_knots(shape: Shape) -> Array:
    inner = np.linspace(0.0, 1.0, shape.spans + 1)
    return np.concatenate([np.zeros(shape.degree), inner, np.ones(shape.degree)])


def _sample_points(shape: Shape) -> Array:
    """Knots and `points` - 1 instants between each two: where the loads of a spline peak."""
    return np.linspace(0.0, 1.0, shape.spans * shape.points + 1)


def _design_matrices(shape: Shape, u: Array) -> tuple[Array, ...]:
    """Matrices from coefficients to value and up to four derivatives at u = t/T, each (m, k)."""
    knots = _spline_knots(shape)
    basis = BSpline(knots, np.eye(len(knots) - shape.degree - 1), shape.degree)
    return tuple(np.asarray(basis(u, nu)) for nu in range(5))


def _point_loads() -> casadi.Function:
    """sigma, d1, d2, d3 (per second), G in body axes, J -> rates, torque, torque rate, H."""
    *sigmas, total, j = (casadi.SX.sym(name, 3) for name in ("s", "d1", "d2", "d3", "G", "J"))
    omega, alpha, jerk = body_motion(sigmas, casadi.dot, casadi.cross)
    precession = casadi.cross(omega, total)
    torque_rate = j * jerk + casadi.cross(alpha, total) - casadi.cross(omega, precession)
    return casadi.Function(
        "loads",
        [*sigmas, total, j],
        [omega, j * alpha + precession, torque_rate, total - j * omega],
    )


@cache
def _build_transcription(objective: SlewObjective) -> Transcription:
    """Build the kept solver of an objective (0.5-1 s, once a process)."""
    shape = SHAPES[objective]
    u = _sample_points(shape)
    design = _design_matrices(shape, u)
    ends = _design_matrices(shape, np.array([0.0, 1.0]))
    size = design[0].shape[1]
    c = casadi.SX.sym("c", size, 3)
    span = casadi.SX.sym("T")
    boundary = casadi.SX.sym("b", 6, 3)  # sigma, d1, d2 at start and at end
    total, j = casadi.SX.sym("G", len(u), 3), casadi.SX.sym("J", 3)
    limits = casadi.SX.sym("limits", 5)
    rate, rate_axis, torque_most, torque_rate_most, sphere = casadi.vertsplit(limits)
    values = [casadi.mtimes(casadi.DM(m), c) for m in design]
    point = _point_loads()
    g: list[casadi.SX] = []
    shaking = casadi.SX(0)
    for k in range(len(u)):
        here = [values[d][k, :].T / span**d for d in range(4)]
        omega, torque, torque_rate, stored = point(*here, total[k, :].T, j)
        g += [
            casadi.dot(omega, omega) / rate**2,
            omega / rate_axis,
            casadi.dot(torque, torque) / torque_most**2,
            casadi.dot(torque_rate, torque_rate) / torque_rate_most**2,
            casadi.dot(stored, stored) / sphere**2,
        ]
        shaking += casadi.dot(torque_rate, torque_rate) / torque_rate_most**2
        if objective == "smooth":
            snap = 4.0 * j * values[4][k, :].T / span**4
            shaking += 0.1 * casadi.dot(snap, snap) / torque_rate_most**2
    shaking = shaking / len(u)
    for end in range(2):
        for d in range(3):
            made = casadi.mtimes(casadi.DM(ends[d][end : end + 1]), c)
            g.append((made - boundary[3 * end + d, :] * span**d).T)
    cost = span + 1e-3 * shaking if objective == "minimum_time" else 100.0 * shaking
    nlp: dict[str, casadi.SX] = {
        "x": casadi.vertcat(casadi.vec(c), span),
        "p": casadi.vertcat(casadi.vec(boundary), casadi.vec(total), j, limits),
        "f": cost,
        "g": casadi.vertcat(*g),
    }
    return Transcription(shape, Solver(nlp, OPTIONS, Work(PROGRAMME.solve, PROGRAMME.iteration)))


def solve_slew(
    problem: AttitudeSlewProblem,
    guess: AttitudeSlew,
    objective: SlewObjective,
    duration_s: float | None,
) -> AttitudeSlew | None:
    """The optimal slew from a guess, or None when Ipopt finds none that keeps the limits.

    duration_s None: T is free, at most the guess's.  What comes back is checked on a dense
    grid, whatever the solver says of itself; where a load bulges over its limit between the
    collocation points, one more pass tightens the limits by as much.
    """
    begun = time.perf_counter()
    kept = _build_transcription(objective)
    low_s, high_s = 0.3 * guess.duration_s, 1.05 * guess.duration_s
    if duration_s is not None:
        low_s = high_s = duration_s
    coefficients = _spline_coefficients(kept.shape, guess).ravel(order="F")
    x = np.append(coefficients, np.clip(guess.duration_s, low_s, high_s))
    limit_factor = PROGRAMME.limit_factor
    for _ in range(PROGRAMME.passes):
        answer = _solve_ipopt(kept, problem, guess, x, (low_s, high_s), limit_factor)
        x = answer.x_numbers
        slew = _slew_of(kept, problem, answer, time.perf_counter() - begun)
        over = slew.loads.share_of(problem.limits)
        if over <= 1.0 + LIMIT_TOLERANCE and _miss_of_ends(problem, slew) < PROGRAMME.end_tolerance:
            return slew
        if over > PROGRAMME.unmendable_share and slew.status != "Solve_Succeeded":
            break
        limit_factor /= 1.0 + PROGRAMME.overcorrected * (min(over, 1.1) - 1.0)
    return None


def _solve_ipopt(
    kept: Transcription,
    problem: AttitudeSlewProblem,
    guess: AttitudeSlew,
    x0: Array,
    span_s: tuple[float, float],
    limit_factor: float,
) -> Answer:
    """Ipopt's: x are the coefficients, column by column, then T."""
    limits = problem.limits
    u = _sample_points(kept.shape)
    q_body_from_eci, _ = guess.attitude_at(u * guess.duration_s)
    total_n_m_s = q_body_from_eci.apply(problem.momentum_eci_n_m_s)
    scale = [
        limits.rate_rad_s,
        limits.rate_axis_rad_s,
        limits.torque_n_m,
        limits.torque_rate_n_m_s,
        limits.momentum_sphere_n_m_s,
    ]
    lower = np.tile(LOWER_LIMITS, len(u))
    ends = np.zeros(END_CONDITIONS)
    free = np.full(len(x0) - 1, 2.0)  # |sigma| < 1 up to half a turn to each side
    return kept.solver.solve(
        x0=x0,
        p=np.concatenate(
            [
                np.vstack(problem.ends_mrp()).ravel(order="F"),
                total_n_m_s.ravel(order="F"),
                problem.inertia_kg_m2,
                limit_factor * np.array(scale),
            ]
        ),
        lbx=np.append(-free, span_s[0]),
        ubx=np.append(free, span_s[1]),
        lbg=np.concatenate([lower, ends]),
        ubg=np.concatenate([np.ones_like(lower), ends]),
    )


def _slew_of(
    kept: Transcription, problem: AttitudeSlewProblem, answer: Answer, solve_s: float
) -> AttitudeSlew:
    x = answer.x_numbers
    span_s = float(x[-1])
    spline = BSpline(_spline_knots(kept.shape), x[:-1].reshape(3, -1).T, kept.shape.degree)

    def mrp_at(t_s: Array) -> MrpMotion:
        u = np.clip(np.asarray(t_s) / span_s, 0.0, 1.0)
        return MrpMotion(
            spline(u), spline(u, 1) / span_s, spline(u, 2) / span_s**2, spline(u, 3) / span_s**3
        )

    return AttitudeSlew(
        q_middle_from_eci=problem.q_middle_from_eci,
        mrp_at=mrp_at,
        duration_s=span_s,
        method="ocp",
        status=answer.run.status,
        solve_s=solve_s,
        loads=loads(problem, mrp_at, span_s),
    )


def _miss_of_ends(problem: AttitudeSlewProblem, slew: AttitudeSlew) -> float:
    """Largest difference in sigma or its derivatives from what the two ends ask for."""
    made = np.array(slew.mrp_at(np.array([0.0, slew.duration_s]))[:3])
    return float(np.max(np.abs(made.swapaxes(0, 1) - np.array(problem.ends_mrp()))))


def _spline_coefficients(shape: Shape, guess: AttitudeSlew) -> Array:
    """Least-squares spline through a slew, shape (k, 3)."""
    u = np.linspace(0.0, 1.0, 8 * shape.spans + 1)
    through = guess.mrp_at(u * guess.duration_s).mrp
    return np.asarray(np.linalg.lstsq(_design_matrices(shape, u)[0], through, rcond=None)[0])
