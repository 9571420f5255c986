"""The least sigma that any estimate of a clock's drift can have: the bound of Cramer and Rao."""

import math

import numpy as np
import other_platform


def drift_bound(table, t_s, noise_rad, *, with_drives=True):
    """table: as `other_platform.read_table` has it.  Each axis has an offset of its own and a
    constant; with_drives: a gain, friction and a share of the acceleration, too."""
    times, motion = table
    blocks = []
    for number, columns in enumerate(motion.values()):
        state = np.radians([other_platform.commanded(times, *columns, t) for t in t_s])
        angle, rate, acceleration = state.T
        own = [rate, np.ones(len(t_s))]
        if with_drives:
            own += [angle, np.tanh(rate / math.radians(0.01)), acceleration]
        slope = np.zeros((len(t_s), 1 + 2 * len(own)))
        slope[:, 0] = rate * t_s
        slope[:, 1 + number * len(own) : 1 + (number + 1) * len(own)] = np.column_stack(own)
        blocks.append(slope / noise_rad)
    whole = np.vstack(blocks)
    unit = np.linalg.norm(whole, axis=0)
    unit[unit == 0.0] = 1.0
    return math.sqrt(np.linalg.pinv((whole / unit).T @ (whole / unit))[0, 0]) / unit[0]
