"""The judge's own count of what battery, memory and wheels hold, step by step; compiled."""

import numpy as np

from planner.base.arrays import Array
from planner.base.compiled import compiled


@compiled
def held_by_store(
    begin_level: float, step_numbers: Array, least_level: float, most_level: float
) -> Array:
    """From a level on, after each of n steps, (n + 1,): what would pass its ends is lost."""
    held = np.empty(len(step_numbers) + 1)
    held[0] = begin_level
    for number in range(len(step_numbers)):
        held[number + 1] = min(max(held[number] + step_numbers[number], least_level), most_level)
    return held


@compiled
def held_by_wheels(
    axes_eci: Array,
    middle_axes_eci: Array,
    impulse_eci_n_m_s: Array,
    unloading_n_m_s: Array,
    held_n_m_s: Array,
) -> None:
    """Into held_n_m_s, (n, 3).

    It begins with what the body turns with, negative, and in row 0 with what the wheels hold.
    axes_eci, middle_axes_eci: body axes as rows, at rows (n, 3, 3) and half way (n - 1, 3, 3).
    impulse_eci_n_m_s: of outer torques from row to row, (n, 3); in row 0 what body and wheels
    hold.  unloading_n_m_s: the most that is taken from an axis between rows, (n - 1,).
    """
    total = impulse_eci_n_m_s[0].copy()
    for row in range(1, len(held_n_m_s)):
        total += impulse_eci_n_m_s[row]
        for axis in range(3):
            held_n_m_s[row, axis] += np.sum(axes_eci[row, axis] * total)
        most = unloading_n_m_s[row - 1]
        if most == 0.0:
            continue
        for axis in range(3):
            value, left = held_n_m_s[row - 1, axis], 1.0
            change = held_n_m_s[row, axis] - value
            while left > 0.0:
                towards = value if value != 0.0 else change
                if value == 0.0 and abs(change) <= most:
                    break  # what comes in is taken off at once
                net = change - most if towards > 0.0 else change + most
                if value * net < 0.0 and -value / net < left:
                    left += value / net
                    value = 0.0
                else:
                    value += net * left
                    left = 0.0
            taken = held_n_m_s[row, axis] - value
            held_n_m_s[row, axis] = value
            total -= taken * middle_axes_eci[row - 1, axis]
