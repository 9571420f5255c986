"""A proof of how little squared jerk any motion can do with, from multipliers of its contacts.

Whatever multipliers are put on meeting the end and on keeping limits at some instants, the least
of the Lagrangian over all jerks within their limit is a lower bound of the cost of every
motion that meets the end and keeps the limits.  That least is found instant by instant: the
jerk is the costate, a quadratic of time bent by the contacts' multipliers, cut off at its limit.
These may come from any solver; the end's multipliers are those that make the bound highest,
sought from those whose costate is nearest to a known motion's jerk.  (A solver's multipliers of
the dynamics aren't the costate where coefficients beside a knot are at their limits.)
All in normalised time: the motion lasts 1.
Source: weak duality, Luenberger 1969, Optimization by Vector Space Methods, ch. 8.
"""

import numpy as np

from planner.base.arrays import Array
from planner.motion.slew.spans import solve_scaled

NEWTON_STEPS = 20
CONVERGED = 1e-9  # of the bound
_MIDDLE = 0.5
_NODES = np.sqrt(0.6) * np.array([[-1.0], [0.0], [1.0]])  # Gauss, exact for the quartics here
_WEIGHTS = np.array([[5.0], [8.0], [5.0]]) / 18.0


def lower_bound(
    ends: Array, limits: Array, contacts: Array, knots: Array, jerks: Array
) -> tuple[float, Array]:
    """The bound on the integral of squared jerk, and where the jerks miss the costate's.

    ends (2, 3): angle, rate, acceleration at start and end.  limits (4, 2) of angle, rate,
    acceleration, jerk.  contacts (m, 3): instant, order (0 angle, 1 rate, 2 acceleration),
    multiplier, positive at the upper limit.  knots (n + 1,), jerks (n, 2): a motion near the
    optimum; the second result (n,) is the squared distance of its jerk from the costate's, span
    by span.
    """
    grid = np.unique(np.concatenate([knots, contacts[:, 0], [_MIDDLE]]))
    half, middle = np.diff(grid) / 2.0, (grid[1:] + grid[:-1]) / 2.0
    span = np.searchsorted(knots, middle) - 1
    jerk_max, own_width = limits[3, 1], np.diff(knots)[span]

    def slew_jerk(t: Array) -> Array:
        share = (t - knots[span]) / own_width
        return np.asarray(jerks[span, 0] + share * (jerks[span, 1] - jerks[span, 0]))

    costate, owed = _contacts_part(ends, limits, contacts, grid)
    wanted = _drift_by(ends[1], np.array(_MIDDLE - 1.0)) - _drift_by(ends[0], np.array(_MIDDLE))
    t = middle + half * _NODES
    basis = _multiplier_effects(t)
    rest = slew_jerk(t) - (costate[0] + _NODES * (costate[1] + _NODES * costate[2]))
    weight = half * _WEIGHTS * np.where(np.abs(slew_jerk(t)) < 0.99 * jerk_max, 1.0, 1e-6)
    of_end = solve_scaled(
        np.einsum("ign,gn,jgn->ij", basis, weight, basis),
        np.einsum("ign,gn->i", basis, weight * rest),
    )
    best, missed, kept, step = -np.inf, np.zeros(len(own_width)), of_end, np.zeros(3)
    for _ in range(NEWTON_STEPS):
        away = _MIDDLE - middle
        p2, p1, p0 = of_end[0] / 2.0, of_end[1], of_end[2]
        c0, c1, c2 = costate + np.array(
            [p2 * away**2 + p1 * away + p0, -half * (2.0 * p2 * away + p1), p2 * half**2]
        )
        x, share = _nodes_between(_where_cut_off(c0, c1, c2, jerk_max))
        w, weight, t = c0 + x * (c1 + x * c2), 2.0 * half * share * _WEIGHTS, middle + half * x
        u = np.clip(w, -jerk_max, jerk_max)
        value = float(of_end @ wanted) + owed + float(np.sum(weight * (0.5 * u * u - u * w)))
        gain = value - best
        if gain > 0.0:
            best, kept = value, of_end
            missed = np.sum(weight * (u - slew_jerk(t)) ** 2, axis=(0, 1))
            basis = _multiplier_effects(t)
            slope = wanted - np.einsum("isgn,sgn->i", basis, weight * u)
            free = weight * (np.abs(w) <= jerk_max)
            step = solve_scaled(np.einsum("isgn,sgn,jsgn->ij", basis, free, basis), slope)
        else:
            step = step / 4.0
        if not abs(float(step @ slope)) > CONVERGED * abs(best):
            break
        of_end = kept + step
    by_span = np.zeros(len(knots) - 1)
    np.add.at(by_span, span, missed)
    return 2.0 * best, by_span


def _contacts_part(ends: Array, limits: Array, contacts: Array, grid: Array) -> tuple[Array, float]:
    """The contacts' part of the costate, quadratics (3, pieces) on [-1, 1], and of the bound.

    A contact is reached from the nearer end, and acts from its instant towards it, so that one
    on a short stretch keeps its digits.
    """
    at, order, multiplier = contacts[:, 0], contacts[:, 1].astype(int), contacts[:, 2]
    early = at <= _MIDDLE
    drift = np.where(early, _drift_by(ends[0], at), _drift_by(ends[1], at - 1.0))
    limit = limits[order, (multiplier > 0.0).astype(int)]
    owed = float(multiplier @ (drift[order, np.arange(len(at))] - limit))
    # How the costate's value, slope and curvature away from the middle jump at each contact.
    sign = np.where(early, -1.0, np.where(order == 1, -1.0, 1.0))
    jumps = np.zeros((3, len(grid)))
    np.add.at(jumps, (2 - order, np.searchsorted(grid, at)), sign * multiplier)
    middle = int(np.searchsorted(grid, _MIDDLE))
    before = _integrate_squares(_MIDDLE - grid[middle::-1], jumps[:, middle::-1], bool(early.any()))
    jumps[:, middle] = 0.0  # which acts on what is before
    after = _integrate_squares(grid[middle:] - _MIDDLE, jumps[:, middle:], not bool(early.all()))
    return np.hstack([before[:, ::-1] * [[1.0], [-1.0], [1.0]], after]), owed


def _integrate_squares(x: Array, jumps: Array, acts: bool) -> Array:
    """Quadratics on [-1, 1] of each piece between x, of jumps (3, n) of value, slope, curvature."""
    h = np.diff(x)
    if not acts:
        return np.zeros((3, len(h)))
    curvature = np.cumsum(jumps[2])[:-1]
    slope = np.cumsum(jumps[1, :-1] + np.append(0.0, (h * curvature)[:-1]))
    change = h * (slope + h * curvature / 2.0)
    value = np.cumsum(jumps[0, :-1] + np.append(0.0, change[:-1]))
    half = h / 2.0
    return np.array(
        [
            value + half * (slope + half * curvature / 2.0),
            half * (slope + half * curvature),
            half**2 * curvature / 2.0,
        ]
    )


def _drift_by(state: Array, t: Array) -> Array:
    """Angle, rate, acceleration, (3, ...), a time after the state, or before it, without jerk."""
    q, v, a = state
    return np.array([q + t * (v + t * a / 2.0), v + t * a, a + 0.0 * t])


def _multiplier_effects(t: Array) -> Array:
    """What a unit of each of the end's multipliers adds to the costate, (3, ...)."""
    away = _MIDDLE - t
    return np.array([away * away / 2.0, away, np.ones_like(away)])


def _where_cut_off(c0: Array, c1: Array, c2: Array, jerk_max: float) -> Array:
    """Places in order: -1, 1 and where c0 + c1 x + c2 x^2 passes a limit between, (6, pieces)."""
    cuts = [np.full(len(c0), -1.0), np.full(len(c0), 1.0)]
    with np.errstate(all="ignore"):  # no root, or one at infinity, isn't between
        for level in (jerk_max, -jerk_max):
            q = -0.5 * (c1 + np.copysign(np.sqrt(c1 * c1 - 4.0 * c2 * (c0 - level)), c1))
            cuts += [q / c2, (c0 - level) / q]
    return np.asarray(np.sort(np.clip(np.nan_to_num(cuts, nan=1.0), -1.0, 1.0), axis=0))


def _nodes_between(cuts: Array) -> tuple[Array, Array]:
    """Gauss nodes (parts, 3, pieces) between cuts, and half the parts' widths."""
    half = np.diff(cuts, axis=0)[:, None] / 2.0
    return (cuts[1:] + cuts[:-1])[:, None] / 2.0 + half * _NODES, half
