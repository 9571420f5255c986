"""Momentum of reaction wheels along an attitude, step by step; compiled."""

import numpy as np

from planner.base.arrays import Array
from planner.base.compiled import compiled, nested


@nested
def _unloaded(begin_n_m_s: float, end_n_m_s: float, most_n_m_s: float) -> float:
    """Where a momentum ends that would change evenly, with so much taken off it until it is 0."""
    side = 1.0 if begin_n_m_s > 0.0 or (begin_n_m_s == 0.0 and end_n_m_s > 0.0) else -1.0
    size, change = side * begin_n_m_s, side * (end_n_m_s - begin_n_m_s)
    left = size + change - most_n_m_s
    if left >= 0.0:
        return side * left
    if change >= -most_n_m_s:
        return 0.0
    return side * (change + most_n_m_s) * (1.0 - size / (most_n_m_s - change))


@compiled
def wheel_momentum(
    c_body_from_eci: Array,
    turning_body_n_m_s: Array,
    impulse_eci_n_m_s: Array,
    unloading_n_m_s: Array,
    start_body_n_m_s: Array,
) -> Array:
    """Of the wheels about the body's axes at n instants, (n, 3).

    Body and wheels together hold what the impulses bring; the wheels hold what the body doesn't
    turn with.  c_body_from_eci: (n, 3, 3).  turning_body_n_m_s: inertia times rate, (n, 3).
    impulse_eci_n_m_s: of outer torques in each step, (n - 1, 3).  unloading_n_m_s: the most that
    is taken from each axis in a step, (n - 1,).  start_body_n_m_s: of the wheels, (3,).
    """
    held = np.zeros_like(turning_body_n_m_s)
    held[0] = start_body_n_m_s
    begun = (start_body_n_m_s + turning_body_n_m_s[0]).reshape(3, 1)
    total_eci = np.sum(c_body_from_eci[0] * begun, axis=0)
    for k in range(1, len(held)):
        before, here = c_body_from_eci[k - 1], c_body_from_eci[k]
        total_eci += impulse_eci_n_m_s[k - 1]
        held[k] = np.sum(here * total_eci, axis=1) - turning_body_n_m_s[k]
        if unloading_n_m_s[k - 1] > 0.0:
            for i in range(3):  # about where the axis is half way
                taken = held[k, i] - _unloaded(held[k - 1, i], held[k, i], unloading_n_m_s[k - 1])
                total_eci -= 0.5 * taken * (before[i] + here[i])
            held[k] = np.sum(here * total_eci, axis=1) - turning_body_n_m_s[k]
    return held
