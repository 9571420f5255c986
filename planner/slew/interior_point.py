"""The least integral of squared jerk over motions whose jerk is linear on given spans.

A convex programme with the structure of optimal control: five numbers a span (angle, rate,
acceleration at its begin, jerk at its begin and end), coupled to the next span by the motion
alone.  Mehrotra's predictor and corrector with a Riccati recursion solve it in time
proportional to the spans.  All in normalised time: the motion lasts 1.
Source: Mehrotra 1992, "On the implementation of a primal-dual interior point method".
"""

import numpy as np

from planner.arrays import Array, Mask
from planner.compiled import compiled
from planner.slew.jerk_spans import jerk_cost, reach, solved
from planner.slew.riccati import factor, follow, respond
from planner.slew.row_turns import ROWS, add_curving, bound_turns, follow_turns

ORDERS = np.array([0, 1, 2, 3, 3, 0, 0, 0, 1, 1, 2])  # of each: 0 angle to 3 jerk
GIVEN_BY_START, GIVEN_BY_END = (0, 1, 2, 5, 6, 8), (6, 7, 9)  # and not to be chosen
ITERATIONS_MAX = 80
CENTRED = 0.995  # of the way to the nearest bound
START_COMPLEMENTARITY = 0.3  # of the cost
START_SLACK = 0.05  # of half a bound's range
CONVERGED = 1e-9  # of the cost, and of the bounds' half ranges
STALLED = 1e-6  # what may be left when rounding stops further progress


@compiled
def least_jerk(
    widths: Array,
    flat: Mask,
    ends: Array,
    limits: Array,
    echoes: Array,
    echo_weights: Array,
    guess: Array,
) -> tuple[Array, Array, Array, int, bool]:
    """The jerks (n, 2) at both ends of n spans, the pushes (n, 11) of their bounds, how it went.

    flat: spans of constant jerk; in them angle and rate are bounded where they turn.
    ends (2, 3): angle, rate, acceleration at start and end.
    limits (4, 2): least and greatest angle, rate, acceleration, jerk.  echoes (m, n, 2): linear
    functionals of the jerks whose squares, times echo_weights (m,), are added to the cost, the
    integral of squared jerk.  guess (n, 2): jerks to start at.
    A push is the price of a unit of its bounded quantity, positive at the upper bound.
    Returns jerks, pushes, where in flat spans angle and rate turn, shares of the span (n, 2),
    iterations, and whether they converged.
    """
    steps, rows = _bounded_rows(widths, flat, limits)
    _leave_out_given(rows)
    scale = 1.0 / max(jerk_cost(widths, guess), 1e-12)
    jerks, weights = guess.copy(), scale * echo_weights
    states = _roll_out(steps, ends[0], jerks)
    turns, curving = np.zeros((len(widths), 2)), np.zeros((len(widths), 2))
    bound_turns(rows, turns, curving, widths, flat, limits, states, jerks)
    value = _values(rows, states, jerks, 1.0)
    slack = np.maximum(_within(value, 1.0), START_SLACK)
    begin = scale * jerk_cost(widths, jerks) + _echo_cost(echoes, weights, jerks)
    push = START_COMPLEMENTARITY * begin / len(widths) / slack
    best, found, kept, turned = np.inf, jerks.copy(), push.copy(), turns.copy()
    iterations, dual_left = 0, 1.0
    for _ in range(ITERATIONS_MAX):
        room = _within(value, 1.0) - slack
        missed = ends[1] - states[-1]
        cost = scale * jerk_cost(widths, jerks) + _echo_cost(echoes, weights, jerks)
        left = max(
            np.sum(slack * push) / cost,
            np.max(np.abs(room)),
            np.max(np.abs(missed) * 2.0 / (limits[:3, 1] - limits[:3, 0])),
            dual_left,
        )
        if left < best:
            best, found, kept, turned = left, jerks.copy(), push.copy(), turns.copy()
        if left <= CONVERGED:
            break
        iterations += 1
        hessian = _hessian(widths, rows, scale, push / slack)
        add_curving(hessian, turns, curving, widths, push)
        turn, slack_step, push_step, step = _newton_step(
            steps, rows, widths, hessian, scale, jerks, slack, push, room, missed, echoes, weights
        )
        if np.isnan(np.sum(turn)):
            break
        slack, push, jerks = slack + step * slack_step, push + step * push_step, jerks + step * turn
        states = _roll_out(steps, ends[0], jerks)
        bound_turns(rows, turns, curving, widths, flat, limits, states, jerks)
        value = _values(rows, states, jerks, 1.0)
        follow_turns(slack, _within(value, 1.0), flat)
        dual_left *= 1.0 - step
    half = kept.size // 2
    pushes = ((kept[half:] - kept[:half]) / scale).reshape(len(widths), ROWS)
    for row in range(ROWS):
        low, high = limits[ORDERS[row]]
        pushes[:, row] *= 2.0 / (high - low)
    return found, pushes, turned, iterations, best <= STALLED


@compiled
def _newton_step(
    steps: Array,
    rows: Array,
    widths: Array,
    hessian: Array,
    scale: float,
    jerks: Array,
    slack: Array,
    push: Array,
    room: Array,
    missed: Array,
    echoes: Array,
    weights: Array,
) -> tuple[Array, Array, Array, float]:
    """Changes of jerks, slacks and pushes, and how far they may go.

    First straight at the optimum, then centred by what that reached and corrected for what it
    bent, as far as its own step went: further, the iterates may swing to and fro.
    """
    gains, inverse = factor(steps, hessian)
    unit = _unit_responses(steps, gains, inverse, echoes)
    mu, half = float(np.mean(slack * push)), push.size // 2
    centring, bend = 0.0, np.zeros_like(slack)
    for _ in range(2):
        pull = (centring - bend - push * room) / slack
        gradient = _gradient(widths, rows, scale, jerks, pull[half:] - pull[:half])
        move, turn = respond(steps, gains, inverse, gradient, np.zeros(3))
        prices = _prices(missed, move, turn, unit, echoes, weights, jerks)
        for c in range(len(prices)):
            move += prices[c] * unit[0][c]
            turn += prices[c] * unit[1][c]
        slack_step = _within(_values(rows, move, turn, 0.0), 0.0) + room
        push_step = (centring - bend - push * slack_step) / slack - push
        step = min(1.0, _way(slack, slack_step), _way(push, push_step))
        after = float(np.mean((slack + step * slack_step) * (push + step * push_step)))
        centring, bend = mu * (after / mu) ** 3, step * slack_step * push_step
    return turn, slack_step, push_step, step


@compiled
def bounded_values(widths: Array, states: Array, limits: Array, jerks: Array) -> Array:
    """What `least_jerk` bounds of a given motion, (n, 11), at most 1 where the limits are kept."""
    _, rows = _bounded_rows(widths, np.zeros(len(widths), dtype=np.bool_), limits)
    return _values(rows, states, jerks, 1.0)


@compiled
def _bounded_rows(widths: Array, flat: Mask, limits: Array) -> tuple[Array, Array]:
    """What each span leads to, steps (n, 3, 5), and what is bounded in it, rows (n, 11, 6).

    Rows times a span's five numbers and 1 lie between -1 and 1: angle, rate, acceleration at
    the begin, both jerks, then the inner Bernstein coefficients of angle (3), rate (2) and
    acceleration (1), which with the values at both ends bound them throughout; in flat spans
    `planner.slew.row_turns` has these.
    """
    n = len(widths)
    steps, rows = np.empty((n, 3, 5)), np.zeros((n, ROWS, 6))
    for k in range(n):
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
    for row in range(ROWS):
        low, high = limits[ORDERS[row]]
        rows[:, row] *= 2.0 / (high - low)
        rows[:, row, 5] = -(high + low) / (high - low)
    rows[flat, 5:] = 0.0
    return steps, rows


@compiled
def _leave_out_given(rows: Array) -> None:
    for row in GIVEN_BY_START:
        rows[0, row] = 0.0
    for row in GIVEN_BY_END:
        rows[-1, row] = 0.0


@compiled
def _within(value: Array, edge: float) -> Array:
    """How far above the lower edge, then how far below the upper one: (2 * n * 11,)."""
    values = value.ravel()
    return np.concatenate((edge + values, edge - values))


@compiled
def _echo_cost(echoes: Array, weights: Array, jerks: Array) -> float:
    cost = 0.0
    for echo in range(len(weights)):
        cost += weights[echo] * np.sum(echoes[echo] * jerks) ** 2
    return cost


@compiled
def _roll_out(steps: Array, start: Array, jerks: Array) -> Array:
    states = np.empty((len(jerks) + 1, 3))
    states[0] = start
    for k in range(len(jerks)):
        follow(steps[k], states[k], jerks[k], states[k + 1])
    return states


@compiled
def _values(rows: Array, states: Array, jerks: Array, one: float) -> Array:
    value = np.empty(rows.shape[:2])
    for k in range(len(rows)):
        for row in range(ROWS):
            total = rows[k, row, 5] * one
            for i in range(3):
                total += rows[k, row, i] * states[k, i]
            value[k, row] = total + rows[k, row, 3] * jerks[k, 0] + rows[k, row, 4] * jerks[k, 1]
    return value


@compiled
def _hessian(widths: Array, rows: Array, scale: float, stiffness: Array) -> Array:
    """Its upper triangle; the first five rows bound one number each."""
    hessian, sides = np.zeros((len(widths), 5, 5)), stiffness.reshape(2, len(widths), ROWS)
    for k in range(len(widths)):
        hessian[k, 3, 3] = hessian[k, 4, 4] = scale * widths[k] / 3.0
        hessian[k, 3, 4] = scale * widths[k] / 6.0
        for row in range(ROWS):
            stiff = sides[0, k, row] + sides[1, k, row]
            if row < 5:
                hessian[k, row, row] += stiff * rows[k, row, row] ** 2
                continue
            for i in range(5):
                pulled = stiff * rows[k, row, i]
                for j in range(i, 5):
                    hessian[k, i, j] += pulled * rows[k, row, j]
    return hessian


@compiled
def _gradient(widths: Array, rows: Array, scale: float, jerks: Array, pull: Array) -> Array:
    gradient, pulls = np.zeros((len(widths), 5)), pull.reshape(len(widths), ROWS)
    for k in range(len(widths)):
        share = scale * widths[k] / 6.0
        gradient[k, 3] = share * (2.0 * jerks[k, 0] + jerks[k, 1])
        gradient[k, 4] = share * (jerks[k, 0] + 2.0 * jerks[k, 1])
        for row in range(5):
            gradient[k, row] += pulls[k, row] * rows[k, row, row]
        for row in range(5, ROWS):
            for i in range(5):
                gradient[k, i] += pulls[k, row] * rows[k, row, i]
    return gradient


@compiled
def _unit_responses(
    steps: Array, gains: Array, inverse: Array, echoes: Array
) -> tuple[Array, Array]:
    """States and jerks under a price of 1 on the end's angle, rate, acceleration, each echo."""
    n, count = len(steps), 3 + len(echoes)
    states, jerks = np.empty((count, n + 1, 3)), np.empty((count, n, 2))
    for c in range(count):
        gradient, last = np.zeros((n, 5)), np.zeros(3)
        if c < 3:
            last[c] = 1.0
        else:
            gradient[:, 3:] = echoes[c - 3]
        states[c], jerks[c] = respond(steps, gains, inverse, gradient, last)
    return states, jerks


@compiled
def _prices(
    missed: Array,
    move: Array,
    turn: Array,
    unit: tuple[Array, Array],
    echoes: Array,
    weights: Array,
    jerks: Array,
) -> Array:
    """Of the end's state and of each echo, so that the step meets the end and what echoes cost."""
    states, turns = unit
    count = len(states)
    system, wanted = np.empty((count, count)), np.empty(count)
    for row in range(3):
        system[row] = states[:, -1, row]
        wanted[row] = missed[row] - move[-1, row]
    for row in range(3, count):
        echo = echoes[row - 3]
        for c in range(count):
            system[row, c] = np.sum(echo * turns[c])
        system[row, row] -= 1.0 / weights[row - 3]
        wanted[row] = -np.sum(echo * (jerks + turn))
    return solved(system, wanted)


@compiled
def _way(value: Array, change: Array) -> float:
    """What multiple of the change leaves every value positive."""
    way = np.inf
    for i in range(len(value)):
        if change[i] < 0.0:
            way = min(way, -CENTRED * value[i] / change[i])
    return way
