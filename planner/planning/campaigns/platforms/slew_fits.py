"""Test of a slew between two states of a platform against a time; compiled for every kind."""

from typing import NamedTuple

import numpy as np

from planner.base.arrays import Array
from planner.base.compiled import lean
from planner.planning.campaigns.platforms.axis_slew_time import axes_fit
from planner.planning.campaigns.platforms.body_slew_time import BodyEnvelope, body_fits

SUFFICIENT, NECESSARY = 1.0, -1.0
_NO_BODY = BodyEnvelope(
    np.empty((0, 3)), np.empty(0, np.bool_), np.empty(0), np.empty(0), np.empty(0)
)


class FollowerLimits(NamedTuple):
    """axes: rate, acceleration and jerk limit of each axis, (m, 3); none of a body.

    States are of shape (3 m,), angles, rates, accelerations; of a body as of `body_fits`.
    """

    axes: Array
    body: BodyEnvelope = _NO_BODY


@lean
def slew_fits(
    start_state: Array, end_state: Array, limits: FollowerLimits, sign: float, available_s: float
) -> bool:
    """sign: SUFFICIENT, it surely does; NECESSARY, nothing proves that it doesn't."""
    if len(limits.axes):
        axes = limits.axes
        return axes_fit(
            start_state.reshape(3, len(axes)),
            end_state.reshape(3, len(axes)),
            axes,
            sign,
            available_s,
        )
    return body_fits(start_state, end_state, limits.body, sign, available_s)
