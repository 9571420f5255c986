"""Margins of a body's motion to its agility, anywhere between the first and the last row."""

from collections.abc import Iterator
from datetime import datetime

import numpy as np

from planner.base.arrays import Array
from planner.base.commands import COMMAND_STEP_S, ROWS_PER_S
from planner.verification.limits import RELATIVE_TOLERANCE
from planner.verification.platforms.body.options import OPTIONS
from planner.verification.platforms.body.quintic import FlownMotion
from planner.verification.report import Limit, LimitMargin
from planner.world.frames.time_scales import shifted_utc
from planner.world.platforms.body import Envelope, MagnitudeAgility

WHOLE_BODY = "body"  # stands for the axis where a limit is of a vector's length


def body_margins(
    agility: Envelope, flown: FlownMotion, t_s: Array, row_alpha_rad_s2: Array, epoch_utc: datetime
) -> Iterator[LimitMargin]:
    """Rate and acceleration of n instants, jerk as the mean over each cell.

    flown: with the instants t_s, (n,), rows among them.  row_alpha_rad_s2: of the rows, (m, 3).
    Of the jerk only its mean is a property of the motion that was sampled: within a cell the
    quintic's rings.
    """
    h = COMMAND_STEP_S
    jerk_rad_s3 = (row_alpha_rad_s2[1:] - row_alpha_rad_s2[:-1]) / h
    jerk_s = np.asarray(np.arange(len(jerk_rad_s3)) / ROWS_PER_S)
    rate_max, acceleration_max, jerk_max = agility.by_order_rad
    kinds: tuple[tuple[Limit, Array, Array, Array, Array], ...] = (
        ("rate", t_s, flown.omega_body_rad_s, rate_max, OPTIONS.rate_rings * jerk_max * h**2),
        (
            "acceleration",
            t_s,
            flown.alpha_body_rad_s2,
            acceleration_max,
            OPTIONS.acceleration_rings * jerk_max * h,
        ),
        ("jerk", jerk_s, jerk_rad_s3, jerk_max, 0.0 * jerk_max),
    )
    names = (WHOLE_BODY,) if isinstance(agility, MagnitudeAgility) else ("x", "y", "z")
    for kind, at_s, vector, bound, rings in kinds:
        sizes = sizes_limited(agility, vector)
        for column, name in enumerate(names):
            worst = int(np.argmax(np.abs(sizes[:, column])))
            extreme, limit = float(sizes[worst, column]), float(bound[column])
            yield LimitMargin(
                axis=name,
                kind=kind,
                limit=limit,
                extreme=extreme,
                margin=limit - abs(extreme),
                tolerance=RELATIVE_TOLERANCE * limit + float(rings[column]),
                t_s=float(at_s[worst]),
                at_utc=shifted_utc(epoch_utc, float(at_s[worst])),
            )


def sizes_limited(agility: Envelope, value: Array) -> Array:
    """What of vectors (n, 3) has a limit: their lengths, (n, 1), or components, (n, 3)."""
    if isinstance(agility, MagnitudeAgility):
        return np.asarray(np.linalg.norm(value, axis=1, keepdims=True))
    return value
