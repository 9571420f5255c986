"""The motion of both axes, within all limits, that keeps the boresight nearest a direction.

Both axes move with constant jerk between knots that lie on rows of the command table, so that
the flown cubic Hermite is the motion itself.  Knots, directions and limits enter as numbers:
one solver serves every platform and every pass.
"""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from planner.base.arrays import Array, Indices
from planner.base.commands import ROWS_PER_S
from planner.base.solvers import Solver, Work
from planner.motion.detour.ocp import OPTIONS as DETOUR_PROGRAMME_OPTIONS
from planner.motion.detour.spline_ocp import OPTIONS as SPLINE_PROGRAMME_OPTIONS
from planner.motion.pointing.angles import cosine_coefficients
from planner.world.platforms import AxisLimits, TwoAxisPlatform


@dataclass(frozen=True, kw_only=True)
class KeyholeScales:
    """How a keyhole's programme is scaled and weighed."""

    # of a span, where the error is measured
    samples: tuple[float, ...] = (1.0 / 6.0, 0.5, 5.0 / 6.0)
    time_unit_s: float = 5.0  # makes rates and accelerations of a swing as large as its angles
    # of a mean squared jerk at its limit, beside an error at the frame's edge
    jerk_weight: float = 1e-8
    beyond_weight: float = 10.0  # of the largest square beyond the frame's, beside the mean square
    unbounded: float = 1e19  # what Ipopt takes for no bound


SCALES = KeyholeScales()

OPTIONS = {"tol": 1e-7, "constr_viol_tol": 1e-10, "mu_init": 1e-2}


class NearestOcp:
    """Least integral of the squared angle between boresight and direction, over `spans` spans.

    in_frame: the error is also kept below frame_rad at every sample, or nearest to it.
    """

    def __init__(self, spans: int, *, in_frame: bool) -> None:
        # CasADi takes 0.1 s to import, which only a process that solves should pay.
        import casadi

        self._spans, self._in_frame = spans, in_frame
        state = casadi.SX.sym("state", 6, spans + 1)  # angles, rates, accelerations, in units
        h = casadi.SX.sym("h", 1, spans)  # in time units
        jerk_max = casadi.SX.sym("jerk_max", 2)
        cosine = casadi.SX.sym("cosine", 9, spans * len(SCALES.samples))
        frame_rad = casadi.SX.sym("frame")

        q, v, a = state[:2, :], state[2:4, :], state[4:, :]
        q0, v0, a0 = q[:, :-1], v[:, :-1], a[:, :-1]
        q1, v1, a1 = q[:, 1:], v[:, 1:], a[:, 1:]
        hh = casadi.repmat(h, 2, 1)
        jerk = (a1 - a0) / hh
        rows = [
            v1 - v0 - (a0 + a1) * hh / 2.0,
            q1 - q0 - v0 * hh - (2.0 * a0 + a1) * hh**2 / 6.0,
            v0 + a0 * hh / 2.0,  # the middle Bezier coefficient of the rate
            q0 + v0 * hh / 3.0,  # and both of the angle
            q1 - v1 * hh / 3.0,
            jerk,
        ]
        # From where a free first state was reached, and to where the last one can be braked.
        coast = casadi.SX.sym("coast", 2)
        rows += [q[:, 0] - coast * v[:, 0], q[:, -1] + coast * v[:, -1]]
        squares = []
        for number, share in enumerate(SCALES.samples):
            u = share * hh
            angle = q0 + u * (v0 + u * (a0 / 2.0 + u * jerk / 6.0))
            one = casadi.SX.ones(1, spans)
            outer = [one, casadi.cos(angle[0, :]), casadi.sin(angle[0, :])]
            inner = [one, casadi.cos(angle[1, :]), casadi.sin(angle[1, :])]
            part = cosine[:, number * spans : (number + 1) * spans]
            along = casadi.SX(1, spans)
            for i in range(3):
                for j in range(3):
                    along += part[3 * i + j, :] * outer[i] * inner[j]
            squares.append(2.0 * (1.0 - along) / frame_rad**2)
        weight = h / casadi.sum2(h)
        cost = sum(casadi.dot(weight, square) for square in squares) / len(SCALES.samples)
        share_of_limit = jerk / casadi.repmat(jerk_max, 1, spans)
        cost += SCALES.jerk_weight * casadi.dot(casadi.repmat(weight, 2, 1), share_of_limit**2)
        constraints = [casadi.vec(row) for row in rows]
        variables = [casadi.vec(state)]
        if in_frame:
            beyond = casadi.SX.sym("beyond")
            variables.append(beyond)
            cost += SCALES.beyond_weight * beyond
            constraints += [casadi.vec(square) - beyond for square in squares]
        x, g = casadi.vertcat(*variables), casadi.vertcat(*constraints)
        parameters = casadi.vertcat(h.T, jerk_max, coast, frame_rad, casadi.vec(cosine))
        self._solver = Solver(
            {"x": x, "p": parameters, "f": cost, "g": g},
            OPTIONS | {"max_iter": 70 if in_frame else 150},
            Work(
                SPLINE_PROGRAMME_OPTIONS.solve,
                DETOUR_PROGRAMME_OPTIONS.iteration_row * (x.numel() + g.numel()),
            ),
        )

    def solve(
        self,
        platform: TwoAxisPlatform,
        knots: Indices,
        guess_states: Array,
        directions: Array,
        frame_rad: float,
        *,
        fixed: tuple[bool, bool],
    ) -> Array:
        """Angle, rate, acceleration (rad, s) on every row from the first knot to the last.

        Shape (3, n, 2); to be judged by what it is: the solver's word is not asked.
        knots: rows, (k + 1,).  guess_states: angle, rate, acceleration on them, (3, k + 1, 2).
        directions: unit vectors in the platform frame at `sample_times_s` of the knots.
        frame_rad: unit of the error, and its bound where it is to stay in the frame.
        fixed: whether the guess's first and last state are kept; a free one has no acceleration.
        """
        # SciPy's interpolators take 0.2 s to import, which only a plan should pay.
        from scipy.interpolate import CubicHermiteSpline

        limits = platform.axis_limits
        h = np.diff(knots) / ROWS_PER_S / SCALES.time_unit_s
        scale = np.repeat([1.0, SCALES.time_unit_s, SCALES.time_unit_s**2], 2)
        x0 = np.hstack([*guess_states]) * scale
        units = SCALES.time_unit_s ** np.arange(4.0)[:, None]
        low, high = (
            SPLINE_PROGRAMME_OPTIONS.inside
            * units
            * np.array([[bound[side] for bound in axis.bounds] for axis in limits]).T
            for side in (0, 1)
        )
        lbx = np.tile(low[:3].ravel(), (len(x0), 1))
        ubx = np.tile(high[:3].ravel(), (len(x0), 1))
        for end, is_fixed in zip((0, -1), fixed, strict=True):
            if is_fixed:
                lbx[end] = ubx[end] = x0[end]
            else:
                lbx[end, 4:] = ubx[end, 4:] = 0.0  # else the rate might have broken its limit
        spans = self._spans
        lbg = [np.zeros((spans, 4)).ravel(), *(np.tile(low[i], spans) for i in (1, 0, 0, 3))]
        ubg = [np.zeros((spans, 4)).ravel(), *(np.tile(high[i], spans) for i in (1, 0, 0, 3))]
        x_start, x_low, x_high = np.clip(x0, lbx, ubx).ravel(), lbx.ravel(), ubx.ravel()
        for is_fixed in fixed:
            lbg.append(np.full(2, -SCALES.unbounded) if is_fixed else low[0])
            ubg.append(np.full(2, SCALES.unbounded) if is_fixed else high[0])
        if self._in_frame:
            lbg.append(np.full(spans * len(SCALES.samples), -SCALES.unbounded))
            ubg.append(np.ones(spans * len(SCALES.samples)))
            x_start, x_low = np.append(x_start, 1.0), np.append(x_low, 0.0)
            x_high = np.append(x_high, SCALES.unbounded)
        answer = self._solver.solve(
            x0=x_start,
            p=np.concatenate(
                [
                    h,
                    high[3],
                    [_coasting_s(axis) / SCALES.time_unit_s for axis in limits],
                    [frame_rad],
                    cosine_coefficients(platform, directions).ravel(),
                ]
            ),
            lbx=x_low,
            ubx=x_high,
            lbg=np.concatenate(lbg),
            ubg=np.concatenate(ubg),
        )
        x = answer.x_numbers[: x0.size].reshape(x0.shape) / scale
        # What the solver leaves unsatisfied can't tear the Hermite through the knots apart.
        since_first = knots - knots[0]
        curve = CubicHermiteSpline(since_first / ROWS_PER_S, x[:, :2], x[:, 2:4])
        t_s = np.arange(since_first[-1] + 1) / ROWS_PER_S
        return np.stack([curve(t_s, order) for order in range(3)])


def _coasting_s(limits: AxisLimits) -> float:
    """Braking any rate takes at most so many seconds times that rate."""
    V, A, J = limits.rate_max_rad_s, limits.acceleration_max_rad_s2, limits.jerk_max_rad_s3
    return max(V / (2.0 * A) + A / (2.0 * J), math.sqrt(V / J))


def sample_times_s(knots: Indices) -> Array:
    """When the error is measured: all first samples of the spans, all second ones, ..."""
    start_s, h = knots[:-1] / ROWS_PER_S, np.diff(knots) / ROWS_PER_S
    return np.concatenate([start_s + share * h for share in SCALES.samples])


@lru_cache(maxsize=8)
def nearest_ocp(spans: int, *, in_frame: bool) -> NearestOcp:
    """Made once per process."""
    return NearestOcp(spans, in_frame=in_frame)
