"""The least integral of squared jerk over motions whose jerk is linear on given spans.

A quadratic programme with the structure of optimal control: five numbers a span (angle, rate,
acceleration at its begin, jerk at its begin and end), coupled to the next span by the motion
alone.  Mehrotra's predictor and corrector with a Riccati recursion solve it in time
proportional to the spans.  All quantities in normalised time: the motion lasts 1.
Source: Mehrotra 1992, "On the implementation of a primal-dual interior point method"; Rao,
Wright, Rawlings 1998, "Application of interior-point methods to model predictive control".
"""

import numpy as np

from planner.arrays import Array, Mask
from planner.compiled import compiled
from planner.slew.jerk_spans import reach, solved

ROWS = 11  # bounded in a span, see `bounded_rows`
GIVEN_BY_START, GIVEN_BY_END = (0, 1, 2, 5, 6, 8), (6, 7, 9)  # and not to be chosen
ORDERS = np.array([0, 1, 2, 3, 3, 0, 0, 0, 1, 1, 2])
ITERATIONS_MAX = 80
CENTRED = 0.995  # of the way to the nearest bound
SHORT_STEP, STALLS_BORNE = 0.1, 3  # then all pairs are centred anew
START_COMPLEMENTARITY = 0.3
START_SLACK = 0.05  # of half a bound's range
CONVERGED = 1e-9  # of the cost, of the bounds' half ranges
STALLED = 1e-6  # what may be left when rounding stops further progress


@compiled
def bounded_rows(widths: Array, flat: Mask, steps: Array, rows: Array) -> None:
    """What is bounded in each span, from its five numbers: rows (n, 11, 6), steps (n, 3, 5).

    Angle, rate, acceleration at the begin, both jerks, then the inner Bernstein coefficients of
    angle (3), rate (2) and acceleration (1), which with the values at both ends bound them
    throughout.
    """
    rows[:] = 0.0
    for k in range(len(widths)):
        h = widths[k]
        reach(h, flat[k], steps[k])
        for j in range(5):
            rows[k, j, j] = 1.0
        rows[k, 5, 0] = rows[k, 6, 0] = rows[k, 7, 0] = 1.0
        rows[k, 5, 1], rows[k, 6, 1], rows[k, 7, 1] = h / 4.0, h / 2.0, 3.0 * h / 4.0
        rows[k, 6, 2], rows[k, 7, 2], rows[k, 7, 3] = h * h / 12.0, h * h / 4.0, h**3 / 24.0
        rows[k, 8, 1] = rows[k, 9, 1] = 1.0
        rows[k, 8, 2], rows[k, 9, 2], rows[k, 9, 3] = h / 3.0, 2.0 * h / 3.0, h * h / 6.0
        rows[k, 10, 2], rows[k, 10, 3] = 1.0, h / 2.0
        if flat[k]:
            for row in (7, 9, 10):
                rows[k, row, 3] /= 2.0
                rows[k, row, 4] = rows[k, row, 3]


@compiled
def least_jerk(
    widths: Array,
    flat: Mask,
    ends: Array,
    limits: Array,
    echoes: Array,
    echo_weights: Array,
    guess: Array,
) -> tuple[Array, Array, int, bool]:
    """The jerks (n, 2) at both ends of n spans, the pushes (n, 11) of their bounds, how it went.

    flat: spans of constant jerk.  ends (2, 3): angle, rate, acceleration at start and end.
    limits (4, 2): least and greatest angle, rate, acceleration, jerk.  echoes (m, n, 2): linear
    functionals of the jerks whose squares, times echo_weights (m,), are added to the cost, the
    integral of squared jerk.  guess (n, 2): jerks to start at.
    A push is the price of a unit of its bounded quantity, positive at the upper bound.
    Returns jerks, pushes, iterations, and whether they converged.
    """
    n, m = len(widths), len(echo_weights)
    columns = 4 + m
    steps, rows = np.empty((n, 3, 5)), np.empty((n, ROWS, 6))
    bounded_rows(widths, flat, steps, rows)
    for row in range(ROWS):
        low, high = limits[ORDERS[row]]
        rows[:, row] *= 2.0 / (high - low)
        rows[:, row, 5] = -(high + low) / (high - low)
    for row in GIVEN_BY_START:
        rows[0, row] = 0.0
    for row in GIVEN_BY_END:
        rows[n - 1, row] = 0.0

    z, jerk = np.zeros((n + 1, 3)), guess.copy()
    below, above = np.empty((n, ROWS)), np.empty((n, ROWS))
    push_up, push_down = np.empty((n, ROWS)), np.empty((n, ROWS))
    value = np.empty((n, ROWS))
    z[0] = ends[0]
    _roll_out(steps, z, jerk)
    scale = 1.0 / max(_jerk_cost(widths, jerk), 1e-12)
    begin = 1.0
    for echo in range(m):
        begin += scale * echo_weights[echo] * np.sum(echoes[echo] * jerk) ** 2
    begin *= START_COMPLEMENTARITY / n
    _values(rows, 1.0, z, jerk, value)
    for k in range(n):
        for row in range(ROWS):
            below[k, row] = max(1.0 + value[k, row], START_SLACK)
            above[k, row] = max(1.0 - value[k, row], START_SLACK)
            push_down[k, row] = begin / below[k, row]
            push_up[k, row] = begin / above[k, row]
    pairs = 2.0 * n * ROWS

    gradient = np.empty((n, 5))
    hessian = np.empty((n, 5, 5))
    gains, offsets = np.empty((n, 2, 3)), np.empty((n, 2, columns))
    inverse = np.empty((n, 2, 2))
    dz, djerk = np.empty((columns, n + 1, 3)), np.empty((columns, n, 2))
    dvalue = np.empty((n, ROWS))
    fix_below, fix_above = np.zeros((n, ROWS)), np.zeros((n, ROWS))
    prices = np.empty(columns - 1)
    iterations, dual_left, stalls = 0, 1.0, 0
    best, found, pushes = 1e300, jerk.copy(), push_up - push_down
    for iterations in range(1, ITERATIONS_MAX + 1):
        mu, broken = 0.0, 0.0
        for k in range(n):
            for row in range(ROWS):
                mu += below[k, row] * push_down[k, row] + above[k, row] * push_up[k, row]
                broken = max(broken, abs(1.0 + value[k, row] - below[k, row]))
                broken = max(broken, abs(1.0 - value[k, row] - above[k, row]))
        missed = 0.0
        for order in range(3):
            missed = max(
                missed,
                abs(ends[1, order] - z[n, order]) * 2.0 / (limits[order, 1] - limits[order, 0]),
            )
        cost = scale * _jerk_cost(widths, jerk)
        for echo in range(m):
            cost += scale * echo_weights[echo] * np.sum(echoes[echo] * jerk) ** 2
        left = max(mu / cost, broken, missed, dual_left)
        if left < best:
            best, found, pushes = left, jerk.copy(), push_up - push_down
        if left <= CONVERGED:
            break
        mu /= pairs
        solvable = True
        for corrector in range(2):
            if corrector == 0:
                centring = 0.0
                fix_below[:] = 0.0
                fix_above[:] = 0.0
            # Rows' part of the Newton system.
            for k in range(n):
                h = widths[k]
                for i in range(5):
                    gradient[k, i] = 0.0
                gradient[k, 3] = scale * h * (jerk[k, 0] / 3.0 + jerk[k, 1] / 6.0)
                gradient[k, 4] = scale * h * (jerk[k, 0] / 6.0 + jerk[k, 1] / 3.0)
                if corrector == 0:
                    for i in range(5):
                        for j in range(5):
                            hessian[k, i, j] = 0.0
                    hessian[k, 3, 3] = hessian[k, 4, 4] = scale * h / 3.0
                    hessian[k, 3, 4] = hessian[k, 4, 3] = scale * h / 6.0
                for row in range(ROWS):
                    sl, su = below[k, row], above[k, row]
                    ll, lu = push_down[k, row], push_up[k, row]
                    pull = (centring - fix_above[k, row] - lu * (1.0 - value[k, row] - su)) / su
                    pull -= (centring - fix_below[k, row] - ll * (1.0 + value[k, row] - sl)) / sl
                    stiff = ll / sl + lu / su
                    first = 0
                    last = 5
                    if row < 5:
                        first, last = row, row + 1
                    for i in range(first, last):
                        g = rows[k, row, i]
                        gradient[k, i] += g * pull
                        if corrector == 0:
                            for j in range(first, last):
                                hessian[k, i, j] += stiff * g * rows[k, row, j]
            _backward(steps, hessian, gradient, echoes, corrector, gains, offsets, inverse)
            _forward(steps, gains, offsets, corrector, dz, djerk)
            solvable = _price(ends, z, jerk, echoes, echo_weights, scale, dz, djerk, prices)
            if not solvable:
                break
            for c in range(1, columns):
                dz[0] += prices[c - 1] * dz[c]
                djerk[0] += prices[c - 1] * djerk[c]
            _values(rows, 0.0, dz[0], djerk[0], dvalue)
            step = 1.0
            after = 0.0
            for k in range(n):
                for row in range(ROWS):
                    sl, su = below[k, row], above[k, row]
                    ll, lu = push_down[k, row], push_up[k, row]
                    dsl = dvalue[k, row] + 1.0 + value[k, row] - sl
                    dsu = -dvalue[k, row] + 1.0 - value[k, row] - su
                    dll = (centring - fix_below[k, row] - ll * dsl) / sl - ll
                    dlu = (centring - fix_above[k, row] - lu * dsu) / su - lu
                    if dsl < 0.0:
                        step = min(step, -CENTRED * sl / dsl)
                    if dsu < 0.0:
                        step = min(step, -CENTRED * su / dsu)
                    if dll < 0.0:
                        step = min(step, -CENTRED * ll / dll)
                    if dlu < 0.0:
                        step = min(step, -CENTRED * lu / dlu)
            if corrector == 0:
                for k in range(n):
                    for row in range(ROWS):
                        sl, su = below[k, row], above[k, row]
                        ll, lu = push_down[k, row], push_up[k, row]
                        dsl = dvalue[k, row] + 1.0 + value[k, row] - sl
                        dsu = -dvalue[k, row] + 1.0 - value[k, row] - su
                        dll = -ll * dsl / sl - ll
                        dlu = -lu * dsu / su - lu
                        after += (sl + step * dsl) * (ll + step * dll)
                        after += (su + step * dsu) * (lu + step * dlu)
                        fix_below[k, row] = dsl * dll
                        fix_above[k, row] = dsu * dlu
                after /= pairs
                centring = mu * (after / mu) ** 3
        if not solvable:
            break
        for k in range(n):
            for row in range(ROWS):
                sl, su = below[k, row], above[k, row]
                ll, lu = push_down[k, row], push_up[k, row]
                dsl = dvalue[k, row] + 1.0 + value[k, row] - sl
                dsu = -dvalue[k, row] + 1.0 - value[k, row] - su
                push_down[k, row] = ll + step * (
                    (centring - fix_below[k, row] - ll * dsl) / sl - ll
                )
                push_up[k, row] = lu + step * ((centring - fix_above[k, row] - lu * dsu) / su - lu)
                below[k, row] = sl + step * dsl
                above[k, row] = su + step * dsu
        jerk += step * djerk[0]
        _roll_out(steps, z, jerk)
        _values(rows, 1.0, z, jerk, value)
        dual_left *= 1.0 - step
        stalls = stalls + 1 if step < SHORT_STEP else 0
        if stalls == STALLS_BORNE:
            stalls, dual_left = 0, 1.0
            for k in range(n):
                for row in range(ROWS):
                    push_down[k, row] = mu / below[k, row]
                    push_up[k, row] = mu / above[k, row]
    for row in range(ROWS):
        low, high = limits[ORDERS[row]]
        pushes[:, row] *= 2.0 / (high - low) / scale
    return found, pushes, iterations, best <= STALLED


@compiled
def _jerk_cost(widths: Array, jerk: Array) -> float:
    early, late = jerk[:, 0], jerk[:, 1]
    return np.sum(widths * (early * early + early * late + late * late)) / 3.0


@compiled
def _roll_out(steps: Array, z: Array, jerk: Array) -> None:
    for k in range(len(jerk)):
        for i in range(3):
            total = steps[k, i, 3] * jerk[k, 0] + steps[k, i, 4] * jerk[k, 1]
            for j in range(i, 3):
                total += steps[k, i, j] * z[k, j]
            z[k + 1, i] = total


@compiled
def _values(rows: Array, one: float, z: Array, jerk: Array, value: Array) -> None:
    for k in range(len(jerk)):
        for row in range(ROWS):
            r = rows[k, row]
            total = r[0] * z[k, 0] + r[1] * z[k, 1] + r[2] * z[k, 2] + r[5] * one
            value[k, row] = total + r[3] * jerk[k, 0] + r[4] * jerk[k, 1]


@compiled
def _backward(
    steps: Array,
    hessian: Array,
    gradient: Array,
    echoes: Array,
    corrector: int,
    gains: Array,
    offsets: Array,
    inverse: Array,
) -> None:
    """Riccati recursion: gains (n, 2, 3), and for each right-hand side offsets (n, 2, columns).

    The first column is the programme's own gradient; the next three are unit prices of the end's
    angle, rate and acceleration; the rest of the echoes.  A corrector changes the first alone.
    """
    n, columns = len(steps), offsets.shape[2]
    P, p = np.zeros((3, 3)), np.zeros((3, columns))
    used = 1 if corrector else columns
    if not corrector:
        for order in range(3):
            p[order, 1 + order] = 1.0
    PA = np.empty((3, 5))
    Q = np.empty((5, 5))
    q = np.empty((5, columns))
    for k in range(n - 1, -1, -1):
        step = steps[k]
        if not corrector:
            for i in range(3):
                for j in range(5):
                    PA[i, j] = P[i, 0] * step[0, j] + P[i, 1] * step[1, j] + P[i, 2] * step[2, j]
            for i in range(5):
                for j in range(i, 5):
                    Q[i, j] = hessian[k, i, j] + (
                        step[0, i] * PA[0, j] + step[1, i] * PA[1, j] + step[2, i] * PA[2, j]
                    )
            det = Q[3, 3] * Q[4, 4] - Q[3, 4] ** 2
            inverse[k, 0, 0], inverse[k, 1, 1] = Q[4, 4] / det, Q[3, 3] / det
            inverse[k, 0, 1] = inverse[k, 1, 0] = -Q[3, 4] / det
            for i in range(3):
                for u in range(2):
                    gains[k, u, i] = -(inverse[k, u, 0] * Q[i, 3] + inverse[k, u, 1] * Q[i, 4])
            for i in range(3):
                for j in range(i, 3):
                    P[i, j] = Q[i, j] + Q[i, 3] * gains[k, 0, j] + Q[i, 4] * gains[k, 1, j]
                    P[j, i] = P[i, j]
        for c in range(used):
            for i in range(5):
                q[i, c] = step[0, i] * p[0, c] + step[1, i] * p[1, c] + step[2, i] * p[2, c]
                if c == 0:
                    q[i, c] += gradient[k, i]
            if c > 3:
                q[3, c] += echoes[c - 4, k, 0]
                q[4, c] += echoes[c - 4, k, 1]
            for u in range(2):
                offsets[k, u, c] = -(inverse[k, u, 0] * q[3, c] + inverse[k, u, 1] * q[4, c])
            for i in range(3):
                p[i, c] = q[i, c] + gains[k, 0, i] * q[3, c] + gains[k, 1, i] * q[4, c]


@compiled
def _forward(
    steps: Array, gains: Array, offsets: Array, corrector: int, dz: Array, djerk: Array
) -> None:
    n = len(steps)
    for c in range(1 if corrector else len(dz)):
        for i in range(3):
            dz[c, 0, i] = 0.0
        for k in range(n):
            for u in range(2):
                total = offsets[k, u, c]
                for i in range(3):
                    total += gains[k, u, i] * dz[c, k, i]
                djerk[c, k, u] = total
            for i in range(3):
                total = steps[k, i, 3] * djerk[c, k, 0] + steps[k, i, 4] * djerk[c, k, 1]
                for j in range(i, 3):
                    total += steps[k, i, j] * dz[c, k, j]
                dz[c, k + 1, i] = total


@compiled
def _price(
    ends: Array,
    z: Array,
    jerk: Array,
    echoes: Array,
    echo_weights: Array,
    scale: float,
    dz: Array,
    djerk: Array,
    prices: Array,
) -> bool:
    """What the end's state and each echo cost, so that the step meets them."""
    n, count = len(jerk), len(prices)
    system, wanted = np.empty((count, count)), np.empty(count)
    for row in range(count):
        if row < 3:
            for c in range(count):
                system[row, c] = dz[1 + c, n, row]
            wanted[row] = ends[1, row] - z[n, row] - dz[0, n, row]
            continue
        echo = echoes[row - 3]
        for c in range(count):
            system[row, c] = np.sum(echo * djerk[1 + c])
        system[row, row] -= 1.0 / (scale * echo_weights[row - 3])
        wanted[row] = -np.sum(echo * (jerk + djerk[0]))
    prices[:] = solved(system, wanted)
    return bool(np.all(np.isfinite(prices)))
