"""A proof of how little squared jerk any motion can do with, from prices of its contacts.

Whatever prices are put on meeting the end and on keeping limits at some instants, the least of
(squared jerk - prices) over all jerks within their limit is a lower bound of the cost of every
motion that meets the end and keeps the limits.  That least is found instant by instant: the
jerk is the costate, a quadratic of time less the pushes of the contacts, cut off at its limit.
The pushes may come from any solver; the end's prices are those that make the bound highest.
All in normalised time: the motion lasts 1.
Source: weak duality, Luenberger 1969, Optimization by Vector Space Methods, ch. 8.
"""

import math

import numpy as np

from planner.arrays import Array, Indices
from planner.compiled import compiled
from planner.slew.jerk_spans import solved

NEWTON_STEPS = 40
CONVERGED = 1e-12  # of the bound
_NODE = math.sqrt(0.6)  # of three-point Gauss quadrature, exact for the quartics here
_NODES, _WEIGHTS = np.array([-_NODE, 0.0, _NODE]), np.array([5.0, 8.0, 5.0]) / 18.0


@compiled
def lower_bound(
    ends: Array, limits: Array, contacts: Array, knots: Array, jerks: Array
) -> tuple[float, Array]:
    """The bound on half the integral of squared jerk, doubled, and where the jerks miss it.

    ends (2, 3): angle, rate, acceleration at start and end.  limits (4, 2) of angle, rate,
    acceleration, jerk.  contacts (m, 3): instant, order (0 angle, 1 rate, 2 acceleration), push,
    positive at the upper limit.  knots (n + 1,), jerks (n, 2): a motion near the optimum; the
    second result (n,) is the squared distance of its jerk from the costate's, span by span.
    """
    jerk_max = limits[3, 1]
    grid = np.unique(np.concatenate((knots, contacts[:, 0])))
    pieces = len(grid) - 1
    costate, owed = _pushes(ends, limits, contacts, grid)
    span = np.searchsorted(knots, (grid[1:] + grid[:-1]) / 2.0) - 1
    prices = _first_prices(costate, grid, knots, jerks, span, jerk_max)
    wanted = _moments(ends)
    best, step = -np.inf, np.zeros(3)
    kept = prices.copy()
    for _ in range(NEWTON_STEPS):
        if not np.all(np.isfinite(prices)):
            break
        value, slope, curvature = _dual(prices, costate, grid, jerk_max, wanted)
        value += owed
        if value > best:
            best, kept = value, prices.copy()
            for i in range(3):
                curvature[i, i] *= 1.0 + 1e-12
                curvature[i, i] += 1e-300
            step = solved(curvature, slope)
            if not abs(np.dot(step, slope)) > CONVERGED * abs(best):
                break
        else:
            step = step / 4.0
            if not abs(np.dot(step, slope)) > CONVERGED * abs(best):
                break
        prices = kept + step
    missed = np.zeros(len(knots) - 1)
    for k in range(pieces):
        begin, width = grid[k], grid[k + 1] - grid[k]
        s = span[k]
        for node in range(3):
            at = (1.0 + _NODES[node]) / 2.0
            tau = begin + at * width
            share = (tau - knots[s]) / (knots[s + 1] - knots[s])
            own = jerks[s, 0] + share * (jerks[s, 1] - jerks[s, 0])
            x = 2.0 * at - 1.0
            w = costate[k, 0] + x * (costate[k, 1] + x * costate[k, 2]) + _polynomial(kept, tau)
            w = min(max(w, -jerk_max), jerk_max)
            missed[s] += _WEIGHTS[node] * width * (w - own) ** 2
    return 2.0 * best, missed


@compiled
def _polynomial(prices: Array, tau: float) -> float:
    x = 2.0 * tau - 1.0
    return float(prices[0] + x * prices[1] + (1.5 * x * x - 0.5) * prices[2])


@compiled
def _moments(ends: Array) -> Array:
    """Integrals of the jerk times Legendre's polynomials that lead from start to end."""
    start, end = ends[0], ends[1]
    first = end[2] - start[2]
    second = end[1] - start[1] - start[2]
    third = end[0] - start[0] - start[1] - start[2] / 2.0
    return np.array([first, first - 2.0 * second, first - 6.0 * second + 12.0 * third])


@compiled
def _pushes(ends: Array, limits: Array, contacts: Array, grid: Array) -> tuple[Array, float]:
    """The pushes' part of the costate, quadratics (pieces, 3) on [-1, 1], and what they owe.

    A contact is reached from the nearer end, so that a push on a short stretch keeps its digits.
    """
    costate, owed = np.zeros((len(grid) - 1, 3)), 0.0
    for contact in contacts:
        at, order, push = contact[0], int(contact[1]), contact[2]
        early = at <= 0.5
        end, x = (ends[0], at) if early else (ends[1], at - 1.0)
        if order == 0:
            drift = end[0] + x * (end[1] + x * end[2] / 2.0)
        elif order == 1:
            drift = end[1] + x * end[2]
        else:
            drift = end[2]
        limit = limits[order, 1] if push > 0.0 else limits[order, 0]
        owed += push * (drift - limit)
        sign = -push if early else push
        if not early and order == 1:
            sign = -sign
        for k in range(len(grid) - 1):
            middle, half = (grid[k] + grid[k + 1]) / 2.0, (grid[k + 1] - grid[k]) / 2.0
            away = at - middle if early else middle - at
            if away <= 0.0:
                continue
            slope = -half if early else half
            if order == 2:
                costate[k, 0] += sign
            elif order == 1:
                costate[k, 0] += sign * away
                costate[k, 1] += sign * slope
            else:
                costate[k, 0] += sign * away * away / 2.0
                costate[k, 1] += sign * away * slope
                costate[k, 2] += sign * slope * slope / 2.0
    return costate, owed


@compiled
def _first_prices(
    costate: Array, grid: Array, knots: Array, jerks: Array, span: Indices, jerk_max: float
) -> Array:
    """Prices whose costate comes nearest to the jerks where these are free."""
    system, wanted = np.zeros((3, 3)), np.zeros(3)
    for k in range(len(span)):
        s, width = span[k], grid[k + 1] - grid[k]
        tau = grid[k] + width / 2.0
        share = (tau - knots[s]) / (knots[s + 1] - knots[s])
        own = jerks[s, 0] + share * (jerks[s, 1] - jerks[s, 0])
        weight = width if abs(own) < 0.99 * jerk_max else 1e-6 * width
        x = 2.0 * tau - 1.0
        basis = np.array([1.0, x, 1.5 * x * x - 0.5])
        for i in range(3):
            wanted[i] += weight * basis[i] * (own - costate[k, 0])
            for j in range(3):
                system[i, j] += weight * basis[i] * basis[j]
    return solved(system, wanted)


@compiled
def _dual(
    prices: Array, costate: Array, grid: Array, jerk_max: float, wanted: Array
) -> tuple[float, Array, Array]:
    """The dual value without what contacts owe, its slope and negative curvature in the prices."""
    value = float(np.dot(prices, wanted))
    slope, curvature = wanted.copy(), np.zeros((3, 3))
    cuts = np.empty(6)
    basis = np.empty(3)
    for k in range(len(costate)):
        begin, width = grid[k], grid[k + 1] - grid[k]
        x0, dx = 2.0 * begin - 1.0, 2.0 * width  # Legendre's argument runs over [-1, 1]
        middle, half = x0 + dx / 2.0, dx / 2.0
        c0 = costate[k, 0] + prices[0] + prices[1] * middle + prices[2] * (1.5 * middle**2 - 0.5)
        c1 = costate[k, 1] + half * (prices[1] + 3.0 * prices[2] * middle)
        c2 = costate[k, 2] + 1.5 * prices[2] * half**2
        count = _where_cut_off(c0, c1, c2, jerk_max, cuts)
        for cut in range(count - 1):
            low, high = cuts[cut], cuts[cut + 1]
            if not high > low:
                continue
            for node in range(3):
                x = (low + high) / 2.0 + (high - low) / 2.0 * _NODES[node]
                weight = _WEIGHTS[node] * width * (high - low) / 2.0
                w = c0 + x * (c1 + x * c2)
                u = min(max(w, -jerk_max), jerk_max)
                value += weight * (0.5 * u * u - u * w)
                y = middle + half * x
                basis[0], basis[1], basis[2] = 1.0, y, 1.5 * y * y - 0.5
                free = abs(w) <= jerk_max
                for i in range(3):
                    slope[i] -= weight * u * basis[i]
                    if free:
                        for j in range(3):
                            curvature[i, j] += weight * basis[i] * basis[j]
    return value, slope, curvature


@compiled
def _where_cut_off(c0: float, c1: float, c2: float, jerk_max: float, cuts: Array) -> int:
    """Fills cuts with -1, 1 and where c0 + c1 x + c2 x^2 passes the limit between, in order."""
    cuts[0], cuts[1] = -1.0, 1.0
    count = 2
    for level in (jerk_max, -jerk_max):
        discriminant = c1 * c1 - 4.0 * c2 * (c0 - level)
        if discriminant <= 0.0:
            continue
        q = -0.5 * (c1 + math.copysign(math.sqrt(discriminant), c1))
        for root in (q / c2 if c2 != 0.0 else 2.0, (c0 - level) / q if q != 0.0 else 2.0):
            if -1.0 < root < 1.0:
                cuts[count] = root
                count += 1
    cuts[:count].sort()
    return count
