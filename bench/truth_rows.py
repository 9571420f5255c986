"""A line of the table of bench/truth.py."""

from typing import NamedTuple

NEES_GOAL = (0.8, 1.3)


class Row(NamedTuple):
    """What a point of the table asks for and what was seen; is_met: None where nothing is asked."""

    point: int
    what: str
    goal: str
    seen: str
    is_met: bool | None


def nees_row(point: int, what: str, nees: float, of: str) -> Row:
    """Mean squared error over the told variance, 1 where that is right."""
    low, high = NEES_GOAL
    is_met = bool(low <= nees <= high)
    return Row(point, what, f"NEES {low}-{high}", f"{nees:.2f} {of}", is_met)
