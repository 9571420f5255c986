"""Newton's step of a programme whose stages are coupled by a motion alone.

Each stage has five numbers: a state of three and two jerks.  The least of a quadratic in them,
the states following from the jerks, takes one sweep backward and one forward.  All in
normalised time: the motion lasts 1.
Source: Rao, Wright, Rawlings 1998, "Application of interior-point methods to model predictive
control".
"""

import numpy as np

from planner.arrays import Array
from planner.compiled import compiled


@compiled
def factor(steps: Array, hessian: Array) -> tuple[Array, Array]:
    """Gains (n, 2, 3) from state to jerks, and each stage's inverse (n, 2, 2) of the jerks' part.

    steps (n, 3, 5): the next state from a stage's five numbers.  hessian (n, 5, 5).
    """
    n = len(steps)
    gains, inverse = np.empty((n, 2, 3)), np.empty((n, 2, 2))
    ahead, moved, whole = np.zeros((3, 3)), np.empty((3, 5)), np.empty((5, 5))
    for k in range(n - 1, -1, -1):
        step = steps[k]
        for i in range(3):
            for j in range(5):
                moved[i, j] = (
                    ahead[i, 0] * step[0, j] + ahead[i, 1] * step[1, j] + ahead[i, 2] * step[2, j]
                )
        for i in range(5):
            for j in range(i, 5):
                whole[i, j] = hessian[k, i, j] + (
                    step[0, i] * moved[0, j] + step[1, i] * moved[1, j] + step[2, i] * moved[2, j]
                )
        determinant = whole[3, 3] * whole[4, 4] - whole[3, 4] ** 2
        inverse[k, 0, 0], inverse[k, 1, 1] = whole[4, 4] / determinant, whole[3, 3] / determinant
        inverse[k, 0, 1] = inverse[k, 1, 0] = -whole[3, 4] / determinant
        for i in range(3):
            for u in range(2):
                gains[k, u, i] = -inverse[k, u, 0] * whole[i, 3] - inverse[k, u, 1] * whole[i, 4]
        for i in range(3):
            for j in range(i, 3):
                ahead[i, j] = (
                    whole[i, j] + whole[i, 3] * gains[k, 0, j] + whole[i, 4] * gains[k, 1, j]
                )
                ahead[j, i] = ahead[i, j]
    return gains, inverse


@compiled
def respond(
    steps: Array, gains: Array, inverse: Array, gradient: Array, last: Array
) -> tuple[Array, Array]:
    """States (n + 1, 3) and jerks (n, 2) at the least of the quadratic with a linear part.

    gradient (n, 5) of the stages' numbers, last (3,) of the state after the last stage.
    """
    n = len(steps)
    offsets, price, here = np.empty((n, 2)), last.copy(), np.empty(5)
    for k in range(n - 1, -1, -1):
        step = steps[k]
        for i in range(5):
            here[i] = gradient[k, i] + (
                step[0, i] * price[0] + step[1, i] * price[1] + step[2, i] * price[2]
            )
        for u in range(2):
            offsets[k, u] = -inverse[k, u, 0] * here[3] - inverse[k, u, 1] * here[4]
        for i in range(3):
            price[i] = here[i] + gains[k, 0, i] * here[3] + gains[k, 1, i] * here[4]
    states, jerks = np.zeros((n + 1, 3)), np.empty((n, 2))
    for k in range(n):
        for u in range(2):
            gain = gains[k, u]
            jerks[k, u] = offsets[k, u] + (
                gain[0] * states[k, 0] + gain[1] * states[k, 1] + gain[2] * states[k, 2]
            )
        follow(steps[k], states[k], jerks[k], states[k + 1])
    return states, jerks


@compiled
def follow(step: Array, state: Array, jerk: Array, next_state: Array) -> None:
    """Fills the state after a stage."""
    for i in range(3):
        total = step[i, 3] * jerk[0] + step[i, 4] * jerk[1]
        for j in range(i, 3):
            total += step[i, j] * state[j]
        next_state[i] = total
