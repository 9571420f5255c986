"""How do slews and tracks become one command table?"""

from dataclasses import dataclass
from datetime import datetime

import numpy as np
from numpy.typing import NDArray

from planner.commands import CommandTable


@dataclass(frozen=True, kw_only=True)
class Piece:
    """Rows of a slew or a track, shape (n, m); the first stands at `first_row` of the table."""

    first_row: int
    angle_rad: NDArray[np.float64]
    rate_rad_s: NDArray[np.float64]


def assembled(
    epoch_utc: datetime, axis_names: tuple[str, ...], pieces: list[Piece]
) -> CommandTable:
    """The table of all pieces; where two share a row, the later piece has it."""
    rows = max(piece.first_row + len(piece.angle_rad) for piece in pieces)
    angle_rad = np.full((rows, len(axis_names)), np.nan)
    rate_rad_s = np.full((rows, len(axis_names)), np.nan)
    for piece in pieces:
        here = slice(piece.first_row, piece.first_row + len(piece.angle_rad))
        angle_rad[here] = piece.angle_rad
        rate_rad_s[here] = piece.rate_rad_s
    if np.isnan(angle_rad).any():
        raise AssertionError("the pieces leave a gap in the table")
    return CommandTable(
        epoch_utc=epoch_utc, axis_names=axis_names, angle_rad=angle_rad, rate_rad_s=rate_rad_s
    )
