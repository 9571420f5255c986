"""Least time of a body's slew by another transcription: finer, uniform, by Runge-Kutta.

The jerk is constant on each of many equal intervals, attitudes follow by Runge-Kutta of order 4,
limits are kept at the intervals' ends and middles alone, and the goal is a spline through its rows.
"""

import casadi as ca
import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from planner.base.commands import ROWS_PER_S

STEPS = 2  # of Runge-Kutta in an interval
SMOOTHING = 1e-5  # of the cost, so that what time leaves free is decided


def _derivative(q, w):
    u, s = q[:3], q[3]
    return 0.5 * ca.vertcat(s * w + ca.cross(u, w), -ca.dot(u, w))


def _interval():
    """q, omega, alpha, jerk, h -> q, omega, alpha at its end, omega in its middle."""
    q, w, a, j = (ca.SX.sym(name, size) for name, size in zip("qwaj", (4, 3, 3, 3), strict=True))
    h = ca.SX.sym("h")

    def rate(t):
        return w + t * a + t**2 / 2 * j

    there, step = q, h / STEPS
    for k in range(STEPS):
        t = k * step
        k1 = _derivative(there, rate(t))
        k2 = _derivative(there + step / 2 * k1, rate(t + step / 2))
        k3 = _derivative(there + step / 2 * k2, rate(t + step / 2))
        k4 = _derivative(there + step * k3, rate(t + step))
        there = there + step / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return ca.Function("interval", [q, w, a, j, h], [there, rate(h), a + h * j, rate(h / 2)])


def _begin_at_rows(motion, count):
    """Nodes of a motion on the rows of a table."""
    rows = np.linspace(0.0, len(motion.position) - 1.0, count + 1)
    at = np.arange(len(motion.position))
    parts = [motion.position, motion.rate_rad_s, motion.acceleration_rad_s2]
    return [np.stack([np.interp(rows, at, x) for x in part.T]) for part in parts]


def _begin_straight(problem, row, count):
    """Nodes of an even turn, whose rates are told as none."""
    ends = Rotation.from_quat(
        np.stack([problem.start.position[0], problem.arriving_at(row).goal.position[0]])
    )
    q = Slerp([0.0, 1.0], ends)(np.linspace(0.0, 1.0, count + 1)).as_quat()
    q *= np.where(q @ problem.start.position[0] < 0.0, -1.0, 1.0)[:, None]
    return [q.T, np.zeros((3, count + 1)), np.zeros((3, count + 1))]


def reference_least_s(problem, slew, count=120):
    """The least time found from two starts, the slew among them; None: neither was solved."""
    unit_s = slew.duration_s
    last_s = min(problem.available_s, 1.5 * unit_s)
    goal_s = problem.arrival_rows / ROWS_PER_S
    goal = np.hstack(
        [problem.goal.position, problem.goal.rate_rad_s, problem.goal.acceleration_rad_s2]
    )
    # A spline through every fifth row: a row is far finer than what a goal does.
    kept = np.unique(np.append(np.arange(0, len(goal_s), 5), len(goal_s) - 1))
    goal_at = ca.interpolant("goal", "bspline", [goal_s[kept]], goal[kept].ravel())
    q, w, a = (
        ca.MX.sym("q", 4, count + 1),
        ca.MX.sym("w", 3, count + 1),
        ca.MX.sym("a", 3, count + 1),
    )
    j, T = ca.MX.sym("j", 3, count), ca.MX.sym("T")  # in the slew's time
    h = T / count
    q1, w1, a1, middle = _interval().map(count)(q[:, :-1], w[:, :-1], a[:, :-1], j, h)
    end = goal_at(T * unit_s)
    conjugate = ca.vertcat(-end[:3], end[3])
    last = q[:, -1]
    off = conjugate[3] * last[:3] + last[3] * conjugate[:3] + ca.cross(conjugate[:3], last[:3])
    zero = [q1 - q[:, 1:], w1 - w[:, 1:], a1 - a[:, 1:], off]
    zero += [w[:, -1] - end[4:7] * unit_s, a[:, -1] - end[7:] * unit_s**2]
    most = problem.limits.by_order * unit_s ** np.arange(1, 4)
    limited = []
    for vectors, order in ((w[:, 1:-1], 0), (middle, 0), (a[:, 1:-1], 1), (j, 2)):
        x = vectors / ca.repmat(most[:, order], 1, vectors.shape[1])
        limited.append(ca.vec(ca.sum1(x**2) if problem.limits.kind == "magnitude" else x**2))
    equal, under = ca.veccat(*zero), ca.vertcat(*limited)
    cost = T + SMOOTHING * h * ca.sumsqr(j / ca.repmat(most[:, 2], 1, count))
    x = ca.veccat(q, w, a, j, T)
    options = {
        "max_iter": 400,
        "tol": 1e-7,
        "print_level": 0,
        "sb": "yes",
        "mu_strategy": "adaptive",
    }
    solver = ca.nlpsol(
        "reference",
        "ipopt",
        {"x": x, "f": cost, "g": ca.vertcat(equal, under)},
        {"ipopt": options, "print_time": False},
    )
    low, high = np.full(x.numel(), -np.inf), np.full(x.numel(), np.inf)
    starts_at = np.cumsum([0, 4 * (count + 1), 3 * (count + 1)])
    start = problem.start
    given = [start.position, start.rate_rad_s * unit_s, start.acceleration_rad_s2 * unit_s**2]
    for place, numbers in zip(starts_at, given, strict=True):
        low[place : place + numbers.size] = high[place : place + numbers.size] = numbers[0]
    low[-1], high[-1] = goal_s[0] / unit_s, last_s / unit_s
    size = [equal.numel(), under.numel()]
    row = len(slew.motion.position) - 1
    found_s = []
    for begin in (_begin_at_rows(slew.motion, count), _begin_straight(problem, row, count)):
        x0 = [part * unit_s**k for k, part in enumerate(begin)]
        jerk = np.diff(x0[2], axis=1) * count
        numbers = np.concatenate([part.ravel(order="F") for part in (*x0, jerk)] + [[1.0]])
        answer = solver(
            x0=numbers,
            lbx=low,
            ubx=high,
            lbg=np.append(np.zeros(size[0]), np.full(size[1], -np.inf)),
            ubg=np.append(np.zeros(size[0]), np.ones(size[1])),
        )
        if solver.stats()["success"]:
            found_s.append(float(answer["x"][-1]) * unit_s)
    return min(found_s, default=None)
