"""The request for a comparison of telemetry with a plan, and its bounds."""

from datetime import datetime
from typing import Annotated

from planner.base.spec import Within, spec

SAMPLES_MAX = 400_000  # 15 Hz for seven hours
SECOND_MEASUREMENTS_MAX = 100
PARAMETERS_MAX = 8
_OffsetDeg = Annotated[float, Within(-10.0, 10.0)]


@spec
class ImageOffset:
    """Position of the target in a frame, from its centre.

    epoch: time of the frame, by the plan's clock; UTC. E.g. `"2015-02-27T17:37:00Z"`.
    offset_deg: along the frame's first side and along its second. E.g. `[0.12, -0.05]`.
    sigma_deg: 1-sigma of each.
    """

    epoch: datetime
    offset_deg: tuple[_OffsetDeg, _OffsetDeg]
    sigma_deg: Annotated[float, Within(1e-6, 10.0)] = 0.001
