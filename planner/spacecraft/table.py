"""The rows of a session's table in which the camera runs."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from planner.base.answer_members import Count
from planner.base.commands import COMMAND_STEP_S

TICK_S = COMMAND_STEP_S  # Platonov, Sumarokov 2019: the control cycle


@dataclass(frozen=True, kw_only=True)
class ImagingWindow:
    """One stretch of imaging: rows first_row .. last_row, both with the camera on.

    request, look: which request, and which strip, look or leg of it (from 0).
    """

    request: str
    look: Count
    first_row: Count
    last_row: Count


def camera_on(windows: Sequence[ImagingWindow], rows: int) -> NDArray[np.bool_]:
    """Whether the camera runs from row k to k + 1, shape (rows - 1,)."""
    on = np.zeros(rows - 1, dtype=bool)
    for window in windows:
        on[window.first_row : window.last_row] = True
    return on
