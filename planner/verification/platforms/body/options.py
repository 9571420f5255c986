"""Numbers that the judge of a body works to, each with its reason."""

import math
from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Options:
    """How densely a body's table is looked at, and by how much it may be off.

    A motion whose jerk steps inside a row's cell keeps its limits itself; the quintic through its
    rows rings about it.  `..._rings`: by jerk x step (x step), of two steps of the jerk to zero
    at the limit, its greatest over where in the cell they are.  `..._miss`: by which rows of
    one motion may disagree, in jerk x step^3 and jerk x step^2, where the jerk steps from one limit
    to the other twice inside the cell.
    """

    rows_min: int = 2
    points_per_cell: int = 8  # 25 ms apart: between them a rate rises by 1e-5 of its limit
    # By how much the second derivative of a quintic passes its ends: in what its value is off the
    # cubic through them by step^2, and its slope by step.
    turn_within: float = 5.8
    rate_within: float = 6.9
    unit: float = 1e-9  # of a quaternion's length: 13 decimals, rounded
    # A fifth of what pointing may err by: idle attitudes are found to a hundredth of it.
    end_rad: float = math.radians(0.02 / 3600.0)
    end_rad_s: float = math.radians(0.02 / 3600.0)
    end_rad_s2: float = math.radians(0.02 / 3600.0)  # of an initial acceleration that is asked for
    off_nadir_rad: float = math.radians(0.1 / 3600.0)  # as for pointing
    roll_rad: float = 5e-5  # the end of a line of 8192 pixels then lies a fifth of a pixel off
    motion_difference_s: float = 0.05  # either way: a path's corners take 2 s or more
    acceleration_rings: float = 2.0 * 0.02369
    rate_rings: float = 2.0 * 0.00474
    turn_miss: float = 4.0 * 0.00802
    rate_miss: float = 4.0 * 0.125
    rounding_rad: float = 1e-9  # of attitudes of 13 decimals and rates of 9, over a cell
    idle_difference_s: float = 0.2  # a low orbit's rates err by (0.2 / 880)^2 / 6 of themselves
    finer: int = 20  # instants per cell, 10 ms apart, where an exclusion is near
    finest: int = (
        40  # instants per cell, 5 ms apart, where the gyros may be asked for all they have
    )
    gimbal_rad: float = 1e-9  # of angles and rates of 9 decimals of a degree, over a row
    gimbals_miss: float = 2e-3  # of a rotor's momentum: rates are held over a row
    changes_most: float = 1.5  # times the greatest derivative: the quintic's rings
    # Rows from one look to the next where an exclusion is far: the Sun isn't up for less than 2 s.
    stride: int = 10
    # Angles to limb and glint change with the orbit, too: below 0.2 deg/s from 200 km.
    orbit_rate_rad_s: float = math.radians(0.5)
    rows_at_once: int = 20_000


OPTIONS = Options()
